# SPDX-License-Identifier: Apache-2.0
"""When a flight must be broken off so that the vehicle gets home with its reserve."""

import math
from functools import lru_cache

import numpy as np

from rocsafe_geo.motion.performance import Performance
from rocsafe_sim.airframe import Airframe
from rocsafe_sim.route import Route
from rocsafe_sim.segment import Mode, Pose
from rocsafe_sim.tasks import LEVEL_TOLERANCE_M, stopped
from rocsafe_sim.timeline import Timeline

# The battery is looked at this often, counted from the flight's start: the decision does not
# depend on the simulation's step.
CHECK_PERIOD_S = 1.0


def return_duration_s(airframe: Airframe, start: Pose, route: Route) -> float:
    """Return the time from `start` to standing motors at home, braking first if it moves.

    As long as the timeline of such a return, which takes longer to make.
    """
    performance = airframe.performance
    stop, at = stopped(airframe, start)
    corners = (at.position_enu, *route.around(at.position_enu, route.home_enu), route.home_enu)
    legs_s = performance.legs_s(np.diff(np.array(corners)[:, :2], axis=0)).sum()
    down_s = _descent_s(performance, at.position_enu[2] - route.home_enu[2])
    return (0.0 if stop is None else stop.duration_s) + float(legs_s) + down_s


@lru_cache(maxsize=64)
def _descent_s(performance: Performance, height_m: float) -> float:
    return performance.descent_s(height_m)


def low_battery_s(
    airframe: Airframe, timeline: Timeline, charge_fraction: float, route: Route
) -> float:
    """Return when the charge is only just enough to return and keep the reserve.

    Parameters
    ----------
    airframe : of the vehicle.
    timeline : the flight as intended.
    charge_fraction : at the timeline's start, 0 to 1.
    route : with the home to return to, and what is not flown over.

    Returns
    -------
    Seconds since the timeline's start, a multiple of `CHECK_PERIOD_S`; infinity if the vehicle
    is on its way home before that happens. The way home is reckoned at full power.
    """
    spare_s = (charge_fraction - airframe.reserve_fraction) * airframe.endurance_s
    if timeline.duration_s + _detour_s(airframe) < spare_s:
        return math.inf
    level_from_s = _level_from_s(timeline, route)
    homeward_s = timeline.first_start_s(Mode.RETURNING, Mode.LANDING)
    watt_s_per_s = airframe.power.capacity_j / airframe.endurance_s
    elapsed_s = 0.0
    while elapsed_s < homeward_s:
        margin_s = CHECK_PERIOD_S * _growth_s(airframe, elapsed_s >= level_from_s)
        used_s = timeline.used_j(elapsed_s) / watt_s_per_s
        home_s = return_duration_s(airframe, timeline.pose(elapsed_s), route)
        left_s = spare_s - used_s - home_s - margin_s
        if left_s <= 0.0:
            return elapsed_s
        # no look is needed before the need can have grown by what is left
        elapsed_s += CHECK_PERIOD_S * max(1, math.floor(left_s / margin_s))
    return math.inf


def _detour_s(airframe: Airframe) -> float:
    """Return by how much a return from on the way can outlast the rest of the flight."""
    level = airframe.performance.level
    stop_s = level.cruise_speed_mps / level.acceleration_mps2
    return 2.0 * (stop_s + level.acceleration_mps2 / level.jerk_mps3 + level.smoothing_s)


def _level_from_s(timeline: Timeline, route: Route) -> float:
    """Return from when on the vehicle climbs no more."""
    heights = {waypoint.position_enu[2] for waypoint in route.waypoints}
    is_level = max(heights) - min(heights) <= LEVEL_TOLERANCE_M
    begin_s = timeline.first_start_s(Mode.FLYING, Mode.HOLDING)
    return begin_s if is_level and math.isfinite(begin_s) else math.inf


def _growth_s(airframe: Airframe, is_level: bool) -> float:
    """Return by how much time used plus time to return can grow in a second.

    Speeding up away from home costs most: 1 s of flight, up to 3 s more of braking with its
    jerks, and the way flown in these 4 s and back again; or, in a climb, down again.
    """
    performance = airframe.performance
    slowest = min(performance.descent_rate_mps, performance.autopilot.landing_speed_mps)
    return 8.0 if is_level else 4.0 * (1.0 + max(1.0, performance.climb_rate_mps / slowest))
