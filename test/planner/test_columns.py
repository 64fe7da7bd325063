# SPDX-License-Identifier: Apache-2.0
"""Legs around the columns in which other vehicles climb and come down."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_geo.position import level_offset_m, offset
from rocsafe_planner.checked_planning import checked_plan
from rocsafe_planner.checking.plan_checker import check_plan
from rocsafe_planner.plan.situation import Situation
from rocsafe_planner.plan.survey_options import UnheardVehicle
from rocsafe_planner.plan.vehicle import Aloft
from rocsafe_planner.problem.airspace import Airspace
from rocsafe_planner.problem.detours import Door
from rocsafe_planner.replanning import replan
from rocsafe_planner.site.survey_site import frame_of, survey_site

from .fleets import FIELD, request, vehicle

SEPARATION_M = 10.0


def legs_of(plan, route):
    """Return the level way of a route of one flight, east and north, as lines."""
    for sortie in route.sorties:
        corners = [route.vehicle.start]
        for view, bends in zip([*sortie.viewpoints, None], sortie.bends, strict=True):
            corners += [*bends, route.vehicle.landings[-1] if view is None else view.position]
        yield from map(shapely.LineString, pairwise(frame_of(plan.request).plane_of(corners)))


def nearest_m(plan, route, home):
    """Return how near a route comes to the home of another, metres."""
    place = shapely.Point(frame_of(plan.request).plane_of([home])[0])
    return min(leg.distance(place) for leg in legs_of(plan, route))


def _pair(place):
    return place.latitude_deg, place.longitude_deg


def fleet(*places):
    """Return vehicles with homes at places around the middle of the field, metres."""
    middle = FIELD.centroid()
    return tuple(
        vehicle(f'rav{k}', _pair(offset(middle, *place, 0.0))) for k, place in enumerate(places, 1)
    )


@pytest.mark.slow
@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10**6))
def test_nobody_with_a_reserved_layer_flies_through_the_column_of_another(seed):
    """Homes and an end amid the survey: when somebody lands, nobody is below or above it."""
    rng = np.random.default_rng(seed)
    places = [tuple(rng.uniform(-150.0, 150.0, 2).tolist()) for _ in range(4)]
    end = offset(FIELD.centroid(), *places.pop(), 0.0)
    first, *others = fleet(*places)
    vehicles = (dataclasses.replace(first, end=end), *others)
    plan = checked_plan(
        request(
            vehicles=vehicles, area=FIELD, height_agl_m=40.0, distance_m=SEPARATION_M,
            by='reserved', proposals=5_000,
        )
    )  # fmt: skip
    assert check_plan(plan) == []
    views = [view.position for route in plan.routes for view in route.viewpoints]
    for other, landing in [(one, place) for one in vehicles for place in one.landings]:
        others = [place for one in vehicles if one is not other for place in one.landings]
        gaps = [np.hypot(*level_offset_m(landing, place)) for place in [*views, *others]]
        if min(gaps) < 1.05 * SEPARATION_M:
            continue  # somebody must fly to a place in it
        for route in plan.routes:
            if route.vehicle.name != other.name and route.sorties:
                assert nearest_m(plan, route, landing) >= SEPARATION_M - 1e-3


@pytest.mark.slow
@pytest.mark.parametrize('by', ['reserved', 'layers'])
def test_rest_leads_around_the_column_of_a_vehicle_in_no_plan(by):
    """The straight way home leads through it; it may land at any time."""
    vehicles = fleet((-200.0, 0.0), (200.0, 0.0))
    plan = checked_plan(
        request(
            vehicles=vehicles, area=FIELD, height_agl_m=40.0, distance_m=SEPARATION_M, by=by,
            proposals=5_000,
        )
    )  # fmt: skip
    first, lost = plan.routes
    last = max(first.viewpoints, key=lambda view: view.position.longitude_deg)
    middle = np.array(level_offset_m(first.vehicle.home, last.position)) / 2.0
    column = offset(first.vehicle.home, *(middle + 1.0).tolist(), 0.0)
    visited = {v.id for r in plan.routes for v in r.viewpoints} - {last.id}
    unheard = UnheardVehicle(
        name=lost.vehicle.name, flight_height_m=lost.flight_height_m, home=column, places=()
    )
    straight, around = (
        replan(
            plan,
            Situation(
                alive={first.vehicle.name: Aloft(position=last.position, used_s=60.0)},
                visited=frozenset(visited),
                unheard=unheards,
            ),
        )
        for unheards in ((), (unheard,))
    )
    assert nearest_m(straight, straight.routes[0], column) < SEPARATION_M
    assert check_plan(around) == []
    if around.routes[0].flight_height_m < lost.flight_height_m + SEPARATION_M:
        assert nearest_m(around, around.routes[0], column) >= SEPARATION_M - 1e-3


def test_a_column_in_which_somebody_else_must_land_is_open():
    """Two homes that are near to each other: the plan is as without columns."""
    near = fleet((0.0, 0.0), (4.0, 0.0))
    wish = request(vehicles=near, area=FIELD, distance_m=SEPARATION_M, by='reserved')
    assert survey_site(wish).problem.detours is None


def test_legs_lead_through_the_door_of_their_own_site_only():
    """A square with a site within: from there straight out, for others around."""
    zone = shapely.box(-10.0, -10.0, 10.0, 10.0)
    sites = np.array([[0.0, 0.0], [-30.0, 0.0], [30.0, 0.0]])
    detours = Airspace([zone], 0.0).detours(sites, [Door(site=0, zone=zone)])
    assert detours.length_m[0].tolist() == [0.0, 30.0, 30.0]
    assert detours.length_m[1, 2] == pytest.approx(2.0 * np.hypot(20.0, 10.0) + 20.0, abs=0.01)
    both = Airspace([zone, shapely.box(40.0, -10.0, 60.0, 10.0)], 0.0).detours(
        np.array([[0.0, 0.0], [50.0, 0.0], [80.0, 0.0]]),
        [Door(site=0, zone=zone), Door(site=1, zone=shapely.box(40.0, -10.0, 60.0, 10.0))],
    )
    assert both.length_m[0, 1] == 50.0
    assert both.length_m[0, 2] > 80.0


def test_legs_out_of_a_door_do_not_enter_a_zone_that_lies_across_it():
    """From (0, 0) to (15, 30) the straight line leaves the own zone through that of another."""
    own, other = shapely.box(-10.0, -10.0, 10.0, 10.0), shapely.box(2.0, -12.0, 22.0, 8.0)
    sites, doors = np.array([[0.0, 0.0], [15.0, 30.0]]), [Door(site=0, zone=own)]
    airspace = Airspace([own, other], 0.0)
    straight = float(np.hypot(15.0, 30.0))
    assert airspace.detours(sites, doors).length_m[0, 1] == pytest.approx(straight)
    assert airspace.detours(sites, doors, [own, other]).length_m[0, 1] > straight + 0.01


def test_a_site_in_two_own_zones_leaves_either():
    """As a home that lies within the column over the vehicle's end."""
    zones = shapely.box(-10.0, -10.0, 10.0, 10.0), shapely.box(-6.0, -12.0, 14.0, 8.0)
    doors = [Door(site=0, zone=zone) for zone in zones]
    sites = np.array([[0.0, 0.0], [30.0, 0.0], [-30.0, 0.0], [0.0, -30.0], [0.0, 30.0]])
    detours = Airspace([*zones], 0.0).detours(sites, doors, zones)
    assert detours.length_m[0] == pytest.approx([0.0, 30.0, 30.0, 30.0, 30.0])
