# SPDX-License-Identifier: Apache-2.0
"""The blocks of a scenario's time, places, fleet and survey."""

from datetime import datetime, timezone
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from rocsafe_geo.regions.area import MOST_CORNERS
from rocsafe_planner.plan.survey_options import (
    MAX_VIEWPOINTS_LIMIT,
    AirspaceOptions,
    CoverageOptions,
    Effort,
    Grid,
    Objective,
    Separation,
    SeparationOptions,
    SpacingRule,
)
from rocsafe_scenario.blocks.block import (
    Block,
    Latitude,
    LatLon,
    Longitude,
    SensorName,
    UtcTime,
    defaults_of,
)
from rocsafe_scenario.limits import LARGEST_BUDGET_S, LARGEST_HEIGHT_M, LARGEST_SPEED

DEFAULT_START = datetime(2025, 6, 1, 10, 0, tzinfo=timezone.utc)
# Seconds of messages end on 2038-01-19; missions take days at most.
EARLIEST_START = datetime(1970, 1, 1, tzinfo=timezone.utc)
LATEST_START = datetime(2038, 1, 1, tzinfo=timezone.utc)

_COVERAGE, _AIRSPACE = defaults_of(CoverageOptions), defaults_of(AirspaceOptions)
_SEPARATION, _EFFORT = defaults_of(SeparationOptions), defaults_of(Effort)


def _in_messages(start: datetime) -> datetime:
    """Refuse a time that no message can carry: ROS counts seconds since 1970 in 31 bits."""
    if not EARLIEST_START <= start <= LATEST_START:
        limits = f'{EARLIEST_START:%Y-%m-%d} to {LATEST_START:%Y-%m-%d}'
        raise ValueError(f'must be within {limits}: messages of ROS carry no other times')
    return start


class ClockBlock(Block):
    """Simulated time: `speed` simulated seconds a second, 0 = as fast as the machine can."""

    speed: float = Field(default=0.0, ge=0.0, le=LARGEST_SPEED)
    step_s: float = Field(default=0.1, ge=0.001, le=1.0)
    start: Annotated[UtcTime, AfterValidator(_in_messages)] = DEFAULT_START


class OriginBlock(Block):
    """Origin of the local frame; without a position it is the centroid of the region.

    `ground_altitude_m` is that of the flat ground, above the WGS84 ellipsoid.
    """

    latitude_deg: Latitude | None = None
    longitude_deg: Longitude | None = None
    ground_altitude_m: float = Field(default=0.0, ge=-500.0, le=9000.0)


class RegionBlock(Block):
    """A polygon with holes, written here or in a GeoJSON or KML file.

    Only vehicles that carry all `sensors` survey it.
    """

    polygon: tuple[LatLon, ...] | None = Field(default=None, min_length=3, max_length=MOST_CORNERS)
    holes: tuple[Annotated[tuple[LatLon, ...], Field(min_length=3)], ...] = ()
    file: str | None = None
    sensors: tuple[SensorName, ...] = ()


class AirspaceBlock(Block):
    """What flights keep away from, and the wind: see `AirspaceOptions`."""

    clearance_m: float = Field(default=_AIRSPACE['clearance_m'], ge=0.0, le=1000.0)
    terrain_clearance_m: float = Field(
        default=_AIRSPACE['terrain_clearance_m'], gt=0.0, le=LARGEST_HEIGHT_M
    )
    max_height_agl_m: float = Field(
        default=_AIRSPACE['max_height_agl_m'], gt=0.0, le=LARGEST_HEIGHT_M
    )
    wind_mps: tuple[float, float] = _AIRSPACE['wind_mps']

    def options(self) -> AirspaceOptions:
        """Return it as the planner takes it."""
        return AirspaceOptions(**self.model_dump())


class SeparationBlock(Block):
    """How far apart vehicles stay in the air: see `SeparationOptions`."""

    distance_m: float = Field(default=_SEPARATION['distance_m'], ge=0.0, le=10_000.0)
    by: Separation = _SEPARATION['by']


class FleetBlock(Block):
    """Whether each vehicle has an agent: they go on without an orchestrator.

    `link`: the way of their packets between hosts.
    """

    agents: bool = False
    link: Literal['dds', 'zenoh'] = 'dds'


class EffortBlock(Block):
    """Which method plans, what it minimises, for how long: see `Effort`.

    An empty `method` is the planner's default.
    """

    method: str = ''
    objective: Objective = _EFFORT['objective']
    budget_s: float = Field(default=_EFFORT['budget_s'], ge=0.0, le=LARGEST_BUDGET_S)


class SurveyBlock(Block):
    """How the region is photographed (see `CoverageOptions`), and how the plan is made."""

    height_agl_m: float = Field(gt=0.0, le=LARGEST_HEIGHT_M)
    spacing_rule: SpacingRule = _COVERAGE['spacing_rule']
    overlap_fraction: float = Field(default=_COVERAGE['overlap_fraction'], ge=0.0, le=0.95)
    front_overlap_fraction: float | None = Field(
        default=_COVERAGE['front_overlap_fraction'], ge=0.0, le=0.95
    )
    grid: Grid = _COVERAGE['grid']
    max_viewpoints: int = Field(default=_COVERAGE['max_viewpoints'], ge=1, le=MAX_VIEWPOINTS_LIMIT)
    terrain_file: str = ''
    airspace: AirspaceBlock = AirspaceBlock()
    separation: SeparationBlock = SeparationBlock()
    effort: EffortBlock = EffortBlock()

    def coverage(self) -> CoverageOptions:
        """Return where photographs are taken, as the planner takes it."""
        return CoverageOptions(**self.model_dump(include=set(_COVERAGE)))
