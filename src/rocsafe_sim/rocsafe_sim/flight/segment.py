# SPDX-License-Identifier: Apache-2.0
"""Segments of a flight: mode of the vehicle, and its yaw over time."""

import math
from dataclasses import dataclass
from enum import Enum

from rocsafe_geo.angle import wrap_rad
from rocsafe_geo.motion.state import STILL, Enu, MotionState


class Mode(Enum):
    """Mode of a vehicle, by REP 147."""

    DISARMED = 'disarmed'
    WAITING = 'waiting'
    TAKING_OFF = 'taking off'
    FLYING = 'flying'
    HOLDING = 'holding'
    RETURNING = 'returning'
    LANDING = 'landing'
    LANDED = 'landed'
    FALLING = 'falling'
    CRASHED = 'crashed'

    @property
    def is_airborne(self) -> bool:
        """Whether the vehicle is off the ground."""
        return self not in (Mode.DISARMED, Mode.WAITING, Mode.LANDED, Mode.CRASHED)


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightPose:
    """Position, velocity, acceleration and yaw of a vehicle; metres, seconds, ENU."""

    position_enu: Enu
    velocity_enu: Enu
    yaw_rad: float
    acceleration_enu: Enu = STILL

    @property
    def speed_mps(self) -> float:
        """Horizontal speed."""
        return math.hypot(self.velocity_enu[0], self.velocity_enu[1])

    @property
    def motion(self) -> MotionState:
        """The pose without the yaw."""
        return MotionState(self.position_enu, self.velocity_enu, self.acceleration_enu)


def standing(position_enu: Enu, yaw_rad: float) -> FlightPose:
    """Return the pose of a vehicle that stands still."""
    return FlightPose(position_enu=position_enu, velocity_enu=STILL, yaw_rad=yaw_rad)


@dataclass(frozen=True, slots=True, kw_only=True)
class Segment:
    """A part of a flight in one mode.

    Attributes
    ----------
    mode
        Mode of the vehicle.
    begin_s, end_s
        Seconds since the start of the timeline; the end may be infinite.
    yaw_start_rad, yaw_end_rad
        Yaw at begin and end, interpolated linearly.
    viewpoint_index
        Index in the route of the viewpoint flown to or stood at; None on the way home.
    takes_shot
        Whether its end is photographed.
    """

    mode: Mode
    begin_s: float
    end_s: float
    yaw_start_rad: float
    yaw_end_rad: float
    viewpoint_index: int | None = None
    takes_shot: bool = False

    def yaw_rad(self, elapsed_s: float) -> float:
        """Return the yaw at a time; constant before the begin and after the end."""
        if elapsed_s >= self.end_s or self.yaw_start_rad == self.yaw_end_rad:
            return self.yaw_end_rad
        turned = max(0.0, elapsed_s - self.begin_s) / (self.end_s - self.begin_s)
        turn = wrap_rad(self.yaw_end_rad - self.yaw_start_rad)
        return wrap_rad(self.yaw_start_rad + turned * turn)
