# SPDX-License-Identifier: Apache-2.0
"""`rocsafe whatif`: a table of what becomes of a mission when something fails."""

from collections.abc import Iterator
from pathlib import Path

from rich.console import Console
from rich.table import Table

from rocsafe_fleet.trial.radio import RadioOptions
from rocsafe_fleet.trial.what_if import Row, what_if
from rocsafe_orchestrator.errors import EXIT_COMPLETE
from rocsafe_orchestrator.planning_commands.plan_command import planned
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_file import read_scenario

SEARCH_S = 2.0
_COLUMNS = ('landed s', 'central s', 'more', 'missing', 'twice', 'epochs', 'bytes', 'least m')
_NOTE = (
    'Simulated seconds over level ground. "central": one head that searches 2 s from the same '
    'moment, all viewpoints free; those of a silent vehicle come last for agents. "twice": '
    'photographed again; "bytes": payload of the vehicle that sent most.'
)


def what_if_of(path: Path, loss: float, console: Console) -> int:
    """Print the table of a scenario.

    Raises
    ------
    ScenarioError
        If the file is not valid, or has what is not tried.
    OrchestratorError
        If there is no plan, with the reason of the planner.
    """
    scenario = read_scenario(path)
    lines = [f'{path.name}: {line}' for line in _untried(scenario)]
    if lines:
        raise ScenarioError('\n'.join(lines))
    plan = planned(path, scenario)
    table = Table(title=scenario.name)
    table.add_column('what fails', no_wrap=True)
    for name in _COLUMNS:
        table.add_column(name, justify='right')
    for row in what_if(plan, RadioOptions(loss=loss), scenario.seed, SEARCH_S):
        table.add_row(*_cells(row))
    console.print(table)
    console.print(_NOTE, highlight=False)
    return EXIT_COMPLETE


def _cells(row: Row) -> list[str]:
    central = '-' if row.central_s is None else f'{row.central_s:.0f}'
    more = '-' if row.central_s is None else f'{row.makespan_s / row.central_s - 1.0:+.1%}'
    return [
        row.name,
        f'{row.makespan_s:.0f}',
        central,
        more,
        str(row.missing),
        str(row.duplicates),
        str(row.epochs),
        str(row.payload_bytes),
        f'{row.least_m:.1f}',
    ]


def _untried(scenario: Scenario) -> Iterator[str]:
    """Yield what a scenario has that the trials do not fly."""
    survey = scenario.survey
    if not scenario.fleet.agents:
        yield 'fleet.agents = false: must be true for rocsafe whatif'
    if survey.terrain_file:
        yield f'survey.terrain_file = {survey.terrain_file!r}: must be empty for rocsafe whatif'
    if scenario.exclusions:
        yield f'exclusions = {len(scenario.exclusions)}: must be none for rocsafe whatif'
    if any(survey.airspace.wind_mps):
        wind = survey.airspace.wind_mps
        yield f'survey.airspace.wind_mps = {wind}: must be 0 for rocsafe whatif'
    for index, vehicle in enumerate(scenario.vehicles):
        if vehicle.hover_s == 0.0:
            yield f'vehicles[{index}].hover_s = 0: must be positive for rocsafe whatif'
