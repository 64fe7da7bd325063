# SPDX-License-Identifier: Apache-2.0
"""Readings of a flight in a file, so that a node that is started again has them all.

The command `localize` reads the file, too.
"""

import math
from collections.abc import Iterator

from rocsafe_hazard.row_spool import RowSpool
from rocsafe_radiation.readings.reading_log import FlightReading

FILE_NAME = 'readings.csv'
COLUMNS = (
    'time_ns', 'vehicle', 'latitude_deg', 'longitude_deg', 'altitude_m', 'dose_rate_usvh',
    'dose_rate_std_usvh', 'counts', 'live_time_s', 'integration_time_s', 'saturated', 'model',
)  # fmt: skip


class ReadingSpool:
    """Keeps readings in ``readings.csv`` of a directory; with an empty name, keeps none."""

    def __init__(self, directory: str) -> None:
        self._rows = RowSpool(directory, FILE_NAME, COLUMNS)

    def restored(self) -> Iterator[FlightReading]:
        """Yield the readings that were kept before.

        Raises
        ------
        SpoolError
            If there is a file that cannot be read.
        """
        for row in self._rows.restored():
            reading = _reading(row)
            if reading is not None:
                yield reading

    def keep(self, reading: FlightReading) -> None:
        """Append `reading`.

        Raises
        ------
        SpoolError
            If it cannot be written.
        """
        self._rows.keep(_row(reading))


def _row(reading: FlightReading) -> list[object]:
    return [
        reading.time_ns,
        reading.vehicle,
        reading.latitude_deg,
        reading.longitude_deg,
        reading.altitude_m,
        reading.dose_rate_usvh,
        reading.dose_rate_std_usvh,
        reading.counts,
        reading.live_time_s,
        reading.window_s,
        int(reading.is_saturated),
        reading.model,
    ]


def _reading(row: dict[str, str]) -> FlightReading | None:
    """Return the reading of a row, None if the row is not whole."""
    try:
        numbers = {name: float(row[name]) for name in COLUMNS[2:11]}
        time_ns = int(row['time_ns'])
    except (KeyError, TypeError, ValueError):
        return None
    return FlightReading(
        vehicle=row['vehicle'],
        time_ns=time_ns,
        latitude_deg=numbers['latitude_deg'],
        longitude_deg=numbers['longitude_deg'],
        altitude_m=numbers['altitude_m'],
        dose_rate_usvh=numbers['dose_rate_usvh'],
        dose_rate_std_usvh=numbers['dose_rate_std_usvh'],
        counts=numbers['counts'],
        live_time_s=numbers['live_time_s'],
        window_s=numbers['integration_time_s'],
        is_saturated=not math.isclose(numbers['saturated'], 0.0),
        model=row['model'] or '',
    )
