# SPDX-License-Identifier: Apache-2.0
"""Sends a vehicle's photographs until each has a receipt."""

import time
from collections.abc import Callable

from rclpy.clock import Clock, ClockType
from std_msgs.msg import String

from rocsafe_interfaces.msg import ShotReceipt
from rocsafe_ros import topics
from rocsafe_ros.vehicle_scope import VehicleScopeNode
from rocsafe_sim.camera import Truth
from rocsafe_sim.rav import Rav
from rocsafe_sim.shot import Shot
from rocsafe_sim.shot_conversions import (
    camera_info_message,
    compressed_message,
    depth_message,
    geotagged_message,
    labels_message,
    raw_image_message,
    shot_header,
)
from rocsafe_sim.shot_store import RESEND_S


class ShotSender:
    """Publishes camera/* at each capture, and camera/shot again until its receipt.

    Subscribes: shots/receipts. `on_receipt` is called after each receipt of an own photograph.
    """

    def __init__(self, node: VehicleScopeNode, rav: Rav, on_receipt: Callable[[], None]) -> None:
        self._log = node.get_logger()
        self._rav = rav
        self._on_receipt = on_receipt
        self._raw = topics.create_publisher(node, topics.CAMERA_IMAGE)
        self._compressed = topics.create_publisher(node, topics.CAMERA_IMAGE_COMPRESSED)
        self._info = topics.create_publisher(node, topics.CAMERA_INFO)
        self._depth = topics.create_publisher(node, topics.CAMERA_DEPTH)
        self._labels = topics.create_publisher(node, topics.CAMERA_LABELS)
        self._table = topics.create_publisher(node, topics.CAMERA_LABEL_TABLE)
        camera = rav.parts.camera
        if camera.label_table():
            self._table.publish(String(data=camera.label_table()))
        self._shot = topics.create_publisher(node, topics.SHOT)
        topics.create_subscription(node, topics.RECEIPTS, self._on_receipt_message)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        node.create_timer(0.5 * RESEND_S, self._resend, clock=steady)

    def publish(self, shot: Shot) -> None:
        """Publish a photograph just taken."""
        lens = self._rav.parts.camera.lens
        self._info.publish(camera_info_message(lens, shot_header(shot)))
        self._compressed.publish(compressed_message(shot))
        if self._raw.get_subscription_count() > 0:
            self._raw.publish(raw_image_message(shot))
        truth = self._rav.truth_of(shot)
        if truth is not None:
            self._publish_truth(shot, truth)
        self._send(shot)

    def _publish_truth(self, shot: Shot, truth: Truth) -> None:
        if self._depth.get_subscription_count() > 0:
            self._depth.publish(depth_message(shot, truth))
        if self._labels.get_subscription_count() > 0:
            self._labels.publish(labels_message(shot, truth))

    def _send(self, shot: Shot) -> None:
        parts = self._rav.parts
        self._shot.publish(geotagged_message(shot, parts.camera.lens, parts.noise))
        self._rav.shots.mark_sent(shot.shot_id, time.monotonic())

    def _resend(self) -> None:
        if self._shot.get_subscription_count() == 0:
            return
        for shot in self._rav.shots.overdue(time.monotonic()):
            self._send(shot)

    def _on_receipt_message(self, receipt: ShotReceipt) -> None:
        if receipt.vehicle != self._rav.parts.name:
            return
        if not self._rav.shots.take_receipt(receipt.shot_id, receipt.sha256):
            return
        if receipt.status == ShotReceipt.REJECTED:
            self._log.error(f'{receipt.shot_id} was rejected, it is lost: {receipt.reason}')
        self._on_receipt()
