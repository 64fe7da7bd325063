# SPDX-License-Identifier: Apache-2.0
"""`ros2 topic`: the table of verbs, and the verbs `list`, `info` and `pub`."""

import time
from argparse import Namespace
from typing import Any

from rocsafe_ros2cli.command import (
    CommandError,
    Verb,
    argument,
    flag,
    positive_float,
    positive_int,
)
from rocsafe_ros2cli.command_node import CommandNode, command_node, graph_node
from rocsafe_ros2cli.interfaces import message_class
from rocsafe_ros2cli.message_fill import filled_message
from rocsafe_ros2cli.names import print_names, without_hidden
from rocsafe_ros2cli.verbs.topic_echo import echo
from rocsafe_ros2cli.verbs.topic_rate import DEFAULT_WINDOW, print_rates

WAIT_REPORT_S = 1.0
"""Interval of the line that says that `pub` waits for a subscription."""

WAIT_SILENT_S = 0.5
"""Time that a subscription may take to appear before that line."""

KEEP_ALIVE_S = 0.1
"""Time that `pub` stays after the last message, so that it is delivered."""


def _list(options: Namespace) -> None:
    """List topics."""
    with graph_node() as node:
        topics = without_hidden(node.get_topic_names_and_types())
    print_names(topics, show_types=options.show_types)


def _info(options: Namespace) -> None:
    """Print type, publishers and subscriptions of a topic."""
    name, end = options.topic_name, '\n\n' if options.verbose else '\n'
    with graph_node() as node:
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


def _print_each(endpoints: list[Any]) -> None:
    """Print each endpoint, with an empty line between."""
    for endpoint in endpoints:
        print(endpoint, end='\n\n')


def _pub(options: Namespace) -> None:
    """Publish a message once, some times, or until Ctrl-C."""
    message = filled_message(message_class(options.message_type), options.values)
    times = 1 if options.once else options.times
    with command_node() as holder:
        publisher = holder.node.create_publisher(type(message), options.topic_name, 10)
        if times is not None:
            _await_subscription(holder, publisher)
        print('publisher: beginning loop')
        count = 0

        def publish() -> None:
            nonlocal count
            count += 1
            print(f'publishing #{count}: {message!r}\n')
            publisher.publish(message)

        publish()
        timer = holder.node.create_timer(1.0 / options.rate, publish)
        holder.spin_until(lambda: times is not None and count >= times)
        holder.node.destroy_timer(timer)
        time.sleep(KEEP_ALIVE_S)


def _await_subscription(holder: CommandNode, publisher: Any) -> None:
    """Wait for a subscription, and print that every second."""

    def is_matched() -> bool:
        return bool(publisher.get_subscription_count())

    is_there = holder.spin_until(is_matched, WAIT_SILENT_S)
    while not is_there:
        print('Waiting for at least 1 matching subscription(s)...')
        is_there = holder.spin_until(is_matched, WAIT_REPORT_S)


TOPIC_NAME = argument('topic_name', help="Name of the topic (e.g. '/chatter')")

VERBS = (
    Verb(
        name='echo',
        summary='Output messages from a topic',
        arguments=(
            TOPIC_NAME,
            argument(
                'message_type', nargs='?', help="Type of the message (e.g. 'std_msgs/msg/String')"
            ),
            argument('--field', help="Echo one field (e.g. 'pose.pose.position')"),
            flag('--full-length', '-f', text='Cut nothing short'),
            flag('--no-arr', text='Do not print array fields of messages'),
            flag('--once', text='Print the first message received and then exit'),
        ),
        run=echo,
    ),
    Verb(
        name='hz',
        summary='Print the average publishing rate to screen',
        arguments=(
            TOPIC_NAME,
            argument(
                '--window',
                '-w',
                metavar='WINDOW',
                type=positive_int,
                default=DEFAULT_WINDOW,
                help='Number of intervals the rate is taken over (default: %(default)s)',
            ),
        ),
        run=print_rates,
    ),
    Verb(
        name='info',
        summary='Print information about a topic',
        arguments=(
            TOPIC_NAME,
            flag('--verbose', '-v', text='Show the nodes and their quality of service'),
        ),
        run=_info,
    ),
    Verb(
        name='list',
        summary='Output a list of available topics',
        arguments=(flag('-t', '--show-types', text='Show the types too'),),
        run=_list,
    ),
    Verb(
        name='pub',
        summary='Publish a message to a topic',
        arguments=(
            TOPIC_NAME,
            argument('message_type', help="Type of the message (e.g. 'std_msgs/msg/String')"),
            argument('values', nargs='?', default='{}', help="YAML (e.g. 'data: Hello')"),
            argument(
                '-r', '--rate', metavar='N', type=positive_float, default=1.0, help='Rate in Hz'
            ),
            flag('-1', '--once', text='Publish one message and exit'),
            argument('-t', '--times', type=positive_int, help='Publish so many messages'),
        ),
        run=_pub,
    ),
)
