# SPDX-License-Identifier: Apache-2.0
"""ROS interface of one simulated vehicle, in the node `rav` or `fleet`."""

from collections.abc import Callable
from dataclasses import replace

from diagnostic_msgs.msg import DiagnosticStatus

from rocsafe_geo.evidence.shot import Shot
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_ros.frames import VehicleFrames
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.server_node import LeaseServer
from rocsafe_sim.messages.picture_conversions import mounts_of
from rocsafe_sim.messages.sensor_conversions import sensor_mounts
from rocsafe_sim.rav.rav import Rav
from rocsafe_sim.vehicle.snapshot import VehicleSnapshot
from rocsafe_sim.vehicle_interface.camera_node import CameraInterface
from rocsafe_sim.vehicle_interface.command_node import CommandServices
from rocsafe_sim.vehicle_interface.fly_route_node import FlyRouteServer
from rocsafe_sim.vehicle_interface.light_node import LightService
from rocsafe_sim.vehicle_interface.order_answers_node import OrderAnswers
from rocsafe_sim.vehicle_interface.sensor_topics_node import SensorTopics
from rocsafe_sim.vehicle_interface.shot_sender_node import make_shot_delivery
from rocsafe_sim.vehicle_interface.telemetry_node import Telemetry


class VehicleInterface:
    """Topics, services and the action of the namespace of a vehicle.

    Publishes: ground_truth/fix, fix, velocity, odom, battery_state, state, path, route_markers,
    home, camera/*, control, /tf, /tf_static, and the topics of `SensorTopics`.
    Subscribes: shots/receipts, cmd_vel. Services: lease, set_light, and those of
    `CommandServices`. Action: fly_route.

    Parameters
    ----------
    node
        Node in the namespace of the vehicle.
    rav
        The vehicle with its sensors.
    fix_period_ns
        Simulated time between fixes, nanoseconds.
    on_busy
        Called when a command wakes an idle vehicle.

    Attributes
    ----------
    has_news
        Whether in the last step it announced an early end of its flight, or came to stand.
    lease
        Judges who may give orders.
    """

    def __init__(
        self,
        node: VehicleScopeNode,
        rav: Rav,
        fix_period_ns: int,
        on_busy: Callable[[], None],
    ) -> None:
        self._rav = rav
        self._log = node.get_logger()
        self._on_busy = on_busy
        self.has_news = False
        self._was_told: tuple[bool, bool] = (False, False)
        self._seen: VehicleSnapshot | None = None
        self._shots: list[Shot] = []
        rig = rav.parts.sensors.rig
        frames = VehicleFrames(node, {**mounts_of(rav.parts.cameras), **sensor_mounts(rig)})
        self._sensors = SensorTopics(node, rig)
        self._telemetry = Telemetry(node, rav, fix_period_ns, frames)
        self._delivery = make_shot_delivery(node, rav, self._publish_state)
        self._light = LightService(node, rav)
        self._cameras = [CameraInterface(node, rav, each, frames) for each in rav.parts.cameras]
        self.lease = LeaseServer(node, rav.spool)
        self._flights = FlyRouteServer(node, rav, self.lease, self._after_command)
        answers = OrderAnswers(rav.parts.name, self._after_command, self._flights)
        self._commands = CommandServices(node, rav, self.lease, answers, self._after_command)
        self._publish_state()

    def health(self) -> DiagnosticStatus | None:
        """Return the status of the vehicle, None before its first state."""
        return self._telemetry.health()

    def step(self, time_ns: int) -> bool:
        """Advance the vehicle to `time_ns` and publish all of it; return whether it is idle."""
        self.advance(time_ns)
        self.publish()
        return self.is_idle

    @property
    def is_idle(self) -> bool:
        """Whether nothing happens until the next command."""
        return self._rav.vehicle.is_idle

    def look_ahead(self) -> None:
        """Compute what an order has left to the next step."""
        self._rav.vehicle.look_ahead()

    def advance(self, time_ns: int) -> None:
        """Advance the vehicle to `time_ns`; `publish` follows, orders may come in between."""
        vehicle = self._rav.vehicle
        if time_ns < vehicle.time_ns:
            self._log.warning('time ran backwards: waiting until it is back', once=True)
            return
        missed_ns = self._rav.hold_if_cut_off(time_ns)
        if missed_ns:
            text = f'cut off for {missed_ns / NS_PER_S:.1f} s, holds'
            self._log.warning(f'{self._rav.parts.name}: {text}')
        self._seen, self._shots = self._rav.step(time_ns)
        told = (vehicle.ends_early, vehicle.stands)
        self.has_news = any(now > before for now, before in zip(told, self._was_told, strict=True))
        self._was_told = told

    def publish(self) -> None:
        """Publish what the last step was: once."""
        seen, self._seen = self._seen, None
        if seen is None:
            return
        self._telemetry.publish(seen)
        self._sensors.publish(self._rav.readings)
        self._publish_pictures(self._shots)
        for camera in self._cameras:
            camera.after_step(seen)
        self._flights.after_step(seen.time_ns)

    def _publish_pictures(self, shots: list[Shot]) -> None:
        """Publish the images of viewpoints; the first camera takes the photographs."""
        jpegs: dict[int, bytes | None] = {shot.time_ns: shot.jpeg for shot in shots}
        for camera, own in zip(self._cameras, self._rav.parts.cameras, strict=True):
            for picture in self._rav.pictures_of(own):
                camera.publish(picture, jpegs[picture.time_ns])
            jpegs = dict.fromkeys(jpegs)
        for shot in shots:
            self._delivery.send(shot)

    def _publish_state(self) -> None:
        self._telemetry.publish_state(self._rav.vehicle.observe())

    def _after_command(self) -> None:
        self._rav.keep_journal()
        if self._seen is not None:
            # The step that is still to be published must not tell the state before the order.
            self._seen = replace(self._rav.vehicle.observe(), pose=self._seen.pose)
        self._publish_state()
        if not self._rav.vehicle.is_idle:
            self._on_busy()
