# SPDX-License-Identifier: Apache-2.0
"""Where a vehicle is at any time of its route, in the planner's time model."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rocsafe_planner.fleet_problem import FleetProblem, Order

FloatArray = NDArray[np.float64]


class FlightTrack:
    """Pieces of flights, each straight, at a steady speed or from standstill to standstill.

    Attributes
    ----------
    windows
        (begin, end) of the times in the air, shape (flights, 2), seconds since first take-off.
    is_aloft
        Whether it begins in the air.
    top_speed_mps
        That it never exceeds, climb and descent included.
    low, high
        Corners (east, north, up) of the box that it stays in.
    """

    def __init__(self, problem: FleetProblem, vehicle: int, flights: list[Order]) -> None:
        self._spec = problem.vehicles[vehicle]
        flight = problem.flight(vehicle)
        pieces = _Pieces(problem, vehicle)
        self.windows = np.array(
            [
                pieces.fly(
                    _path(problem, vehicle, order, (number == 0, number == len(flights) - 1)),
                    in_air=number == 0 and self._spec.aloft is not None,
                )
                for number, order in enumerate(flights)
            ]
        ).reshape(-1, 2)
        self.is_aloft = self._spec.aloft is not None
        self._begin_s = np.array(pieces.begin_s)
        self._duration_s = np.array(pieces.duration_s)
        self._from = np.array(pieces.origins).reshape(-1, 3)
        self._to = np.array(pieces.targets).reshape(-1, 3)
        self._is_leg = np.array(pieces.is_leg, dtype=bool)
        ends = np.vstack([self._from, self._to])
        self.low, self.high = ends.min(axis=0), ends.max(axis=0)
        rates = (self._spec.climb_rate_mps, self._spec.descent_rate_mps)
        self.top_speed_mps = float(np.hypot(flight.fastest().cruise_speed_mps, max(rates)))

    @property
    def duration_s(self) -> float:
        """Time from the first take-off to the last touch-down."""
        return float(self.windows[-1, 1])

    def places(self, times_s: FloatArray) -> FloatArray:
        """Return (east, north, up) at times in the air, shape (n, 3)."""
        piece = np.clip(np.searchsorted(self._begin_s, times_s, side='right') - 1, 0, None)
        elapsed = np.clip(times_s - self._begin_s[piece], 0.0, self._duration_s[piece])
        duration = np.where(self._duration_s[piece] > 0.0, self._duration_s[piece], 1.0)
        share = np.where(self._is_leg[piece], self._leg_share(piece, elapsed), elapsed / duration)
        path = self._to[piece] - self._from[piece]
        places: FloatArray = self._from[piece] + share[:, None] * path
        return places

    def _leg_share(self, piece: NDArray[np.intp], elapsed: FloatArray) -> FloatArray:
        """Return the part of legs flown: a ramp up, a cruise, a ramp down."""
        acceleration = self._spec.acceleration_mps2
        path = (self._to - self._from)[piece]
        distance = np.hypot(path[:, 0], path[:, 1])
        duration = self._duration_s[piece]
        # d = peak * (duration - peak / a), the smaller root
        root = np.sqrt(np.maximum(0.0, duration**2 - 4.0 * distance / acceleration))
        peak = 0.5 * acceleration * (duration - root)
        ramp = peak / acceleration
        left = duration - elapsed
        flown = np.where(
            elapsed < ramp,
            0.5 * acceleration * elapsed**2,
            np.where(
                left < ramp,
                distance - 0.5 * acceleration * left**2,
                peak * (elapsed - 0.5 * ramp),
            ),
        )
        share: FloatArray = np.clip(flown / np.where(distance > 0.0, distance, 1.0), 0.0, 1.0)
        return share


class _Pieces:
    """Collects the pieces of flights one after the other."""

    def __init__(self, problem: FleetProblem, vehicle: int) -> None:
        self._spec, self._flight = problem.vehicles[vehicle], problem.flight(vehicle)
        self._height = problem.flight_height_m(vehicle)
        self._now = 0.0
        self.begin_s: list[float] = []
        self.duration_s: list[float] = []
        self.origins: list[FloatArray] = []
        self.targets: list[FloatArray] = []
        self.is_leg: list[bool] = []

    def fly(self, path: list[tuple[FloatArray, bool]], *, in_air: bool) -> tuple[float, float]:
        """Add a flight along places, hovering at those marked; return its begin and end."""
        if self.begin_s:
            self._now += self._spec.battery_swap_s or 0.0
        begin, spec = self._now, self._spec
        here, down = path[0][0], np.array([0.0, 0.0, self._height])
        if not in_air:
            self._add(here - down, here, self._height / spec.climb_rate_mps, is_leg=False)
        for place, is_viewpoint in path[1:]:
            leg_s = float(self._flight.straight(here, place))
            self._add(here, place, leg_s, is_leg=True)
            here = place
            if is_viewpoint:
                self._add(here, here, spec.hover_s, is_leg=False)
        self._add(here, here - down, self._height / spec.descent_rate_mps, is_leg=False)
        return begin, self._now

    def _add(
        self, origin: FloatArray, target: FloatArray, duration_s: float, *, is_leg: bool
    ) -> None:
        is_vertical = bool(np.hypot(*(target - origin)[:2]) < 1e-9)
        self.is_leg.append(is_leg and not is_vertical)
        self.begin_s.append(self._now)
        self.duration_s.append(duration_s)
        self.origins.append(origin)
        self.targets.append(target)
        self._now += duration_s


def _path(
    problem: FleetProblem, vehicle: int, order: Order, is_first_last: tuple[bool, bool]
) -> list[tuple[FloatArray, bool]]:
    """Return the places of a flight, bends included, and whether each is a viewpoint."""
    home = problem.home_site(vehicle)
    start = problem.start_site(vehicle) if is_first_last[0] else home
    end = problem.end_site(vehicle) if is_first_last[1] else home
    stops = [start, *order, *([] if end is None else [end])]
    if len(stops) == 1:
        return [(problem.way(vehicle, start, start)[0], False)]
    path = [(problem.way(vehicle, start, stops[1])[0], False)]
    for here, site in pairwise(stops):
        *bends, place = problem.way(vehicle, here, site)[1:]
        path.extend((bend, False) for bend in bends)
        path.append((place, site < len(problem.points)))
    return path
