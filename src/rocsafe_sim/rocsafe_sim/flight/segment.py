# SPDX-License-Identifier: Apache-2.0
"""What a vehicle is about at a time, and where its nose points."""

import math
from dataclasses import dataclass
from enum import Enum

from rocsafe_geo.angle import wrap_rad
from rocsafe_geo.motion.state import STILL, Enu, MotionState


class Mode(Enum):
    """What the vehicle is about, after REP 147."""

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
class Pose:
    """Where a vehicle is, how it moves and where its nose points; metres, seconds, ENU."""

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
        """The pose without the nose."""
        return MotionState(self.position_enu, self.velocity_enu, self.acceleration_enu)


def standing(position_enu: Enu, yaw_rad: float) -> Pose:
    """Return the pose of standing still somewhere."""
    return Pose(position_enu=position_enu, velocity_enu=STILL, yaw_rad=yaw_rad)


@dataclass(frozen=True, slots=True, kw_only=True)
class Segment:
    """A while in which a vehicle is about one thing.

    Attributes
    ----------
    mode : what it is about.
    begin_s, end_s : since the start of the timeline; the end may be infinity.
    yaw_start_rad, yaw_end_rad : nose direction, turned evenly from one to the other.
    viewpoint_index : in the route, of the viewpoint flown to or stood at; None on the way home.
    takes_shot : whether a photograph is due at its end.
    """

    mode: Mode
    begin_s: float
    end_s: float
    yaw_start_rad: float
    yaw_end_rad: float
    viewpoint_index: int | None = None
    takes_shot: bool = False

    def yaw_rad(self, elapsed_s: float) -> float:
        """Return where the nose points at a time, held before the begin and after the end."""
        if elapsed_s >= self.end_s or self.yaw_start_rad == self.yaw_end_rad:
            return self.yaw_end_rad
        turned = max(0.0, elapsed_s - self.begin_s) / (self.end_s - self.begin_s)
        turn = wrap_rad(self.yaw_end_rad - self.yaw_start_rad)
        return wrap_rad(self.yaw_start_rad + turned * turn)
