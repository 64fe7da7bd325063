# SPDX-License-Identifier: Apache-2.0
"""`ros2 param`."""

import sys
from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from rcl_interfaces.msg import Parameter, ParameterType
from rclpy.parameter import get_parameter_value, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient

from rocsafe_ros.domain.discovery import await_discovery, wait_for
from rocsafe_ros2cli.command import CommandError, Verb, argument
from rocsafe_ros2cli.command_node import CommandNode, command_node
from rocsafe_ros2cli.names import node_names

NODE_LIMIT_S = 1.0
"""Longest wait for a node to appear after discovery."""

SERVICES_LIMIT_S = 5.0
"""Longest wait for the parameter services of a node that was found."""

ANSWER_LIMIT_S = 10.0
"""Longest wait for an answer of a node."""

LABELS = {
    ParameterType.PARAMETER_NOT_SET: 'Parameter not set.',
    ParameterType.PARAMETER_BOOL: 'Boolean value is:',
    ParameterType.PARAMETER_INTEGER: 'Integer value is:',
    ParameterType.PARAMETER_DOUBLE: 'Double value is:',
    ParameterType.PARAMETER_STRING: 'String value is:',
    ParameterType.PARAMETER_BYTE_ARRAY: 'Byte values are:',
    ParameterType.PARAMETER_BOOL_ARRAY: 'Boolean values are:',
    ParameterType.PARAMETER_INTEGER_ARRAY: 'Integer values are:',
    ParameterType.PARAMETER_DOUBLE_ARRAY: 'Double values are:',
    ParameterType.PARAMETER_STRING_ARRAY: 'String values are:',
}


@contextmanager
def _client(node_name: str) -> Iterator[tuple[CommandNode, Any]]:
    """Yield a node and its client of the parameter services of the named node."""
    name = node_name if node_name.startswith('/') else f'/{node_name}'
    with command_node() as holder:
        await_discovery(holder.node)
        if not wait_for(lambda: name in node_names(holder.node), NODE_LIMIT_S):
            raise CommandError('Node not found')
        client = AsyncParameterClient(holder.node, name)
        if not wait_for(client.services_are_ready, SERVICES_LIMIT_S):
            raise CommandError(
                f'Wait for service timed out waiting for parameter services for node {name}'
            )
        yield holder, client


def _answer(holder: CommandNode, future: Any, node_name: str) -> Any:
    """Return the answer of the node."""
    return holder.answer(future, f'calling service of node {node_name}', ANSWER_LIMIT_S)


def _list(options: Namespace) -> None:
    """List the parameters of a node."""
    with _client(options.node_name) as (holder, client):
        listed = _answer(holder, client.list_parameters(), options.node_name)
    for name in sorted(listed.result.names):
        print(f'  {name}')


def _get(options: Namespace) -> None:
    """Print the value of a parameter."""
    with _client(options.node_name) as (holder, client):
        future = client.get_parameters([options.parameter_name])
        values = _answer(holder, future, options.node_name).values
    if not values:
        raise CommandError('Parameter not set')
    value = parameter_value_to_python(values[0])
    print(LABELS[values[0].type], *([] if value is None else [value]))


def _set(options: Namespace) -> None:
    """Set a parameter; a refusal of the node goes to standard error."""
    parameter = Parameter(name=options.parameter_name)
    parameter.value = get_parameter_value(string_value=options.value)
    with _client(options.node_name) as (holder, client):
        future = client.set_parameters([parameter])
        result = _answer(holder, future, options.node_name).results[0]
    reason = f': {result.reason}' if result.reason else ''
    if result.successful:
        print(f'Set parameter successful{reason}')
    else:
        print(f'Setting parameter failed{reason}', file=sys.stderr)


NODE_NAME = argument('node_name', help='Name of the node')
PARAMETER_NAME = argument('parameter_name', help='Name of the parameter')

VERBS = (
    Verb(name='get', summary='Get parameter', arguments=(NODE_NAME, PARAMETER_NAME), run=_get),
    Verb(
        name='list',
        summary='Output a list of available parameters',
        arguments=(NODE_NAME,),
        run=_list,
    ),
    Verb(
        name='set',
        summary='Set parameter',
        arguments=(NODE_NAME, PARAMETER_NAME, argument('value', help='Value of the parameter')),
        run=_set,
    ),
)
