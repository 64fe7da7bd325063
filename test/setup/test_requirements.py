# SPDX-License-Identifier: Apache-2.0
"""The pinned packages belong together."""

import ast
import re
import sys
from pathlib import Path

import pytest

from workspace.packages import SYSTEM_MINIMA, pinned

FOLDER = Path(__file__).resolve().parents[2] / 'requirements'
PYTHON = r"python_version == '3\.\d+'"
LOCKED = rf'[a-z0-9.-]+==[\w.]+( ; {PYTHON}( or {PYTHON})*)?( --hash=sha256:[0-9a-f]{{64}})+'


def test_every_requirement_is_pinned_and_locked_alike():
    """The lock made from the other files says the same as they do."""
    locked = pinned(FOLDER / 'lock.txt')
    for name in ('ros', 'python', 'dev'):
        locked |= pinned(FOLDER / 'lock-dev.txt') if name == 'dev' else {}
        for package, line in pinned(FOLDER / f'{name}.txt').items():
            assert '==' in line, line
            key = package.replace('_', '-')
            assert f'{locked.get(key, "")} '.startswith(f'{key}=={line.split("==")[1]} '), line


def test_every_locked_package_has_the_hashes_of_its_files():
    """Without one pip would refuse the whole lock; each package is named once."""
    names = []
    for lock in ('lock', 'lock-dev'):
        for line in (FOLDER / f'{lock}.txt').read_text().splitlines()[1:]:
            assert re.fullmatch(LOCKED, line), line
            names.append(line.split('==')[0])
    assert len(names) == len(set(names)) > 100


@pytest.mark.slow
def test_every_imported_library_is_there_for_a_mission():
    """What the packages import is pinned for the nodes, not only for the tests."""
    imported = {
        name.split('.')[0]
        for path in (FOLDER.parent / 'src').glob('*/rocsafe_*/**/*.py')
        for node in ast.walk(ast.parse(path.read_text()))
        for name in imported_names(node)
    }
    foreign = {name for name in imported - sys.stdlib_module_names if not is_ros(name)}
    # numpy comes with ROS, pydantic_core with pydantic, markupsafe with jinja2.
    brought = {'numpy', 'pydantic_core', 'markupsafe'}
    # No mission starts the environments for learning, or a campaign.
    extras = {'distributed', 'gymnasium', 'pettingzoo', 'pyarrow'}
    assert foreign - brought - extras <= set(SYSTEM_MINIMA)


def imported_names(node: ast.AST) -> list[str]:
    """Return the modules that a statement imports."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    return [str(node.module)] if isinstance(node, ast.ImportFrom) else []


def is_ros(name: str) -> bool:
    """Tell whether a module comes with ROS or is ours."""
    known = (
        'rclpy',
        'rocsafe_',
        'ament_index_python',
        'rosidl_',
        'rpyutils',
        'domain_coordinator',
    )
    return name.startswith(known) or name.endswith(('_msgs', '_interfaces', '_srvs'))


def test_every_library_can_come_from_the_system():
    """What the wheels bring, a system's ROS may have or must be given."""
    ours = {name.lower() for name, _ in SYSTEM_MINIMA.values()}
    assert ours == set(pinned(FOLDER / 'python.txt'))
