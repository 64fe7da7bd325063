# SPDX-License-Identifier: Apache-2.0
"""Where a vehicle is at any time of its route, in the planner's time model."""

import numpy as np
from numpy.typing import NDArray

from rocsafe_planner.fleet_problem import FleetProblem, Order
from rocsafe_planner.flight_time import FlightTime
from rocsafe_planner.vehicle import Vehicle

FloatArray = NDArray[np.float64]


class FlightTrack:
    """Pieces of flights, each straight, at a steady speed or from standstill to standstill.

    Attributes
    ----------
    windows
        (begin, end) of the times in the air, shape (flights, 2), seconds since first take-off.
    top_speed_mps
        That it never exceeds, climb and descent included.
    low, high
        Corners (east, north, up) of the box that it stays in.
    """

    def __init__(self, problem: FleetProblem, vehicle: int, flights: list[Order]) -> None:
        self._spec = problem.vehicles[vehicle]
        self._flight = problem.flight(vehicle)
        pieces = _Pieces(self._spec, self._flight, problem.height_m)
        self.windows = np.array(
            [
                pieces.fly(_path(problem, vehicle, order, is_last=order is flights[-1]))
                for order in flights
            ]
        ).reshape(-1, 2)
        self._begin_s = np.array(pieces.begin_s)
        self._duration_s = np.array(pieces.duration_s)
        self._from = np.array(pieces.origins).reshape(-1, 3)
        self._to = np.array(pieces.targets).reshape(-1, 3)
        self._is_leg = np.array(pieces.is_leg, dtype=bool)
        ends = np.vstack([self._from, self._to])
        self.low, self.high = ends.min(axis=0), ends.max(axis=0)
        rates = (self._spec.climb_rate_mps, self._spec.descent_rate_mps)
        self.top_speed_mps = max(self._flight.fastest().cruise_speed_mps, *rates)

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

    def __init__(self, spec: Vehicle, flight: FlightTime, height_m: float) -> None:
        self._spec, self._flight, self._height = spec, flight, height_m
        self._now = 0.0
        self.begin_s: list[float] = []
        self.duration_s: list[float] = []
        self.origins: list[FloatArray] = []
        self.targets: list[FloatArray] = []
        self.is_leg: list[bool] = []

    def fly(self, path: list[tuple[FloatArray, bool]]) -> tuple[float, float]:
        """Add a flight along places, hovering at those marked; return its begin and end."""
        if self.begin_s:
            self._now += self._spec.battery_swap_s or 0.0
        begin = self._now
        here = path[0][0]
        self._add(here, here, self._height / self._spec.climb_rate_mps, (0.0, self._height))
        for place, is_viewpoint in path[1:]:
            self._add(here, place, float(self._flight(place - here)), None)
            here = place
            if is_viewpoint:
                self._add(here, here, self._spec.hover_s, (self._height, self._height))
        self._add(here, here, self._height / self._spec.descent_rate_mps, (self._height, 0.0))
        return begin, self._now

    def _add(
        self,
        origin: FloatArray,
        target: FloatArray,
        duration_s: float,
        heights: tuple[float, float] | None,
    ) -> None:
        """Add a piece: a leg at the survey height if no heights are given."""
        self.is_leg.append(heights is None)
        low, high = heights or (self._height, self._height)
        self.begin_s.append(self._now)
        self.duration_s.append(duration_s)
        self.origins.append(np.array([*origin, low]))
        self.targets.append(np.array([*target, high]))
        self._now += duration_s


def _path(
    problem: FleetProblem, vehicle: int, order: Order, *, is_last: bool
) -> list[tuple[FloatArray, bool]]:
    """Return the places of a flight, bends included, and whether each is a viewpoint."""
    sites = problem.sites
    home = problem.home_site(vehicle)
    end = problem.end_site(vehicle) if is_last else home
    path = [(sites[home], False)]
    here = home
    for site in [*order, *([] if end is None else [end])]:
        path.extend((bend, False) for bend in problem.bends(here, site))
        path.append((sites[site], site < len(problem.points)))
        here = site
    return path
