# SPDX-License-Identifier: Apache-2.0
"""Flights that follow the ground: heights, bends over hills, and files that are no terrain."""

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pyproj import Transformer

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import offset
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.terrain.relief import Relief
from rocsafe_geo.terrain.terrain import LocalGround, Terrain, TerrainError
from rocsafe_planner.checking.plan_checker import check_plan
from rocsafe_planner.plan.vehicle import Aloft
from rocsafe_planner.planning import plan_survey

from .fleets import FLEET, changed, request, vehicle
from .surveys import surveys
from .terrains import CENTRE, read_terrain, terrain, write_terrain

LEVEL = terrain(lambda _east, _north: 20.0)
SLOPE = terrain(lambda east, _north: 0.1 * east)
WALL = terrain(lambda east, _north: np.where(np.abs(east - 200.0) < 15.0, 60.0, 0.0))
BLIND = tuple(
    dataclasses.replace(v, home=dataclasses.replace(v.home, altitude_m=math.nan)) for v in FLEET
)


def test_heights_lie_on_planes_between_pixels():
    """A slope is read exactly, also between pixels; outside nothing is known."""
    east = np.array([0.0, 3.3, -111.1, 5000.0])
    places = [offset(CENTRE, e, 7.0) for e in east]
    heights = SLOPE.altitudes_m(
        [p.latitude_deg for p in places], [p.longitude_deg for p in places]
    )
    np.testing.assert_allclose(heights[:3], 0.1 * east[:3], atol=0.05)
    assert math.isnan(heights[3])


def test_a_relief_is_as_high_as_the_ground_below_each_of_its_cells():
    """Between the places that are looked up, in another coordinate system, nothing is lost."""
    across, down = np.meshgrid(np.arange(80), np.arange(80))
    x, y = Transformer.from_crs('EPSG:4326', 'EPSG:32630').transform(
        CENTRE.latitude_deg, CENTRE.longitude_deg
    )
    hills = Terrain(
        heights_m=20.0 * np.sin(across / 7.0) * np.cos(down / 5.0),
        to_column=(0.1, 0.0, 40.0 - 0.1 * x),
        to_row=(0.0, -0.1, 40.0 + 0.1 * y),
        crs='EPSG:32630',
        digest='hills',
    )
    ground = LocalGround(hills, LocalFrame(dataclasses.replace(CENTRE, altitude_m=0.0)), [])
    relief = ground.relief(np.array([(-130.0, -75.0), (140.0, 81.0)]), clearance_m=2.0)
    generator = np.random.default_rng(3)
    places = generator.uniform((-130.0, -75.0), (140.0, 81.0), (200, 2))
    ups = ground.ups_m(places)
    tops = relief._tops(places, places, np.zeros(1), 0)[:, 0] - 2.0
    assert (tops >= ups - 1e-6).all()
    assert (tops <= ups + 2.5).all()


@pytest.mark.slow
def test_level_ground_changes_nothing():
    """A flat terrain gives the plan without one, and the altitudes of the homes."""
    flat, plain = plan_survey(request(terrain=LEVEL)), plan_survey(request())
    assert flat.makespan_s == pytest.approx(plain.makespan_s, abs=1e-6)
    for a, b in zip(flat.routes, plain.routes, strict=True):
        assert [v.id for v in a.viewpoints] == [v.id for v in b.viewpoints]
        for seen, expected in zip(a.viewpoints, b.viewpoints, strict=True):
            assert seen.position.altitude_m == pytest.approx(44.0, abs=1e-6)
            assert seen.position.latitude_deg == pytest.approx(expected.position.latitude_deg)


@pytest.mark.slow
def test_every_viewpoint_is_as_high_above_its_ground():
    """On a slope altitudes follow the ground, above the homes' own datum if they say one."""
    plan = plan_survey(request(terrain=SLOPE, vehicles=BLIND, grid='best'))
    views = [view for route in plan.routes for view in route.viewpoints]
    ground = SLOPE.altitudes_m(
        [v.position.latitude_deg for v in views], [v.position.longitude_deg for v in views]
    )
    altitudes = np.array([view.position.altitude_m for view in views])
    np.testing.assert_allclose(altitudes, ground + 32.0, atol=1e-3)
    assert {view.height_agl_m for view in views} == {32.0}
    assert check_plan(plan) == []


def test_a_climb_is_counted():
    """A leg of 100 m up 60 m takes the climb's time; a plan by hand."""
    cliff = terrain(lambda east, _north: np.where(east > 150.0, 60.0, 0.0))
    home = offset(CENTRE, 100.0, 0.0)
    place = offset(CENTRE, 200.0, 0.0)
    yard = dataclasses.replace(
        request().regions[0],
        area=dataclasses.replace(
            request().regions[0].area,
            boundary=tuple(offset(place, e, n) for e, n in ((-2, -2), (2, -2), (2, 2), (-2, 2))),
        ),
    )
    lone = vehicle(home=(home.latitude_deg, home.longitude_deg), altitude=0.0)
    plan = plan_survey(
        dataclasses.replace(request(terrain=cliff, vehicles=(lone,)), regions=(yard,))
    )
    legs = plan.makespan_s - 32 / 3 - 32 / 2 - 2.0
    level = 100 / 8 + 8 / 2.5
    # Up at 3 m/s and down at 2 m/s; bends at the cliff's edge cost a stop each.
    assert legs >= 60 / 3 + 60 / 2
    assert legs <= 60 / 3 + 60 / 2 + 2 * level + 10.0
    assert check_plan(plan) == []


@pytest.mark.slow
def test_a_wall_is_flown_over():
    """Between homes and region a wall 60 m high: legs bend over it, and none comes near."""
    plan = plan_survey(request(terrain=WALL, method='nearest_to_shortest'))
    bends = [b for r in plan.routes for s in r.sorties for leg in s.bends for b in leg]
    assert bends
    assert max(bend.altitude_m for bend in bends) >= 12.0 + 60.0 + 10.0 - 0.5
    assert check_plan(plan) == []
    assert plan.makespan_s > plan_survey(request(method='nearest_to_shortest')).makespan_s


def test_the_checker_sees_a_leg_too_low():
    """The plan over the wall without its bends comes too near to it."""
    plan = plan_survey(request(terrain=WALL, method='nearest_to_shortest'))
    flat = tuple(
        dataclasses.replace(
            route,
            sorties=tuple(
                dataclasses.replace(sortie, bends=tuple(() for _ in sortie.bends))
                for sortie in route.sorties
            ),
        )
        for route in plan.routes
    )
    assert 'm of the terrain' in ' '.join(check_plan(dataclasses.replace(plan, routes=flat)))


@pytest.mark.slow
@settings(max_examples=12, deadline=None, suppress_health_check=list(HealthCheck))
@given(surveys(distance_m=0.0, exclusions=()), st.floats(0.0, 40.0), st.floats(60.0, 300.0))
def test_plans_over_hills_are_valid(survey, high, wave):
    """Rolling hills, all kinds of regions, fleets and wind: the checker accepts the plan."""
    hills = terrain(
        lambda east, north: high * np.sin(east / wave) * np.cos(north / wave), half_m=1500.0
    )
    plan = plan_survey(changed(survey, terrain=hills, method='nearest_to_shortest'))
    assert check_plan(plan) == []


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_legs_over_random_ground_are_clear(seed):
    """Whatever the ground: each bent leg stays above every sample of it by the clearance."""
    generator = np.random.default_rng(seed)
    tops = generator.uniform(0.0, 40.0, (60, 80)) * (generator.random((60, 80)) < 0.05)
    relief = Relief(np.zeros(2), 5.0, tops, clearance_m=3.0)
    ends = generator.uniform((0.0, 0.0, 45.0), (395.0, 295.0, 60.0), (8, 2, 3))
    ends[:4, :, 2] = 43.5
    first, second = relief.bends(ends[:, 0], ends[:, 1])
    share = np.linspace(0.0, 1.0, 400)[:, None]
    for k in range(len(ends)):
        way = [ends[k, 0], first[k], second[k], ends[k, 1]]
        for a, b in pairwise(way):
            line = a + share * (b - a)
            cells = np.rint(line[:, :2] / 5.0).astype(int)
            ground = tops[cells[:, 1].clip(0, 59), cells[:, 0].clip(0, 79)]
            assert (line[:, 2] >= ground + 3.0 - 1e-6).all()


def legs_over_peaks(seed):
    """Return a relief with some peaks, and ends of 30 legs of all lengths over it."""
    generator = np.random.default_rng(seed)
    tops = generator.uniform(0.0, 40.0, (60, 80)) * (generator.random((60, 80)) < 0.02)
    ends = generator.uniform((0.0, 0.0, 20.0), (395.0, 295.0, 60.0), (30, 2, 3))
    ends[:10, 1, :2] = ends[:10, 0, :2] + generator.uniform(-20.0, 20.0, (10, 2))
    return Relief(np.zeros(2), 5.0, tops, clearance_m=3.0), ends[:, 0], ends[:, 1]


@pytest.mark.parametrize('seed', range(4))
def test_the_bends_of_a_leg_depend_on_that_leg_alone(seed):
    """Whether legs are asked for one by one or at once, they bend at the same places."""
    relief, origins, targets = legs_over_peaks(seed)
    together = relief.bends(origins, targets)
    alone = [relief.bends(a, b) for a, b in zip(origins, targets, strict=True)]
    for k in range(2):
        np.testing.assert_array_equal(together[k], [bends[k] for bends in alone])
    assert 3 <= (together[0] != targets).any(axis=1).sum() <= 27


@pytest.mark.parametrize('seed', range(4))
def test_looks_at_coarse_grids_change_no_bend(monkeypatch, seed):
    """Legs that coarse grids prove to be high enough are those that samples leave straight."""
    relief, origins, targets = legs_over_peaks(seed)
    quick = relief.bends(origins, targets)
    monkeypatch.setattr('rocsafe_geo.terrain.relief._PIECES', ())
    for found, expected in zip(quick, relief.bends(origins, targets), strict=True):
        np.testing.assert_array_equal(found, expected)


def test_each_cell_of_a_coarse_grid_holds_the_highest_of_its_neighbourhood():
    """Grid k has the highest within 2^(k + 1) cells of each cell, at the rim too."""
    tops = np.random.default_rng(5).uniform(0.0, 40.0, (11, 30))
    levels = Relief(np.zeros(2), 1.0, tops, clearance_m=0.0)._levels
    assert len(levels) == 5
    for k, level in enumerate(levels):
        reach = 2 ** (k + 1)
        for row, column in ((0, 0), (5, 7), (10, 29), (3, 29)):
            beside = tops[
                max(0, row - reach) : row + reach + 1, max(0, column - reach) : column + reach + 1
            ]
            assert level[row, column] == beside.max()


def aloft_over_slope(altitude_m):
    """Return a request for a yard of 40 m, and one vehicle in the air over ground 12 m high."""
    yard = tuple(offset(CENTRE, 100.0 + e, n) for e, n in ((0, 0), (40, 0), (40, 40), (0, 40)))
    here = dataclasses.replace(offset(CENTRE, 120.0, -20.0), altitude_m=altitude_m)
    lone = dataclasses.replace(
        FLEET[0], home=offset(CENTRE, 60.0, 0.0), aloft=Aloft(position=here)
    )
    return request(area=SurveyArea(yard), terrain=SLOPE, vehicles=(lone,), method='strips')


@pytest.mark.parametrize('altitude_m', [13.0, 3.0, 90.0])
def test_who_is_near_the_ground_may_leave_it(altitude_m):
    """Just after its take-off it is nearer than the clearance, or so it seems: it climbs.

    The homes know no altitude: the terrain's is that of all.
    """
    assert check_plan(plan_survey(aloft_over_slope(altitude_m))) == []


def test_who_is_deep_in_the_ground_is_refused():
    """By more than the clearance neither terrain nor place can be meant."""
    with pytest.raises(ValueError, match=r'rav1 is in the air 15\.\d m below the terrain: must'):
        plan_survey(aloft_over_slope(-3.0))


def test_a_file_is_read(tmp_path):
    """Heights, holes and name of a GeoTIFF; equal files are equal terrains."""
    heights = np.full((40, 60), 7.0, np.float32)
    heights[0, 0] = -9999.0
    path = write_terrain(tmp_path / 'a.tif', heights, nodata=-9999.0)
    found = read_terrain(path)
    assert found.altitudes_m([CENTRE.latitude_deg], [CENTRE.longitude_deg]) == pytest.approx(7.0)
    assert math.isnan(found.heights_m[0, 0])
    assert found.name == 'terrain a.tif'
    assert found == read_terrain(write_terrain(tmp_path / 'b.tif', heights, nodata=-9999.0))
    assert found != read_terrain(write_terrain(tmp_path / 'c.tif', heights + 1, nodata=-9999.0))


@pytest.mark.parametrize(
    ('write', 'message'),
    [
        (lambda path: path.with_name('none.tif'), 'none.tif: no such file'),
        (lambda path: (path.write_bytes(b'no raster'), path)[1], 'cannot be read as a GeoTIFF'),
        (
            lambda path: write_terrain(path, np.zeros((4, 4), np.float32), crs=None),
            'has no coordinate system',
        ),
        (
            lambda path: write_terrain(path, np.zeros((3, 4, 4), np.uint8)),
            'has 3 bands of uint8: must be one of heights in metres',
        ),
        (
            lambda path: write_terrain(path, np.full((4, 4), -1.0, np.float32), nodata=-1.0),
            'has no height in any pixel',
        ),
    ],
)
def test_files_that_are_no_terrain_are_refused(tmp_path, write, message):
    """One line: the file and what is wrong with it."""
    with pytest.raises(ValueError, match=message) as caught:
        read_terrain(write(tmp_path / 'dem.tif'))
    assert '\n' not in str(caught.value)


def test_a_terrain_elsewhere_is_refused(tmp_path):
    """A raster that ends before the region does: the place is named."""
    small = read_terrain(write_terrain(tmp_path / 'small.tif', np.zeros((4, 4), np.float32)))
    with pytest.raises(TerrainError, match=r'small.tif has no height at 53\.\d+, -9\.\d+: must'):
        plan_survey(request(terrain=small))


def test_the_clearance_is_below_the_flight():
    """Both heights are named."""
    with pytest.raises(ValueError, match='terrain_clearance_m is 32 m: must be below height_agl'):
        request(terrain=LEVEL, terrain_clearance_m=32.0)


def test_heights_above_home_go_to_autopilots():
    """Flight files count from the ground at home, which the terrain says."""
    from rocsafe_planner.plan.flight_path import flight_path

    plan = plan_survey(request(terrain=SLOPE))
    route = plan.routes[0]
    stops = flight_path(route, 0)
    assert stops[0].height_m == 32.0
    home = SLOPE.altitudes_m([route.vehicle.home.latitude_deg], [route.vehicle.home.longitude_deg])
    for stop in stops:
        if stop.viewpoint is not None:
            place = stop.position
            ground = SLOPE.altitudes_m([place.latitude_deg], [place.longitude_deg])
            assert stop.height_m == pytest.approx(float(ground[0] - home[0]) + 32.0, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize('objective', ['longest_time', 'energy'])
def test_more_viewpoints_than_a_table_of_legs_holds(monkeypatch, objective):
    """Legs over hills that are too many for a table are estimates: the plan is valid, and tight.

    Batteries last although the level legs of the search are shorter than those that are flown.
    """
    hills = terrain(lambda east, north: 30.0 * np.sin(east / 25.0) * np.cos(north / 20.0))
    lasting = plan_survey(request(terrain=hills, method='solver', proposals=3000))
    endurance = lasting.makespan_s * 1.1
    weak = tuple(dataclasses.replace(v, endurance_s=endurance) for v in FLEET)
    monkeypatch.setattr('rocsafe_planner.routing.solver_problem.MOST_TERRAIN_SITES', 10)
    plan = plan_survey(
        request(terrain=hills, method='solver', proposals=3000, vehicles=weak, objective=objective)
    )
    assert check_plan(plan) == []
    assert 0.0 < plan.lower_bound_s <= plan.makespan_s <= endurance
