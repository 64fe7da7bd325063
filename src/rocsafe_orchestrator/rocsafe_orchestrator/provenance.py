# SPDX-License-Identifier: Apache-2.0
"""Origin of a run: command, versions, git revision, machine."""

import getpass
import json
import os
import platform
from datetime import datetime
from importlib import metadata
from pathlib import Path
from typing import Any

from rocsafe_geo.evidence.code_version import git_is_dirty, git_revision
from rocsafe_geo.storage.durable import replace_whole

# Distributions whose version decides what a run computes.
_DISTRIBUTIONS = (
    'rocsafe_orchestrator', 'rocsafe_planner', 'rocsafe_scene', 'rocsafe_sim', 'rocsafe_radiation',
    'rocsafe_dispersion', 'rocsafe_mapping', 'ros-jazzy-rclpy', 'ros-jazzy-rmw-fastrtps-cpp',
    'numpy', 'numba', 'opencv-python-headless', 'rasterio', 'shapely', 'pyproj', 'pydantic',
    'mcap', 'pillow',
)  # fmt: skip
# Set by the console for whoever launches a mission there.
COMMANDER_VARIABLE = 'ROCSAFE_COMMANDER'


def provenance(command: list[str], started: datetime) -> dict[str, Any]:
    """Return what is known before a run begins, fit for JSON."""
    source = Path(__file__).resolve().parent
    return {
        'command': [Path(command[0]).name, *command[1:]],
        'started': started.isoformat(timespec='seconds'),
        'commander': commander(),
        'git_revision': git_revision(source),
        'git_dirty': git_is_dirty(source),
        'versions': {'python': platform.python_version(), **versions()},
        'platform': platform.platform(),
        'ros_distro': os.environ.get('ROS_DISTRO', 'jazzy (wheels)'),
        'ros_domain_id': os.environ.get('ROS_DOMAIN_ID', '0'),
        'cpu_count': os.cpu_count(),
        'outcome': None,
    }


def commander() -> str:
    """Return who starts a run: as the console tells, else the user of the machine, if known."""
    try:
        return os.environ.get(COMMANDER_VARIABLE) or getpass.getuser()
    except (KeyError, OSError):
        return ''


def versions() -> dict[str, str]:
    """Return the versions of the installed distributions that matter."""
    found = {}
    for name in _DISTRIBUTIONS:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write `content` so that a reader sees the old file or the new one, never half of it."""
    replace_whole(path, (json.dumps(content, indent=2) + '\n').encode())
