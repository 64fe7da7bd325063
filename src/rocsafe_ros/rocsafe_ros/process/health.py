# SPDX-License-Identifier: Apache-2.0
"""Health of a node on /diagnostics: its own status, and those that it reports of others."""

import os
import time
from typing import Protocol, runtime_checkable

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from rocsafe_ros.conversions import diagnostic, key_values
from rocsafe_ros.domain.interface_versions import InterfaceVersions
from rocsafe_ros.interfaces import topics

PERIOD_S = 1.0


@runtime_checkable
class Examined(Protocol):
    """A node that knows more of its health than that it runs."""

    def health(self) -> list[DiagnosticStatus]:
        """Return its own status first, then those of vehicles or links that it serves."""


class HealthReporter:
    """Publishes the health of a node once a second of wall time.

    A node that has a method `health` is asked for its statuses; to the first one, the values that
    every node has are added. A node that works with others whose interfaces differ says so, in
    one line of its log for each of them, and its status is an error.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._started_s = time.monotonic()
        self._versions = InterfaceVersions(node)
        self._out = topics.create_publisher(node, topics.DIAGNOSTICS)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = node.create_timer(PERIOD_S, self._report, clock=steady)

    def close(self) -> None:
        """Report no more; the node may be destroyed now."""
        self._node.destroy_timer(self._timer)

    def _report(self) -> None:
        for line in self._versions.new_mismatches():
            self._node.get_logger().error(line)
        statuses = (
            self._node.health() if isinstance(self._node, Examined) else [diagnostic('runs')]
        )
        own = statuses[0]
        own.name = self._node.get_fully_qualified_name()
        own.hardware_id = own.hardware_id or os.uname().nodename
        if self._versions.mismatches:
            own.level = DiagnosticStatus.ERROR
            own.message = self._versions.mismatches[0]
        uptime_s = round(time.monotonic() - self._started_s, 1)
        own.values += key_values({'process_id': os.getpid(), 'uptime_s': uptime_s})
        message = DiagnosticArray(status=statuses)
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._out.publish(message)
