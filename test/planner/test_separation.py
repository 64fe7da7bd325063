# SPDX-License-Identifier: Apache-2.0
"""Vehicles stay apart by default: in every plan, and in the plan for the rest in mid-air."""

import dataclasses

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st

from rocsafe_geo.position import GeoPosition
from rocsafe_planner.checking.plan_checker import check_plan
from rocsafe_planner.errors import PlannerError
from rocsafe_planner.flights.flight_track import FlightTrack
from rocsafe_planner.flights.keeping_apart import in_layers
from rocsafe_planner.plan.situation import Situation
from rocsafe_planner.plan.survey_options import SeparationOptions
from rocsafe_planner.plan.vehicle import Aloft
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.replanning import remaining_request
from rocsafe_planner.site.survey_site import survey_site

from .fleets import STARTS, request, vehicle

WANTED_M = SeparationOptions().distance_m
# The independent checker looks five times a second.
TOLERANCE_M = 0.05


def fleet_at(corner, count, apart_deg):
    """Return vehicles that stand beside each other."""
    north, east = STARTS[corner]
    return tuple(vehicle(f'rav{k}', (north + apart_deg * k, east)) for k in range(count))


def aloft(plan, share):
    """Return where vehicles are after a share of a plan; those that climb or land are left out.

    With the ids of what is photographed, the places in the air, metres, and who stands at home.
    """
    site, height_m = survey_site(plan.request), plan.request.coverage.height_agl_m
    layers = tuple(route.flight_height_m - height_m for route in plan.routes)
    problem, time_s = in_layers(site, layers).problem, share * plan.makespan_s
    alive, visited, places = {}, set(), []
    for number, route in enumerate(plan.routes):
        since_s = time_s - route.delay_s
        if not route.sorties or since_s <= 0.0:
            alive[route.vehicle.name] = None
            continue
        done = int(len(route.viewpoints) * min(1.0, since_s / route.duration_s))
        visited |= {view.id for view in route.viewpoints[:done]}
        point = {view.id: at for at, view in enumerate(site.viewpoints)}
        flights = [[point[view.id] for view in one.viewpoints] for one in route.sorties]
        track = FlightTrack(problem, number, flights)
        place = track.places(np.array([min(since_s, track.duration_s)]))[0]
        if place[2] < route.flight_height_m - 0.1:
            continue
        position = GeoPosition(*site.frame.to_geodetic(place[None, :])[0].tolist())
        alive[route.vehicle.name] = Aloft(position=position, used_s=since_s)
        places.append(place)
    return alive, visited, places


@pytest.mark.slow
@settings(max_examples=8, suppress_health_check=list(HealthCheck), deadline=None)
@given(
    st.integers(0, len(STARTS) - 1),
    st.integers(2, 5),
    st.sampled_from([0.0, 2e-5, 3e-4]),
    st.floats(0.05, 0.95),
)
# A vehicle hovers a millimetre beside its next viewpoint.
@example(corner=0, count=4, apart_deg=3e-4, share=0.5234375)
def test_vehicles_stay_apart_by_default(corner, count, apart_deg, share):
    """From one home or several, and after a loss in mid-air: the checker finds nobody near."""
    wish = request(
        vehicles=fleet_at(corner, count, apart_deg),
        method='boustrophedon_minmax',
        separation=SeparationOptions(),
    )
    plan = plan_survey(wish)
    assert plan.minimum_separation_m >= WANTED_M - TOLERANCE_M
    assert check_plan(plan) == []
    alive, visited, places = aloft(plan, share)
    assume(len(alive) > 1)
    del alive[next(iter(alive))]
    try:
        rest = remaining_request(plan, Situation(alive=alive, visited=frozenset(visited)))
        rest = dataclasses.replace(rest, effort=dataclasses.replace(rest.effort, proposals=4096))
        again = plan_survey(rest)
    except PlannerError:
        assume(False)
    assert check_plan(again) == []
    assert again.minimum_separation_m >= WANTED_M - TOLERANCE_M, places


def test_plan_that_comes_nearer_is_a_fault():
    """What is stated is checked against what was asked for, and against the flown tracks."""
    plan = plan_survey(request(separation=SeparationOptions()))
    (fault,) = check_plan(dataclasses.replace(plan, minimum_separation_m=4.0))
    assert 'separation distance_m is 10' in fault


def test_vehicle_in_the_air_climbs_to_its_layer_before_it_moves():
    """Its first bend is above or below where it is."""
    home = STARTS[0]
    here = GeoPosition(home[0] + 2e-3, home[1], 50.0)
    high = dataclasses.replace(vehicle('rav1', home), aloft=Aloft(position=here))
    plan = plan_survey(request(vehicles=(high,)))
    (route,) = plan.routes
    bend = route.sorties[0].bends[0][0]
    assert (bend.latitude_deg, bend.longitude_deg) == pytest.approx(
        (here.latitude_deg, here.longitude_deg), abs=1e-7
    )
    assert check_plan(plan) == []
