# SPDX-License-Identifier: Apache-2.0
"""`ros2 topic`."""

from argparse import ArgumentParser, Namespace
from typing import Any

from rocsafe_ros2cli import topic_echo, topic_hz, topic_pub
from rocsafe_ros2cli.command import Command, CommandError, Verb
from rocsafe_ros2cli.command_node import add_node_arguments, graph_node
from rocsafe_ros2cli.topic_graph import without_hidden

HIDDEN_HELP = 'Consider hidden topics as well'


def _add_arguments(parser: ArgumentParser) -> None:
    """Add what stands between `topic` and the verb."""
    parser.add_argument('--include-hidden-topics', action='store_true', help=HIDDEN_HELP)


def _add_list_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `list`."""
    add_node_arguments(parser)
    parser.add_argument('-t', '--show-types', action='store_true', help='Show the types too')
    parser.add_argument('-c', '--count-topics', action='store_true', help='Show only the number')
    parser.add_argument('--include-hidden-topics', action='store_true', help=HIDDEN_HELP)
    parser.add_argument('-v', '--verbose', action='store_true', help='List full details')


def _list(options: Namespace) -> int:
    """List topics."""
    with graph_node(options) as node:
        topics = without_hidden(
            node.get_topic_names_and_types(), keep=options.include_hidden_topics
        )
        if options.count_topics:
            print(len(topics))
        elif options.verbose:
            _print_details('Published', 'publisher', topics, node.count_publishers)
            _print_details('Subscribed', 'subscriber', topics, node.count_subscribers)
        else:
            for name, types in topics:
                print(f'{name} [{", ".join(types)}]' if options.show_types else name)
    return 0


def _print_details(title: str, role: str, topics: list[Any], count: Any) -> None:
    """Print the topics that have such endpoints, with their number."""
    print(f'{title} topics:')
    for name, types in topics:
        if number := count(name):
            ending = 's' if number > 1 else ''
            print(f' * {name} [{", ".join(types)}] {number} {role}{ending}')
    print()


def _add_info_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `info`."""
    add_node_arguments(parser)
    parser.add_argument('topic_name', help="Name of the topic (e.g. '/chatter')")
    parser.add_argument(
        '--verbose', '-v', action='store_true', help='Show the nodes and their quality of service'
    )


def _info(options: Namespace) -> int:
    """Print type, publishers and subscriptions of a topic."""
    name, end = options.topic_name, '\n\n' if options.verbose else '\n'
    with graph_node(options) as node:
        types = dict(node.get_topic_names_and_types()).get(name)
        if types is None:
            raise CommandError(f"Unknown topic '{name}'")
        print(f'Type: {types[0] if len(types) == 1 else types}', end=end)
        print(f'Publisher count: {node.count_publishers(name)}', end=end)
        if options.verbose:
            _print_each(node.get_publishers_info_by_topic(name))
        print(f'Subscription count: {node.count_subscribers(name)}', end=end)
        if options.verbose:
            _print_each(node.get_subscriptions_info_by_topic(name))
    return 0


def _print_each(endpoints: list[Any]) -> None:
    """Print what is known of each endpoint, with an empty line between."""
    for endpoint in endpoints:
        print(endpoint, end='\n\n')


def _add_type_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `type`."""
    add_node_arguments(parser)
    parser.add_argument('topic_name', help="Name of the topic (e.g. '/chatter')")


def _type(options: Namespace) -> int:
    """Print the type of a topic; status 1 if there is no such topic."""
    with graph_node(options) as node:
        types = dict(node.get_topic_names_and_types()).get(options.topic_name, [])
    for name in types:
        print(name)
    return 0 if types else 1


COMMAND = Command(
    add_arguments=_add_arguments,
    verbs=(
        topic_echo.VERB,
        topic_hz.VERB,
        Verb(
            name='info',
            summary='Print information about a topic',
            add_arguments=_add_info_arguments,
            run=_info,
        ),
        Verb(
            name='list',
            summary='Output a list of available topics',
            add_arguments=_add_list_arguments,
            run=_list,
        ),
        topic_pub.VERB,
        Verb(
            name='type',
            summary="Print a topic's type",
            add_arguments=_add_type_arguments,
            run=_type,
        ),
    ),
)
