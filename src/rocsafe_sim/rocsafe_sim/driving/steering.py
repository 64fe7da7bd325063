# SPDX-License-Identifier: Apache-2.0
"""Steering along a straight line: speed and rate of turn for the next tick.

The rate of turn is that of a circle through the vehicle and a point ahead on the line (pure
pursuit, R. C. Coulter, CMU-RI-TR-92-01, 1992).
"""

import math
from dataclasses import dataclass

from rocsafe_geo.angle import wrap_rad
from rocsafe_geo.motion.ground_motion import GroundMotion, Place

# Distance of the point that is steered to.
AHEAD_M = 1.0
# The vehicle is at the end of a line, and looks where it is to look, within this.
ARRIVED_M, ALIGNED_RAD = 0.05, 0.02
# Least speed on a line.
CREEP_MPS = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """A line to drive: its ends, its speed limit, and the speed at its end."""

    begin: Place
    end: Place
    limit_mps: float
    end_mps: float

    @property
    def length_m(self) -> float:
        """Length of the line."""
        return math.dist(self.begin, self.end)

    @property
    def yaw_rad(self) -> float:
        """Its direction, from east to north."""
        return math.atan2(self.end[1] - self.begin[1], self.end[0] - self.begin[0])

    def left_m(self, place: Place) -> float:
        """Return the distance along the line from beside `place` to its end."""
        yaw = self.yaw_rad
        east, north = self.end[0] - place[0], self.end[1] - place[1]
        return east * math.cos(yaw) + north * math.sin(yaw)


def along(begin: Place, end: Place, distance_m: float) -> Place:
    """Return the place so far from `begin` on the way to `end`."""
    share = distance_m / max(math.dist(begin, end), 1e-9)
    return begin[0] + share * (end[0] - begin[0]), begin[1] + share * (end[1] - begin[1])


def speed_mps(
    line: Line, left_m: float, now_mps: float, motion: GroundMotion, tick_s: float
) -> float:
    """Return the speed after a tick: as fast as limit, end of the line and acceleration allow."""
    a = motion.acceleration_mps2
    braking = math.sqrt(line.end_mps**2 + 2.0 * a * max(left_m, 0.0))
    wanted = min(line.limit_mps, braking)
    # A vehicle without speed would never arrive.
    wanted = max(wanted, min(CREEP_MPS, line.limit_mps))
    return min(max(wanted, now_mps - 2.0 * a * tick_s), now_mps + a * tick_s)


def turn_rate_radps(
    line: Line, place: Place, yaw_rad: float, now_mps: float, motion: GroundMotion
) -> float:
    """Return the rate of turn that leads to the line."""
    direction = line.yaw_rad
    # Beyond the end of the line, if that is nearer.
    ahead = AHEAD_M - line.left_m(place)
    target = (
        line.end[0] + ahead * math.cos(direction),
        line.end[1] + ahead * math.sin(direction),
    )
    bearing = math.atan2(target[1] - place[1], target[0] - place[0])
    reach = max(math.dist(target, place), 0.25)
    rate = 2.0 * now_mps * math.sin(float(wrap_rad(bearing - yaw_rad))) / reach
    return min(max(rate, -motion.turn_rate_radps), motion.turn_rate_radps)


def pivoted(yaw_rad: float, target_rad: float, motion: GroundMotion, tick_s: float) -> float:
    """Return the direction after a tick of turning in place."""
    turn = float(wrap_rad(target_rad - yaw_rad))
    most = motion.turn_rate_radps * tick_s
    return float(wrap_rad(yaw_rad + min(max(turn, -most), most)))


def is_aligned(yaw_rad: float, target_rad: float) -> bool:
    """Return whether the vehicle looks there."""
    return abs(float(wrap_rad(target_rad - yaw_rad))) <= ALIGNED_RAD
