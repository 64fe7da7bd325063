# SPDX-License-Identifier: Apache-2.0
"""What planning needs to know of a vehicle."""

import re
from dataclasses import dataclass

from rocsafe_geo.limits import require_not_negative, require_positive
from rocsafe_geo.motion import MotionLimits
from rocsafe_geo.position import GeoPosition

_NAME = re.compile(r'[A-Za-z][A-Za-z0-9_]{0,63}')


@dataclass(frozen=True, slots=True, kw_only=True)
class Vehicle:
    """A vehicle that flies stop to stop, climbs and descends vertically at its home.

    Attributes
    ----------
    name
        Its namespace; a letter, then letters, digits and underscores.
    home
        Where it takes off and lands; altitude is that of the ground there, NaN if unknown.
    cruise_speed_mps, acceleration_mps2
        Of horizontal legs; braking is as hard as speeding up.
    climb_rate_mps, descent_rate_mps
        Constant vertical speeds, both positive.
    hover_s
        Standing time at each viewpoint.
    endurance_s
        Usable flight time on a full battery.
    """

    name: str
    home: GeoPosition
    cruise_speed_mps: float
    acceleration_mps2: float
    climb_rate_mps: float
    descent_rate_mps: float
    hover_s: float
    endurance_s: float

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not _NAME.fullmatch(self.name):
            raise ValueError(
                f'vehicle name is {self.name!r}: must be a letter and up to 63 letters, digits '
                'or underscores'
            )
        rates = ('cruise_speed_mps', 'acceleration_mps2', 'climb_rate_mps', 'descent_rate_mps')
        for field in (*rates, 'endurance_s'):
            value = require_positive(f'{self.name} {field}', getattr(self, field))
            object.__setattr__(self, field, value)
        hover = require_not_negative(f'{self.name} hover_s', self.hover_s)
        object.__setattr__(self, 'hover_s', hover)

    @property
    def motion(self) -> MotionLimits:
        """Limits of its horizontal legs."""
        return MotionLimits(self.cruise_speed_mps, self.acceleration_mps2)

    def vertical_s(self, height_m: float) -> float:
        """Return the time to climb to `height_m` above home and to descend from it."""
        return height_m / self.climb_rate_mps + height_m / self.descent_rate_mps
