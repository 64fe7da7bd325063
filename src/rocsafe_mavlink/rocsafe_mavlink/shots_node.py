# SPDX-License-Identifier: Apache-2.0
"""Sends the photographs of a real vehicle until each has a receipt."""

import time

from rocsafe_interfaces.msg import ShotReceipt
from rocsafe_mavlink.dialect import Message
from rocsafe_mavlink.drone import Drone
from rocsafe_mavlink.photographer import Exposure, Photographer
from rocsafe_mavlink.shot_conversions import (
    camera_info_message,
    compressed_message,
    geotagged_message,
)
from rocsafe_ros import topics
from rocsafe_ros.vehicle_scope import VehicleScopeNode

# A folder is looked at this often.
DEVELOP_S = 0.25


class ShotSender:
    """Publishes camera/* for each photograph, and camera/shot again until its receipt.

    Subscribes: shots/receipts.

    Parameters
    ----------
    node: in the vehicle's namespace.
    drone: the vehicle.
    photographer: follows its camera.
    horizontal_fov_rad: of the camera.
    """

    def __init__(
        self,
        node: VehicleScopeNode,
        drone: Drone,
        photographer: Photographer,
        horizontal_fov_rad: float,
    ) -> None:
        self._node = node
        self._drone = drone
        self._photographer = photographer
        self._fov_rad = horizontal_fov_rad
        self._due_s = 0.0
        self._compressed = topics.create_publisher(node, topics.CAMERA_IMAGE_COMPRESSED)
        self._info = topics.create_publisher(node, topics.CAMERA_INFO)
        self._shot = topics.create_publisher(node, topics.SHOT)
        topics.create_subscription(node, topics.RECEIPTS, self._on_receipt)

    @property
    def counts(self) -> tuple[int, int]:
        """Photographs taken, and those not yet stored."""
        return self._photographer.shot_count, len(self._photographer.store)

    @property
    def delivered(self) -> int:
        """Photographs that are, or will be, in the store."""
        return self._photographer.delivered

    def on_message(self, message: Message) -> None:
        """Take a message of the vehicle."""
        self._photographer.on_message(message, self._drone.vehicle, time.time())

    def step(self, now_s: float, time_s: float) -> None:
        """Publish what has come, and send again what has no receipt."""
        if now_s < self._due_s:
            return
        self._due_s = now_s + DEVELOP_S
        exposure = Exposure(
            vehicle=self._drone.spec.name,
            assignment=self._drone.assignment,
            gps=self._drone.vehicle.gps,
            clock_s=self._node.get_clock().now().nanoseconds / 1e9 - time_s,
        )
        for photograph in self._photographer.develop(exposure):
            self._info.publish(camera_info_message(photograph, self._fov_rad))
            self._compressed.publish(compressed_message(photograph))
        if self._shot.get_subscription_count():
            for photograph in self._photographer.store.overdue(now_s):
                self._shot.publish(geotagged_message(photograph, self._fov_rad))

    def close(self) -> None:
        """Give the source of pictures back."""
        self._photographer.close()

    def _on_receipt(self, receipt: ShotReceipt) -> None:
        if receipt.vehicle != self._drone.spec.name:
            return
        is_ours = self._photographer.store.take_receipt(receipt.shot_id, receipt.sha256)
        if is_ours and receipt.status == ShotReceipt.REJECTED:
            words = f'{receipt.shot_id} was rejected, it is lost: {receipt.reason}'
            self._node.get_logger().error(words)
