# SPDX-License-Identifier: Apache-2.0
"""The tree of frames by REP 105: earth, map, and below it ``<vehicle>/odom`` of each vehicle.

``<vehicle>/base_link`` moves in ``<vehicle>/odom``; sensors are fixed to it, cameras on gimbals
turn. Positions come from satellites and do not drift, so that ``odom`` lies where ``map`` lies.
``base_link`` is level, as in the topic ``odom``: true attitudes are with the photographs.
"""

from collections.abc import Mapping

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Transform, TransformStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from rocsafe_geo.frame import LocalFrame
from rocsafe_ros.conversions import EARTH_FRAME, MAP_FRAME, quaternion_message
from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode

Rotation = tuple[float, float, float, float]
NO_ROTATION: Rotation = (0.0, 0.0, 0.0, 1.0)
# Sensors in the middle of the vehicle.
SENSORS = ('gps', 'radiation_sensor')
# A camera that looks straight down, the top of its image towards the nose.
LOOKS_DOWN: Rotation = (0.5**0.5, -(0.5**0.5), 0.0, 0.0)


class VehicleFrames:
    """Broadcasts the frames of one vehicle: /tf with each odometry, /tf_static once.

    Parameters
    ----------
    node
        Node in the vehicle's namespace.
    mounts
        Rotation (x, y, z, w) from a frame that is fixed to the vehicle to ``base_link``, by the
        name of the frame without the vehicle's.
    """

    def __init__(self, node: VehicleScopeNode, mounts: Mapping[str, Rotation]) -> None:
        self._vehicle = node.vehicle_name
        self._moving = topics.create_publisher(node, topics.TF)
        self._static = topics.create_publisher(node, topics.TF_STATIC)
        stamp = node.get_clock().now().to_msg()
        fixed = {**dict.fromkeys(SENSORS, NO_ROTATION), **mounts}
        odom = self._transform(MAP_FRAME, 'odom', NO_ROTATION, stamp)
        links = (
            self._transform(f'{self._vehicle}/base_link', name, turned, stamp)
            for name, turned in fixed.items()
        )
        self._static.publish(TFMessage(transforms=[odom, *links]))

    def move(self, odometry: Odometry) -> None:
        """Broadcast where the vehicle is."""
        pose = odometry.pose.pose
        transform = Transform(rotation=pose.orientation)
        to, place = transform.translation, pose.position
        to.x, to.y, to.z = place.x, place.y, place.z
        stamped = TransformStamped(
            header=Header(stamp=odometry.header.stamp, frame_id=f'{self._vehicle}/odom'),
            child_frame_id=odometry.child_frame_id,
            transform=transform,
        )
        self._moving.publish(TFMessage(transforms=[stamped]))

    def turn(self, name: str, rotation: Rotation, stamp: Time) -> None:
        """Broadcast the rotation of a frame on a gimbal to ``base_link``."""
        parent = f'{self._vehicle}/base_link'
        self._moving.publish(
            TFMessage(transforms=[self._transform(parent, name, rotation, stamp)])
        )

    def _transform(
        self, parent: str, name: str, rotation: Rotation, stamp: Time
    ) -> TransformStamped:
        return TransformStamped(
            header=Header(stamp=stamp, frame_id=parent),
            child_frame_id=f'{self._vehicle}/{name}',
            transform=Transform(rotation=quaternion_message(rotation)),
        )


def publish_origin(node: Node, frame: LocalFrame) -> None:
    """Broadcast the pose of the map on the earth; one node of a mission does so, once."""
    place, rotation = frame.earth_pose()
    transform = Transform(rotation=quaternion_message(rotation))
    to = transform.translation
    to.x, to.y, to.z = place
    stamped = TransformStamped(
        header=Header(stamp=node.get_clock().now().to_msg(), frame_id=EARTH_FRAME),
        child_frame_id=MAP_FRAME,
        transform=transform,
    )
    topics.create_publisher(node, topics.TF_STATIC).publish(TFMessage(transforms=[stamped]))
