# SPDX-License-Identifier: Apache-2.0
"""Conversions lose nothing and refuse what is no position."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sensor_msgs.msg import NavSatFix, NavSatStatus

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_interfaces.msg import GeoPoint
from rocsafe_ros import conversions

latitudes = st.floats(-84, 84)
longitudes = st.floats(-180, 180)


@given(st.integers(0, (2**31 - 1) * 10**9))
def test_stamps_keep_every_nanosecond(time_ns):
    """Nanoseconds -> stamp -> nanoseconds is the identity."""
    assert conversions.ns_of_stamp(conversions.stamp_of_ns(time_ns)) == time_ns


@given(latitudes, longitudes, st.floats(-400, 9000))
def test_positions_round_trip(latitude_deg, longitude_deg, altitude_m):
    """Position -> message -> position is the identity."""
    position = GeoPosition(
        latitude_deg=latitude_deg, longitude_deg=longitude_deg, altitude_m=altitude_m
    )
    message = conversions.point_of_position(position)
    assert conversions.position_of_point(message) == position


def test_unknown_altitude_stays_unknown():
    """NaN is not turned into a number on the way."""
    message = conversions.point_of_position(GeoPosition(latitude_deg=1.0, longitude_deg=2.0))
    assert math.isnan(message.altitude)


def test_areas_with_holes_round_trip():
    """Boundary, holes and name survive."""
    corners = [(53.0, -9.0), (53.01, -9.0), (53.01, -8.99), (53.0, -8.99)]
    inner = [(53.004, -8.996), (53.006, -8.996), (53.005, -8.994)]
    area = SurveyArea(
        name='yard',
        boundary=tuple(GeoPosition(latitude_deg=a, longitude_deg=b) for a, b in corners),
        holes=(tuple(GeoPosition(latitude_deg=a, longitude_deg=b) for a, b in inner),),
    )
    back = conversions.area_of_region(conversions.region_of_area(area))
    assert back.name == 'yard'
    assert [(p.latitude_deg, p.longitude_deg) for p in back.boundary] == corners
    assert [(p.latitude_deg, p.longitude_deg) for p in back.holes[0]] == inner


@pytest.mark.parametrize('latitude', [math.nan, 1.0])
def test_fix_without_a_position(latitude):
    """No fix is never taken for 0/0."""
    fix = NavSatFix(latitude=latitude)
    fix.status.status = NavSatStatus.STATUS_NO_FIX
    assert not conversions.has_position(fix)


@pytest.mark.parametrize('values', [(91.0, 0.0, 0.0), (53.0, 0.0, 1e300), (-53.0, 170.0, 60.0)])
def test_place_beyond_any_flight_is_no_order(values):
    """A wild number would end the node of a vehicle where it is used first."""
    frame = LocalFrame(GeoPosition(53.28, -9.06, 60.0))
    latitude, longitude, altitude = values
    point = GeoPoint(latitude=latitude, longitude=longitude, altitude=altitude)
    with pytest.raises(ValueError, match='must be'):
        conversions.enu_of_point(point, frame)


def test_order_without_an_altitude_is_for_the_level_of_the_origin():
    """Its height is told elsewhere."""
    frame = LocalFrame(GeoPosition(53.28, -9.06, 60.0))
    point = GeoPoint(latitude=53.28, longitude=-9.06, altitude=math.nan)
    assert conversions.enu_of_point(point, frame) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
