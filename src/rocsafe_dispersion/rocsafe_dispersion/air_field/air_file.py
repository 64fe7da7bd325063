# SPDX-License-Identifier: Apache-2.0
"""Settings of the simulated air that are lists or blocks: one YAML file.

Its keys are those of a scenario's ``air`` block; the wind is the one that pushes the vehicles.
"""

import math
from dataclasses import dataclass, field

from rocsafe_dispersion.agents.agent_table import PARTICLES, released_agent
from rocsafe_dispersion.detection.sensor_kinds import GAS_SENSORS
from rocsafe_geo.limits import require_between, require_finite, require_not_negative
from rocsafe_geo.wind.mission_wind import WindSettings

# Latitude and longitude, degrees.
Place = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class StopSettings:
    """A place that a moving release passes, `time_s` after its start."""

    time_s: float
    position: Place


@dataclass(frozen=True, slots=True, kw_only=True)
class ReleaseSettings:
    """A release of an industrial chemical, or of particles that stand for biological ones.

    Attributes
    ----------
    name
        Unique among the releases.
    agent
        A chemical of the table of agents, or ``particles``.
    position
        Latitude and longitude, degrees.
    height_m
        Height above the ground, metres.
    rate_g_s, burst_g
        Rate of a chemical, g/s, or what leaves at once, g.
    rate_per_s, burst_count
        The same of particles, in particles.
    start_s, duration_s
        When, seconds after the start of the mission, and how long.
    radius_m
        Radius of the place that it leaves, metres.
    temperature_c
        Temperature at which a chemical leaves at its rate, degrees Celsius: lighter than the air
        it rises; None: it neither rises nor falls.
    track
        Places that a moving release passes.
    settling_mps
        Speed at which particles fall, m/s.
    decay_per_s
        Share that decays in a second, 1/s.
    surface_resistance_s_m
        Resistance of the ground to a gas, s/m; infinite: it takes nothing.
    """

    name: str
    agent: str
    position: Place
    height_m: float = 1.0
    rate_g_s: float = 0.0
    burst_g: float = 0.0
    rate_per_s: float = 0.0
    burst_count: float = 0.0
    start_s: float = 0.0
    duration_s: float = math.inf
    radius_m: float = 0.0
    temperature_c: float | None = None
    track: tuple[StopSettings, ...] = ()
    settling_mps: float = 0.0
    decay_per_s: float = 0.0
    surface_resistance_s_m: float = math.inf

    def __post_init__(self) -> None:
        if self.agent != PARTICLES.name:
            released_agent(self.agent)
        for latitude, longitude in (self.position, *(stop.position for stop in self.track)):
            require_between(f'release {self.name}: latitude', latitude, -90.0, 90.0, 'degrees')
            require_between(f'release {self.name}: longitude', longitude, -180.0, 180.0, 'degrees')
        amounts = {
            'rate_g_s': self.rate_g_s,
            'burst_g': self.burst_g,
            'rate_per_s': self.rate_per_s,
            'burst_count': self.burst_count,
        }
        for name, value in amounts.items():
            require_not_negative(f'release {self.name}: {name}', value)
        own = ('rate_per_s', 'burst_count') if self.is_particles else ('rate_g_s', 'burst_g')
        given = [name for name, value in amounts.items() if value > 0.0]
        if len(given) != 1 or given[0] not in own:
            raise ValueError(f'release {self.name}: needs exactly one of {", ".join(own)} above 0')
        if self.temperature_c is not None and given != ['rate_g_s']:
            raise ValueError(f'release {self.name}: temperature_c needs rate_g_s')

    @property
    def is_particles(self) -> bool:
        """Whether particles are released."""
        return self.agent == PARTICLES.name


@dataclass(frozen=True, slots=True, kw_only=True)
class AirFile:
    """All settings.

    Attributes
    ----------
    wind
        The wind.
    releases
        Releases.
    gas_sensors
        Kinds of gas sensors that each vehicle carries.
    particle_counter, anemometer
        Whether each vehicle carries one.
    dilution, intake_delay_s
        Share of the concentration that arrives at the sensors below the rotors, and when.
    anemometer_std_mps
        Standard deviation of the wind that a vehicle measures over a window, m/s.
    ground_altitude_m
        Altitude of the ground at the origin above the ellipsoid, metres.
    origin
        Origin of the frame of the wind of a site; None: the first release.
    """

    wind: WindSettings = field(default_factory=WindSettings)
    releases: tuple[ReleaseSettings, ...] = ()
    gas_sensors: tuple[str, ...] = ()
    particle_counter: bool = False
    anemometer: bool = True
    dilution: float = 0.7
    intake_delay_s: float = 1.0
    anemometer_std_mps: float = 0.5
    ground_altitude_m: float = 0.0
    origin: Place | None = None

    def __post_init__(self) -> None:
        if self.wind.site_file and self.origin is None:
            raise ValueError('origin must be given with wind.site_file')
        names = [release.name for release in self.releases]
        if len(set(names)) < len(names):
            raise ValueError('releases must have different names')
        for name in self.gas_sensors:
            if name not in GAS_SENSORS:
                raise ValueError(
                    f'gas_sensors = {name!r} must be one of: {", ".join(GAS_SENSORS)}'
                )
        require_between('anemometer_std_mps', self.anemometer_std_mps, 1e-3, 20.0, 'm/s')
        require_finite('ground_altitude_m', self.ground_altitude_m, 'm')
