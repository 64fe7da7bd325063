# SPDX-License-Identifier: Apache-2.0
"""Requirements of a wheel, from the dependencies in its package.xml and the pins of the lock."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from pathlib import Path

# rosdep keys of Python libraries whose package on the index has another name.
_INDEX_NAMES = {
    'mcap-ros2-support': 'mcap-ros2-support',
    'python3-opencv': 'opencv-python-headless',
    'python3-pil': 'pillow',
    'python3-pymavlink-pip': 'pymavlink',
    'python3-yaml': 'pyyaml',
}
# Not among the wheels of ROS: launch files are for machines with a ROS of their own.
_WITHOUT_WHEEL = frozenset({'launch'})
# rclpy loads the middleware while it runs; the wheel does not name one.
_MIDDLEWARE = 'ros-rmw-fastrtps-cpp'


class UnknownRequirementError(ValueError):
    """A package depends on something that the lock does not pin."""


def read_lock(path: Path) -> dict[str, str]:
    """Return the lines of a lock file by the name of their package."""
    lines = [line for line in path.read_text().splitlines() if '==' in line]
    return {line.partition('==')[0]: line for line in lines}


def requirements(manifest: Path, own: Mapping[str, str], lock: Mapping[str, str]) -> list[str]:
    """Return what a package needs while it runs, each with its version.

    Parameters
    ----------
    manifest
        Its package.xml.
    own
        Versions of the packages of this workspace by name.
    lock
        From `read_lock`.

    Raises
    ------
    UnknownRequirementError
        If a dependency is neither of this workspace nor in the lock.
    """
    root = ElementTree.parse(manifest).getroot()  # noqa: S314 - our own file
    keys = {
        str(element.text).strip()
        for kind in ('depend', 'exec_depend')
        for element in root.findall(kind)
    }
    needed = {f'{key}=={own[key]}' for key in keys & own.keys()}
    needed |= {
        _pinned(_index_name(key), manifest, lock) for key in keys - own.keys() - _WITHOUT_WHEEL
    }
    if 'rclpy' in keys:
        needed.add(_pinned(_MIDDLEWARE, manifest, lock))
    return sorted(needed)


def _index_name(key: str) -> str:
    if key in _INDEX_NAMES:
        return _INDEX_NAMES[key]
    if key.startswith('python3-'):
        return key.removeprefix('python3-')
    return f'ros-{key.replace("_", "-")}'


def _pinned(name: str, manifest: Path, lock: Mapping[str, str]) -> str:
    if name not in lock:
        raise UnknownRequirementError(
            f'{manifest}: {name} is not in requirements/lock.txt: run python3 tools/lock.py'
        )
    return lock[name].split(' ')[0]
