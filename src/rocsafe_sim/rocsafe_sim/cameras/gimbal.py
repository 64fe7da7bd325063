# SPDX-License-Identifier: Apache-2.0
"""How a camera hangs on a vehicle, and how a gimbal turns it.

Where a gimbal points is a closed-form function of the time since its last order, as the flight of
its vehicle is: neither the step of the simulation nor a restart changes it.
"""

import math
from dataclasses import dataclass

from rocsafe_geo.angle import wrap_rad
from rocsafe_geo.limits import require_between, require_finite, require_positive
from rocsafe_geo.time_units import NS_PER_S

NADIR_RAD = -0.5 * math.pi


@dataclass(frozen=True, slots=True, kw_only=True)
class Direction:
    """Where a camera looks.

    Attributes
    ----------
    pitch_rad : of the view above the horizon: -pi/2 straight down.
    yaw_rad : of the view from the vehicle's nose, anticlockwise.
    """

    pitch_rad: float = NADIR_RAD
    yaw_rad: float = 0.0

    def __post_init__(self) -> None:
        require_between('pitch_rad', self.pitch_rad, NADIR_RAD, -NADIR_RAD, 'rad')
        require_finite('yaw_rad', self.yaw_rad, 'rad')


@dataclass(frozen=True, slots=True, kw_only=True)
class GimbalLimits:
    """What a gimbal can do.

    Attributes
    ----------
    rate_radps : of turning, in pitch and in yaw each.
    lowest_rad, highest_rad : of the pitch.
    """

    rate_radps: float = math.radians(60.0)
    lowest_rad: float = NADIR_RAD
    highest_rad: float = math.radians(30.0)

    def __post_init__(self) -> None:
        require_positive('rate_radps', self.rate_radps, 'rad/s')
        require_between('lowest_rad', self.lowest_rad, NADIR_RAD, self.highest_rad, 'rad')
        require_between('highest_rad', self.highest_rad, self.lowest_rad, -NADIR_RAD, 'rad')


@dataclass(frozen=True, slots=True, kw_only=True)
class GimbalOrder:
    """An order with the state in which it reached the gimbal: all that follows, follows from it.

    Attributes
    ----------
    start_ns : simulated time.
    start : where it pointed then.
    target : where it is to point.
    """

    start_ns: int
    start: Direction
    target: Direction


class Gimbal:
    """Turns a camera, no faster than it can.

    Parameters
    ----------
    limits : what it can do.
    rest : where it points until it is told otherwise.
    """

    def __init__(self, limits: GimbalLimits, rest: Direction) -> None:
        self.limits = limits
        self.order = GimbalOrder(start_ns=0, start=rest, target=rest)

    def point(self, target: Direction, time_ns: int) -> None:
        """Turn towards `target` from `time_ns` on; a pitch out of reach counts as the nearest."""
        limits = self.limits
        pitch = min(max(target.pitch_rad, limits.lowest_rad), limits.highest_rad)
        within = Direction(pitch_rad=pitch, yaw_rad=wrap_rad(target.yaw_rad))
        self.order = GimbalOrder(start_ns=time_ns, start=self.direction(time_ns), target=within)

    def direction(self, time_ns: int) -> Direction:
        """Return where it points at a time; before its last order it stood still."""
        order = self.order
        reach = self.limits.rate_radps * max(0.0, (time_ns - order.start_ns) / NS_PER_S)
        pitch = order.target.pitch_rad - order.start.pitch_rad
        yaw = wrap_rad(order.target.yaw_rad - order.start.yaw_rad)
        return Direction(
            pitch_rad=order.target.pitch_rad
            if abs(pitch) <= reach
            else order.start.pitch_rad + math.copysign(reach, pitch),
            yaw_rad=order.target.yaw_rad
            if abs(yaw) <= reach
            else wrap_rad(order.start.yaw_rad + math.copysign(reach, yaw)),
        )

    def is_settled(self, time_ns: int) -> bool:
        """Return whether it points where it was told to."""
        return self.direction(time_ns) == self.order.target
