# SPDX-License-Identifier: Apache-2.0
"""Telemetry of a simulated vehicle."""

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from nav_msgs.msg import Path
from std_msgs.msg import Header

from rocsafe_geo.motion.state import Enu
from rocsafe_interfaces.msg import VehicleState
from rocsafe_ros.conversions import (
    MAP_FRAME,
    fix_message,
    odometry_message,
    path_pose,
    point_of_position,
    stamp_of_ns,
    vehicle_diagnostic,
    velocity_message,
)
from rocsafe_ros.domain.audience import Audience
from rocsafe_ros.frames import VehicleFrames
from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_sim.clock.cadence import Cadence
from rocsafe_sim.flight.route import FlightRoute
from rocsafe_sim.messages.conversions import STATES, battery_message, ending_of, waiting_text
from rocsafe_sim.messages.marker_conversions import route_markers
from rocsafe_sim.rav.rav import Rav
from rocsafe_sim.vehicle.snapshot import VehicleSnapshot

SLOW_PERIOD_NS = 1_000_000_000
# Period of a track without subscribers, for those who subscribe later.
UNSEEN_PATH_PERIOD_NS = 10_000_000_000
# Standard deviations of the ground truth.
EXACT_M = (0.0, 0.0)


class Telemetry:
    """Publishes where a vehicle is, its battery, state, track, home and route."""

    def __init__(
        self, node: VehicleScopeNode, rav: Rav, fix_period_ns: int, frames: VehicleFrames
    ) -> None:
        self._frames = frames
        self._rav = rav
        self._fixes = Cadence(fix_period_ns)
        self._slow = Cadence(SLOW_PERIOD_NS)
        self._unseen_path = Cadence(UNSEEN_PATH_PERIOD_NS)
        self._name = rav.parts.name
        self._truth = topics.create_publisher(node, topics.GROUND_TRUTH_FIX)
        self._fix = topics.create_publisher(node, topics.FIX)
        self._velocity = topics.create_publisher(node, topics.VELOCITY)
        self._odom = topics.create_publisher(node, topics.ODOM)
        self._battery = topics.create_publisher(node, topics.BATTERY_STATE)
        self._state = topics.create_publisher(node, topics.STATE)
        self._home = topics.create_publisher(node, topics.HOME)
        self._path = topics.create_publisher(node, topics.PATH)
        self._viewers = Audience(node, self._path)
        self._markers = topics.create_publisher(node, topics.ROUTE_MARKERS)
        self._track = Path(header=Header(frame_id=MAP_FRAME))
        self._said: tuple[object, ...] = ()
        self._last: VehicleState | None = None
        self._shown: FlightRoute | None = None
        self._told_home: Enu | None = None

    def health(self) -> DiagnosticStatus | None:
        """Return the status of the vehicle, None before its first state."""
        return vehicle_diagnostic(self._last) if self._last is not None else None

    def publish(self, seen: VehicleSnapshot) -> None:
        """Publish what is due at a step, position first."""
        stamp = stamp_of_ns(seen.time_ns)
        if self._fixes.is_due(seen.time_ns):
            self._publish_motion(seen, stamp)
        if self._slow.is_due(seen.time_ns):
            power = self._rav.vehicle.airframe.power
            self._battery.publish(battery_message(seen, power, stamp, f'{self._name}/base_link'))
            self._publish_path(seen, stamp)
            self._publish_state(seen, stamp)
        elif self._news(seen) != self._said:
            self._publish_state(seen, stamp)
        self._publish_markers()
        self._publish_home()

    def publish_state(self, seen: VehicleSnapshot) -> None:
        """Publish the state between two steps, if a command or a receipt changed it."""
        if self._news(seen) != self._said:
            self._publish_state(seen, stamp_of_ns(seen.time_ns))
        self._publish_home()

    def _publish_motion(self, seen: VehicleSnapshot, stamp: Time) -> None:
        fix = self._rav.fix(seen.time_ns, seen.pose.position_enu)
        gps, noise, pose = f'{self._name}/gps', self._rav.parts.noise, seen.pose
        std_m = (noise.gps_horizontal_std_m, noise.gps_vertical_std_m)
        self._truth.publish(fix_message(fix.true_position, stamp, gps, EXACT_M))
        self._fix.publish(fix_message(fix.position, stamp, gps, std_m))
        self._velocity.publish(velocity_message(pose.velocity_enu, stamp))
        odometry = odometry_message(
            fix.position_enu, pose.yaw_rad, pose.velocity_enu, stamp, self._name
        )
        self._odom.publish(odometry)
        self._frames.move(odometry)

    def _publish_state(self, seen: VehicleSnapshot, stamp: Time) -> None:
        self._said = self._news(seen)
        flight = self._rav.vehicle.flight
        fix = self._rav.fix(seen.time_ns, seen.pose.position_enu)
        message = VehicleState(
            header=Header(stamp=stamp, frame_id=f'{self._name}/base_link'),
            vehicle=self._name,
            state=STATES[seen.mode],
            is_simulated=True,
            viewpoints_visited=seen.viewpoints_visited,
            shots_taken=self._rav.shots_taken,
            shots_pending=len(self._rav.shots),
            battery_fraction=seen.battery_fraction,
            distance_flown_m=seen.distance_flown_m,
            position=point_of_position(fix.position),
            speed_mps=seen.pose.speed_mps,
        )
        if flight is not None:
            message.plan_id = flight.route.plan_id
            message.viewpoint_count = len(flight.route.waypoints)
            message.ending = ending_of(flight)
            message.text = flight.text or waiting_text(flight.command.number, seen.waits_s)
        self._state.publish(message)
        self._last = message

    def _news(self, seen: VehicleSnapshot) -> tuple[object, ...]:
        flight = self._rav.vehicle.flight
        why = None if flight is None else (flight.route.plan_id, flight.text, ending_of(flight))
        stands = self._rav.vehicle.stands
        return (
            seen.mode,
            stands,
            seen.viewpoints_visited,
            seen.shots_taken,
            len(self._rav.shots),
            why,
        )

    def _publish_path(self, seen: VehicleSnapshot, stamp: Time) -> None:
        if not seen.mode.is_airborne:
            return
        self._track.header.stamp = stamp
        self._track.poses.append(path_pose(seen.pose.position_enu, stamp))
        if self._unseen_path.is_due(seen.time_ns) or self._viewers.is_watching:
            self._path.publish(self._track)

    def _publish_home(self) -> None:
        home = self._rav.vehicle.home_enu
        if home != self._told_home:
            self._told_home = home
            self._home.publish(point_of_position(self._rav.parts.frame.position_of(home)))

    def _publish_markers(self) -> None:
        flight = self._rav.vehicle.flight
        if flight is not None and flight.route is not self._shown:
            self._shown = flight.route
            self._markers.publish(route_markers(flight.route))
