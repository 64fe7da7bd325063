# SPDX-License-Identifier: Apache-2.0
"""Time at which a vehicle must end its flight to land with its reserve."""

import math
from functools import lru_cache

import numpy as np

from rocsafe_geo.motion.performance import Performance
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.flight.fall import Fall
from rocsafe_sim.flight.route import FlightRoute
from rocsafe_sim.flight.segment import FlightPose, Mode
from rocsafe_sim.flight.tasks import LEVEL_TOLERANCE_M, safe_up, stopped
from rocsafe_sim.flight.timeline import Timeline

# Period of the checks of the battery, counted from the start of the flight, so that the decision
# does not depend on the step of the simulation.
CHECK_PERIOD_S = 1.0


def return_duration_s(
    airframe: Airframe, start: FlightPose, route: FlightRoute, number: int = 0
) -> float:
    """Return the time from `start` to standing motors at the refuge, including a stop first.

    It equals the duration of the timeline of this diversion, but is faster to compute.
    """
    performance = airframe.performance
    stop, at = stopped(airframe, start)
    ground = route.refuge(start.position_enu, number)
    up_m = safe_up(route, at.position_enu[2])
    corners = (at.position_enu, *route.around(at.position_enu, ground), ground)
    legs_s = performance.legs_s(np.diff(np.array(corners)[:, :2], axis=0)).sum()
    down_s = _descent_s(performance, up_m - ground[2])
    climb = np.array([0.0, 0.0, up_m - at.position_enu[2]])
    climb_s = float(performance.legs_s(climb)) if climb[2] > 0.0 else 0.0
    return (0.0 if stop is None else stop.duration_s) + climb_s + float(legs_s) + down_s


@lru_cache(maxsize=64)
def _descent_s(performance: Performance, height_m: float) -> float:
    return performance.descent_s(height_m)


def low_battery_s(
    airframe: Airframe,
    timeline: Timeline | Fall,
    charge_fraction: float,
    route: FlightRoute,
    number: int = 0,
    *,
    climbs: bool = False,
) -> float:
    """Return the time at which the charge is just enough to land at the refuge with the reserve.

    Parameters
    ----------
    airframe
        Performance of the vehicle.
    timeline
        Flight as planned.
    charge_fraction
        Charge at the start of the timeline, 0 to 1.
    route
        Route, with its landing places and exclusions.
    number
        Number of the flight of the route.
    climbs
        Whether it may climb on its way.

    Returns
    -------
    float
        Seconds since the start of the timeline, a multiple of `CHECK_PERIOD_S`. Infinite if the
        flight keeps the reserve, or returns before. The way to the refuge counts at full power.
    """
    spare_s = (charge_fraction - airframe.reserve_fraction) * airframe.endurance_s
    watt_s_per_s = airframe.power.capacity_j / airframe.endurance_s
    end_s = timeline.duration_s
    if math.isfinite(end_s) and timeline.used_j(end_s) <= spare_s * watt_s_per_s:
        return math.inf
    level_from_s = math.inf if climbs else _level_from_s(timeline, route)
    homeward_s = timeline.first_start_s(Mode.RETURNING, Mode.LANDING)
    stands_from_s = timeline.stands_from_s
    elapsed_s, home_s, stood = 0.0, 0.0, False
    while elapsed_s < homeward_s:
        margin_s = CHECK_PERIOD_S * _growth_s(airframe, elapsed_s >= level_from_s)
        used_s = timeline.used_j(elapsed_s) / watt_s_per_s
        if not stood:
            home_s = return_duration_s(airframe, timeline.pose(elapsed_s), route, number)
            stood = elapsed_s >= stands_from_s
        left_s = spare_s - used_s - home_s - margin_s
        if left_s <= 0.0:
            return elapsed_s
        # No check is needed before the need can have grown by what is left.
        grows_s = margin_s
        if elapsed_s >= stands_from_s:
            grows_s = CHECK_PERIOD_S * timeline.power_w(elapsed_s) / watt_s_per_s
        elapsed_s += CHECK_PERIOD_S * max(1, math.floor(left_s / grows_s))
    return math.inf


def _level_from_s(timeline: Timeline | Fall, route: FlightRoute) -> float:
    """Return the time from which on the vehicle does not climb."""
    heights = [waypoint.position_enu[2] for waypoint in route.waypoints]
    is_level = max(heights, default=0.0) - min(heights, default=0.0) <= LEVEL_TOLERANCE_M
    begin_s = timeline.first_start_s(Mode.FLYING, Mode.HOLDING)
    return begin_s if is_level and math.isfinite(begin_s) else math.inf


def _growth_s(airframe: Airframe, is_level: bool) -> float:
    """Return an upper bound of the growth of time used plus time to return, seconds per second.

    Acceleration away from home costs most: 1 s of flight, up to 3 s of additional braking, and
    the way back that was flown in these 4 s, or in a climb the descent.
    """
    performance = airframe.performance
    slowest = min(performance.descent_rate_mps, performance.autopilot.landing_speed_mps)
    return 8.0 if is_level else 4.0 * (1.0 + max(1.0, performance.climb_rate_mps / slowest))
