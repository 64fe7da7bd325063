# SPDX-License-Identifier: Apache-2.0
"""`rocsafe replan`: what becomes of its arguments, and what is wrong with them."""

from pathlib import Path

import pytest
from rich.console import Console
from test.planner.fleets import request as survey

from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.planning_commands.replan_command import (
    ReplanRequest,
    replan,
    situation_of,
)
from rocsafe_planner.export.plan_files import write_plan
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.vehicle import Aloft
from rocsafe_planner.planning import plan_survey
from rocsafe_scenario.errors import ScenarioError


@pytest.fixture(scope='module')
def plan() -> SurveyPlan:
    """A plan for three vehicles."""
    return plan_survey(survey(method='strips'))


@pytest.fixture
def plan_file(plan: SurveyPlan, tmp_path: Path) -> Path:
    """The file of that plan."""
    write_plan(plan, tmp_path)
    return tmp_path / 'plan.json'


def test_arguments_become_a_situation(plan: SurveyPlan) -> None:
    """One is lost, one in the air, one at home; ranges are spelt out."""
    request = ReplanRequest(
        plan=Path('plan.json'),
        visited='0-3, 7',
        lost=('rav2',),
        aloft=(('rav3', '53.28', '-9.06', '120'),),
        new_places=((53.281, -9.061),),
    )
    found = situation_of(request, plan)
    assert found.alive == {'rav1': None, 'rav3': found.alive['rav3']}
    aloft = found.alive['rav3']
    assert isinstance(aloft, Aloft)
    assert (aloft.position.latitude_deg, aloft.used_s) == (53.28, 120.0)
    assert found.visited == {0, 1, 2, 3, 7}
    assert [(p.latitude_deg, p.longitude_deg) for p in found.new_places] == [(53.281, -9.061)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'lost': ('x',)}, 'x: must be a vehicle of the plan: rav1, rav2, rav3'),
        ({'visited': '1-x'}, '--visited 1-x: must be a number or a range'),
        ({'visited': '1-'}, '--visited 1-: must be a number or a range'),
        ({'visited': '7-3'}, '--visited 7-3: must be viewpoints of the plan, 0 to'),
        ({'visited': '0-1000000000'}, '--visited 0-1000000000: must be viewpoints of the plan'),
        ({'visited': '500'}, '--visited 500: must be viewpoints of the plan'),
        ({'lost': ('rav1', 'rav1')}, 'rav1: must be named once'),
        ({'lost': ('rav1',), 'aloft': (('rav1', '53.28', '-9.06', '5'),)}, 'rav1: must be named'),
        ({'aloft': (('rav1', 'here', '0', '0'),)}, '--at rav1: here: must be a number'),
        ({'aloft': (('rav1', '99', '0', '0'),)}, '--at rav1: latitude_deg is 99'),
        ({'new_places': ((91.0, 0.0),)}, '--add: latitude_deg is 91'),
        ({'plan': Path('none.json')}, 'none.json: No such file'),
        ({'exclusions': (Path('none.kml'),)}, 'none.kml'),
    ],
)
def test_wrong_arguments_are_named(
    plan_file: Path, changes: dict[str, object], message: str
) -> None:
    """One line each."""
    request = ReplanRequest(**{'plan': plan_file, **changes})  # type: ignore[arg-type]
    with pytest.raises(ScenarioError, match=message) as caught:
        replan(request, Console())
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'lost': ('rav1', 'rav2', 'rav3')}, 'no vehicle is left'),
    ],
)
def test_a_situation_without_a_plan_is_told(
    plan_file: Path, changes: dict[str, object], message: str
) -> None:
    """The reason of the planner, with the file."""
    request = ReplanRequest(**{'plan': plan_file, **changes})  # type: ignore[arg-type]
    with pytest.raises(OrchestratorError, match=message):
        replan(request, Console())


@pytest.mark.slow
def test_what_batteries_do_not_do_for_is_named(
    plan: SurveyPlan, plan_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two are lost, and the third has little left: it does a part, and the rest is named."""
    home = plan.request.vehicles[0].home
    used_s = plan.request.vehicles[0].endurance_s - 300.0
    request = ReplanRequest(
        plan=plan_file,
        lost=('rav2', 'rav3'),
        aloft=(('rav1', str(home.latitude_deg), str(home.longitude_deg), str(used_s)),),
    )
    assert replan(request, Console()) == 0
    assert 'beyond the batteries, and left out: viewpoints ' in capsys.readouterr().out
