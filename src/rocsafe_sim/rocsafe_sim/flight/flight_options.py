# SPDX-License-Identifier: Apache-2.0
"""Options of how simulated vehicles fly."""

from dataclasses import dataclass
from pathlib import Path

from rocsafe_geo.motion.autopilot import ARDUCOPTER, Autopilot
from rocsafe_geo.motion.battery import HOVER_POWER_W
from rocsafe_geo.motion.performance import Performance
from rocsafe_geo.option import option
from rocsafe_geo.storage.value_file import read_values
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_geo.wind.mission_wind import WindSettings, mission_wind
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.flight.sensing_options import SensingOptions
from rocsafe_sim.flight.wind_drift import WindDrift


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightOptions(SensingOptions):
    """What simulated vehicles can do, and the wind; see config/rocsafe.yaml."""

    cruise_speed_mps: float = option(5.0, 'horizontal speed, m/s', 0.01, 100.0)
    acceleration_mps2: float = option(2.0, 'horizontal acceleration, m/s^2', 0.01, 50.0)
    climb_rate_mps: float = option(2.5, 'vertical speed up, m/s', 0.01, 50.0)
    descent_rate_mps: float = option(1.5, 'vertical speed down, m/s', 0.01, 50.0)
    hover_s: float = option(
        1.0, 'time at a viewpoint before its photograph, s; 0: viewpoints are passed', 0.0, 600.0
    )
    endurance_s: float = option(1500.0, 'time in the air on a full battery, s', 1.0, 604_800.0)
    reserve_fraction: float = option(
        0.1, 'charge to land with, as a part of a full battery', 0.0, 0.9
    )
    collision_radius_m: float = option(
        0.4, 'distance to an object that counts as a collision, m; 0: no collisions', 0.0, 10.0
    )
    fails_after_s: float = option(
        0.0, 'time from take-off to a failure of the battery, s; 0: never', 0.0, 1e6
    )
    hover_power_w: float = option(HOVER_POWER_W, 'power of the motors in hover, W', 1.0, 1e6)
    autopilot_file: str = option(
        '', "YAML file of the autopilot's settings, see docs/flight-model.md; empty: ArduCopter's"
    )
    wind_east_mps: float = option(0.0, 'velocity of the air to the east, m/s', -100.0, 100.0)
    wind_north_mps: float = option(0.0, 'velocity of the air to the north, m/s', -100.0, 100.0)
    wind_file: str = option(
        '',
        'YAML file of how the wind changes, see docs/dispersion.md; empty: it is steady',
    )

    def airframe(self) -> Airframe:
        """Return what the vehicles can do.

        Raises
        ------
        ValueError
            If there is too much wind, or the file of the autopilot cannot be read.
        """
        return Airframe(
            performance=self.performance(),
            hover_s=self.hover_s,
            endurance_s=self.endurance_s,
            reserve_fraction=self.reserve_fraction,
            fails_after_s=self.fails_after_s,
            collision_radius_m=self.collision_radius_m,
            hover_power_w=self.hover_power_w,
        )

    def performance(self) -> Performance:
        """Return the limits of their flight.

        Raises
        ------
        ValueError
            As `airframe`.
        """
        return Performance(
            cruise_speed_mps=self.cruise_speed_mps,
            acceleration_mps2=self.acceleration_mps2,
            climb_rate_mps=self.climb_rate_mps,
            descent_rate_mps=self.descent_rate_mps,
            autopilot=self.autopilot(),
            wind_mps=(self.wind_east_mps, self.wind_north_mps),
        )

    def drift(self) -> WindDrift | None:
        """Return how the wind pushes the vehicles, that of the air of the same seed.

        Raises
        ------
        ValueError
            As `airframe`, or if the file of the wind cannot be read.
        """
        if not self.wind_file:
            return None
        settings = read_values(Path(self.wind_file), WindSettings)
        if settings.is_steady:
            return None
        return WindDrift(
            mission_wind(settings, self.seed),
            start_ns=round(self.scene_start_s * NS_PER_S),
            drag_per_m=self.autopilot().drag_per_m,
            mean_mps=(self.wind_east_mps, self.wind_north_mps),
        )

    def autopilot(self) -> Autopilot:
        """Return the settings of the autopilot.

        Raises
        ------
        ValueFileError
            If the file cannot be read, naming each mistake.
        """
        if not self.autopilot_file:
            return ARDUCOPTER
        return read_values(Path(self.autopilot_file), Autopilot)
