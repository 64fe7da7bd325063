# SPDX-License-Identifier: Apache-2.0
"""`ros2 action`."""

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from typing import Any

from rclpy.action import (
    get_action_client_names_and_types_by_node,
    get_action_names_and_types,
    get_action_server_names_and_types_by_node,
)

from rocsafe_ros2cli import action_send_goal
from rocsafe_ros2cli.command import Command, Verb
from rocsafe_ros2cli.command_node import add_node_arguments, graph_node
from rocsafe_ros2cli.node_names import full_node_name
from rocsafe_ros2cli.topic_graph import full_topic_name


def _add_list_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `list`."""
    add_node_arguments(parser)
    parser.add_argument('-t', '--show-types', action='store_true', help='Show the types too')
    parser.add_argument('-c', '--count-actions', action='store_true', help='Show only the number')


def _list(options: Namespace) -> int:
    """List actions."""
    with graph_node(options) as node:
        actions = get_action_names_and_types(node)
    if options.count_actions:
        print(len(actions))
        return 0
    for name, types in actions:
        print(_row(name, types, options))
    return 0


def _add_info_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `info`."""
    add_node_arguments(parser)
    parser.add_argument('action_name', help="Name of the action (e.g. '/rav1/fly_route')")
    parser.add_argument('-t', '--show-types', action='store_true', help='Show the types too')
    parser.add_argument('-c', '--count', action='store_true', help='Show only the numbers')


def _info(options: Namespace) -> int:
    """Print the clients and servers of an action."""
    with graph_node(options) as node:
        name = full_topic_name(node, options.action_name)
        clients = _nodes_with(node, name, get_action_client_names_and_types_by_node)
        servers = _nodes_with(node, name, get_action_server_names_and_types_by_node)
    print(f'Action: {options.action_name}')
    for title, nodes in (('clients', clients), ('servers', servers)):
        print(f'Action {title}: {len(nodes)}')
        if not options.count:
            for node_name, types in nodes:
                print('    ' + _row(node_name, types, options))
    return 0


def _nodes_with(node: Any, action: str, endpoints: Callable[..., Any]) -> list[Any]:
    """Return full name and types of each node that has such an endpoint of the action."""
    return [
        (full_node_name(name, namespace), types)
        for name, namespace in node.get_node_names_and_namespaces()
        for found, types in endpoints(node, name, namespace)
        if found == action
    ]


def _row(name: str, types: list[str], options: Namespace) -> str:
    """Return the name, with the types if they are wanted."""
    return f'{name} [{", ".join(types)}]' if options.show_types else name


COMMAND = Command(
    verbs=(
        Verb(
            name='info',
            summary='Print information about an action',
            add_arguments=_add_info_arguments,
            run=_info,
        ),
        Verb(
            name='list',
            summary='Output a list of action names',
            add_arguments=_add_list_arguments,
            run=_list,
        ),
        action_send_goal.VERB,
    )
)
