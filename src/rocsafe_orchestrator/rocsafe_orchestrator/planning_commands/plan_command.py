# SPDX-License-Identifier: Apache-2.0
"""`rocsafe plan`: plan a survey without flying."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from rich.console import Console

from rocsafe_geo.motion.autopilot import Autopilot
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.regions.area_files import read_areas
from rocsafe_geo.terrain.terrain_file import read_terrain
from rocsafe_orchestrator.errors import EXIT_COMPLETE, OrchestratorError
from rocsafe_orchestrator.planning_commands.plan_tables import quality_table, route_table
from rocsafe_planner.checked_planning import checked_plan
from rocsafe_planner.errors import PlannerError
from rocsafe_planner.export.plan_files import write_plan
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.survey_options import Effort, SeparationOptions
from rocsafe_planner.plan.survey_region import SurveyRegion
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_scenario.blocks.mission import RegionBlock, SurveyBlock
from rocsafe_scenario.blocks.vehicles import LINK_KEYS, VehicleBlock
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_file import read_scenario, region_block
from rocsafe_scenario.search_reserve import planned_endurance_s

REGION_SUFFIXES = ('.geojson', '.json', '.kml', '.kmz', '.plan', '.csv')
# Keys of a vehicle in a scenario that the planner takes in another form, or not at all.
OTHER_KEYS = frozenset(
    {'home', 'end', 'endurance_s', 'reserve_fraction', 'fails_after_s', 'autopilot'}
)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanRequest:
    """Arguments of the command.

    Attributes
    ----------
    files
        Scenarios and region files.
    vehicles, height_agl_m, home
        Fleet and height for region files; without a home all start at the first corner.
    parent
        Folder below which the plans are written; None: nowhere.
    exclusions
        Region files that no leg crosses, beside the exclusions of the scenario.
    seed
        Seed of the search; None: that of the scenario.
    survey, airspace, separation, effort, vehicle
        Values that replace those of the scenario's blocks, by key; `vehicle` for all vehicles.
    """

    files: tuple[Path, ...]
    vehicles: int = 3
    height_agl_m: float = 32.0
    home: tuple[float, float] | None = None
    parent: Path | None = None
    exclusions: tuple[Path, ...] = ()
    seed: int | None = None
    survey: Mapping[str, Any] = field(default_factory=dict)
    airspace: Mapping[str, Any] = field(default_factory=dict)
    separation: Mapping[str, Any] = field(default_factory=dict)
    effort: Mapping[str, Any] = field(default_factory=dict)
    vehicle: Mapping[str, Any] = field(default_factory=dict)


def plan(request: PlanRequest, console: Console) -> int:
    """Plan each file and print its routes.

    Raises
    ------
    ScenarioError
        If a file is not valid.
    OrchestratorError
        If there is no plan, with the reason of the planner.
    """
    zones = tuple(region_block(area) for path in request.exclusions for area in areas_of(path))
    scenarios = [
        (path, _with_options(_scenario(path, request), request, zones)) for path in request.files
    ]
    for path, scenario in scenarios:
        found = planned(path, scenario)
        console.print(quality_table(path, found))
        console.print(route_table(found))
        if request.parent is not None:
            write(found, request.parent / path.stem, console)
    return EXIT_COMPLETE


def write(plan: SurveyPlan, folder: Path, console: Console) -> None:
    """Write the files of a plan and print where they are."""
    try:
        write_plan(plan, folder)
    except ValueError as error:
        raise OrchestratorError(str(error)) from error
    console.print(f'written to {folder}', highlight=False, soft_wrap=True)


def _scenario(path: Path, request: PlanRequest) -> Scenario:
    if path.suffix.lower() not in REGION_SUFFIXES:
        return read_scenario(path)
    areas = areas_of(path)
    first = areas[0].boundary[0]
    home = request.home or (first.latitude_deg, first.longitude_deg)
    try:
        GeoPosition(*home)
    except ValueError as error:
        raise ScenarioError(f'--home: {error}') from error
    names = (f'rav{number}' for number in range(1, request.vehicles + 1))
    return Scenario(
        name=re.sub('[^A-Za-z0-9_-]', '-', path.stem).lstrip('-_')[:64] or 'region',
        region=region_block(areas[0]),
        other_regions=tuple(map(region_block, areas[1:])),
        survey=SurveyBlock(height_agl_m=request.height_agl_m),
        vehicles=tuple(VehicleBlock(name=name, home=home) for name in names),
    )


def areas_of(path: Path) -> tuple[SurveyArea, ...]:
    """Return the polygons of a region file; ScenarioError saying what is wrong with it."""
    try:
        return read_areas(path)
    except ValueError as error:
        raise ScenarioError(str(error)) from error


def _with_options(
    scenario: Scenario, request: PlanRequest, zones: tuple[RegionBlock, ...]
) -> Scenario:
    """Return the scenario with the values of the command line."""
    survey = scenario.survey
    blocks = {
        key: getattr(survey, key).model_copy(update=getattr(request, key))
        for key in ('airspace', 'separation', 'effort')
    }
    changes = {
        'survey': survey.model_copy(update={**request.survey, **blocks}),
        'vehicles': tuple(v.model_copy(update=request.vehicle) for v in scenario.vehicles),
        'exclusions': (*scenario.exclusions, *zones),
        'seed': scenario.seed if request.seed is None else request.seed,
    }
    return scenario.model_copy(update=changes)


def planned(path: Path, scenario: Scenario) -> SurveyPlan:
    """Return the checked plan of a scenario.

    Raises
    ------
    ScenarioError
        If the home of a vehicle is not known.
    OrchestratorError
        If there is no plan, with the reason of the planner.
    """
    homeless = ', '.join(vehicle.name for vehicle in scenario.vehicles if not vehicle.has_home)
    if homeless:
        raise ScenarioError(f'{path}: {homeless}: home must be given to plan without the vehicle')
    try:
        return checked_plan(survey_request(scenario))
    except (PlannerError, ValueError) as error:
        raise OrchestratorError(f'{path}: {error}') from error


def survey_request(scenario: Scenario) -> SurveyRequest:
    """Return what a scenario asks of the planner."""
    survey, camera = scenario.survey, scenario.camera
    effort = survey.effort.model_dump(exclude=set() if survey.effort.method else {'method'})
    return SurveyRequest(
        regions=_regions(scenario),
        exclusions=scenario.exclusion_areas(),
        camera=PinholeCamera(
            math.radians(camera.horizontal_fov_deg), camera.image_width_px, camera.image_height_px
        ),
        vehicles=tuple(_vehicle(scenario, vehicle) for vehicle in scenario.vehicles),
        terrain=read_terrain(survey.terrain_file) if survey.terrain_file else None,
        coverage=survey.coverage(),
        airspace=survey.airspace.options(),
        separation=SeparationOptions(**survey.separation.model_dump()),
        effort=Effort(**effort, seed=scenario.seed),
    )


def _regions(scenario: Scenario) -> tuple[SurveyRegion, ...]:
    others = [
        SurveyRegion(area=replace(area, name=f'{scenario.name} {index}'), sensors=block.sensors)
        for index, (area, block) in enumerate(
            zip(scenario.other_areas(), scenario.other_regions, strict=True), start=2
        )
    ]
    return (SurveyRegion(area=scenario.area(), sensors=scenario.region.sensors), *others)


def _vehicle(scenario: Scenario, block: VehicleBlock) -> Vehicle:
    return Vehicle(
        **block.model_dump(exclude={*OTHER_KEYS, *LINK_KEYS}),
        autopilot=Autopilot(**block.autopilot.model_dump()),
        home=scenario.ground_position(block.home),
        end=None if block.end is None else scenario.ground_position(block.end),
        endurance_s=planned_endurance_s(scenario, block),
    )
