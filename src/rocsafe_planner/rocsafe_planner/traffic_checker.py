# SPDX-License-Identifier: Apache-2.0
"""The checker's look at vehicles that are in the air at the same time."""

import math
from collections.abc import Iterator
from itertools import combinations, pairwise

import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.motion import MotionLimits, leg_duration_s, leg_progress_m
from rocsafe_planner.checked_track import (
    FloatArray,
    frame_of,
    limits_along,
    plane_of,
    ups_m,
    vertical_s,
    way,
)
from rocsafe_planner.flight_checker import ABSOLUTE_M, RELATIVE, Fault
from rocsafe_planner.plan import Route, Sortie, SurveyPlan

_SAMPLE_S = 0.2


def separation_faults(plan: SurveyPlan) -> Iterator[Fault]:
    """Yield vehicles too near to each other, watched at every fifth of a second."""
    frame = frame_of(plan)
    tracks = [_Watched(plan, route, frame) for route in plan.routes if route.sorties]
    times = _SAMPLE_S * np.arange(int(plan.makespan_s / _SAMPLE_S) + 1, dtype=np.float64)
    places = [track.places(times) for track in tracks]
    seen = math.inf
    for a, b in combinations(places, 2):
        apart = np.sqrt(((a - b) ** 2).sum(axis=1))
        seen = min(seen, float(apart[np.isfinite(apart)].min(initial=math.inf)))
    stated = plan.minimum_separation_m
    if stated < plan.request.separation_m - ABSOLUTE_M:
        yield f'minimum_separation_m is {stated}: separation_m is {plan.request.separation_m}'
    if seen < stated - ABSOLUTE_M - RELATIVE * plan.longest_route_m:
        yield f'minimum_separation_m is {stated}: vehicles come within {seen} m'


class _Watched:
    """A route by the clock of the mission."""

    def __init__(self, plan: SurveyPlan, route: Route, frame: LocalFrame) -> None:
        self._wind, self._spec = plan.request.wind_mps, route.vehicle
        self._plan, self._route, self._frame = plan, route, frame

    def places(self, times: FloatArray) -> FloatArray:
        """Return (east, north, up), NaN on the ground."""
        places = np.full((len(times), 3), np.nan)
        now = self._route.delay_s
        for number in range(len(self._route.sorties)):
            now = self._fly(places, times, now, number) + (self._spec.battery_swap_s or 0.0)
        return places

    def _fly(self, places: FloatArray, times: FloatArray, now: float, number: int) -> float:
        spec, height = self._spec, self._route.flight_height_m
        track, down = self._track(number), np.array([0.0, 0.0, self._route.flight_height_m])
        shots = _shot_places(self._frame, self._route.sorties[number])
        if number or spec.aloft is None:
            now = _move(
                places, times, now, (track[0] - down, track[0], height / spec.climb_rate_mps)
            )
        for a, b in pairwise(track):
            now = self._leg(places, times, now, (a, b))
            if tuple(np.round(b[:2], 3)) in shots:
                now = _move(places, times, now, (b, b, spec.hover_s))
        return _move(
            places, times, now, (track[-1], track[-1] - down, height / spec.descent_rate_mps)
        )

    def _track(self, number: int) -> FloatArray:
        """Return the corners of a flight, (east, north, up)."""
        level = 0.0 if self._plan.request.terrain is not None else self._route.flight_height_m
        ups = ups_m(self._plan, self._route, number) + level
        return np.column_stack([plane_of(self._frame, way(self._route, number)), ups])

    def _leg(
        self,
        places: FloatArray,
        times: FloatArray,
        now: float,
        ends: tuple[FloatArray, FloatArray],
    ) -> float:
        """Set places of a straight leg that begins now; return when it ends."""
        a, b = ends
        length, spec = float(np.hypot(*(b - a)[:2])), self._spec
        limits = limits_along(spec, self._wind, (b - a)[:2])
        level_s = float(leg_duration_s(length, limits))
        climb_s = vertical_s(spec, float((b - a)[2]))
        if length < 1e-6:
            return _move(places, times, now, (a, b, climb_s))
        if climb_s > level_s:
            # So slow a cruise that it is over when the climb is.
            root = math.sqrt(climb_s**2 - 4.0 * length / spec.acceleration_mps2)
            speed = 0.5 * spec.acceleration_mps2 * (climb_s - root)
            limits = MotionLimits(speed, spec.acceleration_mps2)
        duration = max(level_s, climb_s)
        inside = (times >= now) & (times <= now + duration)
        share = np.asarray(leg_progress_m(times[inside] - now, length, limits)) / length
        places[inside] = a + share[:, None] * (b - a)
        return now + duration


def _move(
    places: FloatArray, times: FloatArray, now: float, move: tuple[FloatArray, FloatArray, float]
) -> float:
    """Set places of a steady move (from, to, how long) that begins now; return when it ends."""
    origin, target, duration = move
    inside = (times >= now) & (times <= now + duration)
    share = (times[inside] - now) / (duration or 1.0)
    places[inside] = origin + share[:, None] * (target - origin)
    return now + duration


def _shot_places(frame: LocalFrame, sortie: Sortie) -> set[tuple[float, ...]]:
    positions = tuple(view.position for view in sortie.viewpoints)
    return {tuple(place) for place in np.round(plane_of(frame, positions), 3)}
