# SPDX-License-Identifier: Apache-2.0
"""Which Python is taken, and what is said when none will do."""

import json
from pathlib import Path

import pytest

from workspace.errors import SetupError
from workspace.layout import Layout
from workspace.machine import check_disk, check_wheels_exist, choose_python

COMPLETE = {'lacks': [], 'headers': True}


@pytest.fixture
def folder_with(tmp_path):
    """Make folders for the PATH with Pythons that describe themselves as told."""

    def make(name: str, **pythons: dict) -> str:
        for command, facts in pythons.items():
            path = tmp_path / name / command.replace('_', '.')
            path.parent.mkdir(exist_ok=True)
            answer = json.dumps({'executable': str(path), **facts})
            path.write_text(
                f"#!/bin/sh\ncat <<'EOF'\n{answer}\nEOF\n" if facts else '#!/bin/false\n'
            )
            path.chmod(0o755)
        return str(tmp_path / name)

    return make


def choose(path: str, wanted: tuple[int, int] | None = None, **variables: str) -> Path:
    """Choose with nothing but `path`, and whatever /usr/bin holds, behind it."""
    return choose_python({'PATH': path, **variables}, wanted, Path('/none')).executable


def test_first_python3_that_fits_is_taken(folder_with):
    """The user's own order on the PATH counts, before version numbers."""
    path = folder_with(
        'bin',
        python3={'version': (3, 10, 2), **COMPLETE},
        python3_12={'version': (3, 12, 1), **COMPLETE},
    )
    assert choose(path).name == 'python3'


def test_python_out_of_range_is_passed_over(folder_with):
    """A newer default does not hide an older Python that fits."""
    path = folder_with(
        'bin',
        python3={'version': (3, 13, 0), **COMPLETE},
        python3_11={'version': (3, 11, 4), **COMPLETE},
    )
    other = folder_with('old', python3={'version': (3, 9, 2), **COMPLETE})
    # A Python in /usr/bin comes after the names of the PATH, but before other names.
    chosen = choose_python({'PATH': f'{other}:{path}'}, (3, 11), Path('/usr'))
    assert str(chosen.executable) == f'{path}/python3.11'


def test_shim_that_does_not_start_is_passed_over(folder_with):
    """Only running a command tells whether it is a Python."""
    shims = folder_with('shims', python3={})
    path = folder_with('bin', python3={'version': (3, 11, 4), **COMPLETE})
    assert choose(f'{shims}:{path}').parent == Path(path)


def test_complete_python_is_preferred(folder_with):
    """One without headers or venv is taken for no build while a complete one is there."""
    bare = folder_with('bare', python3={'version': (3, 11, 4), 'lacks': [], 'headers': False})
    path = folder_with('bin', python3={'version': (3, 11, 5), **COMPLETE})
    assert choose(f'{bare}:{path}').parent == Path(path)


@pytest.mark.parametrize(
    ('facts', 'lacking', 'package'),
    [
        ({'lacks': ['ensurepip'], 'headers': True}, 'module ensurepip', 'python3.12-venv'),
        ({'lacks': ['venv', 'ensurepip'], 'headers': True}, 'module venv', 'python3.12-venv'),
        ({'lacks': [], 'headers': False}, 'Python.h', 'python3.12-dev'),
    ],
)
def test_incomplete_python_is_told(folder_with, facts, lacking, package):
    """The line names the Python, what it lacks and the Debian package."""
    path = folder_with('bin', python3={'version': (3, 12, 3), **facts})
    with pytest.raises(SetupError) as refused:
        choose_python({'PATH': path, 'PYTHON': f'{path}/python3'}, None, Path('/none'))
    line = str(refused.value)
    assert line.startswith(f'{path}/python3 (Python 3.12.3) lacks {lacking}')
    assert line.endswith(f'sudo apt install {package}')


def test_python_of_the_sourced_ros_is_wanted(folder_with):
    """Only the version that rclpy was built for will do."""
    path = folder_with(
        'bin',
        python3={'version': (3, 11, 2), **COMPLETE},
        python3_12={'version': (3, 12, 3), **COMPLETE},
    )
    assert choose(path, wanted=(3, 12)).name == 'python3.12'
    with pytest.raises(
        SetupError, match=r'no Python 3\.10, for which the sourced rclpy was built'
    ):
        choose_python({'PATH': path}, (3, 10), Path('/usr'))


def test_environments_are_no_base(folder_with):
    """Neither an activated environment nor the one about to be made is built upon."""
    active = folder_with('active', python3={'version': (3, 11, 4), **COMPLETE})
    ours = folder_with('ours', python3={'version': (3, 11, 4), **COMPLETE})
    path = folder_with('bin', python3={'version': (3, 11, 4), **COMPLETE})
    chosen = choose_python(
        {'PATH': f'{active}:{ours}:{path}', 'VIRTUAL_ENV': active}, None, Path(ours)
    )
    assert chosen.executable.parent == Path(path)


def test_full_disk_is_told(monkeypatch, tmp_path):
    """What is free and what is needed."""
    monkeypatch.setattr('shutil.disk_usage', lambda _: type('Usage', (), {'free': 2e8}))
    with pytest.raises(SetupError, match=r'0\.2 GB is free in .*, a set-up needs 1\.5 GB'):
        check_disk(tmp_path)


def test_machine_without_wheels_is_told(monkeypatch):
    """Only Linux on x86_64 has wheels; all others can use a distribution's ROS."""
    monkeypatch.setattr('platform.machine', lambda: 'aarch64')
    with pytest.raises(SetupError, match=r'no wheels for Linux on aarch64.*setup\.bash'):
        check_wheels_exist()


@pytest.mark.parametrize('name', ['with blank', 'a:b', 'a$b', "a'b", 'a;b', 'a(b)'])
def test_names_that_break_build_tools_are_refused(name):
    """The character is shown."""
    with pytest.raises(SetupError, match='in its path'):
        Layout(Path('/srv') / name)


@pytest.mark.parametrize('name', ['rocsafe', 'rocsafe-2.1_b', 'Größe', 'a+b', 'a@b'])
def test_other_names_are_taken(name):
    """Everything else works, also letters beyond English."""
    assert Layout(Path('/srv') / name).venv == Path('/srv') / name / '.venv'
