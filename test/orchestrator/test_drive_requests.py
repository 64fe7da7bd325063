# SPDX-License-Identifier: Apache-2.0
"""Requests of a drive: what is asked again before a further drive."""

from types import SimpleNamespace

import pytest
from rclpy.node import Node
from rclpy.task import Future

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_interfaces.action import DriveRoute
from rocsafe_interfaces.srv import SuggestViewpoints
from rocsafe_orchestrator.drive_requests_node import OUTDATED, DriveRequests
from rocsafe_orchestrator.mission.driving import DriveEnd
from rocsafe_orchestrator.mission.request import Order, OrderKind
from rocsafe_orchestrator.parameters.drive_goal import are_other_sources


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


DRIVE = Order(kind=OrderKind.DRIVE, vehicle='rgv1')
PLACE = GeoPosition(53.28, -9.06, 0.0)


@pytest.mark.parametrize(
    ('known', 'is_other'),
    [
        (((PLACE, 90.0),), False),
        (((PLACE, 190.0),), False),
        (((offset(PLACE, 2.0, 0.0, 0.0), 100.0),), False),
        ((), True),
        (((PLACE, 210.0),), True),
        (((PLACE, 40.0),), True),
        (((offset(PLACE, 4.0, 0.0, 0.0), 100.0),), True),
        (((PLACE, 100.0), (offset(PLACE, 30.0, 0.0, 0.0), 5.0)), True),
    ],
)
def test_other_sources_are_those_that_a_route_was_not_planned_on(known, is_other):
    """Others in number, place or strength; what an assessment changes a little is the same."""
    assert are_other_sources(((PLACE, 100.0),), known) is is_other


def test_drive_on_other_sources_is_stopped_and_planned_anew(ros):
    """Once; what changed in between is in the next plan."""
    node = Node('requests', context=ros.context)
    monitor = SimpleNamespace(sources=((PLACE, 100.0),), images_expected=0)
    requests = DriveRequests(
        node, SimpleNamespace(driver_name='rgv1'), monitor, SimpleNamespace(), []
    )
    cancelled, ends = [], []
    handle = SimpleNamespace(
        accepted=True, cancel_goal_async=lambda: cancelled.append(1), get_result_async=Future
    )
    requests.begin(
        SimpleNamespace(accepted=lambda _order: None, driven=lambda *end: ends.append(end))
    )
    requests._planned_on, requests._goal = monitor.sources, lambda: 'rest'
    requests.on_sources()
    requests._on_goal(DRIVE, print, done(handle))
    requests.on_sources()
    assert not cancelled
    monitor.sources = ((PLACE, 1000.0),)
    requests.on_sources()
    requests.on_sources()
    assert cancelled == [1]
    result = DriveRoute.Result(outcome=DriveRoute.Result.CANCELLED, error_msg='by request')
    requests._on_driven(DRIVE, done(SimpleNamespace(result=result)))
    assert ends == [(OUTDATED, DriveEnd.OUT_WITH_EVIDENCE_LEFT)]
    requests.on_sources()
    assert cancelled == [1]
    requests.close()
    node.destroy_node()


def done(value):
    """Return a future with a value."""
    future = Future()
    future.set_result(value)
    return future
