# SPDX-License-Identifier: Apache-2.0
"""The table of all dose-rate readings, ``readings.csv``."""

import csv
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_orchestrator.products.run_record import Reading
from rocsafe_orchestrator.products.summary import utc_text

COLUMNS = (
    ('time_utc', 'end of the measurement, ISO 8601, UTC'),
    ('time_ns', 'the same, nanoseconds since 1970-01-01T00:00:00Z'),
    ('vehicle', 'name of the vehicle'),
    ('latitude_deg', 'WGS84, degrees, north positive'),
    ('longitude_deg', 'WGS84, degrees, east positive'),
    ('altitude_m', 'metres above the WGS84 ellipsoid'),
    ('east_m', 'metres east of the mission origin'),
    ('north_m', 'metres north of the mission origin'),
    ('up_m', 'metres above the mission origin'),
    ('dose_rate_usvh', 'ambient dose equivalent rate, microsievert per hour'),
    ('dose_rate_std_usvh', 'its standard deviation, 0 for an ideal detector'),
    ('counts', 'raw counts of the detector, 0 if it does not count'),
    ('live_time_s', 'seconds counted, empty if it does not count'),
    ('model', 'field model of a simulated reading'),
    ('saturated', '1: the dose rate is only a lower limit'),
)


def write_readings(path: Path, readings: Sequence[Reading], frame: LocalFrame | None) -> None:
    """Write `readings` as CSV (RFC 4180, UTF-8), one row each, with a row of column names.

    Unknown values are empty; without `frame` east, north and up are empty. Positions are rounded
    to a millimetre, dose rates have all digits that restore the same number.
    """
    places = _places(readings, frame)
    with path.open('w', encoding='utf-8', newline='') as stream:
        table = csv.writer(stream, lineterminator='\n')
        table.writerow(name for name, _ in COLUMNS)
        for reading, enu in zip(readings, places, strict=True):
            table.writerow(_row(reading, enu))


def _places(readings: Sequence[Reading], frame: LocalFrame | None) -> Sequence[Sequence[float]]:
    if frame is None or not readings:
        return [(math.nan,) * 3] * len(readings)
    columns = np.array([(r.latitude_deg, r.longitude_deg, r.altitude_m) for r in readings]).T
    enu: Sequence[Sequence[float]] = frame.to_enu(*columns).tolist()
    return enu


def _row(reading: Reading, enu: Sequence[float]) -> list[object]:
    return [
        utc_text(reading.time_ns),
        reading.time_ns,
        reading.vehicle,
        _number(reading.latitude_deg, 9),
        _number(reading.longitude_deg, 9),
        _number(reading.altitude_m, 3),
        *(_number(value, 3) for value in enu),
        _exact(reading.dose_rate_usvh),
        _exact(reading.dose_rate_std_usvh),
        reading.counts,
        _exact(reading.live_time_s),
        reading.model,
        int(reading.saturated),
    ]


def _number(value: float, digits: int) -> str:
    return f'{value:.{digits}f}' if math.isfinite(value) else ''


def _exact(value: float) -> str:
    return repr(value) if math.isfinite(value) else ''
