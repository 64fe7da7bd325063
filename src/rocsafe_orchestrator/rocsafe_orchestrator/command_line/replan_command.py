# SPDX-License-Identifier: Apache-2.0
"""`rocsafe replan`: the rest of a survey, planned anew."""

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from rocsafe_orchestrator.command_line.plan_command import areas_of, asked_planner
from rocsafe_orchestrator.command_line.plan_tables import quality_table, route_table
from rocsafe_orchestrator.errors import EXIT_COMPLETE
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario_file import region_block


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplanRequest:
    """What the command line asks for.

    Attributes
    ----------
    plan: the file of the plan to go on with.
    visited: ids of viewpoints and ranges of them, by commas.
    lost: names of vehicles that cannot go on.
    aloft: name, latitude, longitude and time on its battery of each vehicle in the air.
    new_places: latitude and longitude of more places to photograph.
    exclusions: region files that no leg crosses any more.
    folder: where the plan's files are written; None: nowhere.
    terrain: file of heights of a plan that follows them.
    """

    plan: Path
    visited: str = ''
    lost: tuple[str, ...] = ()
    aloft: tuple[tuple[str, ...], ...] = ()
    new_places: tuple[tuple[float, ...], ...] = ()
    exclusions: tuple[Path, ...] = ()
    folder: Path | None = None
    terrain: Path | None = None


def replan(request: ReplanRequest, console: Console) -> int:
    """Plan the rest and print its routes.

    Raises
    ------
    ScenarioError: if an argument or a file is wrong.
    OrchestratorError: if there is no plan; the planner's reason is told.
    """
    with tempfile.TemporaryDirectory(prefix='rocsafe-replan-') as scratch:
        folder = request.folder or Path(scratch)
        summary = asked_planner(request.plan, 'replan_file', planner_request(request, folder))
        document = json.loads((folder / 'plan.json').read_text(encoding='utf-8'))
    console.print(quality_table(request.plan, document))
    console.print(route_table(document))
    if summary['unreachable']:
        ids = ', '.join(map(str, summary['unreachable']))
        console.print(f'in exclusions, and left out: viewpoints {ids}', soft_wrap=True)
    for name, way_m in summary['leaving_exclusions_m'].items():
        text = f'{name} is in an exclusion: leaves it the shortest way, {way_m:.1f} m'
        console.print(text, soft_wrap=True, highlight=False)
    if request.folder is not None:
        console.print(f'written to {request.folder}', highlight=False, soft_wrap=True)
    return EXIT_COMPLETE


def planner_request(request: ReplanRequest, folder: Path) -> dict[str, Any]:
    """Return the request to the executable `replan_file`."""
    return {
        'plan': str(request.plan),
        'alive': _alive(request),
        'visited': _ids(request.visited),
        'new_places': [list(place) for place in request.new_places],
        'new_exclusions': [
            region_block(area).model_dump(exclude={'file', 'sensors'})
            for path in request.exclusions
            for area in areas_of(path)
        ],
        'terrain_file': '' if request.terrain is None else str(request.terrain),
        'output_directory': str(folder),
    }


def _alive(request: ReplanRequest) -> list[dict[str, Any]]:
    """Return the vehicles of the plan that are not lost, each where it is."""
    names = _names(request.plan)
    aloft = {words[0]: words for words in request.aloft}
    strangers = [name for name in (*request.lost, *aloft) if name not in names]
    if strangers:
        raise ScenarioError(f'{strangers[0]}: must be a vehicle of the plan: {", ".join(names)}')
    alive = []
    for name in names:
        place = {}
        if name in aloft:
            latitude, longitude, used = (_number(name, word) for word in aloft[name][1:])
            place = {'position': [latitude, longitude], 'used_s': used}
        if name not in request.lost:
            alive.append({'name': name, **place})
    return alive


def _names(path: Path) -> list[str]:
    try:
        document = json.loads(path.read_text(encoding='utf-8'))
        return [route['vehicle'] for route in document['routes']]
    except OSError as error:
        raise ScenarioError(f'{path}: {error.strerror}') from error
    except (KeyError, TypeError, ValueError) as error:
        raise ScenarioError(f'{path}: is no plan.json') from error


def _number(name: str, word: str) -> float:
    try:
        return float(word)
    except ValueError as error:
        raise ScenarioError(f'--at {name}: {word}: must be a number') from error


def _ids(text: str) -> list[int]:
    """Return the numbers of a list such as 0-20,33."""
    ids: list[int] = []
    for part in filter(None, text.split(',')):
        first, _, last = part.strip().partition('-')
        if not first.isdigit() or (last and not last.isdigit()):
            raise ScenarioError(f'--visited {part}: must be a number or a range such as 0-20')
        ids.extend(range(int(first), int(last or first) + 1))
    return ids
