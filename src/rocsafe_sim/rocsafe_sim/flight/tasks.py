# SPDX-License-Identifier: Apache-2.0
"""Timelines of commands: a stop, then a sequence of tasks."""

import math
from collections.abc import Iterator

from rocsafe_geo.angle import wrap_rad
from rocsafe_geo.motion.route_motion import Way
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.motion.stop import StopMotion
from rocsafe_geo.motion.velocity import VelocityMotion
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.flight.route import ON_WAY_M, FlightRoute, horizontal_m
from rocsafe_sim.flight.segment import FlightPose, Mode, standing
from rocsafe_sim.flight.timeline import Task, Timeline

# Heights nearer than this count as equal; a conversion to degrees and back changes about 1 nm.
LEVEL_TOLERANCE_M = 1e-3
# Yaw rate of a commanded turn, as autopilots have it (PX4: MPC_YAWRAUTO_MAX, 45 deg/s).
TURN_RATE_RADPS = math.radians(45.0)
# Yaw is interpolated the shorter way: longer turns are made of such legs.
LEG_OF_TURN_RAD = 2.0
# A bend whose height differs by less is flown level.
LAYER_TOLERANCE_M = 0.4


def fly_timeline(
    airframe: Airframe,
    start: FlightPose,
    route: FlightRoute,
    from_here: tuple[int, int],
    hover_s: float = 0.0,
) -> Timeline:
    """Return the rest of a flight: over its viewpoints, to its landing place, and down.

    `from_here` holds the number of the flight and the index of the first viewpoint left.
    `start` may be on the ground or in the air, standing or moving. In the air it stands for
    `hover_s` first.
    """
    stop, at = stopped(airframe, start)
    tasks = list(_route_tasks(airframe, at, route, *from_here))
    if hover_s > 0.0:
        way = airframe.performance.way(at.position_enu, at.position_enu, hover_s)
        tasks.insert(0, _task(way, Mode.FLYING, at))
    return Timeline(airframe, start, stop, tasks)


def return_timeline(
    airframe: Airframe, start: FlightPose, route: FlightRoute, ground: Enu
) -> Timeline:
    """Return the way from `start` around exclusions to a place on the ground, and down.

    It is flown level; over uneven ground no lower than any viewpoint of the route.
    """
    stop, at = stopped(airframe, start)
    tasks: list[Task] = []
    safe_up_m = safe_up(route, at.position_enu[2])
    if safe_up_m > at.position_enu[2]:
        over = (*at.position_enu[:2], safe_up_m)
        tasks.append(_task(airframe.performance.way(at.position_enu, over), Mode.RETURNING, at))
        at = _at_end(tasks[-1])
    bends = route.around(at.position_enu, ground)
    tasks.extend(_landing_tasks(airframe, at, (*ground[:2], safe_up_m), ground[2], bends))
    return Timeline(airframe, start, stop, tasks)


def safe_up(route: FlightRoute, up_m: float) -> float:
    """Return the height of the way home of a vehicle at height `up_m`."""
    if route.is_level:
        return up_m
    return max(up_m, *(waypoint.position_enu[2] for waypoint in route.waypoints))


def hold_timeline(airframe: Airframe, start: FlightPose) -> Timeline:
    """Return the stop from `start` and a stand without end."""
    stop, at = stopped(airframe, start)
    return Timeline(airframe, start, stop, [_stand(airframe, at)])


def go_to_timeline(
    airframe: Airframe,
    start: FlightPose,
    route: FlightRoute,
    goals: tuple[Enu, ...],
    yaw_rad: float | None = None,
) -> Timeline:
    """Return the way from `start` along places in the air, a turn to `yaw_rad`, and a stand.

    The way to each place goes around exclusions. It is flown level, at the greater of both
    heights.
    """
    stop, at = stopped(airframe, start)
    tasks: list[Task] = []
    for goal in goals:
        up_m = max(at.position_enu[2], goal[2])
        bends = route.around(at.position_enu, goal)
        if at.position_enu[2] <= route.home_enu[2] + LEVEL_TOLERANCE_M:
            for way in airframe.performance.ascent(at.position_enu, up_m):
                tasks.append(_task(way, Mode.TAKING_OFF, at))
                at = _at_end(tasks[-1])
        corners = [(*place[:2], up_m) for place in (at.position_enu, *bends, goal)]
        for corner in (*corners, goal):
            if corner != at.position_enu:
                way = airframe.performance.way(at.position_enu, corner)
                tasks.append(_task(way, Mode.FLYING, at))
                at = _at_end(tasks[-1])
    if yaw_rad is not None:
        turn_s = abs(wrap_rad(yaw_rad - at.yaw_rad)) / TURN_RATE_RADPS
        way = airframe.performance.way(at.position_enu, at.position_enu, turn_s)
        tasks.append(Task(way=way, mode=Mode.FLYING, yaw_rad=yaw_rad))
        at = _at_end(tasks[-1])
    return Timeline(airframe, start, stop, [*tasks, _stand(airframe, at)])


def move_timeline(
    airframe: Airframe,
    start: FlightPose,
    velocity: tuple[Enu, float],
    turn_rate_radps: float = 0.0,
    yaw_rad: float | None = None,
) -> Timeline:
    """Return the flight at a velocity (m/s) for some seconds, a stop, and a stand.

    The vehicle turns at a constant rate until the stop, or to `yaw_rad` if that is given.
    """
    performance = airframe.performance
    limits = (performance.level, performance.vertical)
    motion = VelocityMotion(start.motion, *velocity, *limits)
    turn_s = velocity[1]
    if yaw_rad is not None:
        turn_rad = wrap_rad(yaw_rad - start.yaw_rad)
        turn_rate_radps = math.copysign(TURN_RATE_RADPS, turn_rad)
        turn_s = min(motion.duration_s, abs(turn_rad) / TURN_RATE_RADPS)
    yaws = _turn(start.yaw_rad, turn_rate_radps, turn_s)
    yaw = yaws[-1][1] if yaws else start.yaw_rad
    at = standing(motion.state(motion.duration_s).position_enu, yaw)
    here = Task(way=performance.way(at.position_enu, at.position_enu), mode=Mode.FLYING,
                yaw_rad=yaw)  # fmt: skip
    return Timeline(airframe, start, motion, [here, _stand(airframe, at)], lead_yaws=yaws)


def _turn(yaw_rad: float, rate_radps: float, turn_s: float) -> list[tuple[float, float]]:
    """Return times and yaws of a turn, less than half a turn apart."""
    count = math.ceil(abs(rate_radps) * turn_s / LEG_OF_TURN_RAD)
    times = (turn_s * number / count for number in range(1, count + 1))
    return [(time_s, wrap_rad(yaw_rad + rate_radps * time_s)) for time_s in times]


def land_timeline(
    airframe: Airframe, start: FlightPose, route: FlightRoute, ground_up_m: float | None = None
) -> Timeline:
    """Return the stop from `start` and the vertical descent to the ground."""
    stop, at = stopped(airframe, start)
    if ground_up_m is None:
        ground_up_m = route.ground_below(at.position_enu)[2]
    return Timeline(airframe, start, stop, list(_down_tasks(airframe, at, ground_up_m)))


def stopped(airframe: Airframe, start: FlightPose) -> tuple[StopMotion | None, FlightPose]:
    """Return the stop of a vehicle, None if it stands, and its pose afterwards."""
    if start.motion.is_still:
        return None, start
    performance = airframe.performance
    stop = StopMotion(start.motion, performance.level, performance.vertical)
    return stop, standing(stop.state(stop.duration_s).position_enu, start.yaw_rad)


def _route_tasks(
    airframe: Airframe, at: FlightPose, route: FlightRoute, number: int, first_index: int
) -> Iterator[Task]:
    """Yield the rest of flight `number` for a vehicle that stands at `at`."""
    begin, end = route.begin_of(number), route.end_of(number)
    if first_index == begin < end:
        for task in _climb_tasks(airframe, at, route, begin):
            yield task
            at = _at_end(task)
    for index in range(first_index, end):
        for task in _viewpoint_tasks(airframe, at, route, (number, index)):
            yield task
            at = _at_end(task)
    bends = route.way_to(end, at.position_enu, number)
    ground = route.landing_of(number) or route.ground_below(at.position_enu)
    up_m = at.position_enu[2] if route.is_level else ground[2] + route.height_m
    over = (*ground[:2], up_m)
    yield from _landing_tasks(airframe, at, over, ground[2], bends, is_level=route.is_level)


def _climb_tasks(
    airframe: Airframe, at: FlightPose, route: FlightRoute, index: int
) -> Iterator[Task]:
    """Yield the climb above home, with the take-off if on the ground; nothing elsewhere."""
    performance, here, home = airframe.performance, at.position_enu, route.home_enu
    up_m = home[2] + route.height_m
    if route.is_level:
        up_m = route.waypoints[index].position_enu[2]
    if here[2] <= home[2] + LEVEL_TOLERANCE_M:
        for way in performance.ascent(here, up_m):
            yield _task(way, Mode.TAKING_OFF, at, index)
    elif horizontal_m(here, home) < ON_WAY_M and here[2] < up_m - LEVEL_TOLERANCE_M:
        way = performance.way(here, (here[0], here[1], up_m))
        yield _task(way, Mode.TAKING_OFF, at, index)


def _viewpoint_tasks(
    airframe: Airframe, at: FlightPose, route: FlightRoute, target: tuple[int, int]
) -> Iterator[Task]:
    """Yield the way to a viewpoint, with a stop at each bend, and the photograph there.

    `target` holds the number of the flight and the index of the viewpoint.
    """
    number, index = target
    performance, waypoint = airframe.performance, route.waypoints[index]
    for bend in route.way_to(index, at.position_enu, number):
        over_bend = _over(bend, at, is_level=route.is_level)
        task = _task(performance.way(at.position_enu, over_bend), Mode.FLYING, at, index)
        yield task
        at = _at_end(task)
    # Autopilots stop before they return, at the last viewpoint, too.
    is_passed = airframe.hover_s == 0.0 and index < route.end_of(number) - 1
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


def _landing_tasks(
    airframe: Airframe,
    at: FlightPose,
    over: Enu,
    ground_up_m: float,
    bends: tuple[Enu, ...],
    *,
    is_level: bool = True,
) -> Iterator[Task]:
    """Yield the way over `bends` to the place `over` the landing, the wait, and the descent."""
    performance = airframe.performance
    for bend in bends:
        over_bend = _over(bend, at, is_level=is_level)
        task = _task(performance.way(at.position_enu, over_bend), Mode.RETURNING, at)
        yield task
        at = _at_end(task)
    way = performance.way(at.position_enu, over, performance.autopilot.home_wait_s)
    task = _task(way, Mode.RETURNING, at)
    yield task
    yield from _down_tasks(airframe, _at_end(task), ground_up_m)


def _over(bend: Enu, at: FlightPose, *, is_level: bool) -> Enu:
    """Return a bend at the height of `at`; over uneven ground, or in another layer, at its own."""
    is_layer = abs(bend[2] - at.position_enu[2]) > LAYER_TOLERANCE_M
    return bend if is_layer or not is_level else (bend[0], bend[1], at.position_enu[2])


def _down_tasks(airframe: Airframe, at: FlightPose, ground_up_m: float) -> Iterator[Task]:
    for way in airframe.performance.descent(at.position_enu, ground_up_m):
        yield _task(way, Mode.LANDING, at)


def _stand(airframe: Airframe, at: FlightPose) -> Task:
    """Return a stand without end."""
    way = airframe.performance.way(at.position_enu, at.position_enu, math.inf)
    return _task(way, Mode.HOLDING, at)


def _task(way: Way, mode: Mode, at: FlightPose, viewpoint_index: int | None = None) -> Task:
    """Return a task with constant yaw."""
    return Task(way=way, mode=mode, yaw_rad=at.yaw_rad, viewpoint_index=viewpoint_index)


def _at_end(task: Task) -> FlightPose:
    return standing(task.way.end_enu, task.yaw_rad)
