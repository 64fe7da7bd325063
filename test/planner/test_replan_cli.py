# SPDX-License-Identifier: Apache-2.0
"""`replan_file`: a plan's file and what happened in, a summary out."""

import io
import json
import sys

import numpy as np
import pytest

from rocsafe_planner.command_line.replan_command import main
from rocsafe_planner.export.plan_files import write_plan
from rocsafe_planner.planning import plan_survey

from .fleets import request
from .terrains import read_terrain, write_terrain


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Write the derailment's plan."""
    path = tmp_path_factory.mktemp('plan')
    write_plan(plan_survey(request()), path)
    return path


@pytest.fixture
def replan_file(monkeypatch, capsys):
    """Give a function that runs the command: a request in; exit code, output and errors out."""

    def run(**request):
        content = io.BytesIO(json.dumps(request).encode())
        monkeypatch.setattr(sys, 'stdin', io.TextIOWrapper(content))
        code = main([])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


def test_the_rest_is_planned_and_written(replan_file, folder):
    """One vehicle is lost, one in the air, one at home; ten viewpoints are done, one is new."""
    code, out, err = replan_file(
        plan=str(folder / 'plan.json'),
        alive=[{'name': 'rav1', 'position': [53.28, -9.064], 'used_s': 60.0}, {'name': 'rav3'}],
        visited=list(range(10)),
        new_places=[[53.2799, -9.0615]],
        output_directory=str(folder / 'rest'),
    )
    assert (code, err) == (0, '')
    summary = json.loads(out)
    assert summary['viewpoint_count'] == 59 - 10 + 1
    assert summary['unreachable'] == []
    rest = json.loads((folder / 'rest' / 'plan.json').read_text())
    assert [route['vehicle'] for route in rest['routes']] == ['rav1', 'rav3']


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'alive': [{'name': 'x'}]}, "alive has 'x': must be of rav1, rav2, rav3"),
        ({'alive': []}, 'no vehicle is left'),
        ({'visited': [500]}, 'visited has viewpoint 500'),
        ({'plan': 'none.json'}, 'none.json: No such file'),
        ({'vehicle': 1}, 'vehicle: Extra inputs'),
        ({'new_places': [[91.0, 0.0]]}, 'new_places.0: latitude_deg is 91'),
    ],
)
def test_a_wrong_request_gives_one_line(replan_file, folder, changes, message):
    """Exit code 2 and one line that names what is wrong."""
    values = {'plan': str(folder / 'plan.json'), 'alive': [{'name': 'rav1'}], **changes}
    code, out, err = replan_file(**values)
    assert (code, out) == (2, '')
    assert message in err
    assert err.count('\n') == 1


def test_plan_over_a_terrain_needs_its_file(replan_file, tmp_path):
    """With the same heights the rest is planned over them; without, or with others, refused."""
    ridge, other = tmp_path / 'ridge.tif', tmp_path / 'other.tif'
    slope = np.linspace(0.0, 30.0, 200) * np.ones((200, 1))
    write_terrain(ridge, slope)
    write_terrain(other, 2.0 * slope)
    plan = plan_survey(request(terrain=read_terrain(ridge), method='strips'))
    write_plan(plan, tmp_path / 'plan')
    asked = {
        'plan': str(tmp_path / 'plan' / 'plan.json'),
        'alive': [{'name': 'rav1'}, {'name': 'rav3'}],
        'visited': list(range(30)),
    }
    code, out, err = replan_file(**asked, terrain_file=str(ridge))
    assert (code, err) == (0, '')
    assert json.loads(out)['viewpoint_count'] == 59 - 30
    for wrong, message in (('', 'must be given that file'), (str(other), 'has other heights')):
        code, _, err = replan_file(**asked, terrain_file=wrong)
        assert code == 2
        assert message in err
        assert err.count('\n') == 1
