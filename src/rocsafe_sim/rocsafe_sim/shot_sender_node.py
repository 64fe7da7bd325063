# SPDX-License-Identifier: Apache-2.0
"""Publishes a simulated vehicle's photographs and what is true of them."""

from collections.abc import Callable

from std_msgs.msg import String

from rocsafe_geo.shot import Shot
from rocsafe_interfaces.msg import GeotaggedImage
from rocsafe_ros import topics
from rocsafe_ros.conversions import (
    camera_info_message,
    compressed_message,
    geotagged_message,
    shot_header,
)
from rocsafe_ros.shot_delivery_node import ShotDelivery
from rocsafe_ros.vehicle_scope import VehicleScopeNode
from rocsafe_sim.camera import Truth
from rocsafe_sim.rav import Rav
from rocsafe_sim.shot_conversions import depth_message, labels_message, raw_image_message


class ShotSender:
    """Publishes camera/* at each capture, and camera/shot again until its receipt.

    `on_receipt` is called after each receipt of an own photograph.
    """

    def __init__(self, node: VehicleScopeNode, rav: Rav, on_receipt: Callable[[], None]) -> None:
        self._rav = rav
        self._raw = topics.create_publisher(node, topics.CAMERA_IMAGE)
        self._compressed = topics.create_publisher(node, topics.CAMERA_IMAGE_COMPRESSED)
        self._info = topics.create_publisher(node, topics.CAMERA_INFO)
        self._depth = topics.create_publisher(node, topics.CAMERA_DEPTH)
        self._labels = topics.create_publisher(node, topics.CAMERA_LABELS)
        self._table = topics.create_publisher(node, topics.CAMERA_LABEL_TABLE)
        camera = rav.parts.camera
        if camera.label_table():
            self._table.publish(String(data=camera.label_table()))
        self._delivery = ShotDelivery(node, rav.shots, self._message_of, on_receipt)

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
        self._delivery.send(shot)

    def _publish_truth(self, shot: Shot, truth: Truth) -> None:
        if self._depth.get_subscription_count() > 0:
            self._depth.publish(depth_message(shot, truth))
        if self._labels.get_subscription_count() > 0:
            self._labels.publish(labels_message(shot, truth))

    def _message_of(self, shot: Shot) -> GeotaggedImage:
        parts = self._rav.parts
        return geotagged_message(shot, parts.camera.lens, parts.noise.attitude_std_rad)
