# SPDX-License-Identifier: Apache-2.0
"""The air block of a scenario file: releases, how the wind changes, gas sensors."""

from typing import Annotated, Literal

from pydantic import Field

from rocsafe_scenario.blocks.block import Block, LatLon
from rocsafe_scenario.blocks.radiation import LARGEST_TIME_S, StopBlock

# Industrial chemicals of the table of agents, or particles that stand for biological ones.
ReleasedAgent = Literal[
    'acetone', 'ammonia', 'benzene', 'bromine', 'carbon_monoxide', 'chlorine', 'ethylene_oxide',
    'hydrogen_fluoride', 'hydrogen_sulphide', 'isobutylene', 'methane', 'methyl_chloride',
    'methyl_isocyanate', 'nitrogen_dioxide', 'particles', 'sulphur_dioxide',
]  # fmt: skip
GasSensorKind = Literal[
    'electrochemical_ammonia', 'electrochemical_chlorine', 'electrochemical_hydrogen_sulphide',
    'electrochemical_sulphur_dioxide', 'ion_mobility', 'metal_oxide', 'open_path_methane',
    'pid_10_6_ev',
]  # fmt: skip
Amount = Annotated[float, Field(ge=0.0, le=1e15)]


class ReleaseBlock(Block):
    """A release of an industrial chemical or of particles, `height_m` above the ground.

    It leaves at a rate (`rate_g_s`, particles: `rate_per_s`) for `duration_s`, or at once
    (`burst_g`, `burst_count`), from `start_s` after the start of the mission, and may move along
    a `track` whose times count from its start. A chemical that leaves at a rate with a
    `temperature_c` rises where it is lighter than the air of 20 degrees.
    """

    name: Annotated[str, Field(min_length=1, max_length=64)]
    agent: ReleasedAgent
    position: LatLon
    height_m: float = Field(default=1.0, ge=0.0, le=30.0)
    rate_g_s: Amount = 0.0
    burst_g: Amount = 0.0
    rate_per_s: Amount = 0.0
    burst_count: Amount = 0.0
    start_s: float = Field(default=0.0, ge=-LARGEST_TIME_S, le=LARGEST_TIME_S)
    duration_s: float = Field(default=LARGEST_TIME_S, gt=0.0, le=LARGEST_TIME_S)
    radius_m: float = Field(default=0.0, ge=0.0, le=500.0)
    track: tuple[StopBlock, ...] = Field(default=(), max_length=1000)
    temperature_c: float | None = Field(default=None, ge=-200.0, le=2000.0)
    settling_mps: float = Field(default=0.0, ge=0.0, le=10.0)
    decay_per_s: float = Field(default=0.0, ge=0.0, le=1.0)

    @property
    def amounts(self) -> dict[str, float]:
        """What leaves, by key, where it is above 0."""
        keys = ('rate_g_s', 'burst_g', 'rate_per_s', 'burst_count')
        return {key: getattr(self, key) for key in keys if getattr(self, key)}

    @property
    def own_amounts(self) -> tuple[str, str]:
        """The keys of which it needs one."""
        is_particles = self.agent == 'particles'
        return ('rate_per_s', 'burst_count') if is_particles else ('rate_g_s', 'burst_g')


class AirWindBlock(Block):
    """How the wind of `survey.airspace.wind_mps`, measured at `height_m`, changes.

    It grows with height by the roughness of the ground and the stability (Pasquill class), and
    has gusts. With `record_file`, the record of an anemometer, the air moves as recorded, and
    `survey.airspace.wind_mps` is the forecast that flights are planned with. With `scene_file`
    buildings and ground of that scene shelter and channel it. All of it moves gas and vehicles.
    """

    height_m: float = Field(default=10.0, ge=1.0, le=200.0)
    roughness_m: float = Field(default=0.03, ge=1e-3, le=0.5)
    stability: Literal['A', 'B', 'C', 'D', 'E', 'F'] = 'D'
    gust_std_mps: float = Field(default=0.0, ge=0.0, le=20.0)
    gust_scale_s: float = Field(default=20.0, ge=1.0, le=3600.0)
    record_file: str = ''
    scene_file: str = ''

    @property
    def is_steady(self) -> bool:
        """Whether it is everywhere and always the same, up to its profile."""
        return not (self.gust_std_mps or self.record_file or self.scene_file)


class GasSearchBlock(Block):
    """How releases are searched for, and when the search stops.

    With `extra_rounds`, after the survey the vehicles fly up to so many more times to
    `viewpoints_a_round` places from which readings tell most, until it is enough. `agent` is what
    is known to leak, e.g. from a placard, or particles; empty: what the sensors are made for. It
    falls at `settling_mps` and decays by `decay_per_s`. Places count as searched where less than
    `smallest_g_s`, of particles `smallest_per_s`, may be released unseen.
    """

    agent: ReleasedAgent | Literal[''] = ''
    release_height_m: float = Field(default=1.0, ge=0.0, le=30.0)
    smallest_g_s: float = Field(default=0.5, ge=1e-9, le=1e9)
    smallest_per_s: float = Field(default=1e8, ge=1.0, le=1e15)
    settling_mps: float = Field(default=0.0, ge=0.0, le=10.0)
    decay_per_s: float = Field(default=0.0, ge=0.0, le=1.0)
    region_m: float = Field(default=10.0, ge=0.1, le=1e4)
    hidden_share: float = Field(default=0.05, ge=1e-3, le=0.9)
    extra_rounds: int = Field(default=0, ge=0, le=20)
    viewpoints_a_round: int = Field(default=12, ge=1, le=100)


class AirBlock(Block):
    """What is in the air, and the sensors that every simulated vehicle carries for it."""

    wind: AirWindBlock = AirWindBlock()
    releases: tuple[ReleaseBlock, ...] = Field(default=(), max_length=50)
    gas_sensors: tuple[GasSensorKind, ...] = Field(default=(), max_length=8)
    particle_counter: bool = False
    anemometer: bool = True
    dilution: float = Field(default=0.7, ge=0.01, le=1.0)
    intake_delay_s: float = Field(default=1.0, ge=0.0, le=60.0)
    window_s: float = Field(default=1.0, ge=0.1, le=600.0)
    search: GasSearchBlock = GasSearchBlock()

    @property
    def is_used(self) -> bool:
        """Whether a mission needs it: something is released, or a sensor carried."""
        return bool(self.releases or self.reads)

    @property
    def reads(self) -> bool:
        """Whether sensors for what is released are carried."""
        return bool(self.gas_sensors or self.particle_counter)
