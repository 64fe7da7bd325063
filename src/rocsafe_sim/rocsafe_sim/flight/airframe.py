# SPDX-License-Identifier: Apache-2.0
"""Performance of a vehicle: flight, hover time, battery."""

from dataclasses import dataclass, field, replace

from rocsafe_geo.limits import require_between, require_not_negative, require_positive
from rocsafe_geo.motion.battery import HOVER_POWER_W, PowerModel
from rocsafe_geo.motion.performance import Performance


@dataclass(frozen=True, slots=True, kw_only=True)
class Airframe:
    """Performance of a multirotor.

    Attributes
    ----------
    performance
        Limits of its flight, and the wind.
    hover_s
        Time at a viewpoint, at whose end it photographs, seconds; 0: it passes viewpoints without
        a stop.
    endurance_s
        Time in the air on a full battery at the largest airspeed, seconds.
    reserve_fraction
        Charge to land with, as a part of a full battery.
    fails_after_s
        Time from take-off to a failure of the battery, seconds; 0: never.
    collision_radius_m
        Distance to an object that counts as a collision, metres; 0: no collisions.
    hover_power_w
        Power in hover in still air, W.
    """

    performance: Performance
    hover_s: float
    endurance_s: float
    reserve_fraction: float
    hover_power_w: float = HOVER_POWER_W
    fails_after_s: float = 0.0
    collision_radius_m: float = 0.4
    _power: PowerModel | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        require_not_negative('hover_s', self.hover_s)
        require_positive('endurance_s', self.endurance_s)
        require_not_negative('fails_after_s', self.fails_after_s)
        require_not_negative('collision_radius_m', self.collision_radius_m)
        require_between('reserve_fraction', self.reserve_fraction, 0.0, 0.9)
        _ = self.power

    def at_speed(self, speed_mps: float) -> 'Airframe':
        """Return it with another horizontal speed and the same battery; 0: its own speed.

        Raises
        ------
        ValueError
            If it is faster than its own.
        """
        if not speed_mps:
            return self
        own_mps = self.performance.cruise_speed_mps
        require_positive('speed_mps', speed_mps, 'm/s')
        require_between('speed_mps', speed_mps, 0.0, own_mps, 'm/s')
        slower = replace(self.performance, cruise_speed_mps=speed_mps)
        return replace(self, performance=slower, _power=self.power)

    def in_wind(self, wind_mps: tuple[float, float] | None) -> 'Airframe':
        """Return it in another wind, east and north, with the same battery; None: in its own.

        Raises
        ------
        ValueError
            If there is too much wind.
        """
        if wind_mps is None:
            return self
        windy = replace(self.performance, wind_mps=wind_mps)
        return replace(self, performance=windy, _power=self.power)

    @property
    def power(self) -> PowerModel:
        """Power in flight."""
        if self._power is not None:
            return self._power
        return PowerModel(
            hover_power_w=self.hover_power_w,
            endurance_s=self.endurance_s,
            top_airspeed_mps=self.performance.airspeed_mps,
        )
