# SPDX-License-Identifier: Apache-2.0
"""Write config/rocsafe.yaml: every parameter of every node with its default.

The options dataclasses of the packages are the only source; a test keeps the file equal to them.

    python tools/default_parameters.py
"""

import dataclasses
import importlib
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

CONFIG = Path(__file__).parents[1] / 'config' / 'rocsafe.yaml'

# Node name, what it is for, its options.
NODES = (
    ('orchestrator', 'who runs when', 'rocsafe_orchestrator.mission.options:OrchestratorOptions'),
    (
        'fleet_verbs',
        'commands to all vehicles at once',
        'rocsafe_orchestrator.fleet_verbs_node:FleetVerbsOptions',
    ),
    ('recorder', 'messages of a run', 'rocsafe_orchestrator.recorder_node:RecorderOptions'),
    ('planner', 'region to routes', 'rocsafe_planner.options:PlannerOptions'),
    ('world', 'simulated time', 'rocsafe_sim.options:WorldOptions'),
    ('rgv', 'a simulated ground vehicle', 'rocsafe_sim.driving.rgv_options:RgvOptions'),
    ('rav', 'one simulated vehicle', 'rocsafe_sim.options:RavOptions'),
    ('fleet', 'many simulated vehicles, alike', 'rocsafe_sim.options:FleetOptions'),
    ('bridge', 'real vehicles', 'rocsafe_mavlink.bridge_options:BridgeOptions'),
    (
        'radiation_field',
        'simulated gamma field',
        'rocsafe_radiation.field_parameters.field_options:FieldOptions',
    ),
    (
        'air',
        'simulated gas, particles and wind',
        'rocsafe_dispersion.air_field.air_options:AirOptions',
    ),
    (
        'estimator',
        'releases of gas from readings',
        'rocsafe_dispersion.estimator_options:EstimatorOptions',
    ),
    (
        'advisor',
        'which agent, from detectors and reports',
        'rocsafe_dispersion.advisor_options:AdvisorOptions',
    ),
    ('detector', 'a real detector', 'rocsafe_radiation.detector_options:DetectorOptions'),
    ('localizer', 'sources from readings', 'rocsafe_radiation.localizer_options:LocalizerOptions'),
    ('router', 'drives of a ground vehicle', 'rocsafe_ground.options:RouterOptions'),
    ('agents', 'agents of the vehicles', 'rocsafe_fleet.options:AgentOptions'),
    (
        'mavlink_view',
        'simulated vehicles, shown to a ground station',
        'rocsafe_mavlink.view_options:ViewOptions',
    ),
    ('viewer', 'a live view of the scene', 'rocsafe_sim.viewer_options:ViewerOptions'),
    ('airsim', "AirSim's API", 'rocsafe_airsim.options:AirsimOptions'),
    ('collector', 'image store', 'rocsafe_mapping.options:CollectorOptions'),
    ('mosaic', 'map of all photographs', 'rocsafe_mapping.options:MosaicOptions'),
)

HEAD = """\
# Every parameter of every node with its default, a block a node. Written by
# tools/default_parameters.py from the options of the packages: change a default there.
#
# It is a ROS parameter file. A copy with other values is given to all nodes of a run by
#   rocsafe run SCENARIO --config my.yaml       (what the scenario says wins)
# and to a single node by
#   ros2 run rocsafe_sim rav --ros-args -r __ns:=/rav1 --params-file my.yaml
# A node refuses parameters that it does not have; those under /** are for each node.
"""


def config_text() -> str:
    """Return the content of the file."""
    blocks = (_block(node, purpose, options) for node, purpose, options in NODES)
    return HEAD + ''.join(blocks)


def _block(node: str, purpose: str, options: str) -> str:
    module, _, name = options.partition(':')
    fields = dataclasses.fields(getattr(importlib.import_module(module), name))
    lines = [f'\n# {purpose}', f'/**/{node}:', '  ros__parameters:']
    for field in fields:
        lines += _lines(field)
    return '\n'.join(lines) + '\n'


def _lines(field: 'dataclasses.Field[Any]') -> Iterator[str]:
    doc = str(field.metadata.get('doc', ''))
    yield f'    # {doc}{_limits(field)}'
    if field.default == ():
        # An empty list has no type that ROS could read; an example says what it holds.
        yield f'    # {field.name}: []'
    else:
        yield f'    {field.name}: {_value(field.default)}'


def _limits(field: 'dataclasses.Field[Any]') -> str:
    low, high = field.metadata.get('min'), field.metadata.get('max')
    if low is None and high is None:
        return ''
    return f' [{_limit(low)} to {_limit(high)}]'


def _limit(value: float | None) -> str:
    if value is None:
        return ''
    return str(value) if isinstance(value, int) else f'{value:g}'


def _value(default: Any) -> str:
    plain = list(default) if isinstance(default, tuple) else default
    return yaml.safe_dump(plain, default_flow_style=True).removesuffix('...\n').strip()


def main() -> int:
    """Write the file."""
    CONFIG.write_text(config_text(), encoding='utf-8')
    print(f'{CONFIG} written')
    return 0


if __name__ == '__main__':
    sys.exit(main())
