# SPDX-License-Identifier: Apache-2.0
"""Readings of a flight in a file, so that a node that is started again has them all.

The command `localize` reads the file, too. A row that a crash has cut off is left out when the
file is read.
"""

import csv
import math
from collections.abc import Iterator
from pathlib import Path
from typing import IO

from rocsafe_radiation.errors import RadiationError
from rocsafe_radiation.readings.reading_log import FlightReading

FILE_NAME = 'readings.csv'
COLUMNS = (
    'time_ns', 'vehicle', 'latitude_deg', 'longitude_deg', 'altitude_m', 'dose_rate_usvh',
    'dose_rate_std_usvh', 'counts', 'live_time_s', 'integration_time_s', 'saturated', 'model',
)  # fmt: skip


class SpoolError(RadiationError):
    """The file cannot be read or written."""


class ReadingSpool:
    """Keeps readings in ``readings.csv`` of a directory; with an empty name, keeps none."""

    def __init__(self, directory: str) -> None:
        self._path = Path(directory) / FILE_NAME if directory else None
        self._stream: IO[str] | None = None

    def restored(self) -> Iterator[FlightReading]:
        """Yield the readings that were kept before.

        Raises
        ------
        SpoolError
            If there is a file that cannot be read.
        """
        if self._path is None or not self._path.exists():
            return
        try:
            with self._path.open(encoding='utf-8', newline='') as stream:
                # A row that was cut off has no end of line.
                lines = [line for line in stream if line.endswith('\n')]
        except (OSError, UnicodeDecodeError) as error:
            raise SpoolError(f'{self._path}: cannot be read: {error}') from error
        for row in csv.DictReader(lines):
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
        if self._path is None:
            return
        try:
            if self._stream is None:
                self._stream = self._opened(self._path)
            csv.writer(self._stream, lineterminator='\n').writerow(_row(reading))
            self._stream.flush()
        except OSError as error:
            raise SpoolError(f'{self._path}: cannot be written: {error}') from error

    def _opened(self, path: Path) -> IO[str]:
        path.parent.mkdir(parents=True, exist_ok=True)
        content = path.read_bytes() if path.exists() else b''
        stream = path.open('a', encoding='utf-8', newline='')
        if not content:
            csv.writer(stream, lineterminator='\n').writerow(COLUMNS)
        elif not content.endswith(b'\n'):
            stream.write('\n')
        return stream


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
