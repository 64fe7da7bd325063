# SPDX-License-Identifier: Apache-2.0
"""config/rocsafe.yaml says the truth."""

import importlib.util
import itertools
import re
from pathlib import Path

import yaml

from rocsafe_orchestrator.parameters.config_file import NODES, require_parameter_file

REPOSITORY = Path(__file__).parents[2]
_SPEC = importlib.util.spec_from_file_location(
    'default_parameters', REPOSITORY / 'tools' / 'default_parameters.py'
)
assert _SPEC is not None
assert _SPEC.loader is not None
default_parameters = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(default_parameters)


def test_file_holds_the_defaults_of_the_options() -> None:
    """After a change of a default: python tools/default_parameters.py."""
    path = REPOSITORY / 'config' / 'rocsafe.yaml'
    assert path.read_text(encoding='utf-8') == default_parameters.config_text()


def test_every_parameter_has_a_comment() -> None:
    """No option goes without saying what it means."""
    lines = default_parameters.config_text().splitlines()
    for above, line in itertools.pairwise(lines):
        if line.startswith('    ') and not line.startswith('    #'):
            assert above.strip().startswith('# '), line
            assert len(above.strip()) > len('# '), line


def test_file_is_a_ros_parameter_file() -> None:
    """Each node, in whatever namespace, has a block."""
    content = yaml.safe_load(default_parameters.config_text())
    assert set(content) == {f'/**/{name}' for name, _, _ in default_parameters.NODES}
    require_parameter_file(REPOSITORY / 'config' / 'rocsafe.yaml')
    assert content['/**/rav']['ros__parameters']['cruise_speed_mps'] == 5.0


def test_options_of_every_node_are_in_the_file() -> None:
    """A node that is new must not be forgotten."""
    declared = {
        name
        for path in (REPOSITORY / 'src').rglob('*_node.py')
        for name in re.findall(r'declare_options\(\w+, (\w+)\)', path.read_text())
    }
    assert [name for name, _, _ in default_parameters.NODES] == list(NODES)
    assert declared == {options.partition(':')[2] for _, _, options in default_parameters.NODES}
