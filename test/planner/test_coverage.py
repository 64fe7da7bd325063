# SPDX-License-Identifier: Apache-2.0
"""Viewpoints: the paper's spacing, and an area seen as a whole."""

import math

import numpy as np
import pytest
import shapely
import shapely.affinity
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_planner.coverage.sight import sight
from rocsafe_planner.coverage.viewpoint_grid import (
    GRIDS,
    CoverageSpec,
    cover,
    coverage_spec,
    spacing_m,
)
from rocsafe_planner.errors import NoWayError, TooManyViewpointsError
from rocsafe_planner.plan.survey_options import CoverageOptions
from rocsafe_planner.problem.airspace import Airspace

CAMERA = PinholeCamera(math.radians(60.0), 640, 480)


def spec(overlap=0.2, rule='iou', grid='axis_aligned', limit=5000, height=32.0):
    """Return the grid of the paper's camera."""
    return coverage_spec(
        CAMERA,
        CoverageOptions(
            height_agl_m=height,
            overlap_fraction=overlap,
            spacing_rule=rule,
            grid=grid,
            max_viewpoints=limit,
        ),
    )


@st.composite
def areas(draw):
    """Draw star-shaped polygons of some hundred metres, some with a hole about the centre."""
    count = draw(st.integers(3, 9))
    radii = draw(st.lists(st.floats(20.0, 300.0), min_size=count, max_size=count))
    turn = draw(st.floats(0.0, math.tau))
    angles = turn + math.tau * np.arange(count) / count
    ring = np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])
    hole = [0.3 * ring] if draw(st.booleans()) else []
    return shapely.Polygon(ring, hole)


@pytest.mark.parametrize(
    ('fov_deg', 'rule', 'spacing'),
    [(60.0, 'iou', 24.634), (90.0, 'iou', 42.667), (90.0, 'linear', 51.2)],
)
def test_spacing_of_the_paper(fov_deg, rule, spacing):
    """At 32 m with 20 % overlap the rules give the values of the reference."""
    footprint = 2.0 * 32.0 * math.tan(math.radians(fov_deg) / 2.0)
    assert spacing_m(footprint, 0.2, rule) == pytest.approx(spacing, abs=5e-4)


@given(st.floats(0.0, 0.9))
def test_rules_mean_what_they_say(overlap):
    """Iou shares the fraction of both photographs together, linear that of one."""
    for rule in ('iou', 'linear'):
        moved = spacing_m(10.0, overlap, rule)
        shared, either = 10.0 - moved, 10.0 + moved
        assert shared / (either if rule == 'iou' else 10.0) == pytest.approx(overlap)


def test_overlap_holds_across_and_along():
    """Each side of the footprint has its own spacing: a 4:3 image overlaps 20 % both ways."""
    plan = spec()
    assert plan.spacing_m[0] == pytest.approx(24.634, abs=5e-4)
    assert plan.spacing_m[1] / plan.spacing_m[0] == pytest.approx(480 / 640)


def test_slivers_are_photographed():
    """Strips less than half a tile wide hold no tile's centre: the paper sees none of them."""
    plan = CoverageSpec(
        footprint_m=(12.0, 12.0), spacing_m=(10.0, 10.0), grid='axis_aligned', max_viewpoints=100
    )
    corner = shapely.Polygon([(0, 0), (20, 0), (20, 4), (4, 4), (4, 20), (0, 20)])
    coverage = cover([corner], plan)
    assert not any(corner.contains(shapely.Point(centre)) for centre in coverage.centres)
    assert len(coverage.centres) == 3
    assert coverage.sight.covered_area_m2 == pytest.approx(corner.area)


@pytest.mark.parametrize('sides', [3, 4, 5, 6, 7, 8])
def test_turned_grids_lose_no_footprint(sides):
    """Uniting rectangles that nearly share an edge is where GEOS 3.13 loses some of them."""
    radii = np.random.default_rng(sides).uniform(20.0, 300.0, (20, sides))
    for turn, ring in enumerate(radii):
        angles = turn + math.tau * np.arange(sides) / sides
        area = shapely.Polygon(np.column_stack([ring * np.cos(angles), ring * np.sin(angles)]))
        coverage = cover([area], spec(overlap=0.0, grid='rotated', height=60.0))
        assert coverage.sight.covered_area_m2 == pytest.approx(area.area, rel=1e-9)


@pytest.mark.slow
@settings(max_examples=50)
@given(
    areas(),
    st.sampled_from(sorted(GRIDS)),
    st.sampled_from(['iou', 'linear']),
    st.floats(0.0, 0.6),
)
def test_the_whole_area_is_seen(area, grid, rule, overlap):
    """Whatever the shape, every square metre is inside a footprint."""
    coverage = cover([area], spec(overlap, rule, grid, height=64.0))
    assert coverage.sight.region_area_m2 == pytest.approx(area.area)
    assert coverage.sight.covered_area_m2 == pytest.approx(area.area, rel=1e-9)


@settings(max_examples=50)
@given(areas())
def test_tiles_are_those_that_touch(area):
    """The tiles are those of the circum-rectangle that share ground with the area."""
    plan = spec(height=64.0)
    (width, height), (west, south, east, north) = plan.spacing_m, area.bounds
    columns, rows = math.ceil((east - west) / width), math.ceil((north - south) / height)
    x, y = np.meshgrid(
        (west + east) / 2 + width * (np.arange(columns) - (columns - 1) / 2),
        (south + north) / 2 + height * (np.arange(rows) - (rows - 1) / 2),
    )
    tiles = shapely.box(x - width / 2, y - height / 2, x + width / 2, y + height / 2)
    shared = shapely.area(shapely.intersection(tiles, area)).ravel()
    kept = {(round(e, 3), round(n, 3)) for e, n in cover([area], plan).centres}
    places = [(round(e, 3), round(n, 3)) for e, n in zip(x.ravel(), y.ravel(), strict=True)]
    # Of tiles that share some square centimetres only, rounding decides.
    must = {place for place, ground in zip(places, shared, strict=True) if ground > 1e-3}
    may = {place for place, ground in zip(places, shared, strict=True) if ground > 0.0}
    assert must <= kept <= may


def test_whole_tiles_are_not_rounded_up():
    """A rectangle of exactly 4 by 3 tiles needs 12 viewpoints, anywhere in the plane."""
    plan = spec()
    width, height = plan.spacing_m
    for east in (0.0, 0.1, 1234.567):
        rectangle = shapely.box(east, -east, east + 4 * width, -east + 3 * height)
        assert len(cover([rectangle], plan).centres) == 12


def test_covered_area_is_that_of_the_footprints():
    """Spacing wider than the footprint leaves gaps, and the covered area says so."""
    plan = CoverageSpec(
        footprint_m=(5.0, 8.0), spacing_m=(10.0, 10.0), grid='axis_aligned', max_viewpoints=100
    )
    coverage = cover([shapely.box(0, 0, 30, 20)], plan)
    assert coverage.sight.covered_area_m2 == pytest.approx(6 * 5.0 * 8.0)


def test_rotated_grid_follows_a_slanted_rectangle():
    """The grid has as few tiles as the field's own sides allow, and the nose turns with it."""
    angle = math.radians(30.0)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    width, height = spec().spacing_m
    corners = np.array([(0, 0), (4 * width, 0), (4 * width, 3 * height), (0, 3 * height)])
    field = shapely.Polygon(corners @ turn.T)
    rotated = cover([field], spec(grid='rotated'))
    assert len(rotated.centres) == 12
    assert rotated.yaw_rad[0] == pytest.approx(math.pi / 2 + angle)
    assert len(cover([field], spec()).centres) > 12
    assert cover([field], spec()).yaw_rad[-1] == pytest.approx(math.pi / 2)


def test_limit_is_exact():
    """As many viewpoints as the limit are planned, one more is refused with both numbers."""
    ring = shapely.box(0, 0, 400, 300).difference(shapely.box(60, 60, 340, 240))
    needed = len(cover([ring], spec()).centres)
    assert len(cover([ring], spec(limit=needed)).centres) == needed
    with pytest.raises(TooManyViewpointsError, match=rf'at least {needed} .* is {needed - 1}'):
        cover([ring], spec(limit=needed - 1))


def test_hopeless_areas_are_refused_at_once():
    """A region of 100 km by 100 km is refused before a tile is made."""
    with pytest.raises(TooManyViewpointsError, match=r'at least 219\d{5} viewpoints 24.63 m by'):
        cover([shapely.box(0, 0, 1e5, 1e5)], spec())


@pytest.mark.parametrize(
    ('overlap', 'rule', 'message'),
    [
        (1.0, 'iou', 'overlap_fraction is 1: must be from 0 to below 1'),
        (-0.1, 'iou', 'overlap_fraction is -0.1'),
        (math.nan, 'iou', 'overlap_fraction is nan'),
        (0.2, 'side', "spacing_rule is 'side': must be one of iou, linear"),
    ],
)
def test_impossible_overlap_is_refused(overlap, rule, message):
    """Value and limit are named."""
    with pytest.raises(ValueError, match=message):
        spacing_m(10.0, overlap, rule)


@pytest.mark.slow
@settings(max_examples=12)
@given(areas())
def test_best_grid_needs_fewest(area):
    """No other grid has fewer viewpoints."""
    counts = {grid: len(cover([area], spec(grid=grid, height=64.0)).centres) for grid in GRIDS}
    assert counts['best'] <= min(counts.values())


def test_front_overlap_stands_alone():
    """80 % along the track, 60 % between tracks, as photogrammetry wants it."""
    options = CoverageOptions(
        height_agl_m=32.0,
        spacing_rule='linear',
        overlap_fraction=0.6,
        front_overlap_fraction=0.8,
    )
    plan = coverage_spec(CAMERA, options)
    assert plan.spacing_m == pytest.approx((0.4 * 36.950, 0.2 * 27.713), abs=1e-3)


def test_holes_and_several_polygons():
    """Each polygon has its grid; what is not photographed is measured, part by part."""
    plan = CoverageSpec(
        footprint_m=(10.0, 10.0), spacing_m=(10.0, 10.0), grid='axis_aligned', max_viewpoints=100
    )
    west, east = shapely.box(0, 0, 30, 10), shapely.box(100, 0, 130, 20)
    coverage = cover([west, east], plan, zones((100.0, -5.0, 120.0, 25.0)))
    assert coverage.polygon.tolist() == [0, 0, 0, 1, 1]
    assert coverage.sight.region_area_m2 == pytest.approx(900.0)
    assert coverage.sight.forbidden_area_m2 == pytest.approx(400.0)
    assert coverage.sight.covered_area_m2 == pytest.approx(500.0)
    assert coverage.sight.largest_hole_m2 == 0.0
    with pytest.raises(NoWayError, match='leave no viewpoint'):
        cover([west], plan, zones((-50.0, -50.0, 50.0, 150.0)))


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 3.0))
def test_rows_joined_cover_the_same(seed, turn):
    """Uniting whole rows gives the area that uniting each footprint gives, gaps included."""
    generator = np.random.default_rng(seed)
    cos, sin = math.cos(turn), math.sin(turn)
    axes = np.array([[cos, -sin], [sin, cos]])
    spots = np.array([(7.0 * x, 6.0 * y) for y in range(8) for x in range(9)])
    spots = spots[generator.random(len(spots)) < 0.8] @ axes.T
    corners = np.array([(-5.0, -4.0), (5.0, -4.0), (5.0, 4.0), (-5.0, 4.0)]) @ axes.T
    footprints = spots[:, None, :] + corners
    region = shapely.Polygon(np.array([(-3.0, -3.0), (60.0, -1.0), (50.0, 44.0)]) @ axes.T)
    seen = sight([region], footprints)
    alone = shapely.union_all(shapely.polygons(footprints), grid_size=1e-6)
    assert seen.covered_area_m2 == pytest.approx(region.intersection(alone).area, abs=1e-3)


def test_a_narrow_strip_needs_fewer_photographs_by_default():
    """The usual grid follows a strip of 400 m by 25 m; the paper's rectangle does not."""
    strip = shapely.affinity.rotate(shapely.box(0.0, 0.0, 400.0, 25.0), 30.0)
    usual = CoverageOptions(height_agl_m=32.0).grid
    counts = {
        grid: len(
            cover(
                [strip],
                CoverageSpec(
                    footprint_m=(37.0, 28.0),
                    spacing_m=(24.6, 18.5),
                    grid=grid,
                    max_viewpoints=1000,
                ),
            ).centres
        )
        for grid in (usual, 'axis_aligned')
    }
    assert counts[usual] < 0.8 * counts['axis_aligned']


def zones(*boxes):
    """Return the airspace without boxes (west, south, east, north), widened by 2 m."""
    return Airspace([shapely.box(*box) for box in boxes], 2.0)


FOOTPRINTS = CoverageSpec(
    footprint_m=(37.0, 28.0), spacing_m=(24.6, 18.5), grid='best', max_viewpoints=1000
)


@pytest.mark.parametrize(
    'boxes',
    [
        [(40.0, 30.0, 60.0, 45.0)],
        [(-10.0, 20.0, 70.0, 31.0)],
        [(10.0, 10.0, 28.0, 60.0), (45.0, 5.0, 95.0, 25.0)],
    ],
)
def test_ground_beside_exclusions_is_photographed(boxes):
    """All ground outside zones that are no wider than a footprint is seen, from outside them."""
    region, air = shapely.box(0.0, 0.0, 120.0, 80.0), zones(*boxes)
    found = cover([region], FOOTPRINTS, air)
    seen = shapely.union_all(shapely.polygons(found.footprints))
    ground = region.difference(shapely.union_all([shapely.box(*box) for box in boxes]))
    assert ground.difference(seen).area < 0.05
    assert air.holds(found.centres).all()
    assert found.sight.forbidden_area_m2 == pytest.approx(region.area - ground.area)
    assert found.sight.covered_area_m2 == pytest.approx(ground.area, abs=0.05)


def test_ground_too_deep_between_exclusions_is_named_as_unseen():
    """Of a yard inside a ring of a zone nothing is seen; the hole is its size, the zone is not."""
    region = shapely.box(0.0, 0.0, 300.0, 300.0)
    yard = shapely.box(140.0, 140.0, 160.0, 160.0)
    ring = shapely.box(80.0, 80.0, 220.0, 220.0).difference(yard)
    found = cover([region], FOOTPRINTS, Airspace([ring], 12.0))
    assert found.sight.largest_hole_m2 == pytest.approx(yard.area, abs=0.1)
    assert found.sight.forbidden_area_m2 == pytest.approx(ring.area)
    assert region.area - ring.area - found.sight.covered_area_m2 == pytest.approx(400.0, abs=0.1)


def test_an_unreachable_yard_is_named_as_unseen():
    """Viewpoints that exclusions shut off are left out as those inside: the rest is planned."""
    region = shapely.box(0.0, 0.0, 300.0, 300.0)
    yard = shapely.box(100.0, 100.0, 200.0, 200.0)
    ring = shapely.box(80.0, 80.0, 220.0, 220.0).difference(yard)
    air = Airspace([ring], 2.0, np.array([(-10.0, -10.0)]))
    found = cover([region], FOOTPRINTS, air)
    assert not shapely.intersects_xy(yard, *found.centres.T).any()
    assert found.sight.forbidden_area_m2 == pytest.approx(ring.area)
    missed_m2 = region.area - ring.area - found.sight.covered_area_m2
    assert missed_m2 == pytest.approx(yard.area, abs=0.1)
    air.detours(found.centres)


def test_photographs_beside_a_concave_exclusion_are_few():
    """All that can be seen is, from few places: each shows most, and more than the others do."""
    region = shapely.box(0.0, 0.0, 200.0, 200.0)
    turn = np.arange(10) * np.pi / 5
    far = np.where(np.arange(10) % 2, 12.0, 80.0)
    star = shapely.Polygon(100.0 + np.column_stack([far * np.cos(turn), far * np.sin(turn)]))
    found = cover([region], FOOTPRINTS, Airspace([star], 2.0))
    assert region.area - star.area - found.sight.covered_area_m2 < 0.1
    assert len(found.centres) <= 95


@pytest.mark.slow
@settings(max_examples=40)
@given(
    st.lists(
        st.tuples(st.floats(-20.0, 110.0), st.floats(-20.0, 70.0), st.floats(1.0, 70.0),
                  st.floats(1.0, 50.0)),
        min_size=1, max_size=3,
    ),
    st.floats(0.0, 3.1),
)  # fmt: skip
def test_no_ground_that_can_be_seen_is_left(boxes, turn):
    """Wherever a hole is left, no place outside the zones has it in its footprint."""
    region = shapely.affinity.rotate(shapely.box(0.0, 0.0, 120.0, 80.0), turn, use_radians=True)
    shapes = [
        shapely.affinity.rotate(shapely.box(x, y, x + w, y + h), 2.0 * turn, use_radians=True)
        for x, y, w, h in boxes
    ]
    air = Airspace(shapes, 2.0)
    try:
        found = cover([region], FOOTPRINTS, air)
    except NoWayError:
        return
    seen = shapely.union_all(shapely.polygons(found.footprints), grid_size=1e-6)
    left = region.difference(shapely.union_all(shapes)).difference(seen)
    frame = found.footprints[0] - found.centres[0]
    for part in shapely.get_parts(left):
        if part.area < 0.1:
            continue
        spot = np.asarray(part.representative_point().coords)[0]
        around = shapely.Polygon(spot + 0.99 * frame)
        assert around.difference(air.shut).area < 1e-6
