# SPDX-License-Identifier: Apache-2.0
"""Origin of a run: command, versions, git revision, machine."""

import getpass
import json
import os
import platform
import subprocess
from datetime import datetime
from importlib import metadata
from pathlib import Path
from typing import Any

from rocsafe_geo.storage.durable import replace_whole

# Distributions whose version decides what a run computes.
_DISTRIBUTIONS = (
    'rocsafe_orchestrator', 'rocsafe_planner', 'rocsafe_scene', 'rocsafe_sim', 'rocsafe_radiation',
    'rocsafe_dispersion', 'rocsafe_mapping', 'ros-jazzy-rclpy', 'ros-jazzy-rmw-fastrtps-cpp',
    'numpy', 'numba', 'opencv-python-headless', 'rasterio', 'shapely', 'pyproj', 'pydantic',
    'mcap', 'pillow',
)  # fmt: skip
_GIT_TIMEOUT_S = 5.0
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


def version_text() -> str:
    """Return the version of ROCSAFE, with the git revision of its source where there is one."""
    source = Path(__file__).resolve().parent
    version = metadata.version('rocsafe_orchestrator')
    revision = git_revision(source)
    if revision is None:
        return f'rocsafe {version}'
    changed = ', with changes that are not committed' if git_is_dirty(source) else ''
    return f'rocsafe {version} (git {revision[:12]}{changed})'


def versions() -> dict[str, str]:
    """Return the versions of the installed distributions that matter."""
    found = {}
    for name in _DISTRIBUTIONS:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


def git_revision(folder: Path) -> str | None:
    """Return the revision that `folder` is checked out at; None outside a checkout."""
    return _git(folder, 'rev-parse', 'HEAD')


def git_is_dirty(folder: Path) -> bool | None:
    """Return whether there are changes that are not committed; None outside a checkout."""
    changes = _git(folder, 'status', '--porcelain', '--untracked-files=no')
    return None if changes is None else bool(changes)


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write `content` so that a reader sees the old file or the new one, never half of it."""
    replace_whole(path, (json.dumps(content, indent=2) + '\n').encode())


def _git(folder: Path, *arguments: str) -> str | None:
    command = ['git', '-C', str(folder), *arguments]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=_GIT_TIMEOUT_S, check=True
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()
