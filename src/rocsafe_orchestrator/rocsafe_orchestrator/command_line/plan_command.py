# SPDX-License-Identifier: Apache-2.0
"""`rocsafe plan`: who photographs what, without flying."""

import json
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from rocsafe_geo.area import SurveyArea
from rocsafe_geo.area_files import read_area
from rocsafe_orchestrator.command_line.progress import clock_text
from rocsafe_orchestrator.errors import EXIT_COMPLETE, OrchestratorError, ScenarioError
from rocsafe_orchestrator.processes.launches import find_executable
from rocsafe_orchestrator.scenario.scenario import Scenario
from rocsafe_orchestrator.scenario.scenario_blocks import (
    LINK_KEYS,
    RegionBlock,
    SurveyBlock,
    VehicleBlock,
)
from rocsafe_orchestrator.scenario.scenario_file import read_scenario, region_block

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
    vehicles, height_agl_m: of a region, which says neither.
    parent: folder below which the plans are written, None: nowhere.
    exclusions: region files that no leg crosses, besides the scenario's own.
    seed: of the search; None: the scenario's.
    survey, vehicle: keys of the scenario's survey, and of all its vehicles, with other values.
    """

    files: tuple[Path, ...]
    method: str = ''
    vehicles: int = 3
    height_agl_m: float = 32.0
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
    zones = tuple(region_block(_area(path)) for path in request.exclusions)
    scenarios = [
        (path, _with_options(_scenario(path, request), request, zones)) for path in request.files
    ]
    for path, scenario in scenarios:
        with tempfile.TemporaryDirectory(prefix='rocsafe-plan-') as scratch:
            folder = Path(scratch) if request.parent is None else request.parent / path.stem
            document = planned(path, scenario, request.method, folder)
        console.print(_quality_table(path, document))
        console.print(_route_table(document))
        if request.parent is not None:
            console.print(f'written to {folder}', highlight=False, soft_wrap=True)
    return EXIT_COMPLETE


def _scenario(path: Path, request: PlanRequest) -> Scenario:
    if path.suffix.lower() not in REGION_SUFFIXES:
        return read_scenario(path)
    area = _area(path)
    first = area.boundary[0]
    home = (first.latitude_deg, first.longitude_deg)
    names = (f'rav{number}' for number in range(1, request.vehicles + 1))
    return Scenario(
        name='region',
        region=region_block(area),
        survey=SurveyBlock(height_agl_m=request.height_agl_m),
        vehicles=tuple(VehicleBlock(name=name, home=home) for name in names),
    )


def _area(path: Path) -> SurveyArea:
    try:
        return read_area(path)
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
KEYS_SAID_OTHERWISE = frozenset({'home', 'end', 'endurance_s', 'reserve_fraction'})


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
    command = [str(find_executable('rocsafe_planner', 'plan_file'))]
    request = json.dumps(planner_request(scenario, method, folder))
    try:
        done = subprocess.run(
            command, input=request, capture_output=True, text=True, timeout=TIMEOUT_S, check=False
        )
    except subprocess.TimeoutExpired as error:
        raise OrchestratorError(f'{path}: no plan within {TIMEOUT_S:g} s') from error
    if done.returncode != 0:
        words = done.stderr.strip().splitlines() or [f'planner ended with {done.returncode}']
        raise OrchestratorError(f'{path}: {words[-1].removeprefix("error: ")}')
    document: dict[str, Any] = json.loads((folder / 'plan.json').read_text(encoding='utf-8'))
    return document


def _quality_table(path: Path, document: dict[str, Any]) -> Table:
    table = Table.grid(padding=(0, 2))
    table.add_column(style='dim')
    table.add_row('plan', f'{path}, method {document["method"]}')
    table.add_row(
        'viewpoints',
        f'{document["viewpoint_count"]}, which see {100.0 * document["covered_fraction"]:.1f} % '
        f'of {document["region_area_m2"] / 1e4:.2f} ha',
    )
    is_time = document['objective'] == 'longest_time'
    gap = f', at most {100.0 * document["gap_fraction"]:.1f} % above optimal' if is_time else ''
    table.add_row(
        'makespan',
        f'{clock_text(document["makespan_s"])}; no plan is shorter than '
        f'{clock_text(document["lower_bound_s"])} ({document["lower_bound_method"]}){gap}',
    )
    if not is_time:
        table.add_row(document['objective'], _objective_text(document))
    table.add_row(
        'flown in all',
        f'{document["total_length_m"] / 1000.0:.2f} km with {document["total_energy_wh"]:.0f} Wh',
    )
    nearest = document['minimum_separation_m']
    if nearest is not None:
        table.add_row('nearest', f'{nearest:.1f} m between two vehicles in the air')
    return table


def _objective_text(document: dict[str, Any]) -> str:
    """Return the value of an objective that is no makespan, and how good it is."""
    name, gap = document['objective'], document['objective_gap_fraction']
    unit = 'Wh' if name == 'energy' else 'm' if name.endswith('distance') else 's'
    proof = '' if gap is None else f', at most {100.0 * gap:.1f} % above optimal'
    return f'{document["objective_value"]:.0f} {unit}{proof}'


def _route_table(document: dict[str, Any]) -> Table:
    table = Table(box=None, pad_edge=False, header_style='dim')
    for column in (
        'vehicle',
        'viewpoints',
        'flights',
        'length',
        'duration',
        'takes off',
        'height',
    ):
        table.add_column(column, justify='left' if column == 'vehicle' else 'right')
    for route in document['routes']:
        table.add_row(
            route['vehicle'],
            str(len(route['viewpoints'])),
            str(len(route['sorties'])),
            f'{route["length_m"]:.0f} m',
            clock_text(route['duration_s']),
            f'after {clock_text(route["delay_s"])}' if route['delay_s'] else 'at once',
            f'{route["flight_height_m"]:.0f} m',
        )
    return table
