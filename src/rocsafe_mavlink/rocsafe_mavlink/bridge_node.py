# SPDX-License-Identifier: Apache-2.0
"""The node ``bridge``: real vehicles, each in its own namespace, like simulated ones."""

import os
import time
from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from rocsafe_interfaces.msg import MissionState
from rocsafe_mavlink.assembly import (
    clock_warnings,
    make_drone,
    make_geotagger,
    make_stations,
)
from rocsafe_mavlink.bridge_options import BridgeOptions
from rocsafe_mavlink.camera.geotagging import Geotagger
from rocsafe_mavlink.camera.video_source import DECODER_OPTIONS
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.drone.standstill import Standstill, awake_s
from rocsafe_mavlink.drone_options import DroneOptions, read_drones
from rocsafe_mavlink.errors import MavlinkError
from rocsafe_mavlink.flight.late_start import LateStart
from rocsafe_mavlink.knowledge.events import Event
from rocsafe_mavlink.vehicle_interface.command_node import CommandServices
from rocsafe_mavlink.vehicle_interface.conversions import link_status
from rocsafe_mavlink.vehicle_interface.drive_route_node import DriveRouteServer
from rocsafe_mavlink.vehicle_interface.drone_node import TelemetryPublisher
from rocsafe_mavlink.vehicle_interface.fly_route_node import FlyRouteServer
from rocsafe_mavlink.vehicle_interface.node_timing import TIMING
from rocsafe_mavlink.vehicle_interface.route_goals_node import RouteGoals
from rocsafe_mavlink.vehicle_interface.shots_node import ShotSender
from rocsafe_mavlink.wire.dialect import Message
from rocsafe_ros.conversions import diagnostic
from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.server_node import LeaseServer
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.process.run import run


class DroneInterface:
    """All topics, services and the action in a vehicle's namespace."""

    def __init__(
        self,
        node: VehicleScopeNode,
        drone: Drone,
        geotagger: Geotagger,
        options: BridgeOptions,
        doubt: Callable[[], str],
        *,
        drives: bool,
    ) -> None:
        self.node = node
        self.drone = drone
        self.drives = drives
        self._master = ''
        folder = options.state_path(drone.spec.name)
        self._lease = LeaseServer(node, folder, doubt)
        self.shots = ShotSender(node, drone, geotagger, options.horizontal_fov_rad)
        self._telemetry = TelemetryPublisher(node, drone, lambda: self.shots.counts)
        self._commands = CommandServices(node, drone, self._lease, time.monotonic)
        self._routes: RouteGoals
        if drives:
            self._routes = DriveRouteServer(node, drone, self._lease)
        else:
            late_start = LateStart(None if folder is None else folder / 'late_start.json')
            self._routes = FlyRouteServer(node, drone, self._lease, self.shots.owed, late_start)
        drone.listen(self.on_message, self.on_event)

    def on_message(self, message: Message) -> None:
        """Take a message of the vehicle."""
        self._telemetry.on_message(message, time.monotonic())
        self.shots.on_message(message)

    def on_event(self, event: Event) -> None:
        """Take something that happened to the vehicle."""
        self._telemetry.on_event(event)

    def health(self) -> DiagnosticStatus | None:
        """Return the status of the vehicle, None before its first state."""
        return self._telemetry.health()

    def follow(self) -> None:
        """Publish what can wait until the fixes of all vehicles are published."""
        self._telemetry.follow()

    def step(self, now_s: float, time_s: float, *, is_supervised: bool) -> None:
        """Let time pass."""
        self.drone.step(now_s)
        self._watch_master()
        self._routes.step(now_s, is_supervised=is_supervised)
        self._commands.step()
        self._telemetry.step(now_s)
        self.shots.step(now_s, time_s)

    def _watch_master(self) -> None:
        """Make the lease void when a pilot or another station takes the vehicle."""
        kind, before = self.drone.session.known_autopilot(), self._master
        if kind is None:
            return
        self._master = self.drone.session.custody.new_master(self.drone.vehicle, kind)
        if self._master and self._master != before:
            self._lease.revoke(self._master)


class BridgeNode(Node):
    """Serves all drones of `drones_file`, each behind a node in its own namespace.

    Takes no part in lock-step: real vehicles fly by the clock on the wall. Subscribes:
    mission/state, if its supervisor is to be watched.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('bridge', **node_options)
        self._options = declare_options(self, BridgeOptions)
        self._standstill = Standstill()
        # A clock that is set in flight must not move the time stamps of signatures ahead: other
        # stations with the right time would be refused from then on.
        self._signed_less_awake_s = time.time() - awake_s()
        try:
            self._fleet = read_drones(self._options.drones_file)
            self._stations = make_stations(self._options, self._fleet)
            for line in clock_warnings(self._fleet, time.time()):
                self.get_logger().warning(line)
            self._interfaces = [
                self._interface(drone, node_options) for drone in self._fleet.drones
            ]
        except (MavlinkError, ValueError, OSError) as error:
            raise ParameterError(f'bridge: {error}') from error
        fliers = [interface.drone for interface in self._interfaces if not interface.drives]
        for drone in fliers:
            drone.others = fliers
        self._supervised_s = self._ticked_s = time.monotonic()
        if self._options.needs_supervisor:
            topics.create_subscription(self, topics.MISSION_STATE, self._on_mission)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(TIMING.poll_s, self._poll, clock=steady)

    @property
    def vehicle_nodes(self) -> list[VehicleScopeNode]:
        """Nodes in the namespaces of the drones."""
        return [interface.node for interface in self._interfaces]

    def destroy_node(self) -> None:
        """Close sockets, devices and cameras."""
        for station in self._stations.values():
            station.close()
        for interface in self._interfaces:
            interface.shots.close()
        super().destroy_node()

    def _interface(self, options: DroneOptions, node_options: dict[str, Any]) -> DroneInterface:
        drone = make_drone(options, self._options, self._stations[options.link])
        geotagger = make_geotagger(options, self._options, time.time)
        node = self._vehicle_node(drone, node_options)
        return DroneInterface(
            node, drone, geotagger, self._options, self._standstill.doubt, drives=options.drives
        )

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
        now_s, signed_s = time.monotonic(), self._signed_less_awake_s + awake_s()
        if gap_s := self._standstill.look():
            self._go_on_after(gap_s, now_s)
        for station in self._stations.values():
            if self._standstill.is_deaf:
                station.discard(now_s)
            else:
                station.take(now_s, signed_s)
        for interface in self._interfaces:
            interface.follow()
        if now_s - self._ticked_s >= TIMING.tick_s:
            self._ticked_s = now_s
            self._tick(now_s, signed_s)

    def _go_on_after(self, gap_s: float, now_s: float) -> None:
        """Begin anew with each vehicle: what waits in buffers is old, the oldest of it first."""
        reason = f'the bridge stood still for {gap_s:.0f} s'
        self.get_logger().error(f'{reason}: what was under way is withdrawn')
        for interface in self._interfaces:
            interface.drone.session.forget_contact(reason, now_s)

    def _tick(self, now_s: float, signed_s: float) -> None:
        is_watched = self._options.needs_supervisor
        is_supervised = not is_watched or now_s - self._supervised_s < TIMING.supervisor_lease_s
        for station in self._stations.values():
            station.tick(now_s, signed_s, is_supervised=is_supervised)
        for interface in self._interfaces:
            interface.step(now_s, time.time(), is_supervised=is_supervised)

    def health(self) -> list[DiagnosticStatus]:
        """Return its own status, those of its links and those of its vehicles."""
        now_s = time.monotonic()
        links = []
        for link, station in self._stations.items():
            names = {drone.name for drone in self._fleet.on(link)}
            contacts = {
                interface.drone.spec.name: interface.drone.vehicle.contact(now_s)
                for interface in self._interfaces
                if interface.drone.spec.name in names
            }
            heard = station.link
            links.append(link_status(link, contacts, heard.counters.by_name(), heard.fault))
        vehicles = (interface.health() for interface in self._interfaces)
        return [diagnostic('runs'), *links, *filter(None, vehicles)]


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
