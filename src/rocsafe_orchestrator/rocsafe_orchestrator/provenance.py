# SPDX-License-Identifier: Apache-2.0
"""Where a run comes from: command, versions, revision of the source; and how it ended."""

import json
import os
import platform
import subprocess
from datetime import datetime
from importlib import metadata
from pathlib import Path
from typing import Any

# Distributions whose version decides what a run computes.
_DISTRIBUTIONS = (
    'rocsafe_orchestrator', 'rocsafe_planner', 'rocsafe_sim', 'rocsafe_radiation',
    'rocsafe_mapping', 'ros-jazzy-rclpy', 'ros-jazzy-rmw-fastrtps-cpp', 'numpy', 'numba',
    'opencv-python-headless', 'rasterio', 'shapely', 'pyproj', 'pydantic', 'mcap', 'pillow',
)  # fmt: skip
_GIT_TIMEOUT_S = 5.0


def provenance(command: list[str], started: datetime) -> dict[str, Any]:
    """Return what is known before a run begins, fit for JSON."""
    return {
        'command': command,
        'started': started.isoformat(timespec='seconds'),
        'git': git_state(Path(__file__).resolve().parent),
        'versions': versions(),
        'python': platform.python_version(),
        'platform': platform.platform(),
        'ros_distro': os.environ.get('ROS_DISTRO', 'jazzy (wheels)'),
        'ros_domain_id': os.environ.get('ROS_DOMAIN_ID', '0'),
        'cpu_count': os.cpu_count(),
        'outcome': None,
    }


def versions() -> dict[str, str]:
    """Return the versions of the installed distributions that matter."""
    found = {}
    for name in _DISTRIBUTIONS:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


def git_state(folder: Path) -> dict[str, Any] | None:
    """Return revision and ``dirty`` (changes not committed); None outside a checkout."""
    revision = _git(folder, 'rev-parse', 'HEAD')
    if revision is None:
        return None
    changes = _git(folder, 'status', '--porcelain', '--untracked-files=no')
    return {'revision': revision, 'dirty': None if changes is None else bool(changes)}


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write `content` so that a reader sees the old file or the new one, never half of it."""
    scratch = path.with_suffix('.tmp')
    scratch.write_text(json.dumps(content, indent=2) + '\n', encoding='utf-8')
    scratch.replace(path)


def _git(folder: Path, *arguments: str) -> str | None:
    command = ['git', '-C', str(folder), *arguments]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=_GIT_TIMEOUT_S, check=True
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()
