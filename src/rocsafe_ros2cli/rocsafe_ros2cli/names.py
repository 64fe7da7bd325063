# SPDX-License-Identifier: Apache-2.0
"""Names and types of nodes, topics and services as the graph knows them."""

from typing import Any

from rclpy.exceptions import InvalidTopicNameException
from rclpy.expand_topic_name import expand_topic_name
from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden
from rclpy.validate_full_topic_name import validate_full_topic_name

from rocsafe_ros2cli.command import CommandError
from rocsafe_ros2cli.interfaces import interface_class

NamesAndTypes = list[tuple[str, list[str]]]


def node_names(node: Any) -> list[str]:
    """Return the full names of the known nodes, without hidden ones."""
    return [
        f'{namespace.rstrip("/")}/{name}'
        for name, namespace in node.get_node_names_and_namespaces()
        if not name.startswith('_')
    ]


def split_node_name(full_name: str) -> tuple[str, str]:
    """Return base name and namespace of a full name."""
    namespace, _, name = full_name.rpartition('/')
    return name, namespace or '/'


def without_hidden(names_and_types: NamesAndTypes) -> NamesAndTypes:
    """Return the names that are not hidden, with their types."""
    return [one for one in names_and_types if not topic_or_service_is_hidden(one[0])]


def print_names(names_and_types: NamesAndTypes, *, show_types: bool) -> None:
    """Print one name per line, with its types if they are wanted."""
    for name, types in names_and_types:
        print(f'{name} [{", ".join(types)}]' if show_types else name)


def full_name(node: Any, name: str) -> str:
    """Return the name of a topic, service or action with its namespace.

    Raises
    ------
    CommandError
        If the name is malformed.
    """
    try:
        expanded = str(expand_topic_name(name, node.get_name(), node.get_namespace()))
        validate_full_topic_name(expanded)
    except (ValueError, InvalidTopicNameException) as error:
        raise CommandError(str(error)) from error
    return expanded


def topic_class(node: Any, topic: str) -> Any:
    """Return the message class of a topic, None while nobody publishes or subscribes it.

    Raises
    ------
    CommandError
        If the topic has several types, or its type is not installed here.
    """
    types = dict(node.get_topic_names_and_types()).get(full_name(node, topic))
    if types is None:
        return None
    if len(types) > 1:
        names = ', '.join(types)
        raise CommandError(
            f"Cannot echo topic '{topic}', as it contains more than one type: [{names}]"
        )
    return interface_class(types[0], 'msg', f"The message type '{types[0]}' is invalid")


def not_published_warning(topic: str) -> str:
    """Return the warning about a topic without a type."""
    return f'WARNING: topic [{topic}] does not appear to be published yet'
