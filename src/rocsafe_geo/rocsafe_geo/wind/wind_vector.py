# SPDX-License-Identifier: Apache-2.0
"""Horizontal wind as a value, and the two conventions of its direction."""

import math
from dataclasses import dataclass

from rocsafe_geo.limits import require_between

LARGEST_WIND_MPS = 100.0


@dataclass(frozen=True, slots=True, kw_only=True)
class WindVector:
    """Velocity of the air in the east, north frame: where it goes to.

    Attributes
    ----------
    towards_east_mps, towards_north_mps
        Components of the velocity, m/s, each within -100 and 100.
    """

    towards_east_mps: float
    towards_north_mps: float

    def __post_init__(self) -> None:
        for name in ('towards_east_mps', 'towards_north_mps'):
            require_between(name, getattr(self, name), -LARGEST_WIND_MPS, LARGEST_WIND_MPS)

    @property
    def speed_mps(self) -> float:
        """Speed, m/s."""
        return math.hypot(self.towards_east_mps, self.towards_north_mps)

    @property
    def from_deg(self) -> float:
        """Direction that it comes from, degrees clockwise from north, 0 to 360 (meteorology)."""
        return math.degrees(math.atan2(-self.towards_east_mps, -self.towards_north_mps)) % 360.0


def wind_from(speed_mps: float, from_deg: float) -> WindVector:
    """Return the wind that comes from a direction, as weather services state it.

    Parameters
    ----------
    speed_mps
        Speed, m/s.
    from_deg
        Where it comes from, degrees clockwise from north: 270 is a west wind, which goes east.

    Raises
    ------
    ValueError
        If a value is out of range.
    """
    speed = require_between('speed_mps', speed_mps, 0.0, LARGEST_WIND_MPS, 'm/s')
    angle = math.radians(require_between('from_deg', from_deg, -360.0, 360.0, 'degrees'))
    return WindVector(
        towards_east_mps=-speed * math.sin(angle), towards_north_mps=-speed * math.cos(angle)
    )
