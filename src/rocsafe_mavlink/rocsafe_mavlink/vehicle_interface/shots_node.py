# SPDX-License-Identifier: Apache-2.0
"""Sends the photographs of a real vehicle until each has a receipt."""

import time

from rocsafe_geo.evidence.shot import Shot
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_interfaces.msg import GeotaggedImage
from rocsafe_mavlink.camera.geotagging import GeotagContext, Geotagger
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.vehicle_interface.node_timing import TIMING
from rocsafe_mavlink.wire.dialect import Message
from rocsafe_ros.conversions import (
    camera_info_message,
    compressed_message,
    geotagged_message,
    shot_header,
)
from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.shot_delivery_node import ShotDelivery

# Standard deviation of an autopilot's attitude in quiet flight.
ATTITUDE_STD_RAD = 0.02


class ShotSender:
    """Publishes camera/* for each photograph, and camera/shot again until its receipt.

    Parameters
    ----------
    node
        Node in the vehicle's namespace.
    drone
        The vehicle.
    geotagger
        Makes the photographs of its camera.
    horizontal_fov_rad
        Angle across the image width.
    """

    def __init__(
        self,
        node: VehicleScopeNode,
        drone: Drone,
        geotagger: Geotagger,
        horizontal_fov_rad: float,
    ) -> None:
        self._node = node
        self._drone = drone
        self._geotagger = geotagger
        self._fov_rad = horizontal_fov_rad
        self._due_s = 0.0
        self._compressed = topics.create_publisher(node, topics.CAMERA_IMAGE_COMPRESSED)
        self._info = topics.create_publisher(node, topics.CAMERA_INFO)
        self._delivery = ShotDelivery(node, geotagger.numbering.store, self._message_of)

    @property
    def counts(self) -> tuple[int, int]:
        """Number of photographs taken, and of those not yet stored."""
        return self._geotagger.shot_count, self._geotagger.pending

    def owed(self, visited: int) -> int:
        """Return how many photographs of the flight, `visited` stops so far, must be stored."""
        return self._geotagger.owed(self._drone.assignment, visited)

    def on_message(self, message: Message) -> None:
        """Take a message of the vehicle."""
        assignment = self._drone.assignment
        plan_id = '' if assignment is None else assignment.plan_id
        self._geotagger.on_message(message, self._drone.vehicle, time.time(), plan_id)

    def step(self, now_s: float, time_s: float) -> None:
        """Publish what has come."""
        if now_s < self._due_s:
            return
        self._due_s = now_s + TIMING.image_look_s
        context = GeotagContext(
            vehicle=self._drone.spec.name,
            assignment=self._drone.assignment,
            gps=self._drone.vehicle.gps,
            clock_s=self._node.get_clock().now().nanoseconds / 1e9 - time_s,
        )
        for shot in self._geotagger.tagged(context, self._node.get_logger().error):
            self._info.publish(camera_info_message(self._lens_of(shot), shot_header(shot)))
            self._compressed.publish(compressed_message(shot))
            self._delivery.send(shot)

    def close(self) -> None:
        """Close the source of images."""
        self._geotagger.close()

    def _lens_of(self, shot: Shot) -> PinholeCamera:
        return PinholeCamera(self._fov_rad, shot.width_px, shot.height_px)

    def _message_of(self, shot: Shot) -> GeotaggedImage:
        return geotagged_message(shot, self._lens_of(shot), ATTITUDE_STD_RAD)
