# SPDX-License-Identifier: Apache-2.0
"""`rocsafe plan`: who photographs what, without flying."""

import json
import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rich.console import Console

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.regions.area_files import read_areas
from rocsafe_orchestrator.command_line.plan_tables import quality_table, route_table
from rocsafe_orchestrator.errors import EXIT_COMPLETE, OrchestratorError
from rocsafe_orchestrator.processes.answers import answer_of
from rocsafe_orchestrator.processes.launches import find_executable
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_blocks import (
    LINK_KEYS,
    RegionBlock,
    SurveyBlock,
    VehicleBlock,
)
from rocsafe_scenario.scenario_file import read_scenario, region_block

REGION_SUFFIXES = ('.geojson', '.json', '.kml', '.kmz', '.plan', '.csv')
# A plan of the largest allowed size takes a fraction of this.
TIMEOUT_S = 600.0
# What a plan needs of the camera.
_PINHOLE = {'horizontal_fov_deg', 'image_width_px', 'image_height_px'}


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanRequest:
    """What the command line asks for.

    Attributes
    ----------
    files: scenarios and regions.
    method: routing method; empty: the scenario's, else the planner's own.
    vehicles, height_agl_m, home: of a region, which says nothing of them; without a home they
        start at its first corner.
    parent: folder below which the plans are written, None: nowhere.
    exclusions: region files that no leg crosses, besides the scenario's own.
    seed: of the search; None: the scenario's.
    survey, vehicle: keys of the scenario's survey, and of all its vehicles, with other values.
    """

    files: tuple[Path, ...]
    method: str = ''
    vehicles: int = 3
    height_agl_m: float = 32.0
    home: tuple[float, float] | None = None
    parent: Path | None = None
    exclusions: tuple[Path, ...] = ()
    seed: int | None = None
    survey: Mapping[str, Any] = field(default_factory=dict)
    vehicle: Mapping[str, Any] = field(default_factory=dict)


def plan(request: PlanRequest, console: Console) -> int:
    """Plan each file and print its routes.

    Raises
    ------
    ScenarioError: if a file is not valid.
    OrchestratorError: if there is no plan; the planner's reason is told.
    """
    zones = tuple(region_block(area) for path in request.exclusions for area in areas_of(path))
    scenarios = [
        (path, _with_options(_scenario(path, request), request, zones)) for path in request.files
    ]
    for path, scenario in scenarios:
        with tempfile.TemporaryDirectory(prefix='rocsafe-plan-') as scratch:
            folder = Path(scratch) if request.parent is None else request.parent / path.stem
            document = planned(path, scenario, request.method, folder)
        console.print(quality_table(path, document))
        console.print(route_table(document))
        if request.parent is not None:
            console.print(f'written to {folder}', highlight=False, soft_wrap=True)
    return EXIT_COMPLETE


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
    """Return the scenario with what the command line says besides."""
    changes = {
        'survey': scenario.survey.model_copy(update=request.survey),
        'vehicles': tuple(v.model_copy(update=request.vehicle) for v in scenario.vehicles),
        'exclusions': (*scenario.exclusions, *zones),
        'seed': scenario.seed if request.seed is None else request.seed,
    }
    return scenario.model_copy(update=changes)


def planner_request(scenario: Scenario, method: str, folder: Path) -> dict[str, Any]:
    """Return the request of `scenario` to the executable `plan_file`."""
    survey, camera = scenario.survey, scenario.camera
    method = method or survey.method
    return {
        'region': {'name': scenario.name, **scenario.region.model_dump(exclude={'file'})},
        'other_regions': [
            {'name': f'{scenario.name} {index}', **region.model_dump(exclude={'file'})}
            for index, region in enumerate(scenario.other_regions, start=2)
        ],
        'exclusions': [
            zone.model_dump(exclude={'file', 'sensors'}) for zone in scenario.exclusions
        ],
        'camera': camera.model_dump(include=_PINHOLE),
        'vehicles': [_vehicle(scenario, vehicle) for vehicle in scenario.vehicles],
        **survey.model_dump(exclude={'method'}),
        **({'method': method} if method else {}),
        'seed': scenario.seed,
        'output_directory': str(folder),
    }


# Of a vehicle, in the planner's own words.
KEYS_SAID_OTHERWISE = frozenset(
    {'home', 'end', 'endurance_s', 'reserve_fraction', 'fails_after_s'}
)


def _vehicle(scenario: Scenario, vehicle: VehicleBlock) -> dict[str, Any]:
    return {
        **vehicle.model_dump(exclude={*KEYS_SAID_OTHERWISE, *LINK_KEYS}),
        'home': [*vehicle.home, scenario.origin.ground_altitude_m],
        'end': None if vehicle.end is None else [*vehicle.end, scenario.origin.ground_altitude_m],
        'endurance_s': vehicle.usable_endurance_s,
    }


def planned(path: Path, scenario: Scenario, method: str, folder: Path) -> dict[str, Any]:
    """Return the plan as its JSON file says it."""
    homeless = ', '.join(vehicle.name for vehicle in scenario.vehicles if not vehicle.has_home)
    if homeless:
        raise ScenarioError(f'{path}: {homeless}: home must be given to plan without the vehicle')
    asked_planner(path, 'plan_file', planner_request(scenario, method, folder))
    document: dict[str, Any] = json.loads((folder / 'plan.json').read_text(encoding='utf-8'))
    return document


def asked_planner(path: Path, executable: str, request: dict[str, Any]) -> dict[str, Any]:
    """Return the summary that an executable of the planner gives; `path` is what it is about.

    Raises
    ------
    OrchestratorError: if there is no plan; the planner's reason is told.
    """
    found = find_executable('rocsafe_planner', executable)
    try:
        return answer_of(found, request, TIMEOUT_S)
    except OrchestratorError as error:
        raise OrchestratorError(f'{path}: {error}') from error
