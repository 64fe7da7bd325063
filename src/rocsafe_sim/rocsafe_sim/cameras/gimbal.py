# SPDX-License-Identifier: Apache-2.0
"""Direction of a camera on a vehicle, and the gimbal that turns it.

The direction of a gimbal is a closed-form function of the time since its last command. Neither the
step of the simulation nor a restart changes it.
"""

import math
from dataclasses import dataclass

from rocsafe_geo.angle import wrap_rad
from rocsafe_geo.limits import require_between, require_finite, require_positive
from rocsafe_geo.time_units import NS_PER_S

NADIR_RAD = -0.5 * math.pi


@dataclass(frozen=True, slots=True, kw_only=True)
class Direction:
    """Direction of a view.

    Attributes
    ----------
    pitch_rad
        Angle above the horizon: -pi/2 is straight down.
    yaw_rad
        Angle from the nose of the vehicle, anticlockwise.
    """

    pitch_rad: float = NADIR_RAD
    yaw_rad: float = 0.0

    def __post_init__(self) -> None:
        require_between('pitch_rad', self.pitch_rad, NADIR_RAD, -NADIR_RAD, 'rad')
        require_finite('yaw_rad', self.yaw_rad, 'rad')


@dataclass(frozen=True, slots=True, kw_only=True)
class GimbalLimits:
    """Limits of a gimbal.

    Attributes
    ----------
    rate_radps
        Rate of pitch and of yaw, rad/s.
    lowest_rad, highest_rad
        Limits of the pitch.
    """

    rate_radps: float = math.radians(60.0)
    lowest_rad: float = NADIR_RAD
    highest_rad: float = math.radians(30.0)

    def __post_init__(self) -> None:
        require_positive('rate_radps', self.rate_radps, 'rad/s')
        require_between('lowest_rad', self.lowest_rad, NADIR_RAD, self.highest_rad, 'rad')
        require_between('highest_rad', self.highest_rad, self.lowest_rad, -NADIR_RAD, 'rad')


@dataclass(frozen=True, slots=True, kw_only=True)
class GimbalTurn:
    """A turn of a gimbal, from the state in which a command reached it.

    Attributes
    ----------
    start_ns
        Simulated time of the command, nanoseconds.
    start
        Direction at that time.
    target
        Direction to turn to.
    """

    start_ns: int
    start: Direction
    target: Direction


class Gimbal:
    """A gimbal that turns a camera.

    Parameters
    ----------
    limits
        Limits of rate and pitch.
    rest
        Direction until the first command.
    """

    def __init__(self, limits: GimbalLimits, rest: Direction) -> None:
        self.limits = limits
        self.turn = GimbalTurn(start_ns=0, start=rest, target=rest)

    def point(self, target: Direction, time_ns: int) -> None:
        """Turn towards `target` from `time_ns` on; its pitch is clipped to the limits."""
        limits = self.limits
        pitch = min(max(target.pitch_rad, limits.lowest_rad), limits.highest_rad)
        within = Direction(pitch_rad=pitch, yaw_rad=wrap_rad(target.yaw_rad))
        self.turn = GimbalTurn(start_ns=time_ns, start=self.direction(time_ns), target=within)

    def direction(self, time_ns: int) -> Direction:
        """Return the direction at a time; before its last turn the gimbal stood still."""
        turn = self.turn
        reach = self.limits.rate_radps * max(0.0, (time_ns - turn.start_ns) / NS_PER_S)
        pitch = turn.target.pitch_rad - turn.start.pitch_rad
        yaw = wrap_rad(turn.target.yaw_rad - turn.start.yaw_rad)
        return Direction(
            pitch_rad=turn.target.pitch_rad
            if abs(pitch) <= reach
            else turn.start.pitch_rad + math.copysign(reach, pitch),
            yaw_rad=turn.target.yaw_rad
            if abs(yaw) <= reach
            else wrap_rad(turn.start.yaw_rad + math.copysign(reach, yaw)),
        )

    def is_settled(self, time_ns: int) -> bool:
        """Return whether it points to its target."""
        return self.direction(time_ns) == self.turn.target
