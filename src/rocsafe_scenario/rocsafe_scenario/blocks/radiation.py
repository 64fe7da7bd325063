# SPDX-License-Identifier: Apache-2.0
"""The radiation block of a scenario file: sources, shields, background and detectors."""

from typing import Annotated, Literal

from pydantic import Field

from rocsafe_scenario.blocks.block import Block, LatLon, UtcTime

LARGEST_TIME_S = 604_800.0
Material = Literal['iron', 'lead', 'concrete', 'water']
Nuclide = Literal[
    'Am-241', 'Ba-133', 'Co-57', 'Co-60', 'Cs-137', 'Eu-152', 'I-131', 'Ir-192', 'Ra-226',
    'Se-75', 'Tc-99m',
]  # fmt: skip


class StopBlock(Block):
    """Place of a moving source `time_s` after the start; it moves on between such places."""

    time_s: float = Field(ge=0.0, le=LARGEST_TIME_S)
    position: LatLon


class SourceBlock(Block):
    """A gamma source, `height_m` above the ground.

    It is at one `position`, or spread along a `line`, or over an `area`, or moves along a `track`.
    Its strength is either `sigma_usvps`, the dose rate in microsievert per second at 1 m of all of
    it in one point, or `activity_gbq` of its nuclide at `activity_date`, by default the start of
    the mission.
    """

    name: Annotated[str, Field(min_length=1, max_length=64)]
    position: LatLon | None = None
    line: tuple[LatLon, ...] = Field(default=(), max_length=1000)
    area: tuple[LatLon, ...] = Field(default=(), max_length=1000)
    track: tuple[StopBlock, ...] = Field(default=(), max_length=1000)
    height_m: float = Field(default=0.0, ge=0.0, le=500.0)
    nuclide: Nuclide | None = None
    sigma_usvps: float | None = Field(default=None, gt=0.0, le=1e12)
    activity_gbq: float | None = Field(default=None, gt=0.0, le=1e9)
    activity_date: UtcTime | None = None

    @property
    def shapes(self) -> tuple[str, ...]:
        """The keys that say where it is; of a valid block, one."""
        return tuple(key for key in ('position', 'line', 'area', 'track') if getattr(self, key))

    @property
    def corners(self) -> tuple[LatLon, ...]:
        """All places that say where it is, none of a point."""
        return self.line or self.area or tuple(stop.position for stop in self.track)

    @property
    def place(self) -> LatLon:
        """Its place, its begin, or its middle."""
        if self.position is not None:
            return self.position
        if self.track:
            return self.track[0].position
        latitudes, longitudes = zip(*self.corners, strict=True)
        count = len(self.corners)
        return sum(latitudes) / count, sum(longitudes) / count

    @property
    def shape_text(self) -> str:
        """Shape of the source: empty for a point, or for instance ``line of 2 corners``."""
        if self.position is not None:
            return ''
        if self.track:
            return f'moves along {len(self.track)} stops'
        return f'{"line" if self.line else "area"} of {len(self.corners)} corners'

    @property
    def strength_text(self) -> str:
        """Its strength as the scenario says it."""
        kind = f' of {self.nuclide}' if self.nuclide else ''
        if self.activity_gbq is None:
            return f'{self.sigma_usvps:g} uSv/s{kind} at 1 m'
        when = f' on {self.activity_date:%Y-%m-%d}' if self.activity_date else ''
        return f'{self.activity_gbq:g} GBq{kind}{when}'


class ShieldBlock(Block):
    """An upright box that shields, for instance a wagon: solid, or hollow with `wall_m`.

    Its `position` is the middle of its bottom, its length points to `heading_deg` from north.
    """

    material: Material
    position: LatLon
    length_m: float = Field(gt=0.0, le=1000.0)
    width_m: float = Field(gt=0.0, le=1000.0)
    height_m: float = Field(gt=0.0, le=500.0)
    base_height_m: float = Field(default=0.0, ge=-100.0, le=500.0)
    heading_deg: float = Field(default=0.0, ge=-360.0, le=360.0)
    wall_m: float = Field(default=0.0, ge=0.0, le=100.0)


class BackgroundBlock(Block):
    """Natural background, which falls with height: the ground's mean, and how it varies.

    With `cosmic`, cosmic rays are added, which grow with the altitude above the sea.
    """

    dose_rate_usvh: float = Field(default=0.0, ge=0.0, le=1e6)
    variation: float = Field(default=0.0, ge=0.0, le=2.0)
    length_m: float = Field(default=60.0, ge=1.0, le=1e5)
    cosmic: bool = True


class SearchBlock(Block):
    """How sources are searched for, and when the search stops.

    With `extra_rounds`, after the survey the vehicles fly up to so many more times to
    `viewpoints_a_round` places from which readings tell most, until it is enough.
    """

    method: Literal['poisson-ml', 'belief-grid'] = 'poisson-ml'
    false_alarm: float = Field(default=0.01, ge=1e-6, le=0.49)
    missed: float = Field(default=0.01, ge=1e-6, le=0.49)
    ellipse_95_m: float = Field(default=5.0, ge=1e-3, le=1e4)
    smallest_source_usvh: float = Field(default=92.0, ge=1e-3, le=1e9)
    extra_rounds: int = Field(default=0, ge=0, le=20)
    viewpoints_a_round: int = Field(default=12, ge=1, le=100)


Level = Annotated[float, Field(gt=0.0, le=1e12)]


class LevelsBlock(Block):
    """Dose rates of cordons at 1 m, and dose rates and doses at which a vehicle's alarm trips.

    At `turn_back_usvh` or `vehicle_budget_usv` the vehicle returns by the way of least dose. Who
    read `contamination_usvh` may be contaminated. 0: never.

    By default those of IAEA EPR-First Responders, GSR Part 7 and ICRP 103; see the documentation.
    """

    cordon_levels_usvh: tuple[Level, ...] = Field(
        default=(2.5, 25.0, 100.0, 1000.0, 100_000.0), min_length=1, max_length=20
    )
    alarm_dose_rates_usvh: tuple[Level, ...] = Field(
        default=(25.0, 100.0, 1000.0, 100_000.0), max_length=20
    )
    alarm_doses_usv: tuple[Level, ...] = Field(default=(1e3, 2e4, 5e4, 1e5, 5e5), max_length=20)
    turn_back_usvh: float = Field(default=1e5, ge=0.0, le=1e12)
    vehicle_budget_usv: float = Field(default=1e7, ge=0.0, le=1e12)
    contamination_usvh: float = Field(default=100.0, ge=0.0, le=1e12)


class CrewBlock(Block):
    """A person at a place, with the largest dose allowed, microsievert."""

    name: Annotated[str, Field(min_length=1, max_length=64)]
    position: LatLon
    budget_usv: float = Field(default=2e4, gt=0.0, le=1e9)


class RadiationBlock(Block):
    """The radiation field; nearer than `source_radius_m` a source counts as that far.

    Every vehicle carries `detector`, which counts over windows of `window_s`; the ideal one reads
    the dose rate itself, at once. The `shields`, and the things of the scene of `scene_file`, a
    path from the scenario's file, matter to the model ``shielded`` alone.
    """

    model: Literal['paper', 'air', 'shielded'] = 'paper'
    detector: Literal['ideal', 'gm_sbm20', 'csi_1cm3', 'csi_33cm3', 'nai_2x2'] = 'ideal'
    window_s: float = Field(default=1.0, ge=1e-3, le=3600.0)
    background: BackgroundBlock = BackgroundBlock()
    source_radius_m: float = Field(default=0.1, gt=0.0, le=100.0)
    search: SearchBlock = SearchBlock()
    levels: LevelsBlock = LevelsBlock()
    crew: tuple[CrewBlock, ...] = Field(default=(), max_length=100)
    sources: tuple[SourceBlock, ...] = ()
    shields: tuple[ShieldBlock, ...] = Field(default=(), max_length=1000)
    scene_file: str = ''

    @property
    def localize_options(self) -> tuple[str, ...]:
        """The options of the command `localize` that mean the same."""
        search, levels = self.search, self.levels.cordon_levels_usvh
        return (
            f'--model={self.estimator_model}',
            f'--detector={self.detector}',
            f'--method={search.method}',
            f'--errors={max(search.false_alarm, search.missed)}',
            f'--smallest={search.smallest_source_usvh}',
            f'--ellipse={search.ellipse_95_m}',
            '--levels',
            *(f'{level:g}' for level in levels),
        )

    @property
    def estimator_model(self) -> str:
        """The law that an estimator, which knows of no shields, goes by."""
        return 'paper' if self.model == 'paper' else 'air'
