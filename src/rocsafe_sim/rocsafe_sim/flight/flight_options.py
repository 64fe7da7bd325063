# SPDX-License-Identifier: Apache-2.0
"""Options of how simulated vehicles fly."""

from dataclasses import dataclass, fields

from rocsafe_geo.motion.autopilot import Autopilot
from rocsafe_geo.motion.performance import Performance
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.flight.origin_options import OriginOptions, option


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightOptions(OriginOptions):
    """What simulated vehicles can do, and the wind; see config/rocsafe.yaml."""

    cruise_speed_mps: float = option(5.0, 'horizontal speed, m/s', 0.01, 100.0)
    acceleration_mps2: float = option(2.0, 'horizontal acceleration, m/s^2', 0.01, 50.0)
    climb_rate_mps: float = option(2.5, 'vertical speed up, m/s', 0.01, 50.0)
    descent_rate_mps: float = option(1.5, 'vertical speed down, m/s', 0.01, 50.0)
    hover_s: float = option(
        1.0, 'standing time before each photograph, s; 0: viewpoints are passed', 0.0, 600.0
    )
    endurance_s: float = option(1500.0, 'time in the air on a full battery, s', 1.0, 604_800.0)
    reserve_fraction: float = option(0.1, 'charge to land with, 0 to 0.9', 0.0, 0.9)
    collision_radius_m: float = option(
        0.4, 'within which nothing of a scene may stand, m; 0: flies through all', 0.0, 10.0
    )
    fails_after_s: float = option(
        0.0, "time from a flight's take-off to the failure of its battery, s; 0: never", 0.0, 1e6
    )
    hover_power_w: float = option(350.0, 'of the motors in still air, W', 1.0, 1e6)
    drag_power_w_s2_per_m2: float = option(
        0.2, 'more power for each square of airspeed, W s^2/m^2', 0.0, 1e4
    )
    voltage_v: float = option(12.6, 'of the battery, V', 1.0, 1e4)
    jerk_mps3: float = option(1.0, 'horizontal jerk, m/s^3', 0.01, 1e12)
    smoothing_s: float = option(0.3, 'in which the jerk rises and falls, s', 0.0, 10.0)
    vertical_acceleration_mps2: float = option(1.0, 'of climb and descent, m/s^2', 0.01, 1e9)
    vertical_jerk_mps3: float = option(1.0, 'of climb and descent, m/s^3', 0.01, 1e12)
    waypoint_radius_m: float = option(
        2.0, 'corners without a stop are passed within, m', 0.0, 100.0
    )
    lean_angle_deg: float = option(30.0, 'largest; with the drag it caps the airspeed', 1.0, 80.0)
    drag_per_m: float = option(0.054, 'drag over mass and airspeed squared, 1/m', 1e-6, 100.0)
    landing_speed_mps: float = option(0.5, 'vertical speed near the ground, m/s', 0.01, 100.0)
    landing_height_m: float = option(10.0, 'below which it lands that slowly, m', 0.0, 1e3)
    take_off_delay_s: float = option(2.5, 'from the order to the climb, s', 0.0, 600.0)
    home_wait_s: float = option(5.0, 'above home before the descent, s', 0.0, 600.0)
    landed_delay_s: float = option(2.0, 'until the motors stand, s', 0.0, 600.0)
    wind_east_mps: float = option(0.0, 'that the air moves towards, m/s', -100.0, 100.0)
    wind_north_mps: float = option(0.0, 'that the air moves towards, m/s', -100.0, 100.0)

    def airframe(self) -> Airframe:
        """Return what the vehicles can do.

        Raises
        ------
        ValueError: if they cannot, e.g. for too much wind.
        """
        return Airframe(
            performance=self.performance(),
            hover_s=self.hover_s,
            endurance_s=self.endurance_s,
            reserve_fraction=self.reserve_fraction,
            fails_after_s=self.fails_after_s,
            collision_radius_m=self.collision_radius_m,
            hover_power_w=self.hover_power_w,
            drag_power_w_s2_per_m2=self.drag_power_w_s2_per_m2,
            voltage_v=self.voltage_v,
        )

    def performance(self) -> Performance:
        """Return the limits of their flight."""
        settings = {setting.name: getattr(self, setting.name) for setting in fields(Autopilot)}
        return Performance(
            cruise_speed_mps=self.cruise_speed_mps,
            acceleration_mps2=self.acceleration_mps2,
            climb_rate_mps=self.climb_rate_mps,
            descent_rate_mps=self.descent_rate_mps,
            autopilot=Autopilot(**settings),
            wind_mps=(self.wind_east_mps, self.wind_north_mps),
        )
