# SPDX-License-Identifier: Apache-2.0
"""`rocsafe preflight`: check real vehicles before a flight."""

from collections.abc import Iterable
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from rocsafe_geo.position import GeoPosition
from rocsafe_orchestrator.errors import EXIT_COMPLETE, EXIT_FAILED, OrchestratorError
from rocsafe_orchestrator.parameters.node_parameters import bridge_parameters
from rocsafe_orchestrator.planning_commands.plan_command import planned
from rocsafe_orchestrator.process_table.executables import find_executable
from rocsafe_orchestrator.processes.answers import answer_of
from rocsafe_planner.plan.plan import Route
from rocsafe_scenario.blocks.ground_vehicle import GroundVehicleBlock
from rocsafe_scenario.blocks.vehicles import VehicleBlock
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_file import read_scenario

# Time to start and end the executable, in addition to its own waiting time.
SPARE_S = 30.0
STYLES = {'pass': 'green', 'warn': 'yellow', 'fail': 'bold red'}


def preflight(path: Path, wait_s: float, console: Console) -> int:
    """Print every check of the real vehicles of the scenario at `path`; return the exit code.

    Raises
    ------
    OrchestratorError
        If the scenario is not valid, has no real vehicle, or a link cannot be used.
    """
    scenario = read_scenario(path)
    if not scenario.linked:
        raise ScenarioError(f'{path}: no vehicle is real (has a link): nothing to check')
    first = look(scenario, wait_s)
    scenario = with_homes(scenario, first)
    unknown = [vehicle.name for vehicle in scenario.linked if not vehicle.has_home]
    answers = first if unknown else look(scenario, wait_s, planned_routes(path, scenario))
    for answer in answers:
        console.print(_table(answer))
    failed = [answer['name'] for answer in answers if not answer['may_fly']]
    words = f'must not fly: {", ".join(failed)}' if failed else 'all may fly'
    console.print(words, style='bold red' if failed else 'bold green')
    return EXIT_FAILED if failed else EXIT_COMPLETE


def look(
    scenario: Scenario, wait_s: float, routes: dict[str, Any] | None = None, host: str = ''
) -> list[dict[str, Any]]:
    """Return what the executable `preflight` says of each real vehicle of a host.

    Raises
    ------
    OrchestratorError
        If there is no answer, with the reason.
    """
    bridge = bridge_parameters(scenario, '', scenario.linked_on(host or scenario.head))
    request = {'bridge': bridge, 'routes': routes or {}, 'patience_s': wait_s}
    executable = find_executable('rocsafe_mavlink', 'preflight')
    answer = answer_of(executable, request, wait_s + SPARE_S)
    vehicles: list[dict[str, Any]] = answer['vehicles']
    return vehicles


def require_links(scenario: Scenario) -> None:
    """Raise `OrchestratorError` if a bridge would refuse its vehicles; no link is opened.

    The executable of the bridge judges: its options are its own. Files of vehicles of another
    host are not looked for: they are there.
    """
    block = scenario.ground_vehicle
    driver = block if block and block.link else None
    if not scenario.linked and driver is None:
        return
    bridge = bridge_parameters(scenario, '', scenario.linked, driver)
    here: list[VehicleBlock | GroundVehicleBlock] = [*scenario.linked_on(scenario.head)]
    if driver is not None:
        here.append(driver)
    for vehicle in here:
        _require_format_file(vehicle)
    request = {'bridge': bridge, 'only_options': True, 'files_of': [each.name for each in here]}
    answer_of(find_executable('rocsafe_mavlink', 'preflight'), request, SPARE_S)


def _require_format_file(vehicle: VehicleBlock | GroundVehicleBlock) -> None:
    """Raise `ScenarioError` if the formats of a vehicle's detector are in no file."""
    detector = vehicle.drone.detector
    file = '' if isinstance(detector, str) else detector.format_file
    if file and not Path(file).is_file():
        raise ScenarioError(f'{vehicle.name}: drone.detector.format_file = {file!r}: no such file')


def cleared(scenario: Scenario, wait_s: float, now: datetime, host: str = '') -> Scenario:
    """Check the real vehicles of a host; return the scenario with homes and the present time.

    Raises
    ------
    OrchestratorError
        If a vehicle must not fly, with every reason.
    """
    answers = look(scenario, wait_s, host=host)
    reasons = [
        f'{answer["name"]} must not fly: {check["name"]} is {check["value"]}: must be '
        f'{check["limit"]}'
        for answer in answers
        for check in answer['checks']
        if check['verdict'] == 'fail'
    ]
    if reasons:
        raise OrchestratorError('\n'.join(reasons))
    return on_wall_time(with_homes(scenario, answers), now)


def on_wall_time(scenario: Scenario, now: datetime) -> Scenario:
    """Return a scenario with a real vehicle at the present time, which runs as on the wall."""
    is_given = 'start' in scenario.clock.model_fields_set
    start = scenario.clock.start if is_given else now.astimezone(timezone.utc)
    clock = scenario.clock.model_copy(update={'speed': 1.0, 'start': start})
    return scenario.model_copy(update={'clock': clock})


def with_homes(scenario: Scenario, answers: Iterable[dict[str, Any]]) -> Scenario:
    """Return the scenario with the homes reported by real vehicles where it has none."""
    told = {answer['name']: answer['home'] for answer in answers if answer['home']}
    vehicles = tuple(
        vehicle
        if vehicle.has_home or vehicle.name not in told
        else vehicle.model_copy(update={'home': tuple(told[vehicle.name])})
        for vehicle in scenario.vehicles
    )
    return scenario.model_copy(update={'vehicles': vehicles})


def planned_routes(path: Path, scenario: Scenario) -> dict[str, Any]:
    """Return what each real vehicle would fly, as the executable `preflight` reads it."""
    plan = planned(path, scenario)
    ground_m = scenario.origin.ground_altitude_m
    homes = {vehicle.name: vehicle.home for vehicle in scenario.linked}
    return {
        route.vehicle.name: {
            'home': list(homes[route.vehicle.name]),
            'waypoints': _waypoints(route, ground_m),
            'exclusions': [
                [[corner.latitude_deg, corner.longitude_deg] for corner in zone.boundary]
                for zone in plan.request.exclusions
            ],
            'clearance_m': plan.request.airspace.clearance_m,
        }
        for route in plan.routes
        if route.vehicle.name in homes and route.viewpoints
    }


def _waypoints(route: Route, ground_m: float) -> list[list[float | bool]]:
    """Return viewpoints and the bends before them: latitude, longitude, height, is a bend."""
    found: list[list[float | bool]] = []
    for sortie in route.sorties:
        height_m = 0.0
        for viewpoint, bends in zip(sortie.viewpoints, sortie.bends, strict=False):
            place = viewpoint.position
            height_m = place.altitude_m - ground_m
            found += [_waypoint(bend, height_m, is_bend=True) for bend in bends]
            found.append(_waypoint(place, height_m, is_bend=False))
        for bends in sortie.bends[len(sortie.viewpoints) :]:
            found += [_waypoint(bend, height_m, is_bend=True) for bend in bends]
    return found


def _waypoint(place: GeoPosition, height_m: float, *, is_bend: bool) -> list[float | bool]:
    return [place.latitude_deg, place.longitude_deg, height_m, is_bend]


def _table(answer: dict[str, Any]) -> Table:
    title = answer['name'] + ('' if answer['may_fly'] else ': must not fly')
    table = Table(title=title, box=None, pad_edge=False, header_style='dim', title_justify='left')
    for column in ('check', '', 'found', 'must be'):
        table.add_column(column)
    for check in answer['checks']:
        verdict = check['verdict']
        table.add_row(
            check['name'],
            f'[{STYLES[verdict]}]{verdict}[/]',
            check['value'],
            check['limit'],
        )
    return table
