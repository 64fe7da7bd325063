# SPDX-License-Identifier: Apache-2.0
"""The file of ROS parameters that a user gives with `--config`."""

from pathlib import Path
from typing import Any

from rocsafe_geo.storage.yaml_source import YamlError, read_yaml
from rocsafe_scenario.errors import ScenarioError

PARAMETERS = 'ros__parameters'


def require_parameter_file(path: Path) -> None:
    """Make sure that the file has the form of ROS parameters; ROS ignores what has not.

    Raises
    ------
    ScenarioError
        In one line, with the line of a syntax error or the key in the wrong place.
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
