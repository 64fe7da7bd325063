# SPDX-License-Identifier: Apache-2.0
"""`ros2 topic echo`."""

from argparse import ArgumentParser, Namespace
from typing import Any

import yaml
from rclpy.event_handler import SubscriptionEventCallbacks

from rocsafe_ros2cli.argument_types import positive_float, unsigned_int
from rocsafe_ros2cli.command import CommandError, Verb
from rocsafe_ros2cli.command_node import CommandNode, add_node_arguments, command_node
from rocsafe_ros2cli.discovery import OTHERS_LIMIT_S, await_discovery, wait_for
from rocsafe_ros2cli.interfaces import message_class
from rocsafe_ros2cli.message_filter import add_filter_argument, passes
from rocsafe_ros2cli.message_text import TextStyle, csv_text, yaml_text
from rocsafe_ros2cli.topic_graph import not_published_warning, topic_class
from rocsafe_ros2cli.topic_qos import (
    add_qos_arguments,
    chosen_qos,
    is_qos_chosen,
    matched_qos,
)

DEFAULT_TRUNCATE_LENGTH = 128
SEPARATOR = '---\n'

FLAGS = {
    '--csv': 'Output all fields separated by commas',
    '--no-arr': 'Do not print array fields of messages',
    '--no-str': 'Do not print string fields of messages',
    '--flow-style': 'Print arrays on one line',
    '--no-lost-messages': 'Do not report when a message is lost',
    '--raw': 'Echo the raw binary representation',
    '--once': 'Print the first message received and then exit',
}


def _add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `echo`."""
    add_node_arguments(parser)
    parser.add_argument('topic_name', help="Name of the topic (e.g. '/chatter')")
    parser.add_argument(
        'message_type', nargs='?', help="Type of the message (e.g. 'std_msgs/msg/String')"
    )
    add_qos_arguments(parser, 'sensor_data')
    for flag, text in FLAGS.items():
        parser.add_argument(flag, action='store_true', help=text)
    parser.add_argument('--field', help="Echo one field (e.g. 'pose.pose.position')")
    add_filter_argument(parser)
    parser.add_argument('--timeout', metavar='N', type=positive_float, help='End after N seconds')
    parser.add_argument(
        '--include-message-info', '-i', action='store_true', help='Show times and sequence numbers'
    )
    parser.add_argument('--full-length', '-f', action='store_true', help='Cut nothing short')
    parser.add_argument(
        '--truncate-length',
        '-l',
        metavar='N',
        type=unsigned_int,
        default=DEFAULT_TRUNCATE_LENGTH,
        help='Cut arrays and strings after N elements (default: %(default)s)',
    )


def _echo(options: Namespace) -> int:
    """Print messages until the first one (`--once`), the timeout or Ctrl-C."""
    printer = _Printer(options)
    with command_node(use_sim_time=options.use_sim_time) as holder:
        message_type = _message_type(holder.node, options)
        await_discovery(holder.node, options.spin_time)
        _subscribe(holder, message_type, printer, options)
        limit_s = float('inf') if options.timeout is None else options.timeout
        holder.spin_until(lambda: options.once and printer.has_printed, limit_s)
    return 0


def _message_type(node: Any, options: Namespace) -> Any:
    """Return the class of the messages: named by the user, or learned from the graph."""
    if options.message_type is not None:
        return message_class(options.message_type)
    limit_s = OTHERS_LIMIT_S if options.spin_time is None else options.spin_time
    wait_for(lambda: topic_class(node, options.topic_name) is not None, limit_s)
    found = topic_class(node, options.topic_name)
    if found is None:
        print(not_published_warning(options.topic_name))
        raise CommandError('Could not determine the type for the passed topic')
    return found


def _subscribe(
    holder: CommandNode, message_type: Any, printer: '_Printer', options: Namespace
) -> None:
    """Subscribe so that all present publishers are heard, unless the user chose otherwise."""
    profile = chosen_qos(options)
    if not is_qos_chosen(options):
        publishers = holder.node.get_publishers_info_by_topic(options.topic_name)
        profile = matched_qos(profile, publishers)
    events = SubscriptionEventCallbacks(message_lost=None if options.no_lost_messages else _lost)
    holder.node.create_subscription(
        message_type,
        options.topic_name,
        printer.take,
        profile,
        event_callbacks=events,
        raw=options.raw,
    )


def _lost(status: Any) -> None:
    """Say that messages were lost on the way."""
    print(
        f'A message was lost!!!\n\ttotal count change:{status.total_count_change}'
        f'\n\ttotal count: {status.total_count}',
        end=SEPARATOR,
    )


class _Printer:
    """Prints messages as the options ask.

    Attributes
    ----------
    has_printed : bool
        Whether any message passed the filter.
    """

    def __init__(self, options: Namespace) -> None:
        self.has_printed = False
        self._options = options
        self._fields = [part for part in (options.field or '').split('.') if part]
        if options.field is not None and not self._fields:
            raise CommandError(f"Invalid field value '{options.field}'")
        self._style = TextStyle(
            truncate_length=None if options.full_length else options.truncate_length,
            show_arrays=not options.no_arr,
            show_strings=not options.no_str,
            flow_style=options.flow_style,
        )

    def take(self, message: Any, info: dict[str, Any]) -> None:
        """Print the message, or the wanted field of it."""
        if self._options.once and self.has_printed:
            return
        value = self._selected(message)
        if passes(self._options.condition, value):
            self.has_printed = True
            self._print(value, info)

    def _selected(self, message: Any) -> Any:
        """Return the wanted field."""
        try:
            for field in self._fields:
                message = getattr(message, field)
        except AttributeError as error:
            raise CommandError(f"Invalid field '{'.'.join(self._fields)}': {error}") from error
        return message

    def _print(self, value: Any, info: dict[str, Any]) -> None:
        """Print a message, or a value that is none."""
        with_info = self._options.include_message_info
        if not hasattr(value, '__slots__'):
            if with_info:
                print(f'---Got new message, message info:---\n{info}\n---Message data:---')
            print(value, end=f'\n{SEPARATOR}')
        elif self._options.csv:
            head = ''.join(f'{item},' for item in info.values()) if with_info else ''
            print(head + csv_text(value, self._style))
        else:
            head = yaml.dump(info) + SEPARATOR if with_info else ''
            print(head + yaml_text(value, self._style), end=SEPARATOR)


VERB = Verb(
    name='echo',
    summary='Output messages from a topic',
    add_arguments=_add_arguments,
    run=_echo,
)
