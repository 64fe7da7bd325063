# SPDX-License-Identifier: Apache-2.0
"""ROS interface of a simulated ground vehicle: telemetry, commands, photographs."""

from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from nav_msgs.msg import Path
from std_msgs.msg import Header

from rocsafe_geo.evidence.shot import Shot
from rocsafe_geo.motion.state import Enu
from rocsafe_interfaces.msg import GeotaggedImage, VehicleState
from rocsafe_ros.conversions import (
    MAP_FRAME,
    fix_message,
    geotagged_message,
    odometry_message,
    path_pose,
    point_of_position,
    stamp_of_ns,
    vehicle_diagnostic,
    velocity_message,
)
from rocsafe_ros.frames import VehicleFrames
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.server_node import LeaseServer
from rocsafe_ros.shot_delivery_node import ShotDelivery
from rocsafe_sim.clock.cadence import Cadence
from rocsafe_sim.driving.rgv import Rgv
from rocsafe_sim.messages.drive_conversions import drive_battery, drive_state_message
from rocsafe_sim.messages.picture_conversions import mounts_of
from rocsafe_sim.vehicle_interface.drive_route_node import DriveRouteServer
from rocsafe_sim.vehicle_interface.order_answers_node import OrderAnswers

SLOW_PERIOD_NS = 1_000_000_000
EXACT_M = (0.0, 0.0)


class RgvInterface:
    """Topics, services and the action of the namespace of a ground vehicle.

    Publishes: ground_truth/fix, fix, velocity, odom, battery_state, state, path, home,
    camera/shot, control, /tf, /tf_static. Subscribes: shots/receipts. Services: lease, hold,
    return_home, resume, set_speed. Action: drive_route.

    Parameters
    ----------
    node
        Node in the namespace of the vehicle.
    rgv
        The vehicle.
    fix_period_ns
        Simulated time between fixes, nanoseconds.
    on_busy
        Called when a command wakes an idle vehicle.
    """

    def __init__(
        self, node: VehicleScopeNode, rgv: Rgv, fix_period_ns: int, on_busy: Callable[[], None]
    ) -> None:
        self._rgv, self._on_busy = rgv, on_busy
        self._fixes, self._slow = Cadence(fix_period_ns), Cadence(SLOW_PERIOD_NS)
        self._frames = VehicleFrames(node, mounts_of((rgv.camera,)))
        self._publish_to(node)
        self._track = Path(header=Header(frame_id=MAP_FRAME))
        self._said: tuple[object, ...] = ()
        self._last: VehicleState | None = None
        self._delivery = ShotDelivery(node, rgv.shots, self._shot_message, self.publish_state)
        lease = LeaseServer(node, rgv.spool)
        self._drives = DriveRouteServer(node, rgv, lease, self._after_command)
        self._serve(node, lease)
        self.publish_state()

    def _publish_to(self, node: VehicleScopeNode) -> None:
        self._truth = topics.create_publisher(node, topics.GROUND_TRUTH_FIX)
        self._fix = topics.create_publisher(node, topics.FIX)
        self._velocity = topics.create_publisher(node, topics.VELOCITY)
        self._odom = topics.create_publisher(node, topics.ODOM)
        self._battery = topics.create_publisher(node, topics.BATTERY_STATE)
        self._state = topics.create_publisher(node, topics.STATE)
        self._path = topics.create_publisher(node, topics.PATH)
        home = topics.create_publisher(node, topics.HOME)
        place: Enu = (*self._rgv.rover.home, 0.0)
        home.publish(point_of_position(self._rgv.frame.position_of(place)))

    def _serve(self, node: VehicleScopeNode, lease: LeaseServer) -> None:
        rover = self._rgv.rover
        answers = OrderAnswers(self._rgv.name, self._after_command, self._drives)
        for spec, command in ((calls.HOLD, rover.hold), (calls.RETURN_HOME, rover.return_home)):
            node.create_service(spec.call_type, spec.name, answers.to_end(command))
        lease.serve(calls.RESUME, answers.to(lambda _request: rover.resume()))
        lease.serve(
            calls.SET_SPEED, answers.to(lambda request: rover.set_speed(request.speed_mps))
        )

    def health(self) -> DiagnosticStatus | None:
        """Return the status of the vehicle, None before its first state."""
        return vehicle_diagnostic(self._last) if self._last is not None else None

    def step(self, time_ns: int) -> None:
        """Advance the vehicle to `time_ns` and publish all of it."""
        shots = self._rgv.step(time_ns)
        stamp = stamp_of_ns(time_ns)
        if self._fixes.is_due(time_ns):
            self._publish_motion(stamp)
        if self._slow.is_due(time_ns):
            self._battery.publish(drive_battery(self._rgv, stamp))
            self._publish_path(stamp)
            self._said = ()
        self.publish_state()
        for shot in shots:
            self._delivery.send(shot)
        self._drives.after_step(time_ns)

    def publish_state(self) -> None:
        """Publish the state if it is new."""
        state = self._rgv.rover.state
        news = (state.mode, state.shots, len(self._rgv.shots), state.ledger.outcome)
        if news == self._said:
            return
        self._said = news
        self._last = drive_state_message(self._rgv, stamp_of_ns(state.time_ns))
        self._state.publish(self._last)

    def _publish_motion(self, stamp: Any) -> None:
        rgv, fix = self._rgv, self._rgv.fix()
        gps, noise = f'{rgv.name}/gps', rgv.noise
        std_m = (noise.gps_horizontal_std_m, noise.gps_vertical_std_m)
        self._truth.publish(fix_message(fix.true_position, stamp, gps, EXACT_M))
        self._fix.publish(fix_message(fix.position, stamp, gps, std_m))
        velocity = rgv.velocity_enu()
        self._velocity.publish(velocity_message(velocity, stamp))
        yaw = rgv.rover.state.looks_rad
        odometry = odometry_message(fix.position_enu, yaw, velocity, stamp, rgv.name)
        self._odom.publish(odometry)
        self._frames.move(odometry)

    def _publish_path(self, stamp: Any) -> None:
        if self._rgv.rover.is_idle:
            return
        self._track.header.stamp = stamp
        self._track.poses.append(path_pose(self._rgv.place_enu(), stamp))
        self._path.publish(self._track)

    def _shot_message(self, shot: Shot) -> GeotaggedImage:
        settings = self._rgv.camera.settings
        distortion = settings.effects.distortion
        std = self._rgv.noise.attitude_std_rad
        return geotagged_message(shot, settings.lens, std, distortion)

    def _after_command(self) -> None:
        self._rgv.keep_journal()
        self.publish_state()
        if not self._rgv.rover.is_idle:
            self._on_busy()
