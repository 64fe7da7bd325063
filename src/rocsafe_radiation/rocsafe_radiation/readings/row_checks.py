# SPDX-License-Identifier: Apache-2.0
"""Rows of a survey file that cannot be, by themselves or beside the others."""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray, IndexArray
from rocsafe_hazard.value_runs import are_again, are_at_top
from rocsafe_radiation.readings.calibration import calibration_of

# No detector reads more, no vehicle of a survey flies higher or farther.
RANGES = {
    'latitude_deg': (-90.0, 90.0),
    'longitude_deg': (-180.0, 180.0),
    'east_m': (-1e6, 1e6),
    'north_m': (-1e6, 1e6),
    'altitude_m': (-1e3, 2e4),
    'up_m': (-1e3, 2e4),
    'dose_rate_usvh': (0.0, 1e12),
    'dose_rate_std_usvh': (0.0, 1e12),
    'counts': (0.0, 1e12),
    'live_time_s': (1e-6, 1e6),
    'reference_counts': (0.0, 1e12),
}
ANY = (-math.inf, math.inf)
METRES_A_DEGREE = 111_000.0
# Places so many times as far from the middle as half of all, and so far, are errors.
FAR_MEDIANS, FAR_M = 20.0, 1000.0
# So many readings in a row without a single count show a detector that is switched off or broken,
# if half of the others have so many counts.
FEWEST_EMPTY, FEWEST_COUNTS = 8, 5.0
# Probability that two readings in a row have equal counts, of so many; less of more. That of the
# difference 0 of two Poisson numbers (Skellam 1946).
ALIKE_BY_CHANCE = 0.128
# Units of dose rates differ by 1000 or more; responses of one detector differ by less than this.
LARGEST_RATIO = 300.0
# Lesser steps, beside a true source, for each one of such a ratio.
FEWEST_BETWEEN = 0.1


def out_of_range(values: Mapping[str, float]) -> str:
    """Return which of the named values is out of its range, and the range, or nothing."""
    for name, value in values.items():
        low, high = RANGES.get(name, ANY)
        if value < low or value > high:
            return f'{name} is not within {low:g} and {high:g}'
    return ''


def from_middle_m(places: FloatArray, is_geodetic: bool) -> FloatArray:
    """Return places (n, 2), degrees or metres, as ways from the middle of all, metres (n, 2)."""
    if not len(places):
        return np.zeros((0, 2))
    middle = np.median(places, axis=0)
    ways = places - middle
    if is_geodetic:
        ways[:, 1] = (ways[:, 1] + 180.0) % 360.0 - 180.0
        ways *= METRES_A_DEGREE * np.array([1.0, np.cos(np.radians(middle[0]))])
    return np.asarray(ways)


def far(places: FloatArray, is_geodetic: bool) -> BoolArray:
    """Return which places (n, 2), degrees or metres, lie far from the middle of all, (n,)."""
    if not len(places):
        return np.zeros(0, dtype=bool)
    distances = np.hypot(*from_middle_m(places, is_geodetic).T)
    limit = max(FAR_M, FAR_MEDIANS * float(np.median(distances)))
    return np.asarray(distances > limit, dtype=bool)


def dead(vehicles: Sequence[str], amounts: FloatArray) -> BoolArray:
    """Return which readings (n,) are of a detector that reads nothing but 0, always or for a time.

    Nature gives counts everywhere: a detector without any proves no absence of sources.

    Parameters
    ----------
    vehicles : n names
        Of each reading.
    amounts : shape (n,)
        Counts, or the dose rate where the detector does not count.
    """
    found = np.zeros(len(amounts), dtype=bool)
    for rows in rows_by_vehicle(vehicles):
        own = amounts[rows]
        others = own[own > 0.0]
        if not others.size or np.median(others) >= FEWEST_COUNTS:
            found[rows] = _in_long_runs(own == 0.0)
    return found


def dead_caveats(count: int) -> tuple[str, ...]:
    """Return what is to be said of so many readings of a dead detector."""
    return (f'{count} readings are of a dead detector: nothing is known there',) if count else ()


def repeated(
    vehicles: Sequence[str], counts: FloatArray, rates: FloatArray, places_m: FloatArray
) -> BoolArray:
    """Return which readings (n,) are the one before again: read too often, or stuck.

    Parameters
    ----------
    vehicles : n names
        Of each reading.
    counts, rates : shape (n,)
        Counts, which are alike by chance now and then; where there are none, dose rates.
    places_m : shape (n, 2)
        East and north, or north and east, from any place.
    """
    found = np.zeros(len(counts), dtype=bool)
    for rows in rows_by_vehicle(vehicles):
        own = counts[rows]
        if not own.any():
            steps_m = np.hypot(*np.diff(places_m[rows], axis=0, prepend=places_m[rows][:1]).T)
            found[rows] = are_again(rates[rows], steps_m)
            continue
        alike = np.concatenate([[False], np.diff(own) == 0.0])
        by_chance = ALIKE_BY_CHANCE * len(own)
        if np.median(own) >= FEWEST_COUNTS and alike.sum() > by_chance + 5.0 * by_chance**0.5:
            found[rows] = alike
    return found


def at_top(vehicles: Sequence[str], amounts: FloatArray) -> BoolArray:
    """Return which amounts (n,), counts or dose rates, are the largest that a detector shows."""
    found = np.zeros(len(amounts), dtype=bool)
    for rows in rows_by_vehicle(vehicles):
        found[rows] = are_at_top(amounts[rows])
    return found


def repeat_caveats(count: int) -> tuple[str, ...]:
    """Return what is to be said of so many readings that are those before again."""
    return (f'{count} readings are those before again: read too often, or stuck',) if count else ()


def of_other_units(
    vehicles: Sequence[str], counts: FloatArray, live_s: FloatArray, rates: FloatArray
) -> BoolArray:
    """Return where counts for a dose rate are not at all those of the other rows, (n,).

    All arrays have shape (n,). Rows without counts or without a dose rate agree with all.
    """
    found = np.zeros(len(counts), dtype=bool)
    for rows in rows_by_vehicle(vehicles):
        own = counts[rows], live_s[rows], rates[rows]
        dark_cps = calibration_of(*own).dark_rate_cps
        with np.errstate(divide='ignore', invalid='ignore', over='ignore'):
            responses = np.log((own[0] / own[1] - dark_cps) / own[2])
        known = np.isfinite(responses)
        if known.any():
            misses = responses[known] - np.median(responses[known])
            found[rows[known]] = np.abs(misses) > math.log(LARGEST_RATIO)
    return found


def jumping(vehicles: Sequence[str], rates: FloatArray) -> BoolArray:
    """Return which dose rates (n,) differ from most others by sudden steps as of another unit.

    The dose rate near a source rises over some readings. From one reading to the next it is 300
    times as high, or a 300th, with few lesser steps: the unit is another from there on.
    """
    levels = np.zeros(len(rates), np.int64)
    sudden, lesser = 0, 0
    for rows in rows_by_vehicle(vehicles):
        own = rows[rates[rows] > 0.0]
        steps = np.diff(np.log(rates[own]))
        are_far = np.abs(steps) > math.log(LARGEST_RATIO)
        sudden += int(are_far.sum())
        lesser += int((np.abs(steps) > math.log(LARGEST_RATIO) / 2.0).sum() - are_far.sum())
        levels[own[1:]] = np.cumsum(np.sign(steps) * are_far)
        levels[own] -= np.int64(np.median(levels[own])) if own.size else 0
    return np.asarray((levels != 0) & (lesser < FEWEST_BETWEEN * sudden), dtype=bool)


def rows_by_vehicle(vehicles: Sequence[str]) -> Iterator[IndexArray]:
    """Yield the rows of each vehicle."""
    _, owner = np.unique(np.array(vehicles, dtype=str), return_inverse=True)
    order = np.argsort(owner, kind='stable')
    yield from np.split(order, np.flatnonzero(np.diff(owner[order])) + 1)


def _in_long_runs(empty: BoolArray) -> BoolArray:
    """Return which of n readings are one of many empty ones in a row, (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], empty.astype(np.int8), [0]])))
    starts, stops = edges[::2], edges[1::2]
    is_long = stops - starts >= FEWEST_EMPTY
    marks = np.zeros(len(empty) + 1, np.int64)
    np.add.at(marks, starts[is_long], 1)
    np.add.at(marks, stops[is_long], -1)
    return np.asarray(np.cumsum(marks)[:-1] > 0, dtype=bool)
