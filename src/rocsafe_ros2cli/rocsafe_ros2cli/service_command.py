# SPDX-License-Identifier: Apache-2.0
"""`ros2 service`."""

import time
from argparse import ArgumentParser, Namespace
from typing import Any

from rocsafe_ros2cli.argument_types import positive_float
from rocsafe_ros2cli.command import Command, CommandError, Verb
from rocsafe_ros2cli.command_node import (
    NAME_PREFIX,
    CommandNode,
    add_node_arguments,
    command_node,
    graph_node,
)
from rocsafe_ros2cli.interfaces import interface_class
from rocsafe_ros2cli.message_fill import fill, new_message, read_values, values_text
from rocsafe_ros2cli.topic_graph import without_hidden

HIDDEN_HELP = 'Consider hidden services as well'


def _add_arguments(parser: ArgumentParser) -> None:
    """Add what stands between `service` and the verb."""
    parser.add_argument('--include-hidden-services', action='store_true', help=HIDDEN_HELP)


def _add_list_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `list`."""
    add_node_arguments(parser)
    parser.add_argument('-t', '--show-types', action='store_true', help='Show the types too')
    parser.add_argument('-c', '--count-services', action='store_true', help='Show only the number')
    parser.add_argument('--include-hidden-services', action='store_true', help=HIDDEN_HELP)


def _list(options: Namespace) -> int:
    """List services."""
    with graph_node(options) as node:
        services = without_hidden(
            node.get_service_names_and_types(), keep=options.include_hidden_services
        )
    if options.count_services:
        print(len(services))
        return 0
    for name, types in services:
        print(f'{name} [{", ".join(types)}]' if options.show_types else name)
    return 0


def _add_type_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `type`."""
    add_node_arguments(parser)
    parser.add_argument('service_name', help="Name of the service (e.g. '/hold')")


def _type(options: Namespace) -> int:
    """Print the type of a service; status 1 if there is no such service."""
    with graph_node(options) as node:
        types = dict(node.get_service_names_and_types()).get(options.service_name, [])
    for name in types:
        print(name)
    return 0 if types else 1


def _add_call_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `call`."""
    parser.add_argument('service_name', help="Name of the service (e.g. '/rav1/hold')")
    parser.add_argument('service_type', help="Type of the service (e.g. 'std_srvs/srv/Trigger')")
    values = parser.add_mutually_exclusive_group()
    values.add_argument('values', nargs='?', default='{}', help="YAML (e.g. '{data: true}')")
    values.add_argument('--stdin', action='store_true', help='Read values from standard input')
    parser.add_argument('-r', '--rate', metavar='N', type=positive_float, help='Repeat, in Hz')


def _call(options: Namespace) -> int:
    """Call a service, once or until Ctrl-C."""
    service_type = _service_class(options.service_type)
    request = new_message(service_type.Request)
    values = read_values(values_text(options.values, from_stdin=options.stdin))
    try:
        fill(request, values)
    except Exception as error:  # the setters of messages raise what they like
        raise CommandError(f'Failed to populate field: {error}') from error
    name = f'{NAME_PREFIX}_requester_{options.service_type.replace("/", "_")}'
    with command_node(name) as holder:
        client = holder.node.create_client(service_type, options.service_name)
        if not client.service_is_ready():
            print('waiting for service to become available...')
            holder.spin_until(client.service_is_ready)
        _call_once(holder, client, request)
        while options.rate is not None:
            time.sleep(1.0 / options.rate)
            _call_once(holder, client, request)
    return 0


def _service_class(name: str) -> Any:
    """Return the class of a service."""
    return interface_class(
        name, 'srv', 'The passed service type is invalid', 'The passed type is not a service'
    )


def _call_once(holder: CommandNode, client: Any, request: Any) -> None:
    """Call and print request and response."""
    print(f'requester: making request: {request!r}\n')
    future = client.call_async(request)
    holder.spin_until(future.done)
    if future.result() is None:
        raise CommandError(f'Exception while calling service: {future.exception()!r}')
    print(f'response:\n{future.result()!r}\n')


COMMAND = Command(
    add_arguments=_add_arguments,
    verbs=(
        Verb(
            name='call',
            summary='Call a service',
            add_arguments=_add_call_arguments,
            run=_call,
        ),
        Verb(
            name='list',
            summary='Output a list of available services',
            add_arguments=_add_list_arguments,
            run=_list,
        ),
        Verb(
            name='type',
            summary="Output a service's type",
            add_arguments=_add_type_arguments,
            run=_type,
        ),
    ),
)
