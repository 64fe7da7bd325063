# SPDX-License-Identifier: Apache-2.0
"""When a flight must be broken off so that the vehicle gets home with its reserve."""

import math

from rocsafe_sim.airframe import Airframe
from rocsafe_sim.route import Enu
from rocsafe_sim.segment import Mode, Pose
from rocsafe_sim.timeline import Timeline, return_segments

# The battery is looked at this often, counted from the flight's start: the decision does not
# depend on the simulation's step.
CHECK_PERIOD_S = 1.0


def return_duration_s(airframe: Airframe, start: Pose, home_enu: Enu) -> float:
    """Return the time from `start` to touch-down at home, braking first if it moves."""
    return sum(segment.duration_s for segment in return_segments(airframe, start, home_enu))


def low_battery_s(
    airframe: Airframe, timeline: Timeline, charge_fraction: float, home_enu: Enu
) -> float:
    """Return when the charge is only just enough to return and keep the reserve.

    Parameters
    ----------
    airframe : of the vehicle.
    timeline : the flight as intended.
    charge_fraction : at the timeline's start, 0 to 1.
    home_enu : where to return to, metres.

    Returns
    -------
    Seconds since the timeline's start, a multiple of `CHECK_PERIOD_S`; infinity if the vehicle
    is on its way home before that happens.
    """
    spare_s = (charge_fraction - airframe.reserve_fraction) * airframe.endurance_s
    margin_s = _margin_s(airframe)
    limits = airframe.limits
    if (
        timeline.duration_s + margin_s + 2.0 * limits.cruise_speed_mps / limits.acceleration_mps2
        < spare_s
    ):
        return math.inf
    homeward_s = timeline.first_start_s(Mode.RETURNING, Mode.LANDING)
    elapsed_s = 0.0
    while elapsed_s < homeward_s:
        home_s = return_duration_s(airframe, timeline.pose(elapsed_s), home_enu)
        if elapsed_s + home_s + margin_s >= spare_s:
            return elapsed_s
        elapsed_s += CHECK_PERIOD_S
    return math.inf


def _margin_s(airframe: Airframe) -> float:
    """Return by how much elapsed time plus time to return can grow until the next check.

    Speeding up away from home costs most: per second 1 s of flight, 1 s more of braking, and 2 s
    for twice the cruise speed's distance. Climbing costs its own second and the later descent.
    """
    climbing = 1.0 + airframe.climb_rate_mps / airframe.descent_rate_mps
    return CHECK_PERIOD_S * max(4.0, climbing)
