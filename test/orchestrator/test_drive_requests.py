# SPDX-License-Identifier: Apache-2.0
"""Requests of a drive: what is asked again before a further drive."""

from types import SimpleNamespace

from rclpy.node import Node
from rclpy.task import Future

from rocsafe_interfaces.srv import SuggestViewpoints
from rocsafe_orchestrator.drive_requests_node import DriveRequests


class Assessor:
    """A service that has assessed all readings, and counts how often it is asked."""

    def __init__(self):
        self.count = 0

    def call_async(self, _request):
        """Return an answer that is there at once."""
        self.count += 1
        answer = Future()
        answer.set_result(SuggestViewpoints.Response())
        return answer


def test_readings_are_assessed_before_each_drive(ros):
    """The rest is planned anew after a vehicle was blocked: the second order is answered, too."""
    node = Node('requests', context=ros.context)
    assessors = [Assessor(), Assessor()]
    requests = DriveRequests(
        node, SimpleNamespace(driver_name='rgv1'), SimpleNamespace(), SimpleNamespace(), assessors
    )
    answered = []
    requests.begin(SimpleNamespace(answered=answered.append))
    for order in ('first', 'second'):
        requests.send_assess(order)
    assert answered == ['first', 'second']
    assert [one.count for one in assessors] == [2, 2]
    requests.close()
    node.destroy_node()
