# SPDX-License-Identifier: Apache-2.0
"""`ros2 service`."""

from argparse import Namespace

from rocsafe_ros2cli.command import Verb, argument, flag
from rocsafe_ros2cli.command_node import command_node, graph_node
from rocsafe_ros2cli.interfaces import interface_class
from rocsafe_ros2cli.message_fill import filled_message
from rocsafe_ros2cli.names import print_names, without_hidden


def _list(options: Namespace) -> None:
    """List services."""
    with graph_node() as node:
        services = without_hidden(node.get_service_names_and_types())
    print_names(services, show_types=options.show_types)


def _call(options: Namespace) -> None:
    """Call a service and print request and response."""
    service_type = interface_class(
        options.service_type,
        'srv',
        'The passed service type is invalid',
        'The passed type is not a service',
    )
    request = filled_message(service_type.Request, options.values)
    with command_node() as holder:
        client = holder.node.create_client(service_type, options.service_name)
        if not client.service_is_ready():
            print('waiting for service to become available...')
            holder.spin_until(client.service_is_ready)
        print(f'requester: making request: {request!r}\n')
        response = holder.answer(client.call_async(request), 'calling service')
        print(f'response:\n{response!r}\n')


VERBS = (
    Verb(
        name='call',
        summary='Call a service',
        arguments=(
            argument('service_name', help="Name of the service (e.g. '/rav1/hold')"),
            argument('service_type', help="Type of the service (e.g. 'std_srvs/srv/Trigger')"),
            argument('values', nargs='?', default='{}', help="YAML (e.g. '{data: true}')"),
        ),
        run=_call,
    ),
    Verb(
        name='list',
        summary='Output a list of available services',
        arguments=(flag('-t', '--show-types', text='Show the types too'),),
        run=_list,
    ),
)
