# SPDX-License-Identifier: Apache-2.0
"""The dose-rate field is the paper's formula, everywhere finite."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.position import GeoPosition, ecef_m, offset
from rocsafe_radiation.errors import UnknownPointError
from rocsafe_radiation.physics.field import RadiationField, dose_rate_usvps
from rocsafe_radiation.physics.source import RadiationSource

# Float64 keeps 2e-16; the formula is one product and one quotient.
FORMULA_TOLERANCE = 1e-12
# Geocentric coordinates of 6.4e6 m round to 1 nm, so 32 m carry 6e-11 relative, dose rates twice.
DISTANCE_TOLERANCE = 3e-10
WRECK = GeoPosition(53.2838, -9.0633, 60.0)


def source_at(position, sigma_usvps=2.57, name='wreck'):
    """Return a source."""
    return RadiationSource(name=name, position=position, sigma_usvps=sigma_usvps)


def rate_usvh(field, position):
    """Return the dose rate at one position."""
    rates = field.source_dose_rates_usvh(
        position.latitude_deg, position.longitude_deg, position.altitude_m
    )
    return rates[:, 0].sum()


def test_one_microsievert_per_second_at_1_m_is_3600_per_hour():
    """The unit of sigma is per second, that of readings per hour."""
    field = RadiationField(sources=(source_at(WRECK, 1.0),))
    assert rate_usvh(field, offset(WRECK, 0.0, 0.0, 1.0)) == pytest.approx(3600.0, rel=1e-8)


def test_a_drone_32_m_above_reads_sigma_over_1024():
    """Worked by hand: 2.57 uSv/s / 32^2 * 3600 s/h = 9.03515625 uSv/h."""
    field = RadiationField(sources=(source_at(WRECK),))
    above = offset(WRECK, 0.0, 0.0, 32.0)
    assert rate_usvh(field, above) == pytest.approx(9.03515625, rel=DISTANCE_TOLERANCE)


def test_distance_is_the_slant_of_a_3_4_5_triangle():
    """30 m east and 40 m up are 50 m away, not 30 m."""
    field = RadiationField(sources=(source_at(WRECK, 2500.0),))
    place = offset(WRECK, 30.0, 0.0, 40.0)
    # The geodesic is 30 m at the ellipsoid, 60 m to 100 m below: longer by up to 16 ppm up there.
    assert rate_usvh(field, place) == pytest.approx(3600.0, rel=4e-5)


@given(
    sigma=st.floats(1e-6, 1e9),
    distance=st.floats(0.1, 1e5),
)
def test_the_formula_is_exact(sigma, distance):
    """The model is sigma / d^2 to 1e-12."""
    rates = dose_rate_usvps(sigma, np.array([distance]), 0.1)
    assert rates[0] == pytest.approx(sigma / distance**2, rel=FORMULA_TOLERANCE)


@pytest.mark.slow
@given(
    east=st.floats(-2000, 2000),
    north=st.floats(-2000, 2000),
    up=st.floats(1, 200),
    latitude=st.floats(-80, 80),
    longitude=st.floats(-179, 179),
)
def test_the_field_is_the_formula_at_the_slant_distance(east, north, up, latitude, longitude):
    """In all four quadrants of the globe."""
    centre = GeoPosition(latitude, longitude, 25.0)
    place = offset(centre, east, north, up)
    field = RadiationField(sources=(source_at(centre, 7.0),))
    ends = ecef_m(
        [latitude, place.latitude_deg], [longitude, place.longitude_deg], [25.0, 25.0 + up]
    )
    expected = 7.0 / float(np.sum((ends[1] - ends[0]) ** 2)) * 3600.0
    assert rate_usvh(field, place) == pytest.approx(expected, rel=FORMULA_TOLERANCE)


def test_sources_add_up():
    """Two sources together read the sum of each alone."""
    sources = (source_at(WRECK), source_at(offset(WRECK, 80.0, 10.0), 5.0, 'drum'))
    place = offset(WRECK, 20.0, -30.0, 32.0)
    alone = [rate_usvh(RadiationField(sources=(source,)), place) for source in sources]
    together = rate_usvh(RadiationField(sources=sources), place)
    assert together == pytest.approx(sum(alone), rel=FORMULA_TOLERANCE)


@pytest.mark.parametrize('up_m', [0.0, 1e-9, 0.05, 0.0999])
def test_at_the_source_the_rate_is_that_at_its_radius(up_m):
    """Neither infinite nor NaN: below the radius the distance counts as the radius."""
    field = RadiationField(sources=(source_at(WRECK, 2.0),), source_radius_m=0.1)
    rate = rate_usvh(field, offset(WRECK, 0.0, 0.0, up_m))
    assert rate == pytest.approx(2.0 / 0.1**2 * 3600.0, rel=FORMULA_TOLERANCE)


def test_the_strongest_source_at_the_smallest_radius_is_finite():
    """No permitted field overflows."""
    field = RadiationField(sources=(source_at(WRECK, 1e12),), source_radius_m=1e-3)
    assert math.isfinite(rate_usvh(field, WRECK))


def test_no_source_reads_zero():
    """A field without sources is zero, not empty."""
    assert rate_usvh(RadiationField(sources=()), WRECK) == 0.0


def test_many_points_at_once_equal_each_alone():
    """Vectorised: shape (n,) in, shape (n,) out."""
    field = RadiationField(sources=(source_at(WRECK),))
    latitudes = np.linspace(53.28, 53.29, 7)
    (together,) = field.source_dose_rates_usvh(latitudes, -9.06, 90.0)
    alone = [field.source_dose_rates_usvh(latitude, -9.06, 90.0)[0, 0] for latitude in latitudes]
    assert together.shape == (7,)
    np.testing.assert_array_equal(together, alone)


@pytest.mark.parametrize(
    ('latitude', 'longitude', 'altitude', 'message'),
    [
        (math.nan, 0.0, 0.0, 'point 0: latitude = nan'),
        (90.1, 0.0, 0.0, 'point 0: latitude = 90.1 must be within -90 and 90'),
        (0.0, -180.5, 0.0, 'longitude = -180.5'),
        (0.0, 0.0, math.inf, 'altitude = inf must be finite'),
        (0.0, 0.0, math.nan, 'altitude = nan'),
    ],
)
def test_what_is_no_place_is_refused(latitude, longitude, altitude, message):
    """The error names the point, the coordinate and its limit."""
    with pytest.raises(UnknownPointError, match=message):
        RadiationField(sources=()).source_dose_rates_usvh(latitude, longitude, altitude)


@pytest.mark.parametrize('sigma', [0.0, -1.0, math.nan, math.inf, 1e13])
def test_a_source_has_a_positive_finite_sigma(sigma):
    """Refused with the source's name."""
    with pytest.raises(ValueError, match='source wreck: sigma_usvps'):
        source_at(WRECK, sigma)


def test_a_source_has_an_altitude():
    """An unknown altitude would make every distance NaN."""
    with pytest.raises(ValueError, match='altitude_m'):
        source_at(GeoPosition(53.0, -9.0))


def test_two_sources_of_one_name_are_refused():
    """Names tell sources apart in reports."""
    with pytest.raises(ValueError, match='source names must differ: wreck, wreck'):
        RadiationField(sources=(source_at(WRECK), source_at(WRECK)))


@pytest.mark.parametrize('radius', [0.0, -1.0, math.nan, math.inf, 1e-4])
def test_the_source_radius_has_a_lower_limit(radius):
    """Zero would bring the singularity back."""
    with pytest.raises(ValueError, match='source_radius_m'):
        RadiationField(sources=(), source_radius_m=radius)
