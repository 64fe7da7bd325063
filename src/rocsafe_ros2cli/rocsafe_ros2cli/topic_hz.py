# SPDX-License-Identifier: Apache-2.0
"""`ros2 topic hz`."""

import math
from argparse import ArgumentParser, Namespace
from collections import deque
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.qos import qos_profile_sensor_data

from rocsafe_ros2cli.argument_types import positive_int
from rocsafe_ros2cli.command import Verb
from rocsafe_ros2cli.command_node import add_node_arguments, command_node
from rocsafe_ros2cli.discovery import OTHERS_LIMIT_S, wait_for
from rocsafe_ros2cli.message_filter import add_filter_argument, passes
from rocsafe_ros2cli.topic_graph import not_published_warning, topic_class

DEFAULT_WINDOW = 10000
REPORT_PERIOD_NS = 1_000_000_000


class RateMeter:
    """Rate of arrivals over the last `window` intervals, reported once a second."""

    def __init__(self, window: int) -> None:
        self._intervals_ns: deque[int] = deque(maxlen=window)
        self._last_ns: int | None = None
        self._reported_ns: int | None = None

    def arrive(self, time_ns: int) -> str:
        """Note an arrival; return the report if one is due, else an empty text."""
        if time_ns == 0:
            return self._reset()
        if self._last_ns is None or time_ns < self._last_ns:
            self._intervals_ns.clear()
        else:
            self._intervals_ns.append(time_ns - self._last_ns)
        self._last_ns = time_ns
        return self._report_if_due(time_ns)

    def _reset(self) -> str:
        """Forget what a clock said that started again."""
        had_intervals = bool(self._intervals_ns)
        self._intervals_ns.clear()
        return 'time has reset, resetting counters' if had_intervals else ''

    def _report_if_due(self, time_ns: int) -> str:
        """Return the report once a second, counted from the second arrival."""
        if not self._intervals_ns:
            return ''
        if self._reported_ns is None or self._reported_ns > time_ns:
            self._reported_ns = time_ns
            return ''
        if time_ns < self._reported_ns + REPORT_PERIOD_NS:
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


def _add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `hz`."""
    parser.add_argument('topic_name', help="Name of the topic (e.g. '/chatter')")
    parser.add_argument(
        '--window',
        '-w',
        metavar='WINDOW',
        type=positive_int,
        default=DEFAULT_WINDOW,
        help='Number of intervals the rate is taken over (default: %(default)s)',
    )
    add_filter_argument(parser)
    parser.add_argument('--wall-time', action='store_true', help='Use wall time')
    add_node_arguments(parser)


def _hz(options: Namespace) -> int:
    """Print the rate once a second until Ctrl-C."""
    meter = RateMeter(options.window)
    with command_node(use_sim_time=options.use_sim_time) as holder:
        clock = Clock(clock_type=ClockType.SYSTEM_TIME)
        if not options.wall_time:
            clock = holder.node.get_clock()

        def take(message: Any) -> None:
            if passes(options.condition, message):
                report = meter.arrive(clock.now().nanoseconds)
                if report:
                    print(report)

        message_type = _await_type(holder.node, options.topic_name)
        holder.node.create_subscription(
            message_type, options.topic_name, take, qos_profile_sensor_data
        )
        holder.spin_until(lambda: False)
    return 0


def _await_type(node: Any, topic: str) -> Any:
    """Return the class of the messages as soon as the topic appears; say that we wait."""
    if not wait_for(lambda: topic_class(node, topic) is not None, OTHERS_LIMIT_S):
        print(not_published_warning(topic))
        wait_for(lambda: topic_class(node, topic) is not None, math.inf)
    return topic_class(node, topic)


VERB = Verb(
    name='hz',
    summary='Print the average publishing rate to screen',
    add_arguments=_add_arguments,
    run=_hz,
)
