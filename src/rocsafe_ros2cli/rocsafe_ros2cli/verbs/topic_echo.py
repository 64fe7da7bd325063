# SPDX-License-Identifier: Apache-2.0
"""`ros2 topic echo`."""

from argparse import Namespace
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data

from rocsafe_ros.domain.discovery import OTHERS_LIMIT_S, await_discovery, wait_for
from rocsafe_ros2cli.command import CommandError
from rocsafe_ros2cli.command_node import command_node
from rocsafe_ros2cli.interfaces import message_class
from rocsafe_ros2cli.message_text import TextStyle, yaml_text
from rocsafe_ros2cli.names import not_published_warning, topic_class

TRUNCATE_LENGTH = 128
SEPARATOR = '---\n'


def echo(options: Namespace) -> None:
    """Print messages until the first one (`--once`) or Ctrl-C."""
    printer = _Printer(options)
    with command_node() as holder:
        message_type = _message_type(holder.node, options)
        await_discovery(holder.node)
        publishers = holder.node.get_publishers_info_by_topic(options.topic_name)
        profile = matched_qos([publisher.qos_profile for publisher in publishers])
        holder.node.create_subscription(message_type, options.topic_name, printer.take, profile)
        holder.spin_until(lambda: options.once and printer.has_printed)


def _message_type(node: Any, options: Namespace) -> Any:
    """Return the class of the messages: named by the user, or known from the graph."""
    if options.message_type is not None:
        return message_class(options.message_type)
    wait_for(lambda: topic_class(node, options.topic_name) is not None, OTHERS_LIMIT_S)
    found = topic_class(node, options.topic_name)
    if found is None:
        print(not_published_warning(options.topic_name))
        raise CommandError('Could not determine the type for the passed topic')
    return found


def matched_qos(offers: list[QoSProfile]) -> QoSProfile:
    """Return a profile that receives from all publishers, as strict as the least strict of them.

    Parameters
    ----------
    offers
        Profiles of the publishers; without any, the profile is that for sensor data.
    """
    is_reliable = bool(offers) and all(
        offer.reliability is ReliabilityPolicy.RELIABLE for offer in offers
    )
    is_latched = bool(offers) and all(
        offer.durability is DurabilityPolicy.TRANSIENT_LOCAL for offer in offers
    )
    return QoSProfile(
        depth=qos_profile_sensor_data.depth,
        reliability=ReliabilityPolicy.RELIABLE if is_reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE,
    )


class _Printer:
    """Prints messages as the options ask.

    Attributes
    ----------
    has_printed
        Whether any message was printed.
    """

    def __init__(self, options: Namespace) -> None:
        self.has_printed = False
        self._once = options.once
        self._fields = [part for part in (options.field or '').split('.') if part]
        if options.field is not None and not self._fields:
            raise CommandError(f"Invalid field value '{options.field}'")
        self._style = TextStyle(
            truncate_length=None if options.full_length else TRUNCATE_LENGTH,
            show_arrays=not options.no_arr,
        )

    def take(self, message: Any) -> None:
        """Print the message, or the wanted field of it."""
        if self._once and self.has_printed:
            return
        value = self._selected(message)
        self.has_printed = True
        is_message = hasattr(value, '__slots__')
        print(yaml_text(value, self._style) if is_message else f'{value}\n', end=SEPARATOR)

    def _selected(self, message: Any) -> Any:
        """Return the wanted field."""
        try:
            for field in self._fields:
                message = getattr(message, field)
        except AttributeError as error:
            raise CommandError(f"Invalid field '{'.'.join(self._fields)}': {error}") from error
        return message
