# SPDX-License-Identifier: Apache-2.0
"""Publishes the telemetry of a real vehicle: fix, velocity, odom, battery, state, events."""

from collections.abc import Callable
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from nav_msgs.msg import Path
from std_msgs.msg import Float64, Header, UInt8MultiArray

from rocsafe_interfaces.msg import VehicleState
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.drone.station import TUNNEL
from rocsafe_mavlink.drone.status import DroneStatus, enu_of, fix_quality
from rocsafe_mavlink.knowledge.events import Event, EventKind
from rocsafe_mavlink.knowledge.telemetry import Motion
from rocsafe_mavlink.knowledge.traffic import encounters
from rocsafe_mavlink.protocols.stream_rates import POSITION
from rocsafe_mavlink.vehicle_interface.conversions import (
    battery_message,
    event_message,
    predicted_message,
    state_message,
    traffic_message,
)
from rocsafe_mavlink.vehicle_interface.node_timing import TIMING
from rocsafe_mavlink.wire.dialect import Message
from rocsafe_ros.conversions import (
    MAP_FRAME,
    fix_message,
    odometry_message,
    path_pose,
    point_of_position,
    vehicle_diagnostic,
    velocity_message,
)
from rocsafe_ros.domain.audience import Audience
from rocsafe_ros.frames import LOOKS_DOWN, VehicleFrames
from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.interface_spec import TopicSpec
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode

# Types of TUNNEL payloads up to this one are those of known devices.
LARGEST_REGISTERED_TYPE = 32_767


class TelemetryPublisher:
    """Publishes what a drone says, as soon as it says it.

    Publishes: fix, velocity, odom, /tf, rel_alt, heading at each position; state, battery_state,
    path, predicted_fix each second; state and events on change; home on change; traffic when
    heard.

    Parameters
    ----------
    node
        Node in the vehicle's namespace.
    drone
        The vehicle.
    shots
        Returns how many photographs were taken, and how many are not yet stored.
    """

    def __init__(
        self, node: VehicleScopeNode, drone: Drone, shots: Callable[[], tuple[int, int]]
    ) -> None:
        self._node = node
        self._drone = drone
        self._shots = shots
        self._name = drone.spec.name
        self._publishers: dict[str, Any] = {
            spec.name: topics.create_publisher(node, spec)
            for spec in (
                *(topics.FIX, topics.VELOCITY, topics.ODOM, topics.REL_ALT, topics.HEADING),
                *(topics.BATTERY_STATE, topics.STATE, topics.PATH, topics.PREDICTED_FIX),
                *(topics.EVENTS, topics.HOME, topics.TRAFFIC, topics.DETECTOR_BYTES),
            )
        }
        self._frames = VehicleFrames(node, {'camera_optical': LOOKS_DOWN})
        self._track = Path(header=Header(frame_id=MAP_FRAME))
        self._slow_s, self._path_s = -TIMING.slow_s, -TIMING.unseen_path_s
        self._viewers = Audience(node, self._publishers[topics.PATH.name])
        self._said: tuple[object, ...] = ()
        self._last: VehicleState | None = None
        self._texts_left = TIMING.texts_per_s
        self._following: list[tuple[Motion, Time]] = []

    def on_message(self, message: Message, now_s: float) -> None:
        """Publish the fix of a position; the rest of it waits for `follow`."""
        if message.name == TUNNEL:
            self._publish_bytes(message)
        motion, gps = self._drone.vehicle.motion, self._drone.vehicle.gps
        if message.name == 'ADSB_VEHICLE':
            self._publish_traffic(int(message['ICAO_address']), now_s)
        if message.name != POSITION or motion is None:
            return
        stamp = self._node.get_clock().now().to_msg()
        std_m = (gps.horizontal_std_m, gps.vertical_std_m)
        status = int(fix_quality(self._drone.vehicle, now_s))
        frame_id = f'{self._name}/gps'
        self._publish(topics.FIX, fix_message(motion.position, stamp, frame_id, std_m, status))
        self._following.append((motion, stamp))

    def _publish_bytes(self, message: Message) -> None:
        """Publish the bytes of a payload, unless its MAVLink type is that of another device."""
        kind = message['payload_type']
        if kind == 0 or kind > LARGEST_REGISTERED_TYPE:
            data = message['payload'][: message['payload_length']]
            self._publishers[topics.DETECTOR_BYTES.name].publish(UInt8MultiArray(data=data))

    def follow(self) -> None:
        """Publish the rest of the positions that have come: the fixes of all vehicles go first."""
        following, self._following = self._following, []
        for motion, stamp in following:
            place, velocity = enu_of(self._drone.spec.frame, motion), motion.velocity_enu_mps
            self._publish(topics.VELOCITY, velocity_message(velocity, stamp))
            odometry = odometry_message(place, motion.yaw_rad, velocity, stamp, self._name)
            self._publish(topics.ODOM, odometry)
            self._frames.move(odometry)
            self._publish(topics.REL_ALT, Float64(data=motion.height_above_home_m))
            self._publish(topics.HEADING, Float64(data=motion.heading_deg))

    def health(self) -> DiagnosticStatus | None:
        """Return the status of the vehicle, None before its first state."""
        return vehicle_diagnostic(self._last) if self._last is not None else None

    def on_event(self, event: Event) -> None:
        """Publish an event."""
        stamp = self._node.get_clock().now().to_msg()
        self._publish(topics.EVENTS, event_message(event, self._name, stamp))
        if event.kind is EventKind.HOME and self._drone.home is not None:
            self._publish(topics.HOME, point_of_position(self._drone.home))
        if event.kind is EventKind.TEXT and self._texts_left:
            self._texts_left -= 1
            self._node.get_logger().info(f'{self._name}: {event.text}')

    def step(self, now_s: float) -> None:
        """Publish what is due."""
        is_slow = now_s - self._slow_s >= TIMING.slow_s
        if not is_slow and self._drone.news() == self._said:
            return
        seen = self._drone.status(now_s)
        if is_slow:
            self._slow_s, self._texts_left = now_s, TIMING.texts_per_s
            self._publish_slow(seen, now_s)
        self._said = self._drone.news()
        stamp = self._node.get_clock().now().to_msg()
        self._last = state_message(seen, self._name, stamp, self._shots())
        self._publish(topics.STATE, self._last)

    def _publish_traffic(self, icao: int, now_s: float) -> None:
        vehicle = self._drone.vehicle
        stamp = self._node.get_clock().now().to_msg()
        for seen in encounters(vehicle, now_s):
            if seen.aircraft.icao == icao:
                separation_m = vehicle.geoid_separation_m
                said = traffic_message(seen, self._name, stamp, separation_m)
                self._publish(topics.TRAFFIC, said)

    def _publish_slow(self, seen: DroneStatus, now_s: float) -> None:
        stamp = self._node.get_clock().now().to_msg()
        self._publish(
            topics.BATTERY_STATE, battery_message(seen, stamp, f'{self._name}/base_link')
        )
        predicted = predicted_message(seen, stamp, f'{self._name}/gps')
        if predicted is not None:
            self._publish(topics.PREDICTED_FIX, predicted)
        if self._drone.is_in_air and seen.motion is not None:
            self._track.header.stamp = stamp
            self._track.poses.append(path_pose(seen.position_enu, stamp))
            del self._track.poses[: -TIMING.path_length]
            if self._viewers.is_watching or now_s - self._path_s >= TIMING.unseen_path_s:
                self._path_s = now_s
                self._publish(topics.PATH, self._track)

    def _publish(self, spec: TopicSpec, message: Any) -> None:
        self._publishers[spec.name].publish(message)
