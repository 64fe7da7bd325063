# SPDX-License-Identifier: Apache-2.0
"""The node ``detector``: readings of a real detector from its lines."""

import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.clock import Clock, ClockType
from sensor_msgs.msg import NavSatFix
from std_msgs.msg import UInt8MultiArray

from rocsafe_radiation.acquisition.acquisition import Acquisition
from rocsafe_radiation.acquisition_conversions import (
    acquired_reading_of,
    health_event,
    health_status,
)
from rocsafe_radiation.conversions import coordinates_of_fix
from rocsafe_radiation.detector_options import DetectorOptions
from rocsafe_radiation.errors import DetectorLostError
from rocsafe_ros.conversions import diagnostic, has_position, ns_of_stamp
from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.process.run import run

POLL_S = 0.05
WATCH_S = 1.0


class DetectorNode(VehicleScopeNode):
    """Publishes the readings of one real detector; it is in the namespace of its vehicle.

    Subscribes in that namespace: ``fix``, and ``detector/bytes`` where the lines come in MAVLink
    TUNNEL messages. Publishes there: ``radiation``, and ``events`` when the detector falls silent
    or is heard again. Bad lines are counted and named, never guessed.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('detector', **node_options)
        if not self.vehicle_name:
            raise ParameterError('detector: must be in the namespace of a vehicle: -r __ns:=/rav1')
        options = declare_options(self, DetectorOptions)
        try:
            self._format = options.line_format()
            self._source = options.source(self.get_logger().info)
            self._acquisition = Acquisition(self._format, options.acquisition, time.time())
        except ValueError as error:
            raise ParameterError(f'detector: {error}') from error
        self._was_silent = False
        self._bad_told = 0
        self._readings = topics.create_publisher(self, topics.RADIATION)
        self._events = topics.create_publisher(self, topics.EVENTS)
        topics.create_subscription(self, topics.FIX, self._on_fix)
        if options.tunnel:
            topics.create_subscription(self, topics.DETECTOR_BYTES, self._on_bytes)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(POLL_S, self._poll, clock=steady)
        self.create_timer(WATCH_S, self._watch, clock=steady)

    def destroy_node(self) -> None:
        """Close the port."""
        if self._source is not None:
            self._source.close()
        super().destroy_node()

    def _on_fix(self, fix: NavSatFix) -> None:
        if has_position(fix):
            moment_s = ns_of_stamp(fix.header.stamp) / 1e9
            self._acquisition.add_place(moment_s, coordinates_of_fix(fix))

    def _on_bytes(self, message: UInt8MultiArray) -> None:
        self._acquisition.add_bytes(bytes(message.data), time.time())

    def _poll(self) -> None:
        try:
            pieces = [] if self._source is None else self._source.take(time.monotonic())
        except DetectorLostError as error:
            raise ParameterError(f'detector of {self.vehicle_name}: {error}') from error
        now_s = time.time()
        for piece in pieces:
            self._acquisition.add_bytes(piece, now_s)
        for acquired in self._acquisition.finished(now_s):
            self._readings.publish(
                acquired_reading_of(acquired, self.vehicle_name, self._format.name)
            )

    def health(self) -> list[DiagnosticStatus]:
        """Return its own status and that of the detector."""
        health = self._acquisition.health(time.time())
        return [diagnostic('runs'), health_status(health, self.vehicle_name)]

    def _watch(self) -> None:
        health, stamp = self._acquisition.health(time.time()), self.get_clock().now().to_msg()
        status = health_status(health, self.vehicle_name)
        if health.is_silent is not self._was_silent:
            self._was_silent = health.is_silent
            self.get_logger().warning(f'{self.vehicle_name}: {status.message}')
            self._events.publish(health_event(health, self.vehicle_name, stamp))
        bad = sum(health.bad.values())
        if bad >= 2 * self._bad_told + 1:
            self._bad_told = bad
            words = f'{self.vehicle_name}: {bad} bad lines, the last: {health.last_bad}'
            self.get_logger().warning(words)


def main() -> int:
    """Run the node until it is asked to stop."""
    return run(DetectorNode)


if __name__ == '__main__':
    raise SystemExit(main())
