# SPDX-License-Identifier: Apache-2.0
"""Legs, climbs and descents of a vehicle in wind."""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_finite, require_positive
from rocsafe_geo.motion.autopilot import ARDUCOPTER, Autopilot
from rocsafe_geo.motion.leg import LimitArrays, leg_duration_s, solve_legs
from rocsafe_geo.motion.limits import MotionLimits
from rocsafe_geo.motion.route_motion import RouteMotion, Way
from rocsafe_geo.motion.state import Enu

GRAVITY_MPS2 = 9.80665
# A vehicle lags behind its autopilot and passes corners nearer than that aims at: recorded flights
# passed at 0.6 to 0.8 of the radius.
_CORNER_SHARE = 0.8
_WINDIEST = 0.95
_SAMPLE_S = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Performance:
    """Limits of the flight of a multirotor, and the wind.

    Attributes
    ----------
    cruise_speed_mps, acceleration_mps2
        Limits of horizontal motion over ground, m/s and m/s^2.
    climb_rate_mps, descent_rate_mps
        Vertical speeds, m/s.
    autopilot
        Settings of its autopilot.
    wind_mps
        Velocity (east, north) of the air, m/s.
    """

    cruise_speed_mps: float
    acceleration_mps2: float
    climb_rate_mps: float
    descent_rate_mps: float
    autopilot: Autopilot = ARDUCOPTER
    wind_mps: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        rates = ('cruise_speed_mps', 'acceleration_mps2', 'climb_rate_mps', 'descent_rate_mps')
        for name in rates:
            require_positive(name, getattr(self, name))
        wind = require_finite('wind_mps', math.hypot(*self.wind_mps))
        if wind > _WINDIEST * self.airspeed_mps:
            raise ValueError(
                f'wind_mps is {wind:g} m/s: must be up to {_WINDIEST} of the '
                f'{self.airspeed_mps:.4g} m/s that lean_angle_deg and drag_per_m let it fly'
            )

    @property
    def corner_radius_m(self) -> float:
        """Distance from a corner in the middle of a turn, metres."""
        return _CORNER_SHARE * self.autopilot.waypoint_radius_m

    @property
    def airspeed_mps(self) -> float:
        """Airspeed at which drag equals the thrust at the largest lean angle, m/s."""
        lean = math.tan(math.radians(self.autopilot.lean_angle_deg))
        return math.sqrt(GRAVITY_MPS2 * lean / self.autopilot.drag_per_m)

    @property
    def level(self) -> MotionLimits:
        """Limits of horizontal motion without wind."""
        return self._level(min(self.cruise_speed_mps, self.airspeed_mps))

    @property
    def vertical(self) -> MotionLimits:
        """Limits of vertical motion, up or down."""
        return self._vertical(max(self.climb_rate_mps, self.descent_rate_mps))

    def fastest(self) -> MotionLimits:
        """Return limits that no leg in any direction exceeds."""
        wind = math.hypot(*self.wind_mps)
        return self._level(min(self.cruise_speed_mps, self.airspeed_mps + wind))

    @property
    def longest_ramp_s(self) -> float:
        """Time that no leg in any direction takes to reach its speed, or to stop from it."""
        ways = (self.fastest(), self.vertical)
        full = max(way.cruise_speed_mps / way.acceleration_mps2 for way in ways)
        rise = max(way.acceleration_mps2 / way.jerk_mps3 for way in ways)
        return full + rise + self.autopilot.smoothing_s

    def legs_s(self, paths: FloatArray) -> FloatArray:
        """Return times from standstill to standstill; paths (..., 2) or (..., 3), metres."""
        east, north = paths[..., 0], paths[..., 1]
        up = paths[..., 2] if paths.shape[-1] > 2 else np.zeros_like(east)
        if self.wind_mps == (0.0, 0.0) and not np.any(up):
            return np.asarray(leg_duration_s(np.hypot(east, north), self.fastest()))
        distance, limits = self._limits_along(east, north, up)
        return solve_legs(distance, limits).duration_s

    def way(self, start: Enu, end: Enu, stand_s: float = 0.0, *, is_passed: bool = False) -> Way:
        """Return the leg from one place to another."""
        path = [np.asarray(b - a) for a, b in zip(start, end, strict=True)]
        _, limits = self._limits_along(path[0], path[1], path[2])
        speed, acceleration, jerk, smoothing = (float(limit) for limit in limits)
        return Way(
            end_enu=end,
            limits=MotionLimits(speed, acceleration, jerk, smoothing),
            stand_s=stand_s,
            is_passed=is_passed,
        )

    def ascent(self, ground: Enu, up_m: float) -> list[Way]:
        """Return take-off and climb from the ground, or from a height in the air."""
        over = (ground[0], ground[1], up_m)
        return [self.way(ground, ground, self.autopilot.take_off_delay_s), self.way(ground, over)]

    def descent(self, start: Enu, ground_up_m: float) -> list[Way]:
        """Return the way straight down to the ground, slower near it."""
        east, north, up = start
        ground = (east, north, ground_up_m)
        slow = (east, north, ground_up_m + self.autopilot.landing_height_m)
        fast = [] if up <= slow[2] else [self.way(start, slow, is_passed=True)]
        landing = self._vertical(min(self.autopilot.landing_speed_mps, self.descent_rate_mps))
        return [*fast, Way(end_enu=ground, limits=landing, stand_s=self.autopilot.landed_delay_s)]

    def ascent_s(self, height_m: float) -> float:
        """Return the time from the take-off command until `height_m` above ground."""
        return self.ascent_motion(height_m).duration_s

    def ascent_motion(self, height_m: float) -> RouteMotion:
        """Return the motion from the take-off command until `height_m` above ground."""
        return self._motion(self.ascent((0.0, 0.0, 0.0), height_m))

    def descent_motion(self, height_m: float) -> RouteMotion:
        """Return the motion from `height_m` above home, after the wait there, to the ground."""
        high = (0.0, 0.0, height_m)
        return self._motion(self.descent(high, 0.0), high)

    def descent_s(self, height_m: float) -> float:
        """Return the time from arrival above home at `height_m` to standing motors."""
        return self.autopilot.home_wait_s + self.descent_motion(height_m).duration_s

    def low_s(self, height_m: float, low_m: float) -> tuple[float, float]:
        """Return how long a vehicle that climbs to and descends from a height is low.

        That is less than `low_m` above ground: after the take-off command, and before its motors
        stand still; a tenth of a second less at most.
        """
        climb, descent = self.ascent_motion(height_m), self.descent_motion(height_m)
        low_m = min(low_m, height_m)
        longest_s = max(climb.duration_s, descent.duration_s)
        times = _SAMPLE_S * np.arange(int(longest_s / _SAMPLE_S) + 1, dtype=np.float64)
        is_low = climb.positions(times)[:, 2] < low_m
        is_high = descent.positions(times)[:, 2] >= low_m
        return (
            float(times[is_low].max(initial=0.0)),
            descent.duration_s - float(times[is_high].max(initial=0.0)) - _SAMPLE_S,
        )

    def _motion(self, ways: list[Way], start: Enu = (0.0, 0.0, 0.0)) -> RouteMotion:
        return RouteMotion(start, ways, self.corner_radius_m)

    def _vertical(self, speed_mps: float) -> MotionLimits:
        return MotionLimits(
            speed_mps,
            self.autopilot.vertical_acceleration_mps2,
            self.autopilot.vertical_jerk_mps3,
            self.autopilot.smoothing_s,
        )

    def _level(self, speed_mps: float) -> MotionLimits:
        autopilot = self.autopilot
        return MotionLimits(
            speed_mps, self.acceleration_mps2, autopilot.jerk_mps3, autopilot.smoothing_s
        )

    def _limits_along(
        self, east: FloatArray, north: FloatArray, up: FloatArray
    ) -> tuple[FloatArray, LimitArrays]:
        """Return lengths of paths and limits along them, horizontal and vertical ones combined."""
        flat = np.hypot(east, north)
        length = np.hypot(flat, up)
        level = np.divide(flat, length, out=np.ones_like(length), where=length > 0.0)
        steep = np.divide(np.abs(up), length, out=np.zeros_like(length), where=length > 0.0)
        rate = np.where(up > 0.0, self.climb_rate_mps, self.descent_rate_mps)
        limits = self.autopilot
        return length, (
            _less_of(self._over_ground_mps(east, north, flat), level, rate, steep),
            _less_of(self.acceleration_mps2, level, limits.vertical_acceleration_mps2, steep),
            _less_of(limits.jerk_mps3, level, limits.vertical_jerk_mps3, steep),
            np.asarray(limits.smoothing_s),
        )

    def _over_ground_mps(
        self, east: FloatArray, north: FloatArray, flat: FloatArray
    ) -> FloatArray:
        """Return the speed over ground along horizontal paths.

        A vehicle keeps its track at a crab angle. One component of its largest airspeed
        compensates the wind across the track. The other component, plus the wind along the track,
        is its speed.
        """
        length = np.where(flat > 0.0, flat, 1.0)
        wind_east, wind_north = self.wind_mps
        along = (east * wind_east + north * wind_north) / length
        across = (east * wind_north - north * wind_east) / length
        possible = along + np.sqrt(self.airspeed_mps**2 - across**2)
        speed: FloatArray = np.minimum(self.cruise_speed_mps, possible)
        return speed


def _less_of(
    level: FloatArray | float, level_part: FloatArray, rate: FloatArray | float, steep: FloatArray
) -> FloatArray:
    """Return the limit along paths, given the level and the vertical part of their direction."""
    with np.errstate(divide='ignore', over='ignore'):
        less: FloatArray = np.minimum(level / level_part, rate / steep)
    return less
