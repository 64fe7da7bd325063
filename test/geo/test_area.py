# SPDX-License-Identifier: Apache-2.0
"""Survey areas: what is one, and what is refused."""

import math

import pytest

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition, distance_m, offset
from rocsafe_geo.regions.area import SurveyArea

HOME = GeoPosition(53.28, -9.06, 20.0)


def ring(*east_north):
    """Return corners given in metres about HOME."""
    return tuple(offset(HOME, east, north) for east, north in east_north)


def square(east, north, side):
    """Return a square's corners from its south-west one."""
    return ring(
        (east, north), (east + side, north), (east + side, north + side), (east, north + side)
    )


def test_area_in_metres():
    """A square of 100 m with a hole of 20 m has 9 600 square metres, in either turning sense."""
    frame = LocalFrame(HOME)
    for turn in (1, -1):
        area = SurveyArea(square(0, 0, 100)[::turn], (square(40, 40, 20)[::turn],))
        assert area.polygon(frame).area == pytest.approx(9600.0, rel=1e-5)
        assert distance_m(area.centroid(), offset(HOME, 50.0, 50.0)) < 0.01


def test_closing_and_repeated_corners_are_dropped():
    """A closed ring with a corner said twice is the same area."""
    plain = square(0, 0, 100)
    closed = SurveyArea((plain[0], *plain, plain[0]))
    assert closed == SurveyArea(plain)


LINE = tuple(GeoPosition(53.28, lon) for lon in (-9.06, -9.05, -9.055))
"""On one parallel, which is a curve of millimetres in the plane."""
MANY = tuple(
    offset(HOME, 100.0 * math.cos(k / 3000.0), 100.0 * math.sin(k / 3000.0)) for k in range(18_000)
)
POLAR = tuple(GeoPosition(lat, lon) for lat, lon in ((86, 0), (86, 1), (86.1, 1)))
ACROSS = tuple(GeoPosition(lat, lon) for lat, lon in ((1, 179.9), (1, -179.9), (1.1, -179.9)))
WIDE = tuple(GeoPosition(lat, lon) for lat, lon in ((0, 0), (0, 6), (6, 6)))
BOX = square(0, 0, 100)
BOW_TIE = ring((0, 0), (100, 100), (100, 0), (0, 100))


@pytest.mark.parametrize(
    ('boundary', 'holes', 'message'),
    [
        (BOX[:2], (), 'the boundary has 2 distinct corners: must have at least 3'),
        ((), (), 'the boundary has 0 distinct corners'),
        ((BOX[0], BOX[1], BOX[0], BOX[0]), (), 'has 2 distinct corners'),
        (ring((0, 0), (50, 50), (100, 100)), (), 'the boundary encloses .* must enclose at least'),
        (LINE, (), r'is 0\.\d+ m wide in the mean: must be at least 0\.1 m .it is a line'),
        (MANY, (), 'the boundary has 18000 corners: must have at most 10000'),
        (BOW_TIE, (), r'the boundary crosses or touches itself near 53\.28\d+, -9\.059\d+'),
        (POLAR, (), 'at latitude 86 deg: must be within -85 to 85 deg'),
        (ACROSS, (), 'must not cross the antimeridian'),
        (WIDE, (), 'the boundary extends 941 km: must be within 500 km'),
        (BOX, (BOX[:2],), 'hole 1 has 2 distinct corners'),
        (BOX, (square(90, 90, 20),), 'hole 1 reaches outside the boundary near 53.28'),
        (BOX, (square(10, 10, 20), square(200, 0, 5)), 'hole 2 reaches outside'),
        (BOX, (square(10, 10, 20), square(20, 20, 20)), 'holes 1 and 2 overlap near 53.28'),
        (BOX, (BOX,), 'nothing to survey'),
    ],
)
def test_what_is_no_area_is_refused(boundary, holes, message):
    """The refusal is one line with the ring, the place or value, and the limit."""
    with pytest.raises(ValueError, match=message) as refusal:
        SurveyArea(boundary, holes)
    assert '\n' not in str(refusal.value)


def test_crossing_place_is_named():
    """The place named for a bow tie is its crossing, 50 m east and north of the corner."""
    with pytest.raises(ValueError, match='crosses') as refusal:
        SurveyArea(BOW_TIE)
    latitude, longitude = str(refusal.value).split('near ')[1].split(':')[0].split(', ')
    place = GeoPosition(float(latitude), float(longitude))
    assert distance_m(place, offset(HOME, 50.0, 50.0)) < 0.5
