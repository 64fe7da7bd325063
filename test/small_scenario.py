# SPDX-License-Identifier: Apache-2.0
"""A small valid scenario for tests to fly, or to break."""

import copy
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest
import yaml

SMALL: dict[str, Any] = {
    'name': 'small',
    'region': {'polygon': [[53.28, -9.06], [53.281, -9.06], [53.281, -9.062], [53.28, -9.062]]},
    'survey': {'height_agl_m': 32.0},
    'vehicles': [
        {'name': 'rav1', 'home': [53.2795, -9.061]},
        {'name': 'rav2', 'home': [53.2795, -9.062]},
    ],
    'radiation': {
        'sources': [{'name': 'wreck', 'position': [53.2805, -9.061], 'sigma_usvps': 25.0}]
    },
}


@pytest.fixture
def small(tmp_path: Path) -> Callable[..., Path]:
    """Give a function that writes the small scenario, changed: ``{'vehicles[1].name': 'x'}``."""

    def write(changes: Mapping[str, object] = MappingProxyType({})) -> Path:
        content = copy.deepcopy(SMALL)
        for path, value in changes.items():
            *parents, last = keys_of(path)
            place: Any = content
            for key in parents:
                place = place.setdefault(key, {}) if isinstance(place, dict) else place[key]
            place[last] = value
        return written(tmp_path, yaml.safe_dump(content, allow_unicode=True))

    return write


@pytest.fixture
def scenario_text(tmp_path: Path) -> Callable[[str], Path]:
    """Give a function that writes a text as a scenario file."""
    return lambda text: written(tmp_path, text)


def keys_of(path: str) -> list[str | int]:
    """Return ``['vehicles', 1, 'name']`` for ``vehicles[1].name``."""
    keys = re.findall(r'[^.\[\]]+', path)
    return [int(key) if key.isdigit() else key for key in keys]


def written(folder: Path, text: str) -> Path:
    """Write `text` to the scenario file of `folder`."""
    path = folder / 'small.yaml'
    path.write_text(text, encoding='utf-8')
    return path
