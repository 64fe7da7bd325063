# SPDX-License-Identifier: Apache-2.0
"""`rocsafe replan`: what becomes of its arguments, and what is wrong with them."""

import json
from pathlib import Path

import pytest

from rocsafe_orchestrator.command_line.replan_command import ReplanRequest, planner_request
from rocsafe_scenario.errors import ScenarioError


@pytest.fixture
def plan_file(tmp_path: Path) -> Path:
    """A file with as much of a plan as the command reads."""
    path = tmp_path / 'plan.json'
    routes = [{'vehicle': f'rav{k}'} for k in (1, 2, 3)]
    path.write_text(json.dumps({'routes': routes}), encoding='utf-8')
    return path


def test_arguments_become_a_request(plan_file: Path, tmp_path: Path) -> None:
    """One is lost, one in the air, one at home; ranges are spelt out."""
    request = ReplanRequest(
        plan=plan_file,
        visited='0-3, 7',
        lost=('rav2',),
        aloft=(('rav3', '53.28', '-9.06', '120'),),
        new_places=((53.281, -9.061),),
    )
    assert planner_request(request, tmp_path) == {
        'plan': str(plan_file),
        'alive': [
            {'name': 'rav1'},
            {'name': 'rav3', 'position': [53.28, -9.06], 'used_s': 120.0},
        ],
        'visited': [0, 1, 2, 3, 7],
        'new_places': [[53.281, -9.061]],
        'new_exclusions': [],
        'terrain_file': '',
        'output_directory': str(tmp_path),
    }


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'lost': ('x',)}, 'x: must be a vehicle of the plan: rav1, rav2, rav3'),
        ({'visited': '1-x'}, '--visited 1-x: must be a number or a range'),
        ({'aloft': (('rav1', 'here', '0', '0'),)}, '--at rav1: here: must be a number'),
        ({'plan': Path('none.json')}, 'none.json: No such file'),
        ({'exclusions': (Path('none.kml'),)}, 'none.kml'),
    ],
)
def test_wrong_arguments_are_named(
    plan_file: Path, tmp_path: Path, changes: dict[str, object], message: str
) -> None:
    """One line each."""
    request = ReplanRequest(**{'plan': plan_file, **changes})  # type: ignore[arg-type]
    with pytest.raises(ScenarioError, match=message) as caught:
        planner_request(request, tmp_path)
    assert '\n' not in str(caught.value)
