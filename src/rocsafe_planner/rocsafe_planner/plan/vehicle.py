# SPDX-License-Identifier: Apache-2.0
"""A vehicle as the planner sees it."""

import re
from dataclasses import dataclass
from functools import lru_cache

from rocsafe_geo.limits import require_count, require_not_negative, require_positive
from rocsafe_geo.motion.autopilot import ARDUCOPTER, Autopilot
from rocsafe_geo.motion.battery import HOVER_POWER_W
from rocsafe_geo.motion.performance import Performance
from rocsafe_geo.position import GeoPosition

MOST_LAYERS = 1000
_NAME = re.compile(r'[A-Za-z][A-Za-z0-9_]{0,63}')


@dataclass(frozen=True, slots=True, kw_only=True)
class Aloft:
    """Position of a vehicle in the air, and the used time of its battery."""

    position: GeoPosition
    used_s: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, 'used_s', require_not_negative('used_s', self.used_s, 's'))


@dataclass(frozen=True, slots=True, kw_only=True)
class Vehicle:
    """A vehicle that flies from place to place, climbs and descends vertically at its home.

    Attributes
    ----------
    name
        Its namespace; a letter, then letters, digits and underscores.
    home
        Where it takes off and lands; altitude is that of the ground there, NaN if unknown.
    cruise_speed_mps, acceleration_mps2
        Speed and acceleration of horizontal legs; deceleration equals acceleration.
    climb_rate_mps, descent_rate_mps
        Constant vertical speeds, both positive.
    hover_s
        Standing time at each viewpoint; 0: it passes viewpoints without a stop.
    endurance_s
        Usable flight time on a full battery.
    battery_swap_s
        Time on the ground at home to change the battery; None: a battery is not changed.
    end, is_open
        Where it lands instead of home; whether it lands at its last viewpoint instead.
    sensors
        Names of the sensors that it carries besides the camera.
    cruise_power_w, hover_power_w
        Electric power on legs, climb and descent, and at viewpoints: for the objective `energy`.
    aloft
        Where it is in the air and begins its route; None: it takes off at home.
    used_s
        Flight time used of the battery with which it takes off at home.
    autopilot
        Limits with which it accelerates, turns, climbs and lands.
    layer
        Number of the height layer that is reserved for it, from 0; None: none is.
    """

    name: str
    home: GeoPosition
    cruise_speed_mps: float = 5.0
    acceleration_mps2: float = 2.0
    climb_rate_mps: float = 2.5
    descent_rate_mps: float = 1.5
    hover_s: float = 1.0
    endurance_s: float = 1350.0
    battery_swap_s: float | None = None
    end: GeoPosition | None = None
    is_open: bool = False
    sensors: tuple[str, ...] = ()
    cruise_power_w: float = 200.0
    hover_power_w: float = HOVER_POWER_W
    aloft: Aloft | None = None
    used_s: float = 0.0
    autopilot: Autopilot = ARDUCOPTER
    layer: int | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not _NAME.fullmatch(self.name):
            raise ValueError(
                f'vehicle name is {self.name!r}: must be a letter and up to 63 letters, digits '
                'or underscores'
            )
        rates = ('cruise_speed_mps', 'acceleration_mps2', 'climb_rate_mps', 'descent_rate_mps')
        for field in (*rates, 'endurance_s', 'cruise_power_w', 'hover_power_w'):
            value = require_positive(f'{self.name} {field}', getattr(self, field))
            object.__setattr__(self, field, value)
        hover = require_not_negative(f'{self.name} hover_s', self.hover_s)
        object.__setattr__(self, 'hover_s', hover)
        used = require_not_negative(f'{self.name} used_s', self.used_s)
        object.__setattr__(self, 'used_s', used)
        if self.battery_swap_s is not None:
            swap = require_not_negative(f'{self.name} battery_swap_s', self.battery_swap_s)
            object.__setattr__(self, 'battery_swap_s', swap)
        if self.is_open and self.end is not None:
            raise ValueError(f'{self.name} has an end and is_open: must have one of them at most')
        object.__setattr__(self, 'sensors', require_sensors(self.name, self.sensors))
        if self.layer is not None:
            require_count(f'{self.name} layer', self.layer, 0, MOST_LAYERS)

    def performance(self, wind_mps: tuple[float, float] = (0.0, 0.0)) -> Performance:
        """Return the limits of its flight in a wind that blows towards (east, north).

        Raises
        ------
        ValueError
            If it cannot fly in this wind.
        """
        return Performance(
            cruise_speed_mps=self.cruise_speed_mps,
            acceleration_mps2=self.acceleration_mps2,
            climb_rate_mps=self.climb_rate_mps,
            descent_rate_mps=self.descent_rate_mps,
            autopilot=self.autopilot,
            wind_mps=wind_mps,
        )

    @property
    def start(self) -> GeoPosition:
        """Place at which its route begins."""
        return self.home if self.aloft is None else self.aloft.position

    @property
    def landings(self) -> tuple[GeoPosition, ...]:
        """Places at which it may land: its home, and its end if that is another one."""
        return (self.home,) if self.end in (None, self.home) else (self.home, self.end)

    @property
    def first_endurance_s(self) -> float:
        """Flight time that is left on the battery that it has."""
        return self.endurance_s - (self.used_s if self.aloft is None else self.aloft.used_s)

    def vertical_s(self, height_m: float) -> float:
        """Return the time to climb to `height_m` above home and to descend from it."""
        performance = self.performance()
        return _ascent_s(performance, height_m) + _descent_s(performance, height_m)

    def first_vertical_s(self, height_m: float) -> float:
        """Return the same of its first flight: no climb if it is in the air."""
        if self.aloft is None:
            return self.vertical_s(height_m)
        return _descent_s(self.performance(), height_m)


@lru_cache(maxsize=256)
def _ascent_s(performance: Performance, height_m: float) -> float:
    return performance.ascent_s(height_m)


@lru_cache(maxsize=256)
def _descent_s(performance: Performance, height_m: float) -> float:
    return performance.descent_s(height_m)


def require_sensors(owner: str, sensors: tuple[str, ...]) -> tuple[str, ...]:
    """Return sorted names of sensors without duplicates; raise ValueError for a wrong name."""
    for sensor in sensors:
        if not isinstance(sensor, str) or not _NAME.fullmatch(sensor):
            raise ValueError(
                f'{owner} sensors has {sensor!r}: must be a letter and up to 63 letters, digits '
                'or underscores'
            )
    return tuple(sorted(set(sensors)))
