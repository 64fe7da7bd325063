# SPDX-License-Identifier: Apache-2.0
"""The topic `cmd_vel` of a simulated vehicle."""

from collections.abc import Callable

from geometry_msgs.msg import TwistStamped

from rocsafe_ros.conversions import MAP_FRAME, ns_of_stamp
from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.control_lease import LeaseRefusedError
from rocsafe_ros.lease.server_node import LeaseServer
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.rav.rav import Rav
from rocsafe_sim.vehicle.velocity_follower import VelocityFollower

# Wall time between two lines about messages that are not obeyed.
QUIET_S = 5.0


class VelocityStream:
    """Follows cmd_vel from a `move` of kind FOLLOW until another order, or the end of its lease.

    Velocities are east, north, up in the frame `map`, or ahead, left, up in that of the vehicle.
    A message that is not obeyed counts as none: the vehicle stops at the deadline of the last one.

    Parameters
    ----------
    node
        Node in the namespace of the vehicle.
    rav
        The vehicle.
    lease
        Judges who may give orders.
    on_command
        Called after the vehicle got a command.
    """

    def __init__(
        self,
        node: VehicleScopeNode,
        rav: Rav,
        lease: LeaseServer,
        on_command: Callable[[], None],
    ) -> None:
        self._rav, self._lease, self._on_command = rav, lease, on_command
        self._log = node.get_logger()
        self._body = f'{rav.parts.name}/base_link'
        self._token = ''
        self._follower: VelocityFollower | None = None
        topics.create_subscription(node, topics.CMD_VEL, self._on_velocity)

    def begin(self, token: str, deadline_s: float) -> None:
        """Follow from now on; raises as `VelocityFollower` does."""
        self._follower = VelocityFollower(self._rav.vehicle, deadline_s)
        self._token = token

    def _on_velocity(self, message: TwistStamped) -> None:
        follower = self._follower
        if follower is None or follower.is_over:
            self._follower = None
            self._tell('is not followed: call move with kind FOLLOW first')
            return
        try:
            self._lease.require(self._token)
            self._obey(follower, message)
        except (LeaseRefusedError, CommandRefusedError, ValueError) as refusal:
            self._tell(f'is not obeyed: {refusal}')
            return
        self._on_command()

    def _obey(self, follower: VelocityFollower, message: TwistStamped) -> None:
        frame, twist = message.header.frame_id, message.twist
        if frame not in (MAP_FRAME, self._body):
            raise ValueError(f'frame_id is {frame!r}: must be {MAP_FRAME!r} or {self._body!r}')
        linear = twist.linear
        follower.follow(
            (linear.x, linear.y, linear.z),
            twist.angular.z,
            ns_of_stamp(message.header.stamp),
            is_of_body=frame == self._body,
        )

    def _tell(self, text: str) -> None:
        self._log.warning(f'{self._rav.parts.name}: cmd_vel {text}', throttle_duration_sec=QUIET_S)
