# SPDX-License-Identifier: Apache-2.0
"""Readings of gas with the wind from a CSV file, whose header names units and conventions.

Columns: a place (``latitude_deg`` and ``longitude_deg``, or ``east_m`` and ``north_m``),
``height_m`` above the ground, a concentration (``value_g_m3``, or ``value_ppm`` of a named agent),
and the wind (``wind_towards_east_mps`` and ``wind_towards_north_mps``, or ``wind_speed_mps`` and
``wind_from_deg``). If given: ``time_s``, ``std_g_m3`` or ``std_ppm``, ``limit`` (``below`` or
``above``: the value is only a bound) and ``instrument``. Other columns are not read.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rocsafe_dispersion.estimation.gas_survey import LARGEST_READINGS, GasSurvey
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.limits import require_between, require_positive
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.storage.csv_rows import Row, column, read_table
from rocsafe_geo.wind.anemometer_file import FROM, VECTOR, is_vector_record
from rocsafe_geo.wind.wind_vector import wind_from

GEODETIC, LOCAL = ('latitude_deg', 'longitude_deg'), ('east_m', 'north_m')
LIMITS = ('', 'below', 'above')
# Without a column: noise as this share of the largest reading.
DEFAULT_NOISE_SHARE = 0.01
LARGEST_EXTENT_M = 20_000.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GasFile:
    """The survey of a file; the frame is None where its places are east and north already."""

    survey: GasSurvey
    frame: LocalFrame | None


def read_gas(path: Path, g_m3_of_ppm: Callable[[float], float] | None = None) -> GasFile:
    """Return the readings of a file.

    Parameters
    ----------
    path
        The file.
    g_m3_of_ppm
        Converts ppm, for files that have them.

    Raises
    ------
    ValueError
        In one line, naming file, line, column, value and limit.
    """
    return read_table(path, lambda rows: _gas_file(rows, g_m3_of_ppm))


def _gas_file(rows: Sequence[Row], g_m3_of_ppm: Callable[[float], float] | None) -> GasFile:
    if not 1 <= len(rows) <= LARGEST_READINGS:
        raise ValueError(f'has {len(rows)} readings: must be 1 to {LARGEST_READINGS}')
    names = set(rows[0])
    factor = _factor(names, g_m3_of_ppm)
    unit = 'g_m3' if 'value_g_m3' in names else 'ppm'
    places, frame = _places(rows, names)
    limits = [_limit(number, row) for number, row in enumerate(rows, 2)]
    values = factor * column(rows, f'value_{unit}')
    return GasFile(
        survey=GasSurvey(
            places_m=places[:, None],
            weights=np.ones(1),
            wind_towards_mps=_winds(rows, names),
            values_g_m3=values,
            std_g_m3=_stds(rows, names, unit, factor, values),
            is_below=np.array([limit == 'below' for limit in limits]),
            is_above=np.array([limit == 'above' for limit in limits]),
            times_s=(
                column(rows, 'time_s') if 'time_s' in names else np.arange(len(rows), dtype=float)
            ),
            instruments=_instruments(rows, names),
        ),
        frame=frame,
    )


def _factor(names: set[str], g_m3_of_ppm: Callable[[float], float] | None) -> float:
    given = {'value_g_m3', 'value_ppm'} & names
    if len(given) != 1:
        raise ValueError('needs exactly one of the columns value_g_m3 and value_ppm')
    if given == {'value_g_m3'}:
        return 1.0
    if g_m3_of_ppm is None:
        raise ValueError('has value_ppm: name the agent, whose molar mass converts it')
    return g_m3_of_ppm(1.0)


def _places(rows: Sequence[Row], names: set[str]) -> tuple[FloatArray, LocalFrame | None]:
    heights = np.array(
        [
            require_between(f'line {number}: height_m', height, -5.0, 500.0, 'm')
            for number, height in enumerate(column(rows, 'height_m').tolist(), 2)
        ]
    )
    if names >= set(LOCAL):
        east, north = (column(rows, name) for name in LOCAL)
        frame = None
    elif names >= set(GEODETIC):
        latitudes, longitudes = (column(rows, name) for name in GEODETIC)
        for number, (latitude, longitude) in enumerate(zip(latitudes, longitudes, strict=True), 2):
            require_between(f'line {number}: latitude_deg', latitude, -90.0, 90.0, 'degrees')
            require_between(f'line {number}: longitude_deg', longitude, -180.0, 180.0, 'degrees')
        middle = GeoPosition(float(np.median(latitudes)), float(np.median(longitudes)), 0.0)
        frame = LocalFrame(middle)
        east, north, _ = frame.to_enu(latitudes, longitudes, np.zeros(len(rows))).T
    else:
        raise ValueError(f'needs {" and ".join(GEODETIC)}, or {" and ".join(LOCAL)}')
    if max(np.ptp(east), np.ptp(north)) > LARGEST_EXTENT_M:
        raise ValueError(f'the places are more than {LARGEST_EXTENT_M:g} m apart')
    return np.column_stack([east, north, np.maximum(heights, 0.0)]), frame


def _winds(rows: Sequence[Row], names: set[str]) -> FloatArray:
    is_vector = is_vector_record(names)
    first, second = (column(rows, name) for name in (VECTOR if is_vector else FROM))
    if is_vector:
        return np.column_stack([first, second])
    winds = [wind_from(speed, angle) for speed, angle in zip(first, second, strict=True)]
    return np.array([(wind.towards_east_mps, wind.towards_north_mps) for wind in winds])


def _stds(
    rows: Sequence[Row], names: set[str], unit: str, factor: float, values: FloatArray
) -> FloatArray:
    if f'std_{unit}' not in names:
        largest = require_positive('largest value', float(np.abs(values).max()))
        return np.full(len(rows), DEFAULT_NOISE_SHARE * largest)
    return factor * column(rows, f'std_{unit}')


def _instruments(rows: Sequence[Row], names: set[str]) -> np.ndarray:  # type: ignore[type-arg]
    labels = [row['instrument'] if 'instrument' in names else '' for row in rows]
    numbers = {label: number for number, label in enumerate(dict.fromkeys(labels))}
    if len(numbers) > 100:
        raise ValueError(f'has {len(numbers)} instruments: must be at most 100')
    return np.array([numbers[label] for label in labels])


def _limit(number: int, row: Row) -> str:
    text = (row.get('limit') or '').strip().lower()
    if text not in LIMITS:
        raise ValueError(f'line {number}: limit is {text!r}: must be below, above or empty')
    return text
