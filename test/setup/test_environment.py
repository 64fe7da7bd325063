# SPDX-License-Identifier: Apache-2.0
"""What tools and shells get to see."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from workspace.environment import shell_script, tool_environment
from workspace.layout import Layout
from workspace.ros import SystemRos

ROOT = Path(__file__).resolve().parents[2]
SHELLS = [name for name in ('dash', 'bash', 'zsh') if shutil.which(name)]


@pytest.fixture
def layout(tmp_path):
    """Give a checkout with nothing in it."""
    return Layout(tmp_path)


def test_leftovers_of_an_activated_workspace_do_not_reach_the_tools(layout):
    """A set-up started in a shell that sourced env.sh works as in a new one."""
    user = {
        'PATH': f'{layout.venv}/bin:/other/bin:/usr/bin',
        'VIRTUAL_ENV': '/other',
        'AMENT_PREFIX_PATH': f'{layout.install}/rocsafe_geo:/elsewhere',
        'PYTHONPATH': '/elsewhere',
        '_ROS_WHEELS_BOOTSTRAP_COMPLETE': '1',
        'MAKEFLAGS': '-j --jobserver-auth=3,4',
        'PIP_TARGET': '/elsewhere',
        'PIP_INDEX_URL': 'https://mirror.example/simple',
    }
    tools = tool_environment(layout, None, user)
    assert tools['PATH'] == f'{layout.venv}/bin:/usr/bin'
    assert tools['AMENT_PREFIX_PATH'] == str(layout.venv)
    assert tools['PIP_INDEX_URL'] == 'https://mirror.example/simple'
    dropped = {'PYTHONPATH', '_ROS_WHEELS_BOOTSTRAP_COMPLETE', 'MAKEFLAGS', 'PIP_TARGET'}
    assert not dropped & set(tools)


def test_sourced_ros_reaches_the_tools(layout):
    """On a system's ROS its paths stay, without those of this checkout."""
    ros = SystemRos(
        rclpy=Path('/opt/r'), python_version=(3, 12), prefixes=(Path('/opt/ros/jazzy'),)
    )
    user = {
        'PATH': '/opt/ros/jazzy/bin:/usr/bin',
        'AMENT_PREFIX_PATH': f'{layout.install}/rocsafe_geo:/opt/ros/jazzy',
        'PYTHONPATH': '/opt/ros/jazzy/lib/python3.12/site-packages',
    }
    tools = tool_environment(layout, ros, user)
    assert tools['AMENT_PREFIX_PATH'] == '/opt/ros/jazzy'
    assert tools['PYTHONPATH'] == '/opt/ros/jazzy/lib/python3.12/site-packages'


@pytest.mark.parametrize('shell', SHELLS)
def test_script_extends_the_environment_once(layout, shell):
    """Entries go in front, none is empty; a second time changes nothing."""
    captured = {
        'AMENT_PREFIX_PATH': '/w/install/a:/w/install/b',
        'LD_LIBRARY_PATH': '/w/install/a/lib:',
        'PATH': '/w/install/bin:/usr/bin:/bin',
        'ROS_DISTRO': "ja'zzy",
    }
    script = layout.root / 'workspace.sh'
    script.write_text(shell_script(layout, captured, 'token'))
    show = 'printf "%s|" "$PATH" "$AMENT_PREFIX_PATH" "$LD_LIBRARY_PATH" "$ROS_DISTRO"'
    answer = subprocess.run(
        [shell, '-c', f'. {script}; . {script}; {show}'],
        env={'PATH': '/home/bin:/usr/bin', 'AMENT_PREFIX_PATH': '/opt/x'},
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    path, prefixes, libraries, distro, _ = answer.stdout.split('|')
    assert path == f'/w/install/bin:{layout.venv}/bin:/home/bin:/usr/bin'
    assert prefixes == '/w/install/a:/w/install/b:/opt/x'
    assert libraries == '/w/install/a/lib'
    assert distro == "ja'zzy"


@pytest.mark.parametrize('shell', [name for name in SHELLS if name != 'dash'])
def test_env_sh_finds_its_folder_from_anywhere(tmp_path, shell):
    """From another folder, too; it says what to do where nothing is built.

    Linear algebra has one thread: several take five times as long beside other work.
    """
    shutil.copy(ROOT / 'env.sh', tmp_path)
    command = [
        shell,
        '-c',
        f'cd /; . {tmp_path}/env.sh && echo "$ROCSAFE_WORKSPACE $OPENBLAS_NUM_THREADS"',
    ]
    options = {'env': {'PATH': '/usr/bin:/bin'}, 'capture_output': True, 'text': True}
    before = subprocess.run(command, check=False, timeout=60, **options)
    assert before.returncode == 1
    assert before.stderr == (f'env.sh: nothing is built in {tmp_path} yet: run make setup there\n')
    (tmp_path / '.venv').mkdir()
    (tmp_path / '.venv/workspace.sh').write_text('ROCSAFE_WORKSPACE=here\n')
    after = subprocess.run(command, check=False, timeout=60, **options)
    assert (after.returncode, after.stdout, after.stderr) == (0, 'here 1\n', '')


@pytest.mark.skipif(shutil.which('readelf') is None, reason='no readelf here')
def test_libraries_name_no_folder_to_load_others_from():
    """Whoever may write to such a folder would have his code loaded."""
    libraries = [str(path) for path in Layout(ROOT).install.rglob('*.so')]
    if not libraries or '/opt/ros' in os.environ.get('AMENT_PREFIX_PATH', ''):
        pytest.skip('nothing is built here, or by another rule')
    told = subprocess.run(
        ['readelf', '--dynamic', *libraries], capture_output=True, text=True, check=True
    ).stdout
    assert 'Dynamic section' in told
    assert re.findall(r'\((?:RPATH|RUNPATH)\).*', told) == []
