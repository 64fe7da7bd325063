# SPDX-License-Identifier: Apache-2.0
"""`plan_file`: a request in, a summary out."""

import io
import json
import sys

import pytest

from rocsafe_planner.command_line.plan_command import main

pytestmark = pytest.mark.slow

REQUEST = {
    'region': {
        'name': 'rectangle',
        'polygon': [
            [53.27959959, -9.0617270785],
            [53.2805257315, -9.0621271428],
            [53.2801009832, -9.0648776011],
            [53.2791748417, -9.0644775368],
        ],
    },
    'camera': {'horizontal_fov_deg': 60, 'image_width_px': 640, 'image_height_px': 480},
    'vehicles': [
        {
            'name': 'rav1',
            'home': [53.28, -9.07, 12.0],
            'cruise_speed_mps': 8,
            'acceleration_mps2': 2.5,
            'climb_rate_mps': 3,
            'descent_rate_mps': 2,
            'hover_s': 2,
            'endurance_s': 1500,
        }
    ],
    'height_agl_m': 32,
}


@pytest.fixture
def plan_file(monkeypatch, capsys):
    """Give a function that runs the command: text in; exit code, output and errors out."""

    def run(text):
        content = text if isinstance(text, bytes) else text.encode()
        monkeypatch.setattr(sys, 'stdin', io.TextIOWrapper(io.BytesIO(content)))
        code = main([])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


def test_plan_and_summary(plan_file, tmp_path):
    """The summary names the files, which hold the plan that it sums up."""
    request = {**REQUEST, 'output_directory': str(tmp_path / 'out')}
    code, out, err = plan_file(json.dumps(request))
    assert (code, err) == (0, '')
    summary = json.loads(out)
    assert summary['viewpoint_count'] == 59
    assert summary['files'][-1] == str(tmp_path / 'out' / 'plan.json')
    document = json.loads((tmp_path / 'out' / 'plan.json').read_text())
    assert document['makespan_s'] == summary['makespan_s']
    assert document['vehicles'][0]['home']['altitude_m'] == 12.0


def test_nothing_is_written_unasked(plan_file, tmp_path, monkeypatch):
    """Without an output directory only the summary comes."""
    monkeypatch.chdir(tmp_path)
    code, out, _ = plan_file(json.dumps(REQUEST))
    assert code == 0
    assert json.loads(out)['files'] == []
    assert list(tmp_path.iterdir()) == []


def changed(path, value):
    """Return the request with one value changed, by path."""
    request = json.loads(json.dumps(REQUEST))
    *parents, last = path
    item = request
    for key in parents:
        item = item[key]
    item[last] = value
    return json.dumps(request)


CORNERS = REQUEST['region']['polygon']
BOW_TIE = [CORNERS[0], CORNERS[2], CORNERS[1], CORNERS[3]]


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('', 'request: Invalid JSON'),
        (b'\xff\xfe', 'request: Invalid JSON'),
        ('[]', 'request: '),
        ('{}', 'region: Field required'),
        (changed(['heigth'], 3), 'heigth: Extra inputs are not permitted'),
        (changed(['vehicles', 0, 'speed'], 3), 'vehicles.0.speed: Extra inputs'),
        (
            changed(['vehicles', 0, 'hover_s'], '2'),
            'vehicles.0.hover_s: Input should be a valid n',
        ),
        (changed(['vehicles'], []), 'number of vehicles is 0: must be 1 to 1000'),
        (
            changed(['vehicles', 0, 'home'], [91, 0]),
            'rav1 home: latitude_deg is 91: must be -90 to',
        ),
        (changed(['vehicles', 0, 'endurance_s'], 60), 'rav1 needs '),
        (changed(['height_agl_m'], -1), 'height_agl_m is -1 m: must be above 0'),
        (
            changed(['camera', 'horizontal_fov_deg'], 180),
            'horizontal_fov_rad is 3.14159 (180 deg)',
        ),
        (
            changed(['region', 'polygon', 2], [53.28]),
            'region.polygon.2: List should have at least 2',
        ),
        (changed(['region', 'polygon', 2, 0], 953.0), 'region.polygon.2: latitude_deg is 953'),
        (changed(['region', 'polygon'], BOW_TIE), 'region: the boundary crosses or touches'),
        (changed(['max_viewpoints'], 9), 'the region needs at least 45 viewpoints'),
        (changed(['output_directory'], '/dev/null/x'), 'cannot write the plan to /dev/null/x'),
    ],
)
def test_a_wrong_request_gives_one_line(plan_file, text, message):
    """Exit code 2 and one line that names the thing, its value and its limit."""
    code, out, err = plan_file(text)
    assert (code, out) == (2, '')
    assert err.startswith(f'error: {message}')
    assert err.count('\n') == 1
