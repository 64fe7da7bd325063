# SPDX-License-Identifier: Apache-2.0
"""The node ``bridge``: real vehicles, each in its own namespace, as if they were simulated."""

import os
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from rocsafe_interfaces.msg import MissionState
from rocsafe_mavlink.assembly import make_drones, make_lines, make_photographer
from rocsafe_mavlink.bridge_options import BridgeOptions
from rocsafe_mavlink.camera.camera_trigger import Photographer
from rocsafe_mavlink.camera.video_stream import DECODER_OPTIONS
from rocsafe_mavlink.conversions import link_status
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.drone_node import DroneTelemetry
from rocsafe_mavlink.errors import MavlinkError
from rocsafe_mavlink.fly_route_node import FlyRouteServer
from rocsafe_mavlink.knowledge.events import Event
from rocsafe_mavlink.order_node import OrderServices
from rocsafe_mavlink.shots_node import ShotSender
from rocsafe_mavlink.wire.dialect import Message
from rocsafe_ros import topics
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.run import run
from rocsafe_ros.vehicle_scope import VehicleScopeNode

# Between two looks at the sockets: most of the time from a datagram to its topic.
POLL_S = 0.005
# Between two looks at what is due; nothing that a vehicle says waits for them.
TICK_S = 0.02
DIAGNOSE_S = 1.0
# The mission says twice a second that it lives.
SUPERVISOR_LEASE_S = 3.0


class DroneInterface:
    """Everything of a vehicle's namespace: topics, services and the action."""

    def __init__(
        self, node: VehicleScopeNode, drone: Drone, photographer: Photographer, fov_rad: float
    ) -> None:
        self.drone = drone
        self.shots = ShotSender(node, drone, photographer, fov_rad)
        self._telemetry = DroneTelemetry(node, drone, lambda: self.shots.counts)
        self._orders = OrderServices(node, drone, time.monotonic)
        self._flights = FlyRouteServer(node, drone, lambda: self.shots.delivered)

    def on_message(self, message: Message) -> None:
        """Take a message of the vehicle."""
        self.drone.on_message(message)
        self._telemetry.on_message(message, time.monotonic())
        self.shots.on_message(message)

    def on_event(self, event: Event) -> None:
        """Take something that happened to the vehicle."""
        self._telemetry.on_event(event)

    def follow(self) -> None:
        """Publish what can wait until the fixes of all vehicles are out."""
        self._telemetry.follow()

    def step(self, now_s: float, time_s: float) -> None:
        """Let time pass."""
        self.drone.step(now_s)
        self._flights.step(now_s, time_s)
        self._orders.step()
        self._telemetry.step(now_s)
        self.shots.step(now_s, time_s)


class BridgeNode(Node):
    """Serves all vehicles of `vehicles`, each behind a lean node in its own namespace.

    Takes no part in lock-step: real vehicles fly by the clock on the wall. Subscribes:
    mission/state, if its supervisor is to be watched. Publishes: /diagnostics.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('bridge', **node_options)
        self._options = declare_options(self, BridgeOptions)
        try:
            self._lines = make_lines(self._options)
            drones = make_drones(self._options, self._lines)
            photographers = [
                make_photographer(self._options, index, time.time) for index in range(len(drones))
            ]
        except (MavlinkError, ValueError, OSError) as error:
            raise ParameterError(f'bridge: {error}') from error
        self.vehicle_nodes = [self._vehicle_node(drone, node_options) for drone in drones]
        self._interfaces = [
            DroneInterface(node, drone, photographer, self._options.horizontal_fov_rad)
            for node, drone, photographer in zip(
                self.vehicle_nodes, drones, photographers, strict=True
            )
        ]
        for interface, link in zip(self._interfaces, self._options.links, strict=True):
            target = interface.drone.spec.target
            self._lines[link].listen(target, interface.on_message, interface.on_event)
        self._supervised_s = self._ticked_s = time.monotonic()
        if self._options.needs_supervisor:
            topics.create_subscription(self, topics.MISSION_STATE, self._on_mission)
        self._diagnostics = topics.create_publisher(self, topics.DIAGNOSTICS)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(POLL_S, self._poll, clock=steady)
        self.create_timer(DIAGNOSE_S, self._diagnose, clock=steady)

    def destroy_node(self) -> None:
        """Give sockets and devices back."""
        for line in self._lines.values():
            line.close()
        for interface in self._interfaces:
            interface.shots.close()
        super().destroy_node()

    def _vehicle_node(self, drone: Drone, node_options: dict[str, Any]) -> VehicleScopeNode:
        return VehicleScopeNode(
            'bridge',
            namespace=f'{self.get_namespace().rstrip("/")}/{drone.spec.name}',
            start_parameter_services=False,
            enable_rosout=False,
            use_global_arguments=False,
            **node_options,
        )

    def _on_mission(self, _state: MissionState) -> None:
        self._supervised_s = self._ticked_s = time.monotonic()

    def _poll(self) -> None:
        now_s, time_s = time.monotonic(), time.time()
        for line in self._lines.values():
            line.take(now_s, time_s)
        for interface in self._interfaces:
            interface.follow()
        if now_s - self._ticked_s >= TICK_S:
            self._ticked_s = now_s
            self._tick(now_s, time_s)

    def _tick(self, now_s: float, time_s: float) -> None:
        is_watched = self._options.needs_supervisor
        is_supervised = not is_watched or now_s - self._supervised_s < SUPERVISOR_LEASE_S
        for line in self._lines.values():
            line.tick(now_s, time_s, is_supervised=is_supervised)
        for interface in self._interfaces:
            interface.step(now_s, time_s)

    def _diagnose(self) -> None:
        now_s = time.monotonic()
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        for link, line in self._lines.items():
            contacts = {
                interface.drone.spec.name: interface.drone.vehicle.contact(now_s)
                for interface, name in zip(self._interfaces, self._options.links, strict=True)
                if name == link
            }
            message.status.append(
                link_status(link, contacts, line.station.link.counters.by_name())
            )
        self._diagnostics.publish(message)


def make_nodes() -> list[Node]:
    """Return the bridge's node and those of its vehicles."""
    bridge = BridgeNode()
    return [bridge, *bridge.vehicle_nodes]


def main() -> int:
    """Run the nodes until asked to stop."""
    os.environ.setdefault(*DECODER_OPTIONS)
    return run(make_nodes)


if __name__ == '__main__':
    raise SystemExit(main())
