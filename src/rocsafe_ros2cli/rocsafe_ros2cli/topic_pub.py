# SPDX-License-Identifier: Apache-2.0
"""`ros2 topic pub`."""

import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from typing import Any

from rocsafe_ros2cli.argument_types import positive_float, unsigned_int
from rocsafe_ros2cli.command import CommandError, Verb
from rocsafe_ros2cli.command_node import CommandNode, add_node_arguments, command_node
from rocsafe_ros2cli.interfaces import message_class
from rocsafe_ros2cli.message_fill import fill, new_message, read_values, values_text
from rocsafe_ros2cli.topic_qos import add_qos_arguments, chosen_qos

REPEAT_S = 1.0
"""How often we say that we wait for subscriptions."""

PATIENCE_S = 0.5
"""How long subscriptions may take to appear before we say that we wait."""


def _add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `pub`."""
    parser.add_argument('topic_name', help="Name of the topic (e.g. '/chatter')")
    parser.add_argument('message_type', help="Type of the message (e.g. 'std_msgs/msg/String')")
    values = parser.add_mutually_exclusive_group()
    values.add_argument('values', nargs='?', default='{}', help="YAML (e.g. 'data: Hello')")
    values.add_argument('--stdin', action='store_true', help='Read values from standard input')
    parser.add_argument('-n', '--node-name', default='', help='Name of the publishing node')
    _add_timing_arguments(parser)
    add_qos_arguments(parser, 'default')
    add_node_arguments(parser)


def _add_timing_arguments(parser: ArgumentParser) -> None:
    """Add the arguments that say how often and how long to publish."""
    parser.add_argument(
        '-r', '--rate', metavar='N', type=positive_float, default=1.0, help='Rate in Hz'
    )
    parser.add_argument(
        '-p', '--print', metavar='N', type=int, default=1, help='Print every N-th message only'
    )
    times = parser.add_mutually_exclusive_group()
    times.add_argument('-1', '--once', action='store_true', help='Publish one message and exit')
    times.add_argument('-t', '--times', type=unsigned_int, default=0, help='Publish so many')
    parser.add_argument(
        '-w',
        '--wait-matching-subscriptions',
        metavar='N',
        type=unsigned_int,
        help='Wait for N subscriptions (default: 1 with --once and --times, else 0)',
    )
    parser.add_argument(
        '--max-wait-time-secs', metavar='N', type=positive_float, help='Longest such wait'
    )
    parser.add_argument(
        '--keep-alive',
        metavar='N',
        type=positive_float,
        default=0.1,
        help='Seconds to stay after the last message (default: %(default)s)',
    )


def _pub(options: Namespace) -> int:
    """Publish a message, once, some times, or until Ctrl-C."""
    message_type = message_class(options.message_type)
    values = read_values(values_text(options.values, from_stdin=options.stdin))
    if not isinstance(values, dict):
        raise CommandError('The passed value needs to be a dictionary in YAML format')
    times = 1 if options.once else options.times
    wanted = options.wait_matching_subscriptions
    wanted = int(times != 0) if wanted is None else wanted
    if wanted == 0 and options.max_wait_time_secs is not None:
        raise CommandError(
            '--max-wait-time-secs option is only effective'
            ' with --wait-matching-subscriptions, --once or --times'
        )
    with command_node(options.node_name, use_sim_time=options.use_sim_time) as holder:
        publisher = holder.node.create_publisher(
            message_type, options.topic_name, chosen_qos(options)
        )
        publish = _publish_action(
            holder.node, publisher, new_message(message_type), values, options.print
        )
        _await_subscriptions(holder, publisher, wanted, options.max_wait_time_secs)
        _repeat(holder, publish, options.rate, times)
        time.sleep(options.keep_alive)
    return 0


def _await_subscriptions(
    holder: CommandNode, publisher: Any, wanted: int, limit_s: float | None
) -> None:
    """Wait for the subscriptions, and say so every second."""
    end = float('inf') if limit_s is None else time.monotonic() + limit_s

    def is_matched() -> bool:
        return bool(publisher.get_subscription_count() >= wanted)

    holder.spin_until(is_matched, PATIENCE_S)
    while not is_matched():
        print(f'Waiting for at least {wanted} matching subscription(s)...')
        left_s = end - time.monotonic()
        if left_s <= 0.0:
            raise CommandError(
                f'Timed out waiting for subscribers: Expected {wanted} subcribers'
                f' but only got {publisher.get_subscription_count()} subscribers'
            )
        holder.spin_until(is_matched, min(REPEAT_S, left_s))


def _publish_action(
    node: Any, publisher: Any, message: Any, values: dict[str, Any], print_every: int
) -> Callable[[], int]:
    """Return what publishes the message once and gives the number of messages so far."""
    try:
        stamp_setters = fill(message, values, with_clock=True)
    except Exception as error:  # the setters of messages raise what they like
        raise CommandError(f'Failed to populate field: {error}') from error
    count = 0

    def publish() -> int:
        nonlocal count
        now = node.get_clock().now().to_msg()
        for set_stamp in stamp_setters:
            set_stamp(now)
        count += 1
        if print_every and count % print_every == 0:
            print(f'publishing #{count}: {message!r}\n')
        publisher.publish(message)
        return count

    return publish


def _repeat(holder: CommandNode, publish: Callable[[], int], rate_hz: float, times: int) -> None:
    """Publish at once, then at the rate, so many times or without end."""
    print('publisher: beginning loop')
    count = publish()
    if times == 1:
        return

    def tick() -> None:
        nonlocal count
        count = publish()

    timer = holder.node.create_timer(1.0 / rate_hz, tick)
    holder.spin_until(lambda: times != 0 and count >= times)
    holder.node.destroy_timer(timer)


VERB = Verb(
    name='pub',
    summary='Publish a message to a topic',
    add_arguments=_add_arguments,
    run=_pub,
)
