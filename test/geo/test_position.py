# SPDX-License-Identifier: Apache-2.0
"""Offsets on a plane, against geodesy written out by hand."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from test.geo.geodesy import enu

from rocsafe_geo.position import GeoPosition, level_offset_m

# A sphere in place of the ellipsoid, and meridians taken for parallel over 3 km up to 70 degrees.
LARGEST_SHARE = 0.01


@given(
    latitude_deg=st.floats(-70.0, 70.0),
    longitude_deg=st.floats(-180.0, 180.0),
    distance_m=st.floats(1.0, 3000.0),
    bearing_rad=st.floats(0.0, 2.0 * math.pi),
)
def test_offset_on_a_plane_is_that_of_the_ellipsoid(
    latitude_deg, longitude_deg, distance_m, bearing_rad
):
    """To one part in a hundred of the distance, also across the date line."""
    north_deg = distance_m * math.cos(bearing_rad) / 111_195.0
    east_deg = distance_m * math.sin(bearing_rad) / 111_195.0
    other_deg = longitude_deg + east_deg / math.cos(math.radians(latitude_deg))
    other = (latitude_deg + north_deg, math.remainder(other_deg, 360.0))
    known = enu((latitude_deg, longitude_deg, 0.0), (*other, 0.0))[:2]
    found = level_offset_m(GeoPosition(latitude_deg, longitude_deg), GeoPosition(*other))
    assert math.dist(found, known) <= LARGEST_SHARE * distance_m


def test_offset_to_the_same_place_is_zero():
    """Whatever its altitude."""
    place = GeoPosition(53.28, -9.06, 30.0)
    assert level_offset_m(place, GeoPosition(53.28, -9.06)) == pytest.approx((0.0, 0.0))
