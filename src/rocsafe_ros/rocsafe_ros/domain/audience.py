# SPDX-License-Identifier: Apache-2.0
"""Subscribers of a topic that is costly to publish."""

from rclpy.node import Node
from rclpy.publisher import Publisher

# Nodes that take what is published and never ask for more: the recorders of this suite and of
# rosbag2, and the collector, which keeps the labels of the photographs taken at viewpoints.
RECORDERS = frozenset({'recorder', 'rosbag2_recorder', 'collector'})
# The name of a node of which only an endpoint is known so far.
_UNKNOWN = '_NODE_NAME_UNKNOWN_'


class Audience:
    """Tells whether anybody but a recorder subscribes to the topic of a publisher.

    A subscriber counts from when the name of its node is known, so that no recorder counts while
    it is being discovered. The graph is asked only when the number of subscribers has changed.
    """

    def __init__(self, node: Node, publisher: Publisher) -> None:
        self._node, self._publisher = node, publisher
        self._count = 0
        self._is_watching = False

    @property
    def is_watching(self) -> bool:
        """Whether a subscriber other than a recorder exists."""
        count = self._publisher.get_subscription_count()
        if count != self._count:
            found = self._node.get_subscriptions_info_by_topic(self._publisher.topic_name)
            names = [info.node_name for info in found]
            # Asked again until all are known.
            is_known = len(names) >= count and _UNKNOWN not in names
            self._count = count if is_known else -1
            self._is_watching = any(name not in {*RECORDERS, _UNKNOWN} for name in names)
        return self._is_watching
