# SPDX-License-Identifier: Apache-2.0
"""The leases of a mission: whoever else takes one leads the vehicle from that moment on."""

from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.node import Node

from rocsafe_interfaces.srv import Lease
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.holder_node import RENEW_S, Leases
from rocsafe_ros.lease.server_node import LeaseServer

DEADLINE_S = RENEW_S / 2.0


class Hands:
    """A vehicle, the mission that leads it, and somebody else."""

    def __init__(self, ros: Any) -> None:
        self.ros = ros
        self.said: list[str] = []
        self.vehicle = VehicleScopeNode('vehicle', namespace='/rav1', context=ros.context)
        self.server = LeaseServer(self.vehicle, None)
        self.mission = Node('mission', context=ros.context)
        self.other = Node('other', context=ros.context)
        for node in (self.vehicle, self.mission, self.other):
            ros.executor.add_node(node)
        self.leases = Leases(
            self.mission, ['rav1'], 'survey', self.said.append, role='orchestrator'
        )
        self.held: list[str] = []
        self.leases.carry('rav1', self.held.append, self.said.append)
        ros.spin_until(lambda: bool(self.held), DEADLINE_S)

    def taken_over(self, mission: str) -> None:
        """Let somebody of a mission take the lease over."""
        client = self.other.create_client(Lease, '/rav1/lease')
        self.ros.spin_until(client.service_is_ready, DEADLINE_S)
        request = Lease.Request(holder='anna', mission=mission, take_over=True)
        answer = client.call_async(request)
        self.ros.spin_until(answer.done, DEADLINE_S)
        assert answer.result().success
        # Sooner than the mission would hear it by renewing its own.
        self.ros.spin_until(lambda: 'rav1' in self.leases.lost, DEADLINE_S)


@pytest.fixture
def hands(ros: Any) -> Iterator[Hands]:
    """Give a vehicle that a mission leads."""
    made = Hands(ros)
    yield made
    for node in (made.vehicle, made.mission, made.other):
        node.destroy_node()


def test_takeover_by_a_stranger_is_known_at_once(hands: Hands) -> None:
    """The mission says who has it, once, and knows that it must not command it."""
    hands.taken_over('')
    assert hands.leases.led_by_others == {'rav1'}
    (said,) = hands.said
    assert said.startswith('rav1: led by anna, taken over from orchestrator@')
    assert said.endswith(': it takes no orders of this mission')


def test_takeover_within_the_mission_is_no_stranger(hands: Hands) -> None:
    """An agent of the mission has taken it: the lease is lost, the vehicle is not."""
    hands.taken_over('survey')
    assert not hands.leases.led_by_others
    assert not hands.said
