# SPDX-License-Identifier: Apache-2.0
"""Limits of a motion along a line."""

from dataclasses import dataclass

from rocsafe_geo.limits import require_not_negative, require_positive

DEFAULT_JERK_MPS3 = 1.0
"""WPNAV_JERK of ArduCopter."""

DEFAULT_SMOOTHING_S = 0.3
"""Twice the time constant of ArduCopter's attitude input."""


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """Limits of speed, acceleration and jerk.

    Attributes
    ----------
    cruise_speed_mps, acceleration_mps2, jerk_mps3
        Limits in m/s, m/s^2 and m/s^3, above zero.
    smoothing_s
        Time in which the jerk rises from zero to its limit, and falls again, seconds; 0: at once.
    """

    cruise_speed_mps: float
    acceleration_mps2: float
    jerk_mps3: float = DEFAULT_JERK_MPS3
    smoothing_s: float = DEFAULT_SMOOTHING_S

    def __post_init__(self) -> None:
        for name in ('cruise_speed_mps', 'acceleration_mps2', 'jerk_mps3'):
            object.__setattr__(self, name, require_positive(name, getattr(self, name)))
        smoothing = require_not_negative('smoothing_s', self.smoothing_s)
        object.__setattr__(self, 'smoothing_s', smoothing)
