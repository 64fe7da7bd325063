# SPDX-License-Identifier: Apache-2.0
"""A flight as a sequence of segments: where the vehicle is at any time, past or to come."""

import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import accumulate

from rocsafe_sim.airframe import Airframe
from rocsafe_sim.route import Enu, Route
from rocsafe_sim.segment import Mode, Pose, Segment, brake, leg, stand, standing

# Heights nearer than this count as equal; coordinates that went through degrees come back to 1 nm.
LEVEL_TOLERANCE_M = 1e-3


@dataclass(frozen=True, slots=True)
class ShotTime:
    """A photograph due `elapsed_s` seconds after the timeline's start, at a route's viewpoint."""

    elapsed_s: float
    viewpoint_index: int


class Timeline:
    """Segments flown one after the other from time 0 on; at least one.

    All elapsed times are seconds since the start of the first segment. Before it the vehicle is
    where the first segment begins, after the last one where that ends.
    """

    def __init__(self, segments: Iterable[Segment]) -> None:
        self.segments = tuple(segments)
        self._ends = list(accumulate(segment.duration_s for segment in self.segments))
        self._distances = list(
            accumulate((segment.distance_m for segment in self.segments), initial=0.0)
        )

    @property
    def duration_s(self) -> float:
        """Time of the last segment's end; infinity for a stand without end."""
        return self._ends[-1]

    @property
    def distance_m(self) -> float:
        """Horizontal distance flown in all."""
        return self._distances[-1]

    def pose(self, elapsed_s: float) -> Pose:
        """Return the pose at a time."""
        index = self._index(elapsed_s)
        return self.segments[index].pose(self._within(index, elapsed_s))

    def segment(self, elapsed_s: float) -> Segment:
        """Return the segment being flown at a time."""
        return self.segments[self._index(elapsed_s)]

    def progress_m(self, elapsed_s: float) -> float:
        """Return the horizontal distance flown until a time."""
        index = self._index(elapsed_s)
        within_s = self._within(index, elapsed_s)
        return self._distances[index] + self.segments[index].progress_m(within_s)

    def shots(self) -> Iterator[ShotTime]:
        """Yield the photographs of this timeline, in order of time."""
        for segment, end_s in zip(self.segments, self._ends, strict=True):
            if segment.takes_shot and segment.viewpoint_index is not None:
                yield ShotTime(end_s, segment.viewpoint_index)

    def first_start_s(self, *modes: Mode) -> float:
        """Return when the first segment of one of `modes` begins; infinity if none is."""
        for index, segment in enumerate(self.segments):
            if segment.mode in modes:
                return self._begin(index)
        return math.inf

    def _index(self, elapsed_s: float) -> int:
        return min(bisect_right(self._ends, elapsed_s), len(self._ends) - 1)

    def _within(self, index: int, elapsed_s: float) -> float:
        """Return the time since a segment's start; at the very end no rounding counts."""
        return math.inf if elapsed_s >= self.duration_s else elapsed_s - self._begin(index)

    def _begin(self, index: int) -> float:
        return self._ends[index - 1] if index else 0.0


def _route_segments(
    airframe: Airframe, start: Pose, route: Route, first_index: int
) -> Iterator[Segment]:
    """Yield the flight from standstill at `start` over viewpoints, home, and down."""
    first = route.waypoints[first_index]
    yield from _to_height(airframe, start, first.position_enu[2], first_index)
    at = standing((*start.position_enu[:2], first.position_enu[2]), start.yaw_rad)
    for index in range(first_index, len(route.waypoints)):
        waypoint = route.waypoints[index]
        for bend in route.way_to(index, at.position_enu):
            over_bend = (*bend[:2], at.position_enu[2])
            way = leg(Mode.FLYING, at, over_bend, at.yaw_rad, airframe)
            yield replace(way, viewpoint_index=index)
            at = standing(over_bend, at.yaw_rad)
        way = leg(Mode.FLYING, at, waypoint.position_enu, waypoint.yaw_rad, airframe)
        yield replace(way, viewpoint_index=index)
        at = standing(waypoint.position_enu, waypoint.yaw_rad)
        hover = stand(Mode.FLYING, at, airframe.hover_s, airframe.limits)
        yield replace(hover, viewpoint_index=index, takes_shot=True)
    yield from return_segments(airframe, at, route.home_enu, _way_home(route, at))


def _way_home(route: Route, at: Pose) -> tuple[Enu, ...]:
    """Return where the way home bends for a vehicle that has been everywhere."""
    return route.way_to(len(route.waypoints), at.position_enu)


def return_segments(
    airframe: Airframe, start: Pose, home_enu: Enu, bends_enu: tuple[Enu, ...] = ()
) -> Iterator[Segment]:
    """Yield the way home from `start`, standing or moving, at the same height, and down.

    A vehicle that gives up its route knows of no bends: it returns straight, even over exclusions.
    """
    at = start
    if start.speed_mps > 0.0:
        stop = brake(Mode.RETURNING, start, airframe.limits)
        yield stop
        at = standing(stop.end_enu, start.yaw_rad)
    for bend in bends_enu:
        over_bend = (*bend[:2], at.position_enu[2])
        yield leg(Mode.RETURNING, at, over_bend, at.yaw_rad, airframe)
        at = standing(over_bend, at.yaw_rad)
    over_home = (home_enu[0], home_enu[1], at.position_enu[2])
    yield leg(Mode.RETURNING, at, over_home, at.yaw_rad, airframe)
    yield leg(Mode.LANDING, standing(over_home, at.yaw_rad), home_enu, at.yaw_rad, airframe)


def hold_segments(airframe: Airframe, start: Pose) -> Iterator[Segment]:
    """Yield the stop from `start` and a stand without end."""
    stop = brake(Mode.HOLDING, start, airframe.limits)
    yield stop
    at = standing(stop.end_enu, start.yaw_rad)
    yield stand(Mode.HOLDING, at, math.inf, airframe.limits)


def land_segments(airframe: Airframe, start: Pose, ground_up_m: float) -> Iterator[Segment]:
    """Yield the stop from `start` and the way straight down."""
    stop = brake(Mode.LANDING, start, airframe.limits)
    yield stop
    down = (*stop.end_enu[:2], ground_up_m)
    yield leg(Mode.LANDING, standing(stop.end_enu, start.yaw_rad), down, start.yaw_rad, airframe)


def fly_segments(
    airframe: Airframe, start: Pose, route: Route, first_index: int
) -> Iterator[Segment]:
    """Yield the flight over the viewpoints from `first_index` on, home, and down.

    `start` may be on the ground or in the air, standing or moving; no viewpoint may be left.
    """
    at = start
    if start.speed_mps > 0.0:
        stop = brake(Mode.FLYING, start, airframe.limits)
        yield stop
        at = standing(stop.end_enu, start.yaw_rad)
    if first_index < len(route.waypoints):
        yield from _route_segments(airframe, at, route, first_index)
    else:
        yield from return_segments(airframe, at, route.home_enu, _way_home(route, at))


def _to_height(
    airframe: Airframe, start: Pose, up_m: float, viewpoint_index: int
) -> Iterator[Segment]:
    if abs(up_m - start.position_enu[2]) > LEVEL_TOLERANCE_M:
        over_start = (*start.position_enu[:2], up_m)
        climb = leg(Mode.TAKING_OFF, start, over_start, start.yaw_rad, airframe)
        yield replace(climb, viewpoint_index=viewpoint_index)
