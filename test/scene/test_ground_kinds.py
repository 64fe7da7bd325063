# SPDX-License-Identifier: Apache-2.0
"""Kinds of ground: their classes cover what they are given, their earthworks fit them."""

import math

import numpy as np
import pytest
import shapely

from rocsafe_scene.ground.ground_kinds import GROUND_KINDS, yaw_of
from rocsafe_scene.mesh.classes import class_number

OUTLINE = np.array([[-20.0, -10.0], [22.0, -12.0], [25.0, 14.0], [-18.0, 11.0]])
# An arc of 60 m, a quarter of a circle.
RADIUS_M = 60.0 / (0.5 * math.pi)
ANGLES = np.linspace(0.0, 0.5 * math.pi, 13)
LINE = RADIUS_M * np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])
WIDTHS_M = {'road': 6.2, 'gravel_track': 3.4, 'stream': 2.4, 'railway': 5.0}


def work(kind, seed=1, **options):
    """Return the work of a kind of ground."""
    make, shape = GROUND_KINDS[kind]
    return make(OUTLINE if shape == 'outline' else LINE, seed, **options)


def covered(stencil):
    """Return what outlines cover, as one shape."""
    return shapely.union_all([shapely.Polygon(ring).buffer(0.0) for ring in stencil.outlines])


@pytest.mark.parametrize('kind', GROUND_KINDS)
def test_every_kind_has_marks_and_known_classes_near_its_place(kind):
    """Numbers of its classes exist, and nothing has a class far from where it was asked for."""
    made = work(kind)
    assert made.marks
    assert made.stencils
    _, shape = GROUND_KINDS[kind]
    place = shapely.Polygon(OUTLINE) if shape == 'outline' else shapely.LineString(LINE)
    for stencil in made.stencils:
        assert class_number(stencil.label) > 0
        assert covered(stencil).within(place.buffer(6.0))


@pytest.mark.parametrize('kind', GROUND_KINDS)
def test_the_same_seed_makes_the_same_work(kind):
    """Byte for byte."""
    for one, two in zip(work(kind, 3).stencils, work(kind, 3).stencils, strict=True):
        assert one.label == two.label
        for ring, again in zip(one.outlines, two.outlines, strict=True):
            assert np.array_equal(ring, again)


@pytest.mark.parametrize(('kind', 'width_m'), WIDTHS_M.items())
def test_a_way_has_the_class_of_its_width_along_its_length(kind, width_m):
    """An annular sector, whose area is width times length along the middle."""
    (stencil,) = work(kind).stencils
    assert covered(stencil).area == pytest.approx(60.0 * width_m, rel=0.02)
    (course,) = work(kind).courses
    assert np.hypot(*course.line.T) == pytest.approx(RADIUS_M, abs=0.05)


@pytest.mark.parametrize('kind', ['ploughed_field', 'meadow', 'yard'])
def test_a_field_has_the_class_of_its_whole_outline(kind):
    """Its area is that of the outline by Gauss's formula."""
    x, y = OUTLINE.T
    area = 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    (stencil,) = work(kind).stencils
    assert covered(stencil).area == pytest.approx(area)
    assert not work(kind).courses


def test_earthworks_are_as_high_and_wide_as_asked():
    """A road is lifted, a stream is cut, each with its own top."""
    (road,) = work('road', width_m=8.0, lift_m=0.5).courses
    assert (road.lift_m, road.half_width_m) == (0.5, pytest.approx(5.0))
    (stream,) = work('stream', depth_m=2.0, width_m=3.0).courses
    assert (stream.lift_m, stream.half_width_m) == (-2.0, pytest.approx(1.35))


@pytest.mark.parametrize('seed', range(5))
def test_a_spill_begins_where_it_was_spilt(seed):
    """There is liquid at the start of its line, and less of it at the end."""
    (stencil,) = work('spill', seed).stencils
    liquid = covered(stencil)
    near, far = (liquid.intersection(shapely.Point(end).buffer(5.0)).area for end in LINE[[0, -1]])
    assert liquid.intersects(shapely.Point(LINE[0]).buffer(1.0))
    assert near > far


def test_a_yaw_in_degrees_is_turned_into_radians():
    """Other options stay."""
    assert yaw_of({'width_m': 3.0}) == {'width_m': 3.0}
    assert yaw_of({'yaw_deg': 90, 'colour': 'x'}) == {
        'colour': 'x',
        'yaw_rad': pytest.approx(0.5 * math.pi),
    }
