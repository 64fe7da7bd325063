# SPDX-License-Identifier: Apache-2.0
"""What a vehicle can do: its speeds, its hover time, its battery."""

from dataclasses import dataclass

from rocsafe_geo.limits import require_between, require_not_negative, require_positive
from rocsafe_geo.motion import MotionLimits


@dataclass(frozen=True, slots=True, kw_only=True)
class Airframe:
    """Performance of a multirotor.

    Attributes
    ----------
    limits : horizontal speed and acceleration.
    climb_rate_mps, descent_rate_mps : vertical speeds, reached and lost at once.
    hover_s : standing time at a viewpoint, at whose end it photographs.
    endurance_s : time in the air on a full battery.
    reserve_fraction : part of a full battery with which it wants to land.
    """

    limits: MotionLimits
    climb_rate_mps: float
    descent_rate_mps: float
    hover_s: float
    endurance_s: float
    reserve_fraction: float

    def __post_init__(self) -> None:
        require_positive('climb_rate_mps', self.climb_rate_mps)
        require_positive('descent_rate_mps', self.descent_rate_mps)
        require_not_negative('hover_s', self.hover_s)
        require_positive('endurance_s', self.endurance_s)
        require_between('reserve_fraction', self.reserve_fraction, 0.0, 0.9)

    def vertical_rate_mps(self, change_m: float) -> float:
        """Return the vertical speed, above zero, of a change of height with this sign."""
        return self.climb_rate_mps if change_m > 0.0 else self.descent_rate_mps

    def drain_fraction(self, airborne_s: float) -> float:
        """Return the part of a full battery that `airborne_s` seconds in the air use."""
        return airborne_s / self.endurance_s
