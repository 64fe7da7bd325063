# SPDX-License-Identifier: Apache-2.0
"""Pieces of a flight, each a closed-form function of the time since it began."""

import math
from dataclasses import dataclass
from enum import Enum

from rocsafe_geo.angle import wrap_rad
from rocsafe_geo.motion import MotionLimits, leg_duration_s, leg_progress_m, leg_speed_mps
from rocsafe_sim.airframe import Airframe
from rocsafe_sim.route import Enu, horizontal_m


class Mode(Enum):
    """What the vehicle is about, after REP 147."""

    DISARMED = 'disarmed'
    TAKING_OFF = 'taking off'
    FLYING = 'flying'
    HOLDING = 'holding'
    RETURNING = 'returning'
    LANDING = 'landing'
    LANDED = 'landed'

    @property
    def is_airborne(self) -> bool:
        """Whether the motors carry the vehicle."""
        return self not in (Mode.DISARMED, Mode.LANDED)


class Motion(Enum):
    """How a segment moves."""

    STAND = 'stand'  # does not
    LEG = 'leg'  # from standstill to standstill
    BRAKE = 'brake'  # from some speed to standstill


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """Where a vehicle is, how it moves and where its nose points; metres, m/s, ENU."""

    position_enu: Enu
    velocity_enu: Enu
    yaw_rad: float

    @property
    def speed_mps(self) -> float:
        """Horizontal speed."""
        return math.hypot(self.velocity_enu[0], self.velocity_enu[1])


def standing(position_enu: Enu, yaw_rad: float) -> Pose:
    """Return the pose of standing still somewhere."""
    return Pose(position_enu=position_enu, velocity_enu=(0.0, 0.0, 0.0), yaw_rad=yaw_rad)


@dataclass(frozen=True, slots=True, kw_only=True)
class Segment:
    """One piece of a flight.

    Attributes
    ----------
    mode : what the vehicle is about meanwhile.
    motion : how it moves.
    duration_s : infinity for a stand without end.
    start_enu, end_enu : metres.
    yaw_start_rad, yaw_end_rad : nose direction, turned evenly from one to the other.
    viewpoint_index : in the route, of the viewpoint flown to or stood at; None on the way home.
    takes_shot : whether a photograph is due at its end.
    limits : of horizontal motion.
    """

    mode: Mode
    motion: Motion
    duration_s: float
    start_enu: Enu
    end_enu: Enu
    yaw_start_rad: float
    yaw_end_rad: float
    viewpoint_index: int | None = None
    takes_shot: bool = False
    limits: MotionLimits

    @property
    def distance_m(self) -> float:
        """Horizontal distance from start to end."""
        return horizontal_m(self.start_enu, self.end_enu)

    def progress_m(self, elapsed_s: float) -> float:
        """Return the horizontal distance covered `elapsed_s` seconds after the start."""
        if self.motion is Motion.STAND or elapsed_s <= 0.0:
            return 0.0
        distance = self.distance_m
        if elapsed_s >= self.duration_s:
            return distance
        if self.motion is Motion.BRAKE:
            left_s = self.duration_s - elapsed_s
            return distance - 0.5 * self.limits.acceleration_mps2 * left_s**2
        return leg_progress_m(elapsed_s, distance, self.limits)

    def pose(self, elapsed_s: float) -> Pose:
        """Return the pose `elapsed_s` seconds after the start, held at both ends."""
        elapsed = min(max(elapsed_s, 0.0), self.duration_s)
        if self.motion is Motion.STAND:
            return standing(self.end_enu, self.yaw_end_rad)
        return self._moving_pose(elapsed)

    def _moving_pose(self, elapsed: float) -> Pose:
        (x0, y0, _), (x1, y1, _) = self.start_enu, self.end_enu
        distance = self.distance_m
        share = self.progress_m(elapsed) / distance if distance else 1.0
        per_m = self._speed_mps(elapsed) / distance if distance else 0.0
        up, up_rate = self._height(elapsed)
        turn = wrap_rad(self.yaw_end_rad - self.yaw_start_rad)
        turned = elapsed / self.duration_s if self.duration_s else 1.0
        return Pose(
            position_enu=(x0 + share * (x1 - x0), y0 + share * (y1 - y0), up),
            velocity_enu=((x1 - x0) * per_m, (y1 - y0) * per_m, up_rate),
            yaw_rad=wrap_rad(self.yaw_start_rad + turned * turn),
        )

    def _speed_mps(self, elapsed: float) -> float:
        if self.motion is Motion.BRAKE:
            return self.limits.acceleration_mps2 * (self.duration_s - elapsed)
        return leg_speed_mps(elapsed, self.distance_m, self.limits)

    def _height(self, elapsed: float) -> tuple[float, float]:
        """Return height and its rate: it changes evenly over the segment."""
        start, change = self.start_enu[2], self.end_enu[2] - self.start_enu[2]
        if elapsed >= self.duration_s:
            return self.end_enu[2], 0.0
        return start + change * elapsed / self.duration_s, change / self.duration_s


def leg(mode: Mode, start: Pose, end_enu: Enu, yaw_rad: float, airframe: Airframe) -> Segment:
    """Return the way from standstill at `start` to standstill at `end_enu`.

    Horizontally it is the trapezoid of `rocsafe_geo.motion`; a change of height that takes longer
    than that stretches it, so that neither rate is exceeded.
    """
    change = end_enu[2] - start.position_enu[2]
    level_s = leg_duration_s(horizontal_m(start.position_enu, end_enu), airframe.limits)
    return Segment(
        mode=mode,
        motion=Motion.LEG,
        duration_s=max(level_s, abs(change) / airframe.vertical_rate_mps(change)),
        start_enu=start.position_enu,
        end_enu=end_enu,
        yaw_start_rad=start.yaw_rad,
        yaw_end_rad=yaw_rad,
        limits=airframe.limits,
    )


def stand(mode: Mode, at: Pose, duration_s: float, limits: MotionLimits) -> Segment:
    """Return a stand of `duration_s` seconds, or infinity, at `at`."""
    return Segment(
        mode=mode,
        motion=Motion.STAND,
        duration_s=duration_s,
        start_enu=at.position_enu,
        end_enu=at.position_enu,
        yaw_start_rad=at.yaw_rad,
        yaw_end_rad=at.yaw_rad,
        limits=limits,
    )


def brake(mode: Mode, start: Pose, limits: MotionLimits) -> Segment:
    """Return the way from `start`, moving, to the nearest standstill at the same height."""
    speed = start.speed_mps
    duration_s = speed / limits.acceleration_mps2
    x, y, up = start.position_enu
    half_s = 0.5 * duration_s
    end = (x + start.velocity_enu[0] * half_s, y + start.velocity_enu[1] * half_s, up)
    return Segment(
        mode=mode,
        motion=Motion.BRAKE,
        duration_s=duration_s,
        start_enu=start.position_enu,
        end_enu=end,
        yaw_start_rad=start.yaw_rad,
        yaw_end_rad=start.yaw_rad,
        limits=limits,
    )
