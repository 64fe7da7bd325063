# SPDX-License-Identifier: Apache-2.0
"""Settings of an autopilot that decide how long a flight takes.

Defaults are those of ArduCopter 4, whose name is given, or were measured on its recorded flights.
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
    jerk_mps3 : of horizontal motion (WPNAV_JERK).
    smoothing_s : in which the jerk rises and falls (twice ATC_INPUT_TC).
    vertical_acceleration_mps2, vertical_jerk_mps3 : of climb and descent (WPNAV_ACCEL_Z).
    waypoint_radius_m : within which a corner without a stop is to be passed (WPNAV_RADIUS).
    lean_angle_deg : largest (ANGLE_MAX); with the drag it caps the airspeed.
    drag_per_m : drag over mass and airspeed squared; measured: 10.25 m/s at 30 degrees.
    landing_speed_mps, landing_height_m : how slowly it lands (LAND_SPEED), from which height on
        (LAND_ALT_LOW).
    take_off_delay_s : from the order to the climb, while the motors speed up; measured.
    home_wait_s : standing time above home before the descent (RTL_LOIT_TIME).
    landed_delay_s : from touch-down until the motors stand; measured.
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
"""ArduCopter 4 as it comes."""

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
"""An autopilot without delays, jerks or drag: legs are trapezoids of speed over time."""
