# SPDX-License-Identifier: Apache-2.0
"""Motion along a sequence of straight legs."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.motion.corner import overlap_s
from rocsafe_geo.motion.leg import solve_legs
from rocsafe_geo.motion.leg_table import LegTable
from rocsafe_geo.motion.limits import MotionLimits
from rocsafe_geo.motion.state import STILL, Enu, MotionState


@dataclass(frozen=True, slots=True, kw_only=True)
class Way:
    """A leg with the stand at its end.

    Attributes
    ----------
    end_enu
        End of the leg, metres.
    limits
        Limits along the leg.
    stand_s
        Time at its end, seconds; may be infinite.
    is_passed
        Whether the vehicle passes the end without a stop, which rounds the corner.
    """

    end_enu: Enu
    limits: MotionLimits
    stand_s: float = 0.0
    is_passed: bool = False

    def __post_init__(self) -> None:
        if self.is_passed and self.stand_s > 0.0:
            raise ValueError(f'stand_s is {self.stand_s:g} s where is_passed: must be 0')


class RouteMotion:
    """Motion along legs, from standstill to standstill.

    Parameters
    ----------
    start_enu
        Start of the first leg, metres.
    ways
        Legs, at least one; the end of the last is not passed.
    corner_radius_m
        Distance from a passed corner in the middle of the turn, metres.

    Attributes
    ----------
    arrivals_s
        Time at which the end of each leg is reached, seconds; if passed, the middle of the turn.
    departures_s
        Time at which it is left, seconds.
    """

    def __init__(self, start_enu: Enu, ways: Sequence[Way], corner_radius_m: float) -> None:
        places = np.array([start_enu, *(way.end_enu for way in ways)], dtype=np.float64)
        path = np.diff(places, axis=0)
        distance = np.sqrt((path**2).sum(axis=1))
        self._table = LegTable(solve_legs(distance, _limits(ways)))
        unit = np.divide(
            path, distance[:, None], out=np.zeros_like(path), where=distance[:, None] > 0.0
        )
        self._places: list[Enu] = [(e, n, u) for e, n, u in places.tolist()]
        self._units: list[Enu] = [(e, n, u) for e, n, u in unit.tolist()]
        self._level: list[float] = np.hypot(unit[:, 0], unit[:, 1]).tolist()
        self._level_m: list[float] = [0.0, *np.cumsum(np.hypot(path[:, 0], path[:, 1])).tolist()]
        self._distances: list[float] = distance.tolist()
        overlaps = self._overlaps(ways, corner_radius_m)
        self._schedule(ways, overlaps)
        self._arrays = (places, unit, distance)

    @property
    def duration_s(self) -> float:
        """Time at which the last stand ends, seconds."""
        return self.departures_s[-1]

    @property
    def places_enu(self) -> list[Enu]:
        """Begins and ends of the legs; the motion stays within their convex hull."""
        return self._places

    @property
    def distance_m(self) -> float:
        """Horizontal length of all legs."""
        return self._level_m[-1]

    @property
    def knots_s(self) -> list[float]:
        """Times between which the motion is a polynomial, ascending from 0."""
        begins = (np.array(self._begins)[:, None] + self._table.begin_s).ravel()
        return sorted({*begins.tolist(), *self._ends})

    def state(self, elapsed_s: float) -> MotionState:
        """Return the motion at a time."""
        leg = max(0, bisect_right(self._begins, elapsed_s) - 1)
        here = self._part(leg, elapsed_s)
        if leg == 0 or elapsed_s >= self._ends[leg - 1]:
            return here
        before, corner = self._part(leg - 1, elapsed_s), self._places[leg]
        (e, n, u), (e1, n1, u1) = here.position_enu, before.position_enu
        return MotionState(
            (e + e1 - corner[0], n + n1 - corner[1], u + u1 - corner[2]),
            _sum(here.velocity_enu, before.velocity_enu),
            _sum(here.acceleration_enu, before.acceleration_enu),
        )

    def progress_m(self, elapsed_s: float) -> float:
        """Return the horizontal distance covered until a time, measured along the legs."""
        leg = max(0, bisect_right(self._begins, elapsed_s) - 1)
        progress = self._level_m[leg] + self._level[leg] * self._along(leg, elapsed_s)
        if leg and elapsed_s < self._ends[leg - 1]:
            left = self._distances[leg - 1] - self._along(leg - 1, elapsed_s)
            progress -= self._level[leg - 1] * left
        return progress

    def positions(self, times_s: FloatArray) -> FloatArray:
        """Return (east, north, up) at times (k,), shape (k, 3)."""
        places, unit, distance = self._arrays
        begins, ends = np.array(self._begins), np.array(self._ends)
        leg = np.maximum(0, np.searchsorted(begins, times_s, side='right') - 1)
        along = self._table.progress_m(leg, times_s - begins[leg])
        positions: FloatArray = places[leg] + along[:, None] * unit[leg]
        before = np.maximum(0, leg - 1)
        turns = np.flatnonzero((leg > 0) & (times_s < ends[before]))
        if len(turns):
            late = before[turns]
            flown = self._table.progress_m(late, times_s[turns] - begins[late])
            positions[turns] -= (distance[late] - flown)[:, None] * unit[late]
        return positions

    def _along(self, leg: int, elapsed_s: float) -> float:
        return self._table.at(leg, elapsed_s - self._begins[leg])[0]

    def _part(self, leg: int, elapsed_s: float) -> MotionState:
        """Return the motion along one leg without its neighbours."""
        if elapsed_s >= self._ends[leg]:
            return MotionState(self._places[leg + 1])
        along, speed, acceleration = self._table.at(leg, elapsed_s - self._begins[leg])
        (e, n, u), (ue, un, uu) = self._places[leg], self._units[leg]
        if along == 0.0:
            return MotionState((e, n, u), STILL, STILL)
        return MotionState(
            (e + along * ue, n + along * un, u + along * uu),
            (speed * ue, speed * un, speed * uu),
            (acceleration * ue, acceleration * un, acceleration * uu),
        )

    def _overlaps(self, ways: Sequence[Way], radius_m: float) -> list[float]:
        """Return how long each leg overlaps with the next one."""
        return [
            overlap_s(self._table, leg, directions, radius_m) if ways[leg].is_passed else 0.0
            for leg, directions in enumerate(pairwise(self._units))
        ] + [0.0]

    def _schedule(self, ways: Sequence[Way], overlaps: list[float]) -> None:
        """Set when legs begin and end, and when their ends are reached and left."""
        durations = self._table.legs.duration_s.tolist()
        now = 0.0
        self._begins: list[float] = []
        self._ends: list[float] = []
        self.arrivals_s: list[float] = []
        self.departures_s: list[float] = []
        for way, duration, overlap in zip(ways, durations, overlaps, strict=True):
            self._begins.append(now)
            self._ends.append(now + duration)
            self.arrivals_s.append(now + duration - 0.5 * overlap)
            self.departures_s.append(self.arrivals_s[-1] + way.stand_s)
            now = self.departures_s[-1] - 0.5 * overlap


def _limits(ways: Sequence[Way]) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the limits of all legs."""
    limits = [way.limits for way in ways]
    return (
        np.array([limit.cruise_speed_mps for limit in limits]),
        np.array([limit.acceleration_mps2 for limit in limits]),
        np.array([limit.jerk_mps3 for limit in limits]),
        np.array([limit.smoothing_s for limit in limits]),
    )


def _sum(a: Enu, b: Enu) -> Enu:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])
