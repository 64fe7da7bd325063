# SPDX-License-Identifier: Apache-2.0
"""Options dataclasses become ROS parameters, and wrong values become one clear line."""

from dataclasses import dataclass, field
from typing import ClassVar

import pytest
from rclpy.node import Node
from rclpy.parameter import Parameter

from rocsafe_ros.parameters import ParameterError, declare_options


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """Options of no particular node."""

    MOVED_PARAMETERS: ClassVar = {'pace_mps': 'speed_mps'}

    speed_mps: float = field(default=8.0, metadata={'doc': 'speed', 'min': 0.1, 'max': 30.0})
    names: tuple[str, ...] = field(default=(), metadata={'doc': 'names'})
    heights_m: tuple[float, ...] = field(default=(1.5,), metadata={'doc': 'heights'})
    count: int = field(default=3, metadata={'doc': 'count', 'min': 1})
    is_quick: bool = True

    def __post_init__(self) -> None:
        if self.count == 13:
            raise ValueError('count = 13 must not be 13')


@pytest.fixture
def declared(ros):
    """Declare `Options` on a node that was given the keyword arguments as overrides."""
    nodes = []

    def declare(**overrides):
        given = [Parameter(name, value=value) for name, value in overrides.items()]
        node = Node('subject', context=ros.context, parameter_overrides=given)
        nodes.append(node)
        return declare_options(node, Options), node

    yield declare
    for node in nodes:
        node.destroy_node()


def test_defaults_come_from_the_dataclass(declared):
    """Without overrides the options are the dataclass's defaults."""
    options, _ = declared()
    assert options == Options()


def test_overrides_are_read_and_integers_serve_as_floats(declared):
    """A parameter file may say 5 where 5.0 is meant; lists become tuples."""
    options, node = declared(speed_mps=5, names=['a', 'b'], heights_m=[1, 2])
    assert options == Options(speed_mps=5.0, names=('a', 'b'), heights_m=(1.0, 2.0))
    assert node.get_parameter('speed_mps').value == 5.0


def test_descriptor_tells_meaning_and_range(declared):
    """`ros2 param describe` shows the text and the range of the field's metadata."""
    _, node = declared()
    descriptor = node.describe_parameter('speed_mps')
    limits = descriptor.floating_point_range[0]
    assert (descriptor.description, limits.from_value, limits.to_value) == ('speed', 0.1, 30.0)
    assert descriptor.read_only


@pytest.mark.parametrize(
    ('overrides', 'text'),
    [
        ({'speed_mps': -1.0}, 'speed_mps = -1.0 must be within 0.1 to 30.0'),
        ({'speed_mps': float('nan')}, 'speed_mps = nan must be within'),
        ({'speed_mps': 'fast'}, "speed_mps = 'fast' must be of type float"),
        ({'is_quick': 1}, 'is_quick = 1 must be of type bool'),
        ({'count': 0}, 'count = 0 must be within 1 to inf'),
        ({'count': 13}, 'count = 13 must not be 13'),
        ({'names': 'a'}, "names = 'a' must be of type tuple"),
        ({'heights_m': ['a']}, "heights_m = 'a' must be of type float"),
    ],
)
def test_wrong_value_is_refused_in_one_line(declared, overrides, text):
    """The error names the parameter, its value and the limit."""
    with pytest.raises(ParameterError) as caught:
        declared(**overrides)
    assert text in str(caught.value)
    assert '\n' not in str(caught.value)


def test_parameter_of_an_earlier_version_names_the_new_one(declared):
    """Nobody believes that an option counts which is no more."""
    with pytest.raises(ParameterError, match='subject: parameter pace_mps is now speed_mps'):
        declared(pace_mps=3.0)


@pytest.mark.parametrize(
    ('overrides', 'text'),
    [
        ({'sped_mps': 3.0}, 'subject: no parameter sped_mps (did you mean speed_mps?)'),
        ({'speed_mps': 3.0, 'Names': ['a']}, 'no parameter Names (did you mean names?)'),
        ({'MOVED_PARAMETERS': 1}, 'no parameter MOVED_PARAMETERS (did you mean '),
        (
            {'heights': [1.0], 'is_quik': True},
            'no parameter heights (did you mean heights_m?), is_quik (did you mean is_quick?)',
        ),
    ],
)
def test_misspelt_parameter_is_refused_with_the_nearest_name(declared, overrides, text):
    """ROS ignores it, and the node would run with its default."""
    with pytest.raises(ParameterError) as caught:
        declared(**overrides)
    assert text in str(caught.value)
    assert '\n' not in str(caught.value)


def test_parameters_of_ros_are_known(declared):
    """Every node has them."""
    declared(use_sim_time=True, start_type_description_service=False)
