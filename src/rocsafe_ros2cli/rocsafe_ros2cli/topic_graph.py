# SPDX-License-Identifier: Apache-2.0
"""Topics as the graph knows them: names, types, and the class of a type."""

from typing import Any

from rclpy.exceptions import InvalidTopicNameException
from rclpy.expand_topic_name import expand_topic_name
from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden
from rclpy.validate_full_topic_name import validate_full_topic_name

from rocsafe_ros2cli.command import CommandError
from rocsafe_ros2cli.interfaces import interface_class

NamesAndTypes = list[tuple[str, list[str]]]


def without_hidden(names_and_types: NamesAndTypes, *, keep: bool = False) -> NamesAndTypes:
    """Return the names that are not hidden, or all if `keep`."""
    return [
        (name, types)
        for name, types in names_and_types
        if keep or not topic_or_service_is_hidden(name)
    ]


def full_topic_name(node: Any, topic: str) -> str:
    """Return the name with its namespace.

    Raises
    ------
    CommandError
        If this cannot be the name of a topic.
    """
    try:
        name = str(expand_topic_name(topic, node.get_name(), node.get_namespace()))
        validate_full_topic_name(name)
    except (ValueError, InvalidTopicNameException) as error:
        raise CommandError(str(error)) from error
    return name


def topic_class(node: Any, topic: str) -> Any:
    """Return the message class of a topic, None while nobody publishes or subscribes it.

    Raises
    ------
    CommandError
        If the topic has several types, or its type is not installed here.
    """
    types = dict(node.get_topic_names_and_types()).get(full_topic_name(node, topic))
    if types is None:
        return None
    if len(types) > 1:
        names = ', '.join(types)
        raise CommandError(
            f"Cannot echo topic '{topic}', as it contains more than one type: [{names}]"
        )
    return interface_class(types[0], 'msg', f"The message type '{types[0]}' is invalid")


def not_published_warning(topic: str) -> str:
    """Return what is said about a topic without a type."""
    return f'WARNING: topic [{topic}] does not appear to be published yet'
