# SPDX-License-Identifier: Apache-2.0
"""What the planner plans, the simulated vehicles fly: the same places, the same times."""

from dataclasses import replace

import pytest
from hypothesis import HealthCheck, assume, given, settings
from test.planner.fleets import FLEET, STARTS, request
from test.planner.surveys import surveys
from test.planner.terrains import terrain

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.motion.autopilot import Autopilot
from rocsafe_geo.position import GeoPosition
from rocsafe_planner.checking.plan_checker import check_plan
from rocsafe_planner.conversions import message_of_plan
from rocsafe_planner.errors import PlannerError
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.planning import plan_survey
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.messages.conversions import route_of
from rocsafe_sim.vehicle.flight_record import FlightOutcome
from rocsafe_sim.vehicle.simulated_vehicle import SimulatedVehicle

NS = 1_000_000_000
START_NS = 1_700_000_000 * NS
LONG_NS = 10**6 * NS
# Two frames, one about the region and one about the mission, differ by so much of a flight.
RELATIVE = 3e-4

pytest.importorskip('rocsafe_interfaces', reason='no ROS 2 here: source it or run make setup')


def simulated(plan: SurveyPlan, number: int) -> SimulatedVehicle:
    """Return a vehicle that has flown its route of a plan to the end."""
    spec = plan.request.vehicles[number]
    centre = plan.request.regions[0].area.centroid()
    frame = LocalFrame(replace(centre, altitude_m=spec.home.altitude_m))
    airframe = Airframe(
        performance=spec.performance(plan.request.airspace.wind_mps),
        hover_s=spec.hover_s,
        endurance_s=spec.endurance_s / 0.9 + 1.0,
        reserve_fraction=0.1,
    )
    east, north, _ = frame.enu_of(spec.home).tolist()
    flown = SimulatedVehicle(airframe, (east, north, 0.0))
    flown.step(START_NS)
    message = message_of_plan(plan).routes[number]
    flown.fly_route(route_of(message, plan.plan_id, frame))
    flown.step(START_NS + LONG_NS)
    return flown


def assert_flown(plan: SurveyPlan) -> None:
    """Check a plan, fly it and compare."""
    assert check_plan(plan) == []
    for number, route in enumerate(plan.routes):
        if not route.viewpoints:
            continue
        flown = simulated(plan, number)
        summary = flown.summary()
        assert summary.outcome is FlightOutcome.COMPLETED, summary.text
        assert summary.viewpoints_visited == len(route.viewpoints)
        assert summary.duration_s == pytest.approx(route.duration_s, rel=RELATIVE, abs=0.05)
        begun_s = (flown.flight.take_off_ns - START_NS) / NS
        assert begun_s == pytest.approx(route.delay_s, abs=1e-6)
        assert summary.distance_flown_m == pytest.approx(route.length_m, rel=RELATIVE, abs=0.05)
        assert flown.observe().battery_fraction >= 0.1


HILLS = terrain(lambda east, north: 8.0 + 0.05 * east + 0.02 * north)
RIDGE = terrain(lambda east, _north: 20.0 - 0.1 * abs(east - 60.0))
ENDS = (
    replace(FLEET[0], end=GeoPosition(53.2795, -9.0600, 12.0)),
    replace(FLEET[1], is_open=True),
    FLEET[2],
)
SWAPPING = tuple(
    replace(
        v,
        home=GeoPosition(53.2790, -9.0620 - 0.001 * k, 12.0),
        endurance_s=150.0,
        battery_swap_s=90.0,
    )
    for k, v in enumerate(FLEET)
)
CLOSE = tuple(
    replace(v, home=GeoPosition(STARTS[0][0] + 1.2e-4 * k, STARTS[0][1], 12.0))
    for k, v in enumerate(FLEET)
)
AUTOPILOT = Autopilot()


@pytest.mark.slow
@pytest.mark.parametrize(
    'changes',
    [
        {'vehicles': ENDS},
        {'vehicles': SWAPPING, 'method': 'boustrophedon_minmax'},
        {'vehicles': CLOSE, 'distance_m': 12.0},
        {'vehicles': CLOSE, 'distance_m': 15.0, 'by': 'layers'},
        {'vehicles': ENDS, 'wind_mps': (3.0, -2.0)},
        {'terrain': HILLS},
        {'terrain': RIDGE, 'vehicles': ENDS},
        {'terrain': RIDGE, 'vehicles': SWAPPING, 'method': 'boustrophedon_minmax'},
        {'vehicles': tuple(replace(v, hover_s=0.0) for v in SWAPPING)},
    ],
    ids=[
        'other ends', 'battery changes', 'delays', 'layers', 'wind', 'hills', 'ends over a ridge',
        'battery changes over a ridge', 'passed viewpoints',
    ],
)  # fmt: skip
def test_plans_are_flown_as_planned(changes: dict[str, object]) -> None:
    """Times, lengths, viewpoints, delays: the flight is that of the plan."""
    vehicles = changes.get('vehicles', FLEET)
    fleet = tuple(replace(v, autopilot=AUTOPILOT) for v in vehicles)
    plan = plan_survey(request(**{**changes, 'vehicles': fleet}))
    if fleet[0].battery_swap_s is not None and fleet[0].hover_s:
        assert any(len(route.sorties) > 1 for route in plan.routes)
    if plan.request.separation.distance_m:
        delays = any(route.delay_s for route in plan.routes)
        layers = any(route.flight_height_m > 32.0 for route in plan.routes)
        assert layers if plan.request.separation.by == 'layers' else delays
    assert_flown(plan)


@pytest.mark.slow
@settings(max_examples=8, deadline=None, suppress_health_check=list(HealthCheck))
@given(surveys())
def test_any_plan_is_flown_as_planned(asked: object) -> None:
    """Whatever regions, exclusions, wind and fleets: plan and flight agree."""
    try:
        plan = plan_survey(asked)
    except PlannerError:
        assume(False)
    assert_flown(plan)
