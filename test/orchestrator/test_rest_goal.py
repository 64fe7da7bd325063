# SPDX-License-Identifier: Apache-2.0
"""The request for the rest of a survey: who is able, and what counts as photographed."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rocsafe_geo.position import GeoPosition
from rocsafe_interfaces.msg import GeoPoint, Route, SurveyPlan, Viewpoint
from rocsafe_orchestrator.mission.status import FlightState, Monitor, VehicleStatus
from rocsafe_orchestrator.parameters.goal_conversions import rest_goal
from rocsafe_ros.conversions import point_of_position
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_file import read_scenario

REAL = {'vehicles[1].link': 'udp://127.0.0.1:14550'}
HERE = GeoPosition(53.28, -9.06, 98.0)


def route(vehicle: str, *ids: int) -> Route:
    """Return a route over viewpoints."""
    return Route(vehicle=vehicle, viewpoints=[Viewpoint(id=number) for number in ids])


FIRST = SurveyPlan(plan_id='p', routes=[route('rav1', 0, 1, 2), route('rav2', 3, 4, 5)])
SECOND = SurveyPlan(plan_id='q', routes=[route('rav1', 1, 2, 4, 5)])
ROUTES = {(plan.plan_id, r.vehicle): r for plan in (FIRST, SECOND) for r in plan.routes}


def status(name: str, **changes: Any) -> VehicleStatus:
    """Return a vehicle that flies the first plan."""
    flying = VehicleStatus(
        name=name, state=FlightState.FLYING, plan_id='p', position=HERE, battery_fraction=0.5
    )
    return replace(flying, **changes)


def monitor(*vehicles: VehicleStatus) -> Monitor:
    """Return a monitor that has heard these."""
    made = Monitor(('rav1', 'rav2'))
    for each in vehicles:
        made.on_vehicle(each)
    return made


def scenario(small: Callable[..., Path], **changes: object) -> Scenario:
    """Return a scenario of two vehicles."""
    return read_scenario(small(changes))


def test_photographs_that_a_lost_vehicle_has_not_handed_over_are_taken_again(
    small: Callable[..., Path],
) -> None:
    """The last two of three are pending; those of a vehicle that goes on count."""
    seen = monitor(
        status('rav1', viewpoints_visited=1, shots_pending=1),
        status('rav2', viewpoints_visited=3, shots_pending=2),
    )
    goal = rest_goal(scenario(small), (FIRST, ROUTES), seen, {'rav1'})
    assert list(goal.visited) == [0, 3]
    assert [vehicle.name for vehicle in goal.able] == ['rav1']


def test_what_a_vehicle_did_while_it_was_not_heard_counts(small: Callable[..., Path]) -> None:
    """It comes back with a viewpoint of the first plan that the second one holds, too."""
    seen = monitor(
        status('rav1', plan_id='q', viewpoints_visited=1),
        status('rav2', viewpoints_visited=2),
    )
    goal = rest_goal(scenario(small), (SECOND, ROUTES), seen, {'rav1', 'rav2'})
    assert list(goal.visited) == [1, 4]


@pytest.mark.parametrize(('changes', 'able'), [(REAL, ['rav1']), ({}, ['rav1', 'rav2'])])
def test_real_vehicle_that_has_landed_starts_again_by_hand_only(
    changes: dict[str, object], able: list[str], small: Callable[..., Path]
) -> None:
    """A simulated one may."""
    seen = monitor(status('rav1'), status('rav2', state=FlightState.LANDED))
    goal = rest_goal(scenario(small, **changes), (FIRST, ROUTES), seen, {'rav1', 'rav2'})
    assert [vehicle.name for vehicle in goal.able] == able


@pytest.mark.parametrize(
    ('state', 'heights_m'),
    [
        (FlightState.FLYING, [42.0]),
        (FlightState.LOST, [42.0]),
        (FlightState.WAITING, [42.0]),
        (FlightState.LANDED, []),
        (FlightState.CRASHED, []),
        (FlightState.DISARMED, []),
    ],
)
def test_height_of_a_vehicle_that_nobody_hears_is_occupied(
    small: Callable[..., Path], state: FlightState, heights_m: list[float]
) -> None:
    """Unless it stood on the ground for good when it was heard last."""
    seen = monitor(status('rav1'), status('rav2', state=state))
    flown = {key: Route(vehicle=r.vehicle, viewpoints=r.viewpoints) for key, r in ROUTES.items()}
    flown['p', 'rav2'].flight_height_m = 42.0
    goal = rest_goal(scenario(small), (FIRST, flown), seen, {'rav1'}, ['rav2'])
    assert [one.flight_height_m for one in goal.unheard] == heights_m
    places = [view.position for view in flown['p', 'rav2'].viewpoints]
    home = scenario(small).ground_position(scenario(small).vehicles[1].home)
    for one in goal.unheard:
        assert one.places == [point_of_position(HERE), *places]
        assert (one.name, one.home) == ('rav2', point_of_position(home))
    assert rest_goal(scenario(small), (FIRST, flown), seen, {'rav1'}).unheard == []
    flown['p', 'rav2'].end = [GeoPoint(latitude=53.0)]
    goal = rest_goal(scenario(small), (FIRST, flown), seen, {'rav1'}, ['rav2'])
    assert [one.home.latitude for one in goal.unheard[1:]] == [53.0] * len(heights_m)
