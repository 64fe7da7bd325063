# SPDX-License-Identifier: Apache-2.0
"""What an agent hears from its vehicle."""

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.node import Node

from rocsafe_fleet.vehicle_link_node import SILENT_S, VehicleLink
from rocsafe_interfaces.msg import VehicleState
from rocsafe_ros.interfaces import topics
from rocsafe_ros.lease.holder_node import Leases

DEADLINE_S = 30.0


def test_a_vehicle_that_was_left_out_is_silent_until_it_is_heard_again(ros):
    """In the air or on the ground; what it said before does not count."""
    node = Node('agents', context=ros.context)
    vehicle = Node('rav1_node', context=ros.context)
    now_s = 100.0
    leases = Leases(node, ('rav1',), 'mission', print, role='agent', is_reserve=True)
    link = VehicleLink(node, 'rav1', leases, 'mission', lambda: now_s, is_real=False)
    states = topics.create_publisher(vehicle, topics.STATE, 'rav1')
    for one in (node, vehicle):
        ros.executor.add_node(one)

    def hears(state: int) -> None:
        link.state = None

        def is_heard() -> bool:
            states.publish(VehicleState(vehicle='rav1', state=state))
            return link.state is not None

        ros.spin_until(is_heard, DEADLINE_S)

    hears(VehicleState.WAITING)
    now_s = 200.0
    assert not link.is_silent(now_s)  # it waits on the ground
    link.leave_out()
    assert link.is_silent(now_s)
    now_s = 201.0
    hears(VehicleState.HOLDING)
    assert not link.is_silent(now_s)
    assert link.is_silent(now_s + SILENT_S + 1.0)
    link.close()
