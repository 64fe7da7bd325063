# SPDX-License-Identifier: Apache-2.0
"""Checks of the distances of vehicles that are in the air at the same time."""

import math
from collections.abc import Iterator
from itertools import combinations, pairwise

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_planner.checking.checked_track import corners_of, frame_of, motion_of
from rocsafe_planner.checking.flight_checker import ABSOLUTE_M, ABSOLUTE_S, RELATIVE, Fault
from rocsafe_planner.plan.plan import Route, SurveyPlan

_SAMPLE_S = 0.2
_SHORT_M = 0.01


def separation_faults(plan: SurveyPlan) -> Iterator[Fault]:
    """Yield pairs of vehicles that are too near to each other, sampled five times a second."""
    frame = frame_of(plan)
    tracks = [_Watched(plan, route, frame) for route in plan.routes if route.sorties]
    times = _SAMPLE_S * np.arange(int(plan.makespan_s / _SAMPLE_S) + 1, dtype=np.float64)
    places = [track.places(times) for track in tracks]
    seen = math.inf
    for a, b in combinations(places, 2):
        apart = np.sqrt(((a - b) ** 2).sum(axis=1))
        seen = min(seen, float(apart[np.isfinite(apart)].min(initial=math.inf)))
    stated = plan.minimum_separation_m
    # Vehicles in the air cannot wait: two of them may meet, and the plan must state it.
    may_wait = sum(vehicle.aloft is not None for vehicle in plan.request.vehicles) < 2
    wanted = plan.request.separation.distance_m
    if may_wait and stated < wanted - ABSOLUTE_M:
        yield f'minimum_separation_m is {stated}: separation distance_m is {wanted}'
    closing_mps = 2.0 * max(vehicle.cruise_speed_mps for vehicle in plan.request.vehicles)
    doubt_s = ABSOLUTE_S * max((track.shortest_legs for track in tracks), default=0)
    slack_m = ABSOLUTE_M + RELATIVE * plan.longest_route_m + doubt_s * closing_mps
    if seen < stated - slack_m:
        yield f'minimum_separation_m is {stated}: vehicles come within {seen} m'


class _Watched:
    """A route by the clock of the mission."""

    def __init__(self, plan: SurveyPlan, route: Route, frame: LocalFrame) -> None:
        self._spec = route.vehicle
        self._plan, self._route, self._frame = plan, route, frame

    @property
    def shortest_legs(self) -> int:
        """Number of legs so short that their time is uncertain.

        A leg of a millimetre, from beside a viewpoint to it, takes centiseconds: by so much the
        planner's track may be before or behind this one.
        """
        return sum(
            0.0 < math.dist(here, place) < _SHORT_M
            for number in range(len(self._route.sorties))
            for here, place in pairwise(corners_of(self._plan, self._route, number, self._frame))
        )

    def places(self, times: FloatArray) -> FloatArray:
        """Return (east, north, up), NaN on the ground; who begins in the air waits there."""
        places = np.full((len(times), 3), np.nan)
        now = self._route.delay_s
        if self._spec.aloft is not None:
            first = motion_of(self._plan, self._route, 0, self._frame)
            waits = times < now
            places[waits] = first.positions(np.zeros(int(waits.sum())))
        for number in range(len(self._route.sorties)):
            motion = motion_of(self._plan, self._route, number, self._frame)
            end = now + motion.duration_s
            inside = (times >= now) & (times <= end)
            places[inside] = motion.positions(times[inside] - now)
            now = end + (self._spec.battery_swap_s or 0.0)
        return places
