# SPDX-License-Identifier: Apache-2.0
"""The local frame against geodesy that shares no code with it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition, distance_m, ecef_m, offset

from . import geodesy

ONE_MM = 1e-3
# One origin in each quarter of the globe, one on equator and Greenwich, one beside the
# antimeridian, one far north.
ORIGINS = [
    (53.28, -9.06, 60.0),
    (-33.9, 18.4, 25.0),
    (-22.9, -43.2, 800.0),
    (35.6, 139.7, 40.0),
    (0.0, 0.0, 0.0),
    (-17.0, 179.999, 3.0),
    (78.2, 15.6, 500.0),
]
BEARINGS_DEG = range(15, 360, 30)


@pytest.mark.parametrize('origin', ORIGINS)
@pytest.mark.parametrize('bearing_deg', BEARINGS_DEG)
def test_enu_agrees_with_the_geodesic(origin, bearing_deg):
    """East and north are the geodesic's sine and cosine to 1 mm at 2 km, in every quadrant."""
    east, north = (2000.0 * f(math.radians(bearing_deg)) for f in (math.sin, math.cos))
    home = GeoPosition(*origin)
    # A plane's distance is R sin(s/R): 0.03 mm less at 2 km. Off the ellipsoid it grows by h/R.
    level = GeoPosition(origin[0], origin[1], 0.0)
    point = LocalFrame(level).position_of([east, north, -(2000.0**2) / (2 * 6.371e6)])
    distance, azimuth = geodesy.vincenty(
        level.latitude_deg, level.longitude_deg, point.latitude_deg, point.longitude_deg
    )
    assert distance * math.sin(azimuth) == pytest.approx(east, abs=ONE_MM)
    assert distance * math.cos(azimuth) == pytest.approx(north, abs=ONE_MM)
    assert distance_m(home, point) == pytest.approx(distance, abs=1e-5)


@given(
    st.sampled_from(ORIGINS), st.floats(-2000, 2000), st.floats(-2000, 2000), st.floats(-50, 500)
)
def test_enu_agrees_with_the_closed_form(origin, east, north, up):
    """Both directions agree with hand-written ECEF algebra to a thousandth of a millimetre."""
    frame = LocalFrame(GeoPosition(*origin))
    lat, lon, alt = frame.to_geodetic([east, north, up])[0]
    np.testing.assert_allclose(geodesy.enu(origin, (lat, lon, alt)), (east, north, up), atol=1e-6)
    np.testing.assert_allclose(frame.to_enu(lat, lon, alt)[0], (east, north, up), atol=1e-6)
    np.testing.assert_allclose(ecef_m(lat, lon, alt)[0], geodesy.ecef(lat, lon, alt), atol=1e-6)


def test_signs_in_every_quadrant():
    """North-east, south-east, south-west and north-west of home have the signs of their names."""
    frame = LocalFrame(GeoPosition(53.28, -9.06, 0.0))
    enu = frame.to_enu([53.281, 53.279, 53.279, 53.281], [-9.059, -9.059, -9.061, -9.061], 0.0)
    assert np.sign(enu[:, :2]).tolist() == [[1, 1], [1, -1], [-1, -1], [-1, 1]]


def test_frame_spans_the_antimeridian():
    """A metre east stays a metre east where longitude jumps from 180 to -180."""
    frame = LocalFrame(GeoPosition(-17.0, 179.9999, 0.0))
    beyond = frame.position_of([100.0, 0.0, 0.0])
    assert beyond.longitude_deg < -179.99
    np.testing.assert_allclose(frame.enu_of(beyond), [100.0, 0.0, 0.0], atol=1e-6)


def test_unknown_altitude_keeps_the_horizontal_place():
    """NaN altitude gives east and north at the origin's altitude, and up NaN; and back."""
    frame = LocalFrame(GeoPosition(53.28, -9.06, 100.0))
    known = frame.enu_of(GeoPosition(53.281, -9.061, 100.0))
    unknown = frame.enu_of(GeoPosition(53.281, -9.061))
    assert unknown[:2].tolist() == known[:2].tolist()
    assert math.isnan(unknown[2])
    assert math.isnan(frame.position_of(unknown).altitude_m)


def test_frame_refuses_an_origin_of_unknown_altitude():
    """A frame without a datum of height is refused."""
    with pytest.raises(ValueError, match='origin altitude_m is nan'):
        LocalFrame(GeoPosition(53.28, -9.06))


@given(st.floats(-2000, 2000), st.floats(-2000, 2000))
def test_offset_and_distance_are_inverse(east, north):
    """The distance to an offset position is the length of the offset; altitude is kept."""
    home = GeoPosition(53.28, -9.06, 12.0)
    moved = offset(home, east, north, 5.0)
    assert distance_m(home, moved) == pytest.approx(math.hypot(east, north), abs=1e-6)
    assert moved.altitude_m == 17.0
    distance, azimuth = geodesy.vincenty(
        home.latitude_deg, home.longitude_deg, moved.latitude_deg, moved.longitude_deg
    )
    assert distance * math.sin(azimuth) == pytest.approx(east, abs=ONE_MM)
    assert distance * math.cos(azimuth) == pytest.approx(north, abs=ONE_MM)


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        ((90.1, 0.0), 'latitude_deg is 90.1: must be -90 to 90'),
        ((0.0, -180.5), 'longitude_deg is -180.5: must be -180 to 180'),
        ((math.nan, 0.0), 'latitude_deg is nan: must be a finite number'),
        ((0.0, 0.0, math.inf), 'altitude_m is inf: must be a finite number'),
        (('53', 0.0), "latitude_deg is '53': must be a number"),
    ],
)
def test_positions_off_the_globe_are_refused(arguments, message):
    """The refusal names the field, its value and the limit."""
    with pytest.raises(ValueError, match=message):
        GeoPosition(*arguments)


def test_positions_of_unknown_altitude_compare_equal():
    """Two positions with different NaN objects for the altitude are the same position."""
    assert GeoPosition(1.0, 2.0) == GeoPosition(1, 2, float('nan'))
