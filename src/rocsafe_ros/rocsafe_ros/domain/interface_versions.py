# SPDX-License-Identifier: Apache-2.0
"""Comparison of the message types of nodes that meet, by the hashes of REP 2016."""

import time
from collections.abc import Iterable, Iterator
from typing import Any, Protocol

# Topics that are compared in one look: a recorder of a large fleet has thousands.
TOPICS_A_LOOK = 20
# The same while nothing has come since all were compared: a node may restart under its name.
TOPICS_A_LATER_LOOK = 1
# A look ends after this time: a topic takes 0.2 ms, and 10 ms in a fleet of 100 vehicles.
LOOK_S = 0.02
# A discovered endpoint without a hash has version 0.
_NO_VERSION = 0


class GraphNode(Protocol):
    """What is needed of a node: `rclpy.node.Node` has it."""

    publishers: Iterable[Any]
    subscriptions: Iterable[Any]

    def get_fully_qualified_name(self) -> str:
        """Return namespace and name."""

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        """Return name and namespace of every node that is known."""

    def get_publishers_info_by_topic(self, topic_name: str) -> list[Any]:
        """Return who publishes a topic."""

    def get_subscriptions_info_by_topic(self, topic_name: str) -> list[Any]:
        """Return who subscribes to a topic."""


class InterfaceVersions:
    """Finds nodes with another version of a message type on a topic of this node.

    Such nodes read each other's bytes wrongly, or not at all. Services and actions are not
    compared: the graph does not tell their hashes.
    """

    def __init__(self, node: GraphNode) -> None:
        self._node = node
        self._next = 0
        self._graph: object = None
        self._left = 0
        self._found: dict[tuple[str, str], str] = {}

    @property
    def mismatches(self) -> tuple[str, ...]:
        """One line for each node and type found so far."""
        return tuple(self._found.values())

    def new_mismatches(self) -> list[str]:
        """Check the next topics and return a line for each new node and type."""
        before, end_s = set(self._found), time.monotonic() + LOOK_S
        for topic in self._next_topics():
            for key, line in self._of_topic(topic):
                self._found.setdefault(key, line)
            self._next += 1
            self._left -= 1
            if time.monotonic() > end_s:
                break
        return [line for key, line in self._found.items() if key not in before]

    def _next_topics(self) -> list[str]:
        ends = (*self._node.publishers, *self._node.subscriptions)
        names = sorted({end.topic_name for end in ends})
        if not names:
            return []
        graph = (names, sorted(self._node.get_node_names_and_namespaces()))
        if graph != self._graph:
            self._graph, self._left = graph, len(names)
        count = TOPICS_A_LOOK if self._left > 0 else TOPICS_A_LATER_LOOK
        return [names[(self._next + k) % len(names)] for k in range(min(count, len(names)))]

    def _of_topic(self, topic: str) -> Iterator[tuple[tuple[str, str], str]]:
        own_name = self._node.get_fully_qualified_name()
        infos = [
            *self._node.get_publishers_info_by_topic(topic),
            *self._node.get_subscriptions_info_by_topic(topic),
        ]
        known = [info for info in infos if info.topic_type_hash.version != _NO_VERSION]
        own = {info.topic_type: _hash(info) for info in known if _name(info) == own_name}
        for info in known:
            wanted = own.get(info.topic_type)
            if wanted is not None and _hash(info) != wanted:
                yield (_name(info), info.topic_type), _line(info, own_name, topic)


def _line(info: Any, own_name: str, topic: str) -> str:
    return (
        f'{_name(info)} has another version of {info.topic_type} on {topic} than {own_name}: '
        'build both from the same version of rocsafe_interfaces'
    )


def _name(info: Any) -> str:
    return f'{info.node_namespace.rstrip("/")}/{info.node_name}'


def _hash(info: Any) -> bytes:
    return bytes(info.topic_type_hash.value)
