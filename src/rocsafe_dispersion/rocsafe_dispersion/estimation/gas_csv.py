# SPDX-License-Identifier: Apache-2.0
"""Readings of gas with the wind from a CSV file, whose header names units and conventions.

Columns: a place (``latitude_deg`` and ``longitude_deg``, or ``east_m`` and ``north_m``),
``height_m`` above the ground, a concentration (``value_g_m3``, ``value_mg_m3``, or ``value_ppm``
of a named agent; of particles ``value_per_m3`` or ``value_per_l``, or a ``count`` in so many
``litres`` of air), and the wind (``wind_towards_east_mps`` and ``wind_towards_north_mps``, or
``wind_speed_mps`` and ``wind_from_deg``). Rows without a value or a wind, and those in calm air
where most are not, are left out. If given: ``time_s``, the noise in the unit of the
values (``std_g_m3``, ``std_mg_m3`` or ``std_ppm``), ``limit`` (``below`` or ``above``: the value
is only a bound; without this column, values that pile up at an end of the scale are; counts are
none) and
``instrument``, whose readings share a background. Readings that are means
along beams have the other end of each, as well: ``to_height_m``, and ``to_latitude_deg`` and
``to_longitude_deg``, or ``to_east_m`` and ``to_north_m``. Other columns are not read.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from rocsafe_dispersion.estimation.amount import (
    GRAMS,
    L_PER_M3,
    PARTICLES,
    counted_per_m3,
)
from rocsafe_dispersion.estimation.fluctuating_plume import LEAST_SPEED_MPS
from rocsafe_dispersion.estimation.gas_survey import LARGEST_READINGS, GasSurvey, usual_noise
from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.limits import require_between
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.storage.csv_rows import Row, column, has_all, read_table
from rocsafe_geo.wind.anemometer_file import WIND, is_vector_record, wind_of
from rocsafe_hazard.value_runs import are_again, are_at_top

GEODETIC, LOCAL = ('latitude_deg', 'longitude_deg'), ('east_m', 'north_m')
# Columns of the other end of a beam begin with it.
TO = 'to_'
# A beam is a sum over so many places along it, those of Gauss.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)
LIMITS = ('', 'below', 'above')
# Units of readings, g/m^3; what ppm are depends on the gas. Those of particles, 1/m^3.
UNITS = {'g_m3': 1.0, 'mg_m3': 1e-3, 'ppm': math.nan}
OF_PARTICLES = {'per_m3': 1.0, 'per_l': L_PER_M3}
COUNT, LITRES, LARGEST_COUNT, MOST_LITRES = 'count', 'litres', 1e13, 1e6
LARGEST_EXTENT_M = 20_000.0
LONGEST_BEAM_M = 500.0
MOST_NAMED = 5
# Readings and their noise, in the unit of the file: beyond, they are no concentrations.
LEAST_NOISE, LARGEST_VALUE = 1e-15, 1e9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GasFile:
    """The survey of a file.

    Attributes
    ----------
    survey
        Its readings.
    frame
        Of their places; None where these are east and north already.
    notes
        What was left out of the file, in words.
    """

    survey: GasSurvey
    frame: LocalFrame | None
    notes: tuple[str, ...] = ()


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
    return read_table(path, lambda rows: _gas_file(rows, g_m3_of_ppm), LARGEST_READINGS)


def _gas_file(rows: Sequence[Row], g_m3_of_ppm: Callable[[float], float] | None) -> GasFile:
    names = set(rows[0])
    unit, factor = _unit(names, g_m3_of_ppm)
    is_count = unit == COUNT
    rows, notes = _with_all(rows, names, (COUNT, LITRES) if is_count else (f'value_{unit}',))
    places, weights, frame = _places(rows, names)
    limits = [_limit(row) for row in rows]
    values, std = _counted(rows) if is_count else _measured(rows, names, unit, factor)
    survey = GasSurvey(
        places_m=places,
        weights=weights,
        wind_towards_mps=_winds(rows, names),
        values_g_m3=values,
        std_g_m3=std,
        is_below=np.array([limit == 'below' for limit in limits]),
        is_above=np.array([limit == 'above' for limit in limits]),
        times_s=(
            column(rows, 'time_s') if 'time_s' in names else np.arange(len(rows), dtype=float)
        ),
        instruments=_instruments(rows, names),
        has_times='time_s' in names,
        amount=PARTICLES if is_count or unit in OF_PARTICLES else GRAMS,
    )
    if not is_count and 'limit' not in names:
        survey, ends = _with_ends(survey)
        notes += ends
    again = _of_each_instrument(survey, are_again)
    if not is_count and again.any():
        # Values that repeat the one before hide the noise.
        survey = replace(survey, std_g_m3=_stds(rows, names, unit, factor, values[~again]))
        survey = survey.only(~again)
        notes.append(f'{again.sum()} readings left out: as before, read too often or stuck')
    calm = survey.speeds_mps < LEAST_SPEED_MPS
    if calm.any() and calm.mean() < 0.5:
        survey = survey.only(~calm)
        notes.append(f'{calm.sum()} readings left out: the wind is below {LEAST_SPEED_MPS:g} m/s')
    return GasFile(survey=survey, frame=frame, notes=tuple(notes))


def _with_all(
    rows: Sequence[Row], names: set[str], value: tuple[str, ...]
) -> tuple[Sequence[Row], list[str]]:
    """Return the rows that have a value and a wind, and notes of the others.

    Raises
    ------
    ValueError
        If there is none.
    """
    notes: list[str] = []
    for what, columns in (('value', value), ('wind', WIND[is_vector_record(names)])):
        kept = [row for row in rows if has_all(row, columns)]
        if not kept:
            raise ValueError(f'no row has a {what} ({" and ".join(columns)}): one must')
        if len(kept) < len(rows):
            lines = [row.line for row in rows if not has_all(row, columns)]
            named = ', '.join(map(str, lines[:MOST_NAMED]))
            more = ' and more' if len(lines) > MOST_NAMED else ''
            notes.append(f'{len(lines)} readings left out: no {what} (lines {named}{more})')
        rows = kept
    return rows, notes


def _with_ends(survey: GasSurvey) -> tuple[GasSurvey, list[str]]:
    """Return the survey with readings at the ends of a detector's scale as bounds, and notes."""
    lowest = _of_each_instrument(survey, lambda values: are_at_top(-values))
    survey = replace(survey, is_below=lowest)
    highest = _of_each_instrument(survey, are_at_top)
    notes = [
        f'{are.sum()} readings are the {end} that the detector shows: taken as bounds'
        for end, are in (('least', lowest), ('most', highest))
        if are.any()
    ]
    return replace(survey, is_above=highest), notes


def _of_each_instrument(
    survey: GasSurvey, found_in: Callable[[FloatArray], BoolArray]
) -> BoolArray:
    """Return what is found in the values of each instrument, in the order of their times, (n,)."""
    found = np.zeros(len(survey.values_g_m3), dtype=bool)
    order = np.argsort(survey.times_s, kind='stable')
    order = order[~(survey.is_below | survey.is_above)[order]]
    for instrument in np.unique(survey.instruments).tolist():
        own = order[survey.instruments[order] == instrument]
        found[own] = found_in(survey.values_g_m3[own])
    return found


def _unit(names: set[str], g_m3_of_ppm: Callable[[float], float] | None) -> tuple[str, float]:
    """Return the unit of the values and what one of it is, g/m^3."""
    units = UNITS | OF_PARTICLES | {COUNT: 1.0}
    columns = {unit: unit if unit == COUNT else f'value_{unit}' for unit in units}
    given = [unit for unit, name in columns.items() if name in names]
    if len(given) != 1:
        told = ', '.join(columns.values())
        raise ValueError(f'has {len(given)} of the columns {told}: must have one')
    if given[0] == COUNT and LITRES not in names:
        raise ValueError(f'has {COUNT}: a column {LITRES} must tell in how much air')
    if given[0] in (*OF_PARTICLES, COUNT) and g_m3_of_ppm is not None:
        raise ValueError('counts particles: no agent may be named')
    if given[0] != 'ppm':
        return given[0], units[given[0]]
    if g_m3_of_ppm is None:
        raise ValueError('has value_ppm: name the agent, whose molar mass converts it')
    return 'ppm', g_m3_of_ppm(1.0)


def _places(
    rows: Sequence[Row], names: set[str]
) -> tuple[FloatArray, FloatArray, LocalFrame | None]:
    """Return the points of readings (n, k, 3), their weights (k,), and the frame of a globe."""
    is_local = names >= set(LOCAL)
    if is_local == (names >= set(GEODETIC)):
        raise ValueError(f'needs either {" and ".join(GEODETIC)}, or {" and ".join(LOCAL)}')
    frame = None if is_local else LocalFrame(_middle(rows))
    starts = _ends(rows, frame, '')
    _check_extent(rows, starts)
    if not any(name.startswith(TO) for name in names):
        return starts[:, None], np.ones(1), frame
    along = _ends(rows, frame, TO) - starts
    for row, length in zip(rows, np.hypot(along[:, 0], along[:, 1]).tolist(), strict=True):
        require_between(f'line {row.line}: length of the beam', length, 0.0, LONGEST_BEAM_M, 'm')
    shares = (_NODES + 1.0) / 2.0
    return starts[:, None] + shares[:, None] * along[:, None], _WEIGHTS / 2.0, frame


def _check_extent(rows: Sequence[Row], places_m: FloatArray) -> None:
    """Refuse places that are too far apart; name the row furthest from the middle ones."""
    if np.ptp(places_m[:, :2], axis=0).max() > LARGEST_EXTENT_M:
        away = np.abs(places_m[:, :2] - np.median(places_m[:, :2], axis=0)).max(axis=1)
        line = rows[int(away.argmax())].line
        raise ValueError(
            f'line {line}: is {away.max():.6g} m from most other readings: '
            f'all must be within {LARGEST_EXTENT_M:g} m'
        )


def _middle(rows: Sequence[Row]) -> GeoPosition:
    """Return a place amidst all, also where they lie on both sides of 180 degrees."""
    latitudes = _numbers(rows, 'latitude_deg', 90.0, 'degrees')
    longitudes = _numbers(rows, 'longitude_deg', 180.0, 'degrees')
    first = longitudes[0]
    offset = float(np.median((longitudes - first + 180.0) % 360.0 - 180.0))
    middle = (first + offset + 180.0) % 360.0 - 180.0
    return GeoPosition(float(np.median(latitudes)), float(middle), 0.0)


def _ends(rows: Sequence[Row], frame: LocalFrame | None, which: str) -> FloatArray:
    """Return the places of readings, or of the other ends of their beams, (n, 3)."""
    heights = [
        require_between(f'line {row.line}: {which}height_m', height, -5.0, 500.0, 'm')
        for row, height in zip(rows, column(rows, f'{which}height_m').tolist(), strict=True)
    ]
    if frame is None:
        east, north = (column(rows, which + name) for name in LOCAL)
    else:
        latitudes = _numbers(rows, f'{which}latitude_deg', 90.0, 'degrees')
        longitudes = _numbers(rows, f'{which}longitude_deg', 180.0, 'degrees')
        east, north, _ = frame.to_enu(latitudes, longitudes, np.zeros(len(rows))).T
    return np.column_stack([east, north, np.maximum(heights, 0.0)])


def _measured(
    rows: Sequence[Row], names: set[str], unit: str, factor: float
) -> tuple[FloatArray, FloatArray]:
    """Return concentrations and their noise, (n,)."""
    largest = LARGEST_COUNT if unit in OF_PARTICLES else LARGEST_VALUE
    values = factor * _numbers(rows, f'value_{unit}', largest)
    return values, _stds(rows, names, unit, factor, values)


def _counted(rows: Sequence[Row]) -> tuple[FloatArray, FloatArray]:
    """Return concentrations of particles and their noise, (n,), 1/m^3."""
    both = []
    for name, low, high in ((COUNT, 0.0, LARGEST_COUNT), (LITRES, 1e-6, MOST_LITRES)):
        both.append(column(rows, name))
        for row, value in zip(rows, both[-1].tolist(), strict=True):
            require_between(f'line {row.line}: {name}', value, low, high)
    return counted_per_m3(*both)


def _numbers(rows: Sequence[Row], name: str, limit: float, unit: str = '') -> FloatArray:
    """Return a column whose numbers lie between minus `limit` and `limit`."""
    found = column(rows, name)
    for row, value in zip(rows, found.tolist(), strict=True):
        require_between(f'line {row.line}: {name}', value, -limit, limit, unit)
    return found


def _winds(rows: Sequence[Row], names: set[str]) -> FloatArray:
    is_vector = is_vector_record(names)
    winds = [wind_of(row, is_vector=is_vector) for row in rows]
    return np.array([(wind.towards_east_mps, wind.towards_north_mps) for wind in winds])


def _stds(
    rows: Sequence[Row], names: set[str], unit: str, factor: float, values: FloatArray
) -> FloatArray:
    name = f'std_{unit}'
    if name not in names:
        if not values.any():
            raise ValueError(f'all values are 0: a column {name} must tell the noise')
        return np.full(len(rows), usual_noise(values))
    found = column(rows, name)
    for row, value in zip(rows, found.tolist(), strict=True):
        require_between(f'line {row.line}: {name}', value, LEAST_NOISE, LARGEST_VALUE)
    return factor * found


def _instruments(rows: Sequence[Row], names: set[str]) -> np.ndarray:  # type: ignore[type-arg]
    labels = [row['instrument'] if 'instrument' in names else '' for row in rows]
    numbers = {label: number for number, label in enumerate(dict.fromkeys(labels))}
    if len(numbers) > 100:
        raise ValueError(f'has {len(numbers)} instruments: must be at most 100')
    return np.array([numbers[label] for label in labels])


def _limit(row: Row) -> str:
    text = row.get('limit', '').strip().lower()
    if text not in LIMITS:
        raise ValueError(f'line {row.line}: limit is {text!r}: must be below, above or empty')
    return text
