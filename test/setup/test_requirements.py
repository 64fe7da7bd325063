# SPDX-License-Identifier: Apache-2.0
"""The pinned packages belong together."""

from pathlib import Path

from workspace.packages import SYSTEM_MINIMA, pinned

FOLDER = Path(__file__).resolve().parents[2] / 'requirements'


def test_every_requirement_is_pinned_and_locked_alike():
    """The lock made from the other files says the same as they do."""
    locked = pinned(FOLDER / 'constraints.txt')
    for name in ('ros', 'python', 'dev'):
        for package, line in pinned(FOLDER / f'{name}.txt').items():
            assert '==' in line, line
            key = package.replace('_', '-')
            assert locked.get(key, '').split('==')[-1] == line.split('==')[1], line


def test_every_library_can_come_from_the_system():
    """What the wheels bring, a system's ROS may have or must be given."""
    ours = {name.lower() for name, _ in SYSTEM_MINIMA.values()}
    assert ours == set(pinned(FOLDER / 'python.txt'))
