# SPDX-License-Identifier: Apache-2.0
"""The gimbals of a vehicle's cameras: pointed by a topic, heard by another."""

import asyncio

from rclpy.node import Node
from rclpy.publisher import Publisher

from rocsafe_airsim.errors import AirsimError
from rocsafe_interfaces.msg import GimbalCommand, GimbalState
from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.interface_spec import of_camera

# A gimbal turns by some 60 degrees a second of mission time; a world may be slow.
SETTLE_S, LOOK_S = 30.0, 0.02
SAME_RAD = 1e-6
Target = tuple[float, float]


class Gimbals:
    """Points the cameras of one vehicle that have a gimbal.

    Parameters
    ----------
    node
        Node that publishes and listens.
    vehicle
        Name of the vehicle.
    """

    def __init__(self, node: Node, vehicle: str) -> None:
        self._node, self._vehicle = node, vehicle
        self._states: dict[str, GimbalState] = {}
        self._commands: dict[str, Publisher] = {}

    def add(self, camera: str) -> None:
        """Use the gimbal of a camera, if it has one."""
        state = of_camera(topics.GIMBAL_STATE, camera)
        topics.create_subscription(self._node, state, self._on_state, self._vehicle)
        command = of_camera(topics.GIMBAL_COMMAND, camera)
        self._commands[camera] = topics.create_publisher(self._node, command, self._vehicle)

    async def point(self, camera: str, pitch_rad: float, yaw_rad: float) -> None:
        """Point a camera: pitch above the horizon, yaw from the nose, anticlockwise.

        Raises
        ------
        AirsimError
            If it has no gimbal, or does not come to rest there.
        """
        if camera not in self._states:
            raise AirsimError(f'{self._vehicle}: {camera} has no gimbal: it cannot be turned')
        wanted, before = (pitch_rad, yaw_rad), _target(self._states[camera])
        command = GimbalCommand(pitch_rad=pitch_rad, yaw_rad=yaw_rad)
        self._commands[camera].publish(command)
        end_s = asyncio.get_running_loop().time() + SETTLE_S
        while not self._rests(camera, wanted, before):
            if asyncio.get_running_loop().time() > end_s:
                raise AirsimError(f'{self._vehicle}: {camera} has not turned in {SETTLE_S:g} s')
            await asyncio.sleep(LOOK_S)

    def _rests(self, camera: str, wanted: Target, before: Target) -> bool:
        """Return whether it rests at a new target; limits may keep it from what was wanted."""
        state = self._states[camera]
        target = _target(state)
        is_wanted = all(abs(a - b) <= SAME_RAD for a, b in zip(target, wanted, strict=True))
        is_new = is_wanted or target != before
        return bool(state.is_settled) and is_new

    def _on_state(self, message: GimbalState) -> None:
        self._states[message.camera] = message


def _target(state: GimbalState) -> Target:
    return state.pitch_target_rad, state.yaw_target_rad
