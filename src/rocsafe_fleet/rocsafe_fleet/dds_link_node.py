# SPDX-License-Identifier: Apache-2.0
"""Packets between agents over DDS: the topic ``fleet/delta``."""

from collections import deque

from rclpy.node import Node

from rocsafe_interfaces.msg import FleetPacket
from rocsafe_ros.interfaces import topics


class DdsLink:
    """Publishes and hears ``fleet/delta``, best effort; see `FleetLink`.

    Parameters
    ----------
    node
        Node that owns publisher and subscription.
    """

    def __init__(self, node: Node) -> None:
        self.bytes_sent = self.bytes_received = 0
        self._waiting: deque[bytes] = deque()
        self._packets = topics.create_publisher(node, topics.FLEET_DELTA)
        topics.create_subscription(node, topics.FLEET_DELTA, self._on_packet)

    def _on_packet(self, message: FleetPacket) -> None:
        self._waiting.append(bytes(message.data))

    def send(self, data: bytes) -> None:
        """Publish a packet."""
        self.bytes_sent += len(data)
        self._packets.publish(FleetPacket(data=data))

    def receive(self) -> list[bytes]:
        """Return the packets that have come since the last call, own ones included."""
        found = list(self._waiting)
        self._waiting.clear()
        self.bytes_received += sum(map(len, found))
        return found

    def close(self) -> None:
        """Do nothing: the node ends publisher and subscription."""
