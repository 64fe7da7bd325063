# SPDX-License-Identifier: Apache-2.0
"""A route that replaces another in the air is begun late, and in another layer."""

from dataclasses import replace

import pytest

from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.flight.route import FlightRoute, RouteWaypoint
from rocsafe_sim.flight.segment import Mode
from rocsafe_sim.vehicle.simulated_vehicle import SimulatedVehicle

from .flights import AIRFRAME, ROUTE, START_NS

DELAY_S = 20.0


def flying() -> SimulatedVehicle:
    """Return a vehicle that holds in the air."""
    vehicle = SimulatedVehicle(AIRFRAME, ROUTE.home_enu)
    vehicle.step(START_NS)
    vehicle.fly_route(ROUTE)
    vehicle.step(START_NS + 30 * NS_PER_S)
    vehicle.hold()
    vehicle.step(START_NS + 40 * NS_PER_S)
    assert vehicle.stands
    return vehicle


def route(vehicle: SimulatedVehicle, **changes: object) -> FlightRoute:
    """Return a new route from where a vehicle is."""
    values = {'plan_id': 'plan-2', 'waypoints': ROUTE.waypoints[1:], 'delay_s': DELAY_S}
    return replace(ROUTE, **{**values, **changes})


def test_vehicle_waits_where_it_is() -> None:
    """It stands for the delay, then flies, and takes all photographs."""
    vehicle = flying()
    here = vehicle.observe().pose.position_enu
    vehicle.fly_route(route(vehicle), replaces=True)
    seen = vehicle.step(START_NS + 59 * NS_PER_S)
    assert seen.pose.position_enu == pytest.approx(here)
    assert not seen.shots
    vehicle.step(START_NS + 65 * NS_PER_S)
    assert vehicle.observe().pose.position_enu != pytest.approx(here, abs=1.0)
    vehicle.step(START_NS + 1000 * NS_PER_S)
    summary = vehicle.summary()
    assert summary is not None
    assert summary.viewpoints_visited == 3


@pytest.mark.parametrize('command', ['hold', 'cancel'])
def test_vehicle_that_waits_can_be_held(command: str) -> None:
    """It does not fly on when the delay is over."""
    vehicle = flying()
    here = vehicle.observe().pose.position_enu
    vehicle.fly_route(route(vehicle), replaces=True)
    vehicle.step(START_NS + 45 * NS_PER_S)
    getattr(vehicle, command)()
    seen = vehicle.step(START_NS + 200 * NS_PER_S)
    assert seen.mode is Mode.HOLDING
    assert seen.pose.position_enu == pytest.approx(here)


def test_same_route_again_does_not_end_the_wait() -> None:
    """The goal joins the flight that waits."""
    vehicle = flying()
    here = vehicle.observe().pose.position_enu
    for second in (41, 50, 58):
        vehicle.step(START_NS + second * NS_PER_S)
        vehicle.fly_route(route(vehicle), replaces=True)
    assert vehicle.observe().pose.position_enu == pytest.approx(here)


def test_vehicle_climbs_to_its_layer_before_it_moves() -> None:
    """Its first bend is above it, as in a plan."""
    vehicle = flying()
    east, north, up = vehicle.observe().pose.position_enu
    waypoint = RouteWaypoint(
        viewpoint_id=1,
        position_enu=(east + 60.0, north, up + 10.0),
        yaw_rad=0.0,
        approach_enu=((east, north, up + 10.0),),
    )
    vehicle.fly_route(route(vehicle, waypoints=(waypoint,), delay_s=0.0), replaces=True)
    for second in range(41, 120):
        place = vehicle.step(START_NS + second * NS_PER_S).pose.position_enu
        if place[0] > east + 0.1:
            assert place[2] == pytest.approx(up + 10.0, abs=1e-6)
            return
    pytest.fail('it did not move')
