# SPDX-License-Identifier: Apache-2.0
"""`ros2 topic hz`."""

import math
import time
from argparse import Namespace
from collections import deque
from typing import Any

from rclpy.qos import qos_profile_sensor_data

from rocsafe_ros.domain.discovery import OTHERS_LIMIT_S, wait_for
from rocsafe_ros2cli.command_node import command_node
from rocsafe_ros2cli.names import not_published_warning, topic_class

DEFAULT_WINDOW = 10000
REPORT_PERIOD_NS = 1_000_000_000


class RateMeter:
    """Rate of arrivals over the last `window` intervals, reported once a second."""

    def __init__(self, window: int) -> None:
        self._intervals_ns: deque[int] = deque(maxlen=window)
        self._last_ns: int | None = None
        self._reported_ns: int | None = None

    def arrive(self, time_ns: int) -> str:
        """Record an arrival; return the report if one is due, else an empty text."""
        if self._last_ns is not None:
            self._intervals_ns.append(time_ns - self._last_ns)
            if self._reported_ns is None:
                self._reported_ns = time_ns
        self._last_ns = time_ns
        if self._reported_ns is None or time_ns < self._reported_ns + REPORT_PERIOD_NS:
            return ''
        self._reported_ns = time_ns
        return self._report()

    def _report(self) -> str:
        """Return rate and spread of the intervals."""
        intervals_s = [interval * 1e-9 for interval in self._intervals_ns]
        count = len(intervals_s)
        mean_s = sum(intervals_s) / count
        rate_hz = 1.0 / mean_s if mean_s > 0.0 else 0.0
        deviation_s = math.sqrt(sum((one - mean_s) ** 2 for one in intervals_s) / count)
        return (
            f'average rate: {rate_hz:.3f}\n\tmin: {min(intervals_s):.3f}s '
            f'max: {max(intervals_s):.3f}s std dev: {deviation_s:.5f}s window: {count}'
        )


def print_rates(options: Namespace) -> None:
    """Print the rate once a second until Ctrl-C."""
    meter = RateMeter(options.window)

    def take(_message: Any) -> None:
        if report := meter.arrive(time.monotonic_ns()):
            print(report)

    with command_node() as holder:
        message_type = _await_type(holder.node, options.topic_name)
        holder.node.create_subscription(
            message_type, options.topic_name, take, qos_profile_sensor_data
        )
        holder.spin_until(lambda: False)


def _await_type(node: Any, topic: str) -> Any:
    """Return the class of the messages as soon as the topic appears; print that we wait."""
    if not wait_for(lambda: topic_class(node, topic) is not None, OTHERS_LIMIT_S):
        print(not_published_warning(topic))
        wait_for(lambda: topic_class(node, topic) is not None, math.inf)
    return topic_class(node, topic)
