# SPDX-License-Identifier: Apache-2.0
"""Requests of a drive: what is asked again before a further drive."""

import math
from types import SimpleNamespace

import pytest
from rclpy.node import Node
from rclpy.task import Future

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_interfaces.action import DriveRoute, PlanGroundRoute
from rocsafe_interfaces.msg import GeoPoint, GroundRoute, GroundStop
from rocsafe_interfaces.srv import SuggestViewpoints
from rocsafe_orchestrator.mission.drive_watch import Reading
from rocsafe_orchestrator.mission.driving import DriveEnd
from rocsafe_orchestrator.mission_state.request import Order, OrderKind
from rocsafe_orchestrator.parameters.drive_goal import DriveSoFar, dose_change
from rocsafe_orchestrator.requests.drive_requests_node import DriveRequests


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


def route():
    """Return a way of three stops that passes the place at 4 m."""
    places = [offset(PLACE, east, 4.0, 0.0) for east in (-20.0, 0.0, 20.0)]
    points = [GeoPoint(latitude=one.latitude_deg, longitude=one.longitude_deg) for one in places]
    stops = [GroundStop(position=point, dose_usv=dose)
             for point, dose in zip(points, (0.0, 3.0, 3.0), strict=True)]  # fmt: skip
    return GroundRoute(stops=stops)


@pytest.mark.parametrize(
    ('known', 'low', 'high'),
    [
        (((PLACE, 1000.0),), 1.0, 1.0),
        (((PLACE, 3000.0),), 2.5, 3.0),
        ((), 0.0, 0.1),
        # A weak companion changes little, wherever it is; a strong one beside the way much.
        (((PLACE, 1000.0), (offset(PLACE, 1.0, 0.0, 0.0), 50.0)), 1.0, 1.1),
        (((PLACE, 1000.0), (offset(PLACE, 20.0, 0.0, 0.0), 1000.0)), 2.0, 100.0),
    ],
)
def test_dose_by_the_sources_known_now_is_told_in_times_of_the_planned_one(known, low, high):
    """Of the whole route."""
    times = dose_change(route(), ((PLACE, 1000.0),), known)
    assert low - 1e-6 <= times <= high + 1e-6


def test_drive_with_another_dose_than_planned_is_stopped_and_planned_anew(ros):
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
    requests._route = route()
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
    ((text, ending),) = ends
    assert text.startswith('by the sources known now it takes 8.')
    assert ending is DriveEnd.OUT_WITH_EVIDENCE_LEFT
    requests.on_sources()
    assert cancelled == [1]
    requests.close()
    node.destroy_node()


def test_photographs_of_evidence_are_expected_once_however_often_it_is_planned(ros):
    """Those taken, and those of the route that is driven."""
    node = Node('requests', context=ros.context)
    monitor = SimpleNamespace(sources=(), images_expected=59)
    requests = DriveRequests(
        node, SimpleNamespace(driver_name='rgv1', real_names=()), monitor, SimpleNamespace(), []
    )
    requests.begin(SimpleNamespace(remarks=[], drive_planned=lambda: None))
    for taken, planned, expected in ((), 'abc', 62), ((), 'abc', 62), (('a',), 'bcd', 63):
        requests._so_far = DriveSoFar(evidence=taken)
        stops = [GroundStop(evidence=one) for one in planned]
        result = PlanGroundRoute.Result(route=GroundRoute(stops=stops))
        requests._on_route(DRIVE, done(SimpleNamespace(result=result)))
        assert monitor.images_expected == expected
    requests.close()
    node.destroy_node()


@pytest.mark.parametrize('outcome', [DriveRoute.Result.CANCELLED, DriveRoute.Result.BLOCKED])
def test_budget_of_a_real_vehicle_is_one_for_all_its_drives(ros, outcome):
    """It does not know its dose: readings tell it, while it drives and while it waits."""
    node = Node('requests', context=ros.context)
    scenario = SimpleNamespace(driver_name='rgv1', real_names=('rgv1',))
    calls, leases = [], SimpleNamespace(carry=lambda *_: None)
    requests = DriveRequests(
        node, scenario, SimpleNamespace(), leases, [], lambda: calls.append('home')
    )
    requests.begin(SimpleNamespace(driven=lambda *_end: None))
    requests._goal = lambda: 'rest'

    def read(second, rate_usvh):
        requests.on_reading(
            Reading(stamp_s=second, rate_usvh=rate_usvh, place=PLACE, speed_mps=0.0)
        )

    requests._route = route()
    requests._route.dose_budget_usv, requests._route.turn_back_usvh = 1e6, 1e9
    requests.send_drive(DRIVE)
    requests._driving = 'under way'
    for second in range(11):
        read(second, 3600.0)
    # The vehicle was started again, and gets the same route: it joins the drive.
    requests.send_drive(DRIVE)
    result = DriveRoute.Result(outcome=outcome, dose_usv=math.nan)
    requests._on_driven(DRIVE, done(SimpleNamespace(result=result)))
    assert requests._so_far.dose_usv == pytest.approx(10.0)
    assert requests._so_far.duration_s == pytest.approx(10.0)
    for second in range(11, 21):
        read(second, 3600.0)
    assert not calls
    requests._route = route()
    requests._route.dose_budget_usv, requests._route.turn_back_usvh = 12.0, 1e9
    requests.send_drive(DRIVE)
    requests._driving = 'under way'
    for second in range(21, 24):
        read(second, 3600.0)
    assert calls == ['home']
    requests._on_driven(DRIVE, done(SimpleNamespace(result=result)))
    assert requests._so_far.dose_usv == pytest.approx(22.0)
    requests.close()
    node.destroy_node()


def done(value):
    """Return a future with a value."""
    future = Future()
    future.set_result(value)
    return future
