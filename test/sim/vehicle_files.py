# SPDX-License-Identifier: Apache-2.0
"""Files of nested settings of simulated vehicles, for tests."""

from pathlib import Path
from typing import Any

import yaml


def cameras_file(folder: Path, *cameras: dict[str, Any]) -> str:
    """Write the file of the parameter `cameras_file` and return its path."""
    return _written(folder / 'cameras.yaml', {'cameras': list(cameras)})


def fleet_file(folder: Path, homes: dict[str, tuple[float, float]]) -> str:
    """Write the file of the parameter `fleet_file` and return its path."""
    vehicles = [{'name': name, 'home': list(home)} for name, home in homes.items()]
    return _written(folder / 'fleet.yaml', {'vehicles': vehicles})


def autopilot_file(folder: Path, **settings: float) -> str:
    """Write the file of the parameter `autopilot_file` and return its path."""
    return _written(folder / 'autopilot.yaml', settings)


def _written(path: Path, content: dict[str, Any]) -> str:
    path.write_text(yaml.safe_dump(content), encoding='utf-8')
    return str(path)
