# SPDX-License-Identifier: Apache-2.0
"""`ros2 node`."""

import sys
from argparse import Namespace
from typing import Any

from rclpy.action import (
    get_action_client_names_and_types_by_node,
    get_action_server_names_and_types_by_node,
)

from rocsafe_ros2cli.command import CommandError, Verb, argument
from rocsafe_ros2cli.command_node import graph_node
from rocsafe_ros2cli.names import node_names, split_node_name, without_hidden


def _list(_options: Namespace) -> None:
    """List nodes."""
    with graph_node() as node:
        names = sorted(node_names(node))
    if len(set(names)) < len(names):
        print(
            'WARNING: Be aware that there are nodes in the graph that share an exact name, '
            'which can have unintended side effects.',
            file=sys.stderr,
        )
    for name in names:
        print(name)


def _info(options: Namespace) -> None:
    """Print the topics, services and actions of a node."""
    wanted = options.node_name
    with graph_node() as node:
        count = node_names(node).count(wanted)
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
            shown = without_hidden(names_and_types)
            print(f'  {title}:')
            print('\n'.join(f'    {name}: {", ".join(types)}' for name, types in shown))


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


VERBS = (
    Verb(
        name='info',
        summary='Output information about a node',
        arguments=(argument('node_name', help='Name of the node'),),
        run=_info,
    ),
    Verb(name='list', summary='Output a list of available nodes', run=_list),
)
