# SPDX-License-Identifier: Apache-2.0
"""When and how readings were flown past: vehicles, times, velocities, and legs."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray

LEG_S, LEG_GROWTH, LEG_SCALES, MOST_LEGS, LENGTH_STEP = 20.0, 4.0, 3, 60, 1.25
# Times that are further apart, 30 years, are no times of one survey.
LONGEST_S = 1e9
# The velocity is the way from the mean fix of so many seconds before to that of as many after, or
# from one fix to the next: fixes that are off by 1.5 m each second tell it to 0.6 m/s.
VELOCITY_S = 2.0
# No vehicle of a survey is faster: such steps are errors of the fixes.
FASTEST_MPS = 100.0
SIDES: tuple[Literal['left', 'right'], ...] = ('left', 'right')


@dataclass(frozen=True, slots=True, kw_only=True)
class Flight:
    """How n readings were flown past.

    Attributes
    ----------
    vehicles
        Number of the vehicle of each, from 0, shape (n,).
    times_s
        Seconds since the first, shape (n,).
    velocities_mps
        Towards east, north and up, shape (n, 3).
    legs
        Stretches of flight, over which errors of the fixes are alike, of several lengths, numbered
        from 0, shape (n, scales).
    """

    vehicles: IndexArray
    times_s: FloatArray
    velocities_mps: FloatArray
    legs: IndexArray

    def only(self, rows: IndexArray) -> 'Flight':
        """Return the flight past some readings, by their numbers."""
        return Flight(
            vehicles=self.vehicles[rows],
            times_s=self.times_s[rows],
            velocities_mps=self.velocities_mps[rows],
            legs=self.legs[rows],
        )

    def merged(self, owner: IndexArray, first: IndexArray, weights: FloatArray) -> 'Flight':
        """Return the flight past cells of readings.

        Parameters
        ----------
        owner, weights : shape (n,)
            Cell and weight of each reading.
        first : shape (cells,)
            A reading of each cell.
        """
        sums = np.bincount(owner, weights)
        columns = (self.times_s, *self.velocities_mps.T)
        means = [np.bincount(owner, weights * column) / sums for column in columns]
        return Flight(
            vehicles=self.vehicles[first],
            times_s=np.asarray(means[0], np.float64),
            velocities_mps=np.stack(means[1:], axis=1),
            legs=self.legs[first],
        )


def flight_of(vehicles: Sequence[str], times_s: FloatArray, places_m: FloatArray) -> Flight | None:
    """Return the flight past readings; None if the times are not known, or of too many vehicles.

    Legs of the first scale are `LEG_S` long, or longer if there were more than `MOST_LEGS`, those
    of each further scale `LEG_GROWTH` times as long. All have numbers of their own.

    Parameters
    ----------
    vehicles : n names
        Of each reading.
    times_s : shape (n,)
        Seconds since any moment, NaN if not known.
    places_m : shape (n, 3)
        Places as the fixes tell them.
    """
    if not len(times_s) or not np.ptp(times_s) < LONGEST_S:
        return None
    names = np.asarray(np.unique(np.asarray(vehicles), return_inverse=True)[1], np.intp)
    if names.max() >= MOST_LEGS:
        return None
    length_s, since_s = LEG_S, times_s - times_s.min()
    while _numbered(names, since_s, length_s).max() >= MOST_LEGS:
        length_s *= LENGTH_STEP
    scales, count = [], 0
    for scale in range(LEG_SCALES):
        scales.append(count + _numbered(names, since_s, length_s * LEG_GROWTH**scale))
        count = int(scales[-1].max()) + 1
    return Flight(
        vehicles=names,
        times_s=since_s,
        velocities_mps=_velocities(names, since_s, places_m),
        legs=np.stack(scales, axis=1),
    )


def _numbered(names: IndexArray, since_s: FloatArray, length_s: float) -> IndexArray:
    """Return the number, from 0, of the stretch of time and the vehicle of each reading."""
    steps = np.floor(since_s / length_s).astype(np.intp)
    return np.asarray(
        np.unique(names * (steps.max() + 1) + steps, return_inverse=True)[1], np.intp
    )


def _velocities(names: IndexArray, times_s: FloatArray, places_m: FloatArray) -> FloatArray:
    """Return the velocity at each reading, shape (n, 3)."""
    # Vehicles one after the other, so far apart in time that no window holds two of them.
    apart_s = times_s + names * (times_s.max() + 10.0 * VELOCITY_S)
    order = np.argsort(apart_s, kind='stable')
    times, numbers = apart_s[order], np.arange(len(order))
    first, last = (np.searchsorted(names[order], names[order], side) for side in SIDES)
    before = np.searchsorted(times, times - VELOCITY_S)
    after = np.searchsorted(times, times + VELOCITY_S, side='right')
    before = np.maximum(np.minimum(before, numbers - 1), first)
    after = np.minimum(np.maximum(after, numbers + 2), last)
    passed_s = _means(times, numbers, after) - _means(times, before, numbers + 1)
    found: FloatArray = np.zeros((len(order), 3))
    for axis, places in enumerate((places_m - places_m.mean(axis=0))[order].T):
        ways = _means(places, numbers, after) - _means(places, before, numbers + 1)
        with np.errstate(divide='ignore', invalid='ignore'):
            speeds = ways / passed_s
        found[order, axis] = np.where(np.abs(speeds) < FASTEST_MPS, speeds, 0.0)
    return found


def _means(values: FloatArray, low: IndexArray, high: IndexArray) -> FloatArray:
    """Return the means of values from index `low` up to before `high`."""
    totals = np.concatenate([[0.0], np.cumsum(values, dtype=np.longdouble)])
    return np.asarray((totals[high] - totals[low]) / (high - low), np.float64)
