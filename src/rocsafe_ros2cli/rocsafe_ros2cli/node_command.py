# SPDX-License-Identifier: Apache-2.0
"""`ros2 node`."""

import sys
from argparse import ArgumentParser, Namespace
from typing import Any

from rclpy.action import (
    get_action_client_names_and_types_by_node,
    get_action_server_names_and_types_by_node,
)

from rocsafe_ros2cli.command import Command, CommandError, Verb
from rocsafe_ros2cli.command_node import add_node_arguments, graph_node
from rocsafe_ros2cli.node_names import node_names, split_node_name
from rocsafe_ros2cli.topic_graph import without_hidden


def _add_list_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `list`."""
    add_node_arguments(parser)
    parser.add_argument('-a', '--all', action='store_true', help='Show hidden nodes too')
    parser.add_argument('-c', '--count-nodes', action='store_true', help='Show only the number')


def _list(options: Namespace) -> int:
    """List nodes."""
    with graph_node(options) as node:
        names = sorted(node_names(node, with_hidden=options.all))
    if options.count_nodes:
        print(len(names))
        return 0
    if len(set(names)) < len(names):
        print(
            'WARNING: Be aware that there are nodes in the graph that share an exact name, '
            'which can have unintended side effects.',
            file=sys.stderr,
        )
    for name in names:
        print(name)
    return 0


def _add_info_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `info`."""
    add_node_arguments(parser)
    parser.add_argument('node_name', help='Name of the node')
    parser.add_argument('--include-hidden', action='store_true', help='Show hidden names too')


def _info(options: Namespace) -> int:
    """Print what a node publishes, subscribes, serves and calls."""
    wanted = options.node_name
    with graph_node(options) as node:
        count = node_names(node, with_hidden=options.include_hidden).count(wanted)
        if count == 0:
            raise CommandError(f"Unable to find node '{wanted}'")
        if count > 1:
            print(
                f'There are {count} nodes in the graph with the exact name "{wanted}". '
                'You are seeing information about only one of them.',
                file=sys.stderr,
            )
        print(wanted)
        for title, names_and_types in _endpoints(node, wanted).items():
            shown = without_hidden(names_and_types, keep=options.include_hidden)
            print(f'  {title}:')
            print('\n'.join(f'    {name}: {", ".join(types)}' for name, types in shown))
    return 0


def _endpoints(node: Any, name: str) -> dict[str, Any]:
    """Return names and types of the endpoints of a node, by the title of their kind."""
    where = split_node_name(name)
    return {
        'Subscribers': node.get_subscriber_names_and_types_by_node(*where),
        'Publishers': node.get_publisher_names_and_types_by_node(*where),
        'Service Servers': node.get_service_names_and_types_by_node(*where),
        'Service Clients': node.get_client_names_and_types_by_node(*where),
        'Action Servers': get_action_server_names_and_types_by_node(node, *where),
        'Action Clients': get_action_client_names_and_types_by_node(node, *where),
    }


COMMAND = Command(
    verbs=(
        Verb(
            name='info',
            summary='Output information about a node',
            add_arguments=_add_info_arguments,
            run=_info,
        ),
        Verb(
            name='list',
            summary='Output a list of available nodes',
            add_arguments=_add_list_arguments,
            run=_list,
        ),
    )
)
