# SPDX-License-Identifier: Apache-2.0
"""Every script in examples/ runs and finds what is there to be found."""

import os
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from test.system.airsim_server import airsim_server

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / 'examples'
SMALL = ROOT / 'test/system/small.yaml'
LIMIT_S = 240.0
# A Python with the package cosysairsim.
CLIENT = os.environ.get('ROCSAFE_AIRSIM_PYTHON', '')


def example(name):
    """Return the main function of an example."""
    return runpy.run_path(str(EXAMPLES / f'{name}.py'))['main']


def test_every_example_has_a_test():
    """By its name in this file; and a line in docs/examples.md."""
    text = Path(__file__).read_text()
    assert [path.stem for path in EXAMPLES.glob('*.py') if path.stem not in text] == []
    listed = (ROOT / 'docs/examples.md').read_text()
    assert [path.name for path in EXAMPLES.glob('*.*') if path.name not in listed] == []


@pytest.mark.slow
def test_plan_field(tmp_path, capsys):
    """Two drones share a field, and the bound is below the plan."""
    corners = 'latitude,longitude\n53.2800,-9.0600\n53.2805,-9.0600\n53.2805,-9.0590\n'
    (tmp_path / 'field.csv').write_text(corners)
    example('plan_field')(str(tmp_path / 'field.csv'), 2)
    text = capsys.readouterr().out
    assert text.count('photographs') == 2
    assert 'no plan takes less than' in text


@pytest.mark.slow
def test_localise_readings(tmp_path):
    """A source at a known place is found there."""
    east, north = np.meshgrid(np.arange(-50.0, 51.0, 10.0), np.arange(-50.0, 51.0, 10.0))
    places = np.column_stack([east.ravel(), north.ravel(), np.full(east.size, 10.0)])
    squares = ((places - [20.0, -10.0, 0.5]) ** 2).sum(axis=1)
    counts = np.random.default_rng(1).poisson(100.0 * (0.1 + 5000.0 / squares))
    np.savetxt(tmp_path / 'counts.csv', np.column_stack([places, counts]), delimiter=',')
    (source,) = example('localise_readings')(str(tmp_path / 'counts.csv'), 100.0).sources
    assert source.position_enu_m[:2] == pytest.approx([20.0, -10.0], abs=2.0)


@pytest.mark.slow
def test_gymnasium_loop():
    """The same seed gives the same reward."""
    pytest.importorskip('gymnasium')
    main = example('gymnasium_loop')
    assert main(3) == main(3)


@pytest.mark.slow
def test_train_source_search(monkeypatch, capsys):
    """Its help works; the training itself takes minutes and is told in docs/learning.md."""
    monkeypatch.setattr(sys, 'argv', ['train_source_search.py', '--help'])
    with pytest.raises(SystemExit, match='0'):
        example('train_source_search')()
    assert '--rounds' in capsys.readouterr().out


@pytest.mark.all
def test_campaign_heights(tmp_path, capsys):
    """Errors at both heights, of few missions."""
    shipped = ROOT / 'config/campaigns/one_source.yaml'
    text = shipped.read_text().replace('seeds: 50 ', 'seeds: 3 ')
    scenario = shipped.with_name('one_source_scenario.yaml')
    file = tmp_path / 'campaign.yaml'
    file.write_text(text.replace('one_source_scenario.yaml', str(scenario)))
    found = example('campaign_heights')(str(file))
    assert list(found) == [25.0, 35.0]
    assert all(0.0 < error_m < 50.0 for error_m in found.values())
    assert capsys.readouterr().out.count('beside the source') == 2


@pytest.mark.all
@pytest.mark.system
@pytest.mark.skipif(not CLIENT, reason='ROCSAFE_AIRSIM_PYTHON names no Python with cosysairsim')
def test_airsim_photographs(tmp_path, ros_domain_id):
    """Four photographs and four readings; the vehicle is home again."""
    script = EXAMPLES / 'airsim_photographs.py'
    with airsim_server(SMALL, tmp_path / 'out', ros_domain_id, 5.0) as port:
        folder = tmp_path / 'pictures'
        done = subprocess.run(
            [CLIENT, str(script), '--port', str(port), '--folder', str(folder), '--side', '8'],
            capture_output=True, text=True, timeout=LIMIT_S, check=False,
        )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count('uSv/h') == 4
    assert [path.read_bytes()[:4] for path in folder.iterdir()] == [b'\x89PNG'] * 4


@pytest.mark.all
@pytest.mark.system
def test_read_run_and_map_folder(tmp_path, own_domain):
    """A flown run is read without ROS, and its photographs are mapped again."""
    scenario = ROOT / 'test/system/small.yaml'
    command = ['rocsafe', 'run', str(scenario), '--out', str(tmp_path), '--quiet']
    subprocess.run(command, timeout=LIMIT_S, check=True, env=dict(os.environ))
    (run,) = tmp_path.iterdir()
    assert example('read_run')(str(run)) > 0
    width, height = example('map_folder')(str(run / 'images'))
    assert min(width, height) > 100


@pytest.mark.process
def test_fly_vehicle(own_domain, tmp_path):
    """A simulated vehicle, alone in its domain, flies the route and photographs three places."""
    pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')
    nodes = {
        'world': ['-p', 'participants:=[rav1]', '-p', 'speed:=0.0'],
        'rav': ['-r', '__ns:=/rav1', '-p', f'spool_directory:={tmp_path}', '-p', 'scene:=field'],
    }
    running = [
        subprocess.Popen([sys.executable, '-m', f'rocsafe_sim.{name}_node', '--ros-args', *more])
        for name, more in nodes.items()
    ]
    try:
        done = subprocess.run(
            [sys.executable, str(EXAMPLES / 'fly_vehicle.py'), 'rav1'],
            capture_output=True, text=True, timeout=LIMIT_S, check=False,
        )  # fmt: skip
    finally:
        for process in running:
            process.terminate()
            process.wait(LIMIT_S)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith('completed: 3 photographs')
