# SPDX-License-Identifier: Apache-2.0
"""`ros2 param`."""

import sys
import time
from argparse import ArgumentParser, Namespace
from typing import Any

import yaml
from rcl_interfaces.msg import Parameter
from rclpy.parameter import get_parameter_value, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient

from rocsafe_ros2cli.argument_types import regular_expression, unsigned_int
from rocsafe_ros2cli.command import Command, CommandError, Verb
from rocsafe_ros2cli.command_node import CommandNode, add_node_arguments, command_node
from rocsafe_ros2cli.discovery import await_discovery, wait_for
from rocsafe_ros2cli.node_names import absolute, node_names
from rocsafe_ros2cli.parameter_text import TYPE_NAMES, labelled_value, nested

SERVICES_LIMIT_S = 5.0
"""How long the parameter services of a node that is there may take to appear."""

ANSWER_LIMIT_S = 10.0
"""How long a node may take to answer."""


def _add_node_name(parser: ArgumentParser, *, optional: bool = False) -> None:
    """Add the arguments that say whose parameters are meant."""
    add_node_arguments(parser)
    parser.add_argument('node_name', nargs='?' if optional else None, help='Name of the node')
    parser.add_argument(
        '--include-hidden-nodes', action='store_true', help='Consider hidden nodes as well'
    )
    if not optional:
        parser.add_argument(
            '--timeout',
            metavar='N',
            type=unsigned_int,
            default=1,
            help='Seconds to wait for the node (default: %(default)s)',
        )


def _client(holder: CommandNode, options: Namespace) -> Any:
    """Return the client of the parameter services of the named node, once they are there."""
    node, name = holder.node, absolute(options.node_name)
    await_discovery(node, options.spin_time)
    hidden = options.include_hidden_nodes
    if not wait_for(lambda: name in node_names(node, with_hidden=hidden), options.timeout):
        raise CommandError('Node not found')
    client = AsyncParameterClient(node, name)
    if not wait_for(client.services_are_ready, SERVICES_LIMIT_S):
        raise CommandError(
            f'Wait for service timed out waiting for parameter services for node {name}'
        )
    return client


def _answer(holder: CommandNode, future: Any, node_name: str) -> Any:
    """Return what the node answers."""
    if not holder.spin_until(future.done, ANSWER_LIMIT_S):
        raise CommandError(f'No answer of node {node_name} within {ANSWER_LIMIT_S:g} s')
    if future.result() is None:
        raise CommandError(
            f'Exception while calling service of node {node_name}: {future.exception()}'
        )
    return future.result()


def _add_get_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `get`."""
    _add_node_name(parser)
    parser.add_argument('parameter_name', help='Name of the parameter')
    parser.add_argument('--hide-type', action='store_true', help='Hide the type information')


def _get(options: Namespace) -> int:
    """Print the value of a parameter."""
    with command_node(use_sim_time=options.use_sim_time) as holder:
        client = _client(holder, options)
        future = client.get_parameters([options.parameter_name])
        values = _answer(holder, future, options.node_name).values
    if not values:
        raise CommandError('Parameter not set')
    label, value = labelled_value(values[0])
    if options.hide_type:
        print(value)
    elif value is None:
        print(label)
    else:
        print(label, value)
    return 0


def _add_set_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `set`."""
    _add_node_name(parser)
    parser.add_argument('parameter_name', help='Name of the parameter')
    parser.add_argument('value', help='Value of the parameter')


def _set(options: Namespace) -> int:
    """Set a parameter; a refusal of the node goes to standard error."""
    parameter = Parameter(name=options.parameter_name)
    parameter.value = get_parameter_value(string_value=options.value)
    with command_node(use_sim_time=options.use_sim_time) as holder:
        client = _client(holder, options)
        future = client.set_parameters([parameter])
        result = _answer(holder, future, options.node_name).results[0]
    reason = f': {result.reason}' if result.reason else ''
    if result.successful:
        print(f'Set parameter successful{reason}')
    else:
        print(f'Setting parameter failed{reason}', file=sys.stderr)
    return 0


def _add_list_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `list`."""
    _add_node_name(parser, optional=True)
    parser.add_argument(
        '--filter', nargs=1, type=regular_expression, help='Show only names that match'
    )
    parser.add_argument('--param-prefixes', nargs='+', default=[], help='Show only these')
    parser.add_argument('--param-type', action='store_true', help='Show the types too')


def _list(options: Namespace) -> int:
    """List the parameters of a node, or of all."""
    with command_node(use_sim_time=options.use_sim_time) as holder:
        await_discovery(holder.node, options.spin_time)
        names = node_names(holder.node, with_hidden=options.include_hidden_nodes)
        if options.node_name is not None:
            if absolute(options.node_name) not in names:
                raise CommandError('Node not found')
            names = [absolute(options.node_name)]
        clients = {name: AsyncParameterClient(holder.node, name) for name in sorted(set(names))}
        end = time.monotonic() + SERVICES_LIMIT_S
        for name, client in clients.items():
            if wait_for(client.services_are_ready, end - time.monotonic()):
                _print_names(holder, client, name, options)
            else:
                print(f'Wait for service timed out waiting for parameter services for node {name}')
    return 0


def _print_names(holder: CommandNode, client: Any, node_name: str, options: Namespace) -> None:
    """Print the parameters of one node."""
    future = client.list_parameters(prefixes=options.param_prefixes)
    names = sorted(_answer(holder, future, node_name).result.names)
    if options.filter is not None:
        names = [name for name in names if options.filter[0].match(name)]
    if names and options.node_name is None:
        print(f'{node_name}:')
    types = dict.fromkeys(names, '')
    if options.param_type:
        described = _answer(holder, client.describe_parameters(names), node_name)
        for one in described.descriptors:
            types[one.name] = f' (type: {TYPE_NAMES[one.type]})'
    for name in names:
        print(f'  {name}{types[name]}')


def _dump(options: Namespace) -> int:
    """Print all parameters of a node as a parameter file."""
    with command_node(use_sim_time=options.use_sim_time) as holder:
        client = _client(holder, options)
        listed = _answer(holder, client.list_parameters(), options.node_name)
        names = sorted(listed.result.names)
        got = _answer(holder, client.get_parameters(names), options.node_name)
    values = [parameter_value_to_python(value) for value in got.values]
    parameters = nested(dict(zip(names, values, strict=True)))
    print(yaml.dump({absolute(options.node_name): {'ros__parameters': parameters}}))
    return 0


COMMAND = Command(
    verbs=(
        Verb(
            name='dump',
            summary='Show all of the parameters of a node in a YAML file format',
            add_arguments=_add_node_name,
            run=_dump,
        ),
        Verb(name='get', summary='Get parameter', add_arguments=_add_get_arguments, run=_get),
        Verb(
            name='list',
            summary='Output a list of available parameters',
            add_arguments=_add_list_arguments,
            run=_list,
        ),
        Verb(name='set', summary='Set parameter', add_arguments=_add_set_arguments, run=_set),
    )
)
