# SPDX-License-Identifier: Apache-2.0
"""Delivery of the photographs of a simulated vehicle."""

from collections.abc import Callable

from rocsafe_geo.evidence.shot import Shot
from rocsafe_interfaces.msg import GeotaggedImage
from rocsafe_ros.conversions import geotagged_message
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.shot_delivery_node import ShotDelivery
from rocsafe_sim.rav.rav import Rav


def make_shot_delivery(
    node: VehicleScopeNode, rav: Rav, on_receipt: Callable[[], None]
) -> ShotDelivery:
    """Return the sender of the photographs of `rav`; `on_receipt` is called after each receipt."""
    noise = rav.parts.noise

    def message_of(shot: Shot) -> GeotaggedImage:
        camera = rav.parts.cameras[0].settings
        distortion = camera.effects.distortion
        return geotagged_message(shot, camera.lens, noise.attitude_std_rad, distortion)

    return ShotDelivery(node, rav.shots, message_of, on_receipt)
