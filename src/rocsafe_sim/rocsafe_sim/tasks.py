# SPDX-License-Identifier: Apache-2.0
"""What a vehicle does to obey an order: stop, then these tasks."""

import math
from collections.abc import Iterator

from rocsafe_geo.motion.route_motion import Way
from rocsafe_geo.motion.stop import StopMotion
from rocsafe_sim.airframe import Airframe
from rocsafe_sim.route import Enu, Route
from rocsafe_sim.segment import Mode, Pose, standing
from rocsafe_sim.timeline import Task, Timeline

# Heights nearer than this count as equal; coordinates that went through degrees come back to 1 nm.
LEVEL_TOLERANCE_M = 1e-3


def fly_timeline(airframe: Airframe, start: Pose, route: Route, first_index: int) -> Timeline:
    """Return the flight over the viewpoints from `first_index` on, home, and down.

    `start` may be on the ground or in the air, standing or moving; no viewpoint may be left.
    """
    stop, at = stopped(airframe, start)
    tasks = list(_route_tasks(airframe, at, route, first_index))
    return Timeline(airframe, start, stop, tasks)


def return_timeline(airframe: Airframe, start: Pose, route: Route) -> Timeline:
    """Return the way home from `start` at the same height, around exclusions, and down."""
    stop, at = stopped(airframe, start)
    bends = route.around(at.position_enu, route.home_enu)
    return Timeline(airframe, start, stop, list(_home_tasks(airframe, at, route, bends)))


def hold_timeline(airframe: Airframe, start: Pose) -> Timeline:
    """Return the stop from `start` and a stand without end."""
    stop, at = stopped(airframe, start)
    way = airframe.performance.way(at.position_enu, at.position_enu, math.inf)
    return Timeline(airframe, start, stop, [_task(way, Mode.HOLDING, at)])


def land_timeline(airframe: Airframe, start: Pose, ground_up_m: float) -> Timeline:
    """Return the stop from `start` and the way straight down."""
    stop, at = stopped(airframe, start)
    return Timeline(airframe, start, stop, list(_down_tasks(airframe, at, ground_up_m)))


def stopped(airframe: Airframe, start: Pose) -> tuple[StopMotion | None, Pose]:
    """Return how a vehicle stops, None if it stands, and where it then is."""
    if start.motion.is_still:
        return None, start
    performance = airframe.performance
    stop = StopMotion(start.motion, performance.level, performance.vertical)
    return stop, standing(stop.state(stop.duration_s).position_enu, start.yaw_rad)


def _route_tasks(airframe: Airframe, at: Pose, route: Route, first_index: int) -> Iterator[Task]:
    """Yield what is left of a route for a vehicle that stands at `at`."""
    count = len(route.waypoints)
    if first_index < count:
        for task in _climb_tasks(airframe, at, route, first_index):
            yield task
            at = _at_end(task)
    for index in range(first_index, count):
        for task in _viewpoint_tasks(airframe, at, route, index):
            yield task
            at = _at_end(task)
    bends = route.way_to(count, at.position_enu)
    yield from _home_tasks(airframe, at, route, bends)


def _climb_tasks(airframe: Airframe, at: Pose, route: Route, index: int) -> Iterator[Task]:
    """Yield the climb to the first viewpoint's height, with the take-off if on the ground."""
    performance, here = airframe.performance, at.position_enu
    up_m = route.waypoints[index].position_enu[2]
    if here[2] <= route.home_enu[2] + LEVEL_TOLERANCE_M:
        for way in performance.ascent(here, up_m):
            yield _task(way, Mode.TAKING_OFF, at, index)
    elif abs(up_m - here[2]) > LEVEL_TOLERANCE_M:
        way = performance.way(here, (here[0], here[1], up_m))
        yield _task(way, Mode.TAKING_OFF, at, index)


def _viewpoint_tasks(airframe: Airframe, at: Pose, route: Route, index: int) -> Iterator[Task]:
    """Yield the way to a viewpoint, with a stop at each bend, and the photograph there."""
    performance, waypoint = airframe.performance, route.waypoints[index]
    for bend in route.way_to(index, at.position_enu):
        over_bend = (bend[0], bend[1], at.position_enu[2])
        task = _task(performance.way(at.position_enu, over_bend), Mode.FLYING, at, index)
        yield task
        at = _at_end(task)
    # before it turns home a vehicle stops, as autopilots do before they return
    is_passed = airframe.hover_s == 0.0 and index < len(route.waypoints) - 1
    way = performance.way(
        at.position_enu, waypoint.position_enu, airframe.hover_s, is_passed=is_passed
    )
    yield Task(
        way=way,
        mode=Mode.FLYING,
        yaw_rad=waypoint.yaw_rad,
        viewpoint_index=index,
        takes_shot=True,
    )


def _home_tasks(
    airframe: Airframe, at: Pose, route: Route, bends: tuple[Enu, ...]
) -> Iterator[Task]:
    """Yield the way home over `bends` at the same height, the wait there, and the way down."""
    performance, home, up_m = airframe.performance, route.home_enu, at.position_enu[2]
    for bend in bends:
        task = _task(
            performance.way(at.position_enu, (bend[0], bend[1], up_m)), Mode.RETURNING, at
        )
        yield task
        at = _at_end(task)
    wait_s = performance.autopilot.home_wait_s
    way = performance.way(at.position_enu, (home[0], home[1], up_m), wait_s)
    task = _task(way, Mode.RETURNING, at)
    yield task
    yield from _down_tasks(airframe, _at_end(task), home[2])


def _down_tasks(airframe: Airframe, at: Pose, ground_up_m: float) -> Iterator[Task]:
    for way in airframe.performance.descent(at.position_enu, ground_up_m):
        yield _task(way, Mode.LANDING, at)


def _task(way: Way, mode: Mode, at: Pose, viewpoint_index: int | None = None) -> Task:
    """Return a task during which the nose keeps its direction."""
    return Task(way=way, mode=mode, yaw_rad=at.yaw_rad, viewpoint_index=viewpoint_index)


def _at_end(task: Task) -> Pose:
    return standing(task.way.end_enu, task.yaw_rad)
