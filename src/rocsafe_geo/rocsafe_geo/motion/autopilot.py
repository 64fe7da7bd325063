# SPDX-License-Identifier: Apache-2.0
"""Settings of an autopilot that determine the duration of a flight.

The defaults are those of ArduCopter 4 (parameter names in brackets), or were measured on its
recorded flights.
"""

from dataclasses import dataclass, fields

from rocsafe_geo.limits import require_between, require_not_negative, require_positive
from rocsafe_geo.motion.limits import DEFAULT_JERK_MPS3, DEFAULT_SMOOTHING_S

_MAY_BE_ZERO = (
    'smoothing_s', 'waypoint_radius_m', 'landing_height_m', 'take_off_delay_s', 'home_wait_s',
    'landed_delay_s',
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Autopilot:
    """How an autopilot moves a multirotor.

    Attributes
    ----------
    jerk_mps3
        Jerk of horizontal motion, m/s^3 (WPNAV_JERK).
    smoothing_s
        Time in which the jerk rises and falls, seconds (twice ATC_INPUT_TC).
    vertical_acceleration_mps2, vertical_jerk_mps3
        Acceleration and jerk of climb and descent, m/s^2 and m/s^3 (WPNAV_ACCEL_Z).
    waypoint_radius_m
        Radius within which a corner without a stop is passed, metres (WPNAV_RADIUS).
    lean_angle_deg
        Largest lean angle, degrees (ANGLE_MAX). With the drag it limits the airspeed.
    drag_per_m
        Drag over mass and airspeed squared, 1/m. Measured: 10.25 m/s at 30 degrees.
    landing_speed_mps, landing_height_m
        Vertical speed near the ground, m/s (LAND_SPEED), and the height below which it applies,
        metres (LAND_ALT_LOW).
    take_off_delay_s
        Time from the command to the climb, in which the motors speed up, seconds; measured.
    home_wait_s
        Time above home before the descent, seconds (RTL_LOIT_TIME).
    landed_delay_s
        Time from touch-down until the motors stand still, seconds; measured.
    """

    jerk_mps3: float = DEFAULT_JERK_MPS3
    smoothing_s: float = DEFAULT_SMOOTHING_S
    vertical_acceleration_mps2: float = 1.0
    vertical_jerk_mps3: float = 1.0
    waypoint_radius_m: float = 2.0
    lean_angle_deg: float = 30.0
    drag_per_m: float = 0.054
    landing_speed_mps: float = 0.5
    landing_height_m: float = 10.0
    take_off_delay_s: float = 2.5
    home_wait_s: float = 5.0
    landed_delay_s: float = 2.0

    def __post_init__(self) -> None:
        for field in fields(self):
            require = require_not_negative if field.name in _MAY_BE_ZERO else require_positive
            object.__setattr__(self, field.name, require(field.name, getattr(self, field.name)))
        require_between('lean_angle_deg', self.lean_angle_deg, 1.0, 80.0)


ARDUCOPTER = Autopilot()
"""ArduCopter 4 with its default settings."""

DIRECT = Autopilot(
    jerk_mps3=1e12,
    smoothing_s=0.0,
    vertical_acceleration_mps2=1e9,
    vertical_jerk_mps3=1e12,
    waypoint_radius_m=0.0,
    lean_angle_deg=80.0,
    drag_per_m=1e-4,
    landing_speed_mps=100.0,
    landing_height_m=0.0,
    take_off_delay_s=0.0,
    home_wait_s=0.0,
    landed_delay_s=0.0,
)
"""An autopilot without delays, jerk limits and drag: speed over time is a trapezoid."""
