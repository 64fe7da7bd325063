# SPDX-License-Identifier: Apache-2.0
"""Parcels of a release on their way with the wind, in fixed steps of time."""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import Travel, at_rows
from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_geo.limits import require_positive
from rocsafe_geo.wind.site_wind import SiteWind
from rocsafe_geo.wind.wind_field import WindField


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Parcels:
    """Parcels at one time.

    Attributes
    ----------
    numbers : (n,)
        Number of the step of time in which each left.
    places_m : (n, 2)
        East and north of their middles, metres.
    distances_m : (n,)
        How far each has travelled, metres.
    headings : (n, 2)
        Unit vectors of the way they go, east and north.
    masses_g : (n,)
        What is still in the air of each, g.
    """

    numbers: IndexArray
    places_m: FloatArray
    distances_m: FloatArray
    headings: FloatArray
    masses_g: FloatArray


class Carriers:
    """Moves the parcels of one release; the state at a time is a function of that time alone.

    Steps begin at whole multiples of their length, and parcels older than `longest_s` are left
    out: after a restart the same parcels are at the same places. On a site a parcel moves with
    the mean of the wind across its own width, and grows as it would in the open wind: one that is
    caught behind a house grows until the wind beside the house takes it along.
    """

    def __init__(
        self,
        release: Release,
        travel: Travel,
        wind: WindField,
        step_s: float,
        longest_s: float = 3600.0,
    ) -> None:
        self._release, self._travel, self._wind = release, travel, wind
        self._is_site = isinstance(wind, SiteWind)
        self._open_wind = wind.open_wind if isinstance(wind, SiteWind) else wind
        self._step_s = require_positive('step_s', step_s, 's')
        self._kept = math.ceil(require_positive('longest_s', longest_s, 's') / step_s)
        self._reset(math.floor(release.start_s / step_s))

    def at(self, time_s: float) -> Parcels:
        """Return the parcels at the end of the last whole step before `time_s`."""
        last = math.floor(time_s / self._step_s + 1e-9)
        first = max(last - self._kept, math.floor(self._release.start_s / self._step_s))
        if last < self._next or first > self._next:
            self._reset(first)
        while self._next < last:
            self._advance()
        return self._parcels(max(first - self._first, 0))

    def _reset(self, first: int) -> None:
        self._first = self._next = first
        self._places: FloatArray = np.zeros((0, 2))
        self._headings: FloatArray = np.zeros((0, 2))
        self._distances: FloatArray = np.zeros(0)
        self._released: FloatArray = np.zeros(0)

    def _advance(self) -> None:
        """Release the parcel of one step, in its middle, and move all to its end."""
        begin_s = self._next * self._step_s
        ends = np.array([begin_s, begin_s + self._step_s])
        before, after = self._release.released_g(ends)
        place = self._release.places_m(ends.mean(keepdims=True))
        self._places = np.concatenate([self._places, place])
        self._headings = np.concatenate([self._headings, np.zeros((1, 2))])
        self._distances = np.append(self._distances, 0.0)
        self._released = np.append(self._released, after - before)
        durations = np.full(len(self._distances), self._step_s)
        durations[-1] /= 2.0
        self._move(begin_s + self._step_s / 2.0, durations)
        self._next += 1
        if len(self._distances) > 2 * self._kept:
            self._drop(len(self._distances) - self._kept)

    def _drop(self, count: int) -> None:
        self._first += count
        self._places, self._headings = self._places[count:], self._headings[count:]
        self._distances, self._released = self._distances[count:], self._released[count:]

    def _move(self, time_s: float, durations_s: FloatArray) -> None:
        rows = self._travel.rows(self._distances)
        heights = at_rows(self._travel.wind_heights_m, rows)
        velocities = self._open_wind.velocities_mps(
            time_s, np.column_stack([self._places, heights])
        )
        speeds = np.hypot(velocities[:, 0], velocities[:, 1])
        if self._is_site:
            velocities = self._across(time_s, heights, at_rows(self._travel.sigma_y_m, rows))
        lengths = np.hypot(velocities[:, 0], velocities[:, 1])
        self._headings = velocities[:, :2] / np.maximum(lengths, 1e-9)[:, None]
        self._places = self._places + velocities[:, :2] * durations_s[:, None]
        self._distances = self._distances + speeds * durations_s

    def _across(self, time_s: float, heights: FloatArray, sigmas: FloatArray) -> FloatArray:
        """Return the wind at the parcels, the mean of three places across them, (n, 3)."""
        side = sigmas[:, None] * np.column_stack([-self._headings[:, 1], self._headings[:, 0]])
        places = [self._places, self._places - side, self._places + side]
        rows = np.concatenate([np.column_stack([each, heights]) for each in places])
        found = self._wind.velocities_mps(time_s, rows)
        return np.asarray(found.reshape(3, -1, 3).mean(axis=0))

    def _parcels(self, skipped: int) -> Parcels:
        own = np.flatnonzero(self._released[skipped:] > 0.0) + skipped
        rows = self._travel.rows(self._distances[own])
        return Parcels(
            numbers=own + self._first,
            places_m=self._places[own],
            distances_m=self._distances[own],
            headings=self._headings[own],
            masses_g=self._released[own] * at_rows(self._travel.airborne, rows),
        )
