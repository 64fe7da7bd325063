# SPDX-License-Identifier: Apache-2.0
"""`rocsafe replan`: plan the rest of a survey."""

import re
from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.terrain.terrain_file import read_terrain
from rocsafe_orchestrator.errors import EXIT_COMPLETE, OrchestratorError
from rocsafe_orchestrator.planning_commands.plan_command import areas_of, write
from rocsafe_orchestrator.planning_commands.plan_tables import quality_table, route_table
from rocsafe_planner.errors import PlannerError
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.plan_reading import read_plan
from rocsafe_planner.plan.situation import Situation
from rocsafe_planner.plan.vehicle import Aloft
from rocsafe_planner.replanning import leaving_exclusions_m, unreachable
from rocsafe_planner.replanning import replan as planner_replan
from rocsafe_scenario.errors import ScenarioError


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplanRequest:
    """Arguments of the command.

    Attributes
    ----------
    plan
        File of the plan to go on with.
    visited
        Ids of viewpoints and ranges of them, separated by commas.
    lost
        Names of vehicles that cannot go on.
    aloft
        Name, latitude, longitude and used battery time of each vehicle in the air.
    new_places
        Latitude and longitude of more places to photograph.
    exclusions
        Region files that no leg crosses any more.
    folder
        Where the files of the plan are written; None: nowhere.
    terrain
        File of heights of a plan over terrain.
    """

    plan: Path
    visited: str = ''
    lost: tuple[str, ...] = ()
    aloft: tuple[tuple[str, ...], ...] = ()
    new_places: tuple[tuple[float, float], ...] = ()
    exclusions: tuple[Path, ...] = ()
    folder: Path | None = None
    terrain: Path | None = None


def replan(request: ReplanRequest, console: Console) -> int:
    """Plan the rest and print its routes.

    Raises
    ------
    ScenarioError
        If an argument or a file is wrong.
    OrchestratorError
        If there is no plan, with the reason of the planner.
    """
    plan = plan_of(request.plan, request.terrain)
    situation = situation_of(request, plan)
    try:
        rest = planner_replan(plan, situation)
    except (PlannerError, ValueError) as error:
        raise OrchestratorError(f'{request.plan}: {error}') from error
    console.print(quality_table(request.plan, rest))
    console.print(route_table(rest))
    for why, left_out in (
        ('in exclusions', unreachable(rest)),
        ('beyond the batteries', rest.left_out),
    ):
        if left_out:
            ids = ', '.join(map(str, left_out))
            console.print(f'{why}, and left out: viewpoints {ids}', soft_wrap=True)
    for name, way_m in leaving_exclusions_m(rest).items():
        text = f'{name} is in an exclusion: leaves it the shortest way, {way_m:.1f} m'
        console.print(text, soft_wrap=True, highlight=False)
    if request.folder is not None:
        write(rest, request.folder, console)
    return EXIT_COMPLETE


def plan_of(path: Path, terrain: Path | None) -> SurveyPlan:
    """Return the plan of a file; ScenarioError saying what is wrong with it."""
    try:
        return read_plan(path, read_terrain(terrain) if terrain else None)
    except ValueError as error:
        raise ScenarioError(str(error)) from error


def situation_of(request: ReplanRequest, plan: SurveyPlan) -> Situation:
    """Return what has become of a plan by the arguments of the command."""
    names = [vehicle.name for vehicle in plan.request.vehicles]
    aloft = {words[0]: words for words in request.aloft}
    strangers = [name for name in (*request.lost, *aloft) if name not in names]
    if strangers:
        raise ScenarioError(f'{strangers[0]}: must be a vehicle of the plan: {", ".join(names)}')
    told = Counter((*request.lost, *(words[0] for words in request.aloft)))
    for name in (name for name, times in told.items() if times > 1):
        raise ScenarioError(f'{name}: must be named once, by --lost or by --at')
    rest = plan.request.continuation
    views = (*rest.visited, *rest.viewpoints, *(v for r in plan.routes for v in r.viewpoints))
    return Situation(
        alive={
            name: _aloft(aloft[name]) if name in aloft else None
            for name in names
            if name not in request.lost
        },
        visited=frozenset(_ids(request.visited, {view.id for view in views})),
        new_places=tuple(_place('--add', *place) for place in request.new_places),
        new_exclusions=tuple(a for path in request.exclusions for a in areas_of(path)),
    )


def _aloft(words: tuple[str, ...]) -> Aloft:
    option = f'--at {words[0]}'
    latitude, longitude, used_s = (_number(option, word) for word in words[1:])
    try:
        return Aloft(position=_place(option, latitude, longitude), used_s=used_s)
    except ValueError as error:
        raise ScenarioError(f'{option}: {error}') from error


def _place(option: str, latitude: float, longitude: float) -> GeoPosition:
    try:
        return GeoPosition(latitude, longitude)
    except ValueError as error:
        raise ScenarioError(f'{option}: {error}') from error


def _number(option: str, word: str) -> float:
    try:
        return float(word)
    except ValueError as error:
        raise ScenarioError(f'{option}: {word}: must be a number') from error


def _ids(text: str, known: Collection[int]) -> set[int]:
    """Return the numbers of a list such as 0-20,33, which are all known."""
    ids: set[int] = set()
    for part in filter(None, text.split(',')):
        found = re.fullmatch(r'\s*([0-9]+)(?:-([0-9]+))?\s*', part)
        if found is None:
            raise ScenarioError(f'--visited {part}: must be a number or a range such as 0-20')
        first, last = int(found[1]), int(found[2] or found[1])
        if not (first <= last and {first, last} <= set(known)):
            raise ScenarioError(
                f'--visited {part}: must be viewpoints of the plan, {min(known)} to {max(known)}, '
                'the lower one first'
            )
        ids |= set(range(first, last + 1))
    return ids
