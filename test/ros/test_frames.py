# SPDX-License-Identifier: Apache-2.0
"""The tree of frames is one, and puts things where they are."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import rotation_body_from_optical, rotation_of_quaternion
from rocsafe_geo.position import GeoPosition, ecef_m

DEADLINE_S = 30.0


def test_map_at_the_equator_lies_a_radius_away():
    """At latitude and longitude 0, up is x, east is y and north is z of the earth."""
    place, quaternion = LocalFrame(GeoPosition(0.0, 0.0, 0.0)).earth_pose()
    assert place == pytest.approx((6_378_137.0, 0.0, 0.0), abs=1e-6)
    rotation = rotation_of_quaternion(quaternion)
    assert rotation @ (0.0, 0.0, 1.0) == pytest.approx((1.0, 0.0, 0.0), abs=1e-12)
    assert rotation @ (1.0, 0.0, 0.0) == pytest.approx((0.0, 1.0, 0.0), abs=1e-12)


@given(
    st.floats(-89.0, 89.0), st.floats(-180.0, 180.0), st.floats(-100.0, 5000.0),
    st.tuples(*[st.floats(-1e4, 1e4)] * 3),
)  # fmt: skip
def test_pose_on_the_earth_is_that_of_the_frame(latitude, longitude, altitude, enu):
    """A place of the map, rotated and moved, is where the ellipsoid has it, to a millimetre."""
    frame = LocalFrame(GeoPosition(latitude, longitude, altitude))
    place, quaternion = frame.earth_pose()
    moved = rotation_of_quaternion(quaternion) @ np.array(enu) + place
    assert moved == pytest.approx(ecef_m(*frame.to_geodetic(enu)[0])[0], abs=1e-3)


def test_camera_looks_down():
    """The constant is the rotation of a camera whose image has its top towards the nose."""
    from rocsafe_ros.frames import LOOKS_DOWN

    wanted = rotation_body_from_optical()
    assert rotation_of_quaternion(LOOKS_DOWN) == pytest.approx(wanted, abs=1e-12)


def test_tree_is_one(ros):
    """Every frame has one parent, and all lead to the earth; each vehicle has its own."""
    from nav_msgs.msg import Odometry
    from rclpy.node import Node

    from rocsafe_ros.frames import LOOKS_DOWN, VehicleFrames, publish_origin
    from rocsafe_ros.interfaces import topics
    from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode

    listener = Node('listener', context=ros.context)
    vehicles = [
        VehicleScopeNode('rav', namespace=f'/rav{number}', context=ros.context)
        for number in (1, 2)
    ]
    nodes = [listener, *vehicles]
    for node in nodes:
        ros.executor.add_node(node)
    parents, seen = {}, set()

    def note(message):
        for transform in message.transforms:
            child, parent = transform.child_frame_id, transform.header.frame_id
            assert parents.setdefault(child, parent) == parent
            seen.add(child)

    topics.create_subscription(listener, topics.TF, note)
    topics.create_subscription(listener, topics.TF_STATIC, note)
    publish_origin(listener, LocalFrame(GeoPosition(53.28, -9.06, 66.0)))
    for node in vehicles:
        frames = VehicleFrames(node, {'camera_optical': LOOKS_DOWN})
        odometry = Odometry(child_frame_id=f'{node.vehicle_name}/base_link')
        odometry.pose.pose.position.x = 3.0
        ros.spin_until(lambda f=frames: f._moving.get_subscription_count() > 0, DEADLINE_S)
        frames.move(odometry)
    ros.spin_until(lambda: len(seen) == 11, DEADLINE_S)
    for number in (1, 2):
        for name in ('gps', 'radiation_sensor', 'camera_optical'):
            frame, way = f'rav{number}/{name}', []
            while frame in parents:
                frame = parents[frame]
                way.append(frame)
            assert way == [f'rav{number}/base_link', f'rav{number}/odom', 'map', 'earth']
    for node in nodes:
        ros.executor.remove_node(node)
        node.destroy_node()
