# SPDX-License-Identifier: Apache-2.0
"""The file of ROS parameters that a user gives with `--config`."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rocsafe_geo.storage.yaml_source import YamlError, read_yaml
from rocsafe_ros.parameters import with_nearest
from rocsafe_scenario.errors import ScenarioError

PARAMETERS = 'ros__parameters'
# Nodes that have parameters; each refuses names that it does not know.
NODES = (
    'orchestrator', 'fleet_verbs', 'recorder', 'planner', 'world', 'rgv', 'rav', 'fleet', 'bridge',
    'radiation_field', 'air', 'estimator', 'advisor', 'detector', 'localizer', 'router', 'agents',
    'mavlink_view', 'viewer', 'airsim', 'collector', 'mosaic',
)  # fmt: skip


def require_parameter_file(path: Path) -> None:
    """Make sure that the file has parameters of nodes that there are; ROS ignores all else.

    Raises
    ------
    ScenarioError
        In one line, with the line of a syntax error, the key in the wrong place, or the node.
    """
    try:
        content = read_yaml(path)
    except YamlError as error:
        raise ScenarioError(str(error)) from error
    if wrong := _misplaced(content):
        raise ScenarioError(
            f'{path}: {wrong}: must be blocks `node: {{{PARAMETERS}: {{name: value}}}}`, '
            'like config/rocsafe.yaml'
        )
    unknown = {name for name in _nodes(content) if name not in NODES and '*' not in name}
    if unknown:
        raise ScenarioError(f'{path}: no node {with_nearest(unknown, NODES)}')


def _misplaced(content: Any, key: str = '') -> str:
    """Return the key of what is not in a block of parameters, empty if there is none."""
    if content is None:
        return ''
    if not isinstance(content, dict):
        return key or f'{str(content)[:40]!r}'
    inner = (
        ('' if isinstance(block, dict) else name)
        if name == PARAMETERS
        else _misplaced(block, str(name))
        for name, block in content.items()
    )
    return next(filter(None, inner), '')


def _nodes(content: Any, key: str = '') -> Iterator[str]:
    """Yield the name of the node of each block, without its namespace."""
    for name, block in (content or {}).items():
        if name == PARAMETERS:
            yield key.rpartition('/')[2]
        else:
            yield from _nodes(block, str(name))
