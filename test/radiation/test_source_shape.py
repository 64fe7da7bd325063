# SPDX-License-Identifier: Apache-2.0
"""Sources along lines, over areas and on the move agree with formulas worked by hand."""

import math

import numpy as np
import pytest

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition, offset
from rocsafe_radiation.physics.field import RadiationField
from rocsafe_radiation.physics.source import RadiationSource
from rocsafe_radiation.physics.source_shape import AreaShape, LineShape, TrackShape

WRECK = GeoPosition(53.2838, -9.0633, 60.0)
# Sources are taken apart into points half a metre apart.
TOLERANCE = 2e-3


def field_of(shape, sigma_usvps=1.0):
    """Return the lossless field of one source of `shape`."""
    source = RadiationSource(name='x', position=WRECK, sigma_usvps=sigma_usvps, shape=shape)
    return RadiationField(sources=(source,))


def rate_usvh(field, east_m, north_m, up_m, time_s=0.0):
    """Return the dose rate at a place relative to the wreck."""
    place = offset(WRECK, east_m, north_m, up_m)
    rates = field.source_dose_rates_usvh(
        place.latitude_deg, place.longitude_deg, place.altitude_m, time_s
    )
    return rates[:, 0].sum()


def test_a_line_gives_what_its_integral_says():
    """Sigma / L * 2 / h * atan(L / 2h) at the height h over its middle."""
    ends = (offset(WRECK, -20.0, 0.0), offset(WRECK, 20.0, 0.0))
    for height in (2.0, 10.0, 32.0):
        exact = 1.0 / 40.0 * 2.0 / height * math.atan(20.0 / height) * 3600.0
        found = rate_usvh(field_of(LineShape(corners=ends)), 0.0, 0.0, height)
        assert found == pytest.approx(exact, rel=TOLERANCE)


def test_a_bent_line_is_spread_evenly_along_its_length():
    """A long and a short leg carry what their lengths are worth."""
    corners = (offset(WRECK, 0.0, 0.0), offset(WRECK, 30.0, 0.0), offset(WRECK, 30.0, 10.0))
    places = LocalFrame(WRECK).to_enu(*LineShape(corners=corners).places(0.0).T)
    assert np.mean(places[:, 1] < 0.01) == pytest.approx(0.75, abs=0.02)


def test_an_area_gives_what_its_integral_says():
    """Sigma / R^2 * ln(1 + R^2 / h^2) over the middle of a disc."""
    angles = np.linspace(0.0, 2.0 * math.pi, 90, endpoint=False)
    corners = tuple(offset(WRECK, 15.0 * math.cos(a), 15.0 * math.sin(a)) for a in angles)
    found = rate_usvh(field_of(AreaShape(corners=corners)), 0.0, 0.0, 20.0)
    exact = math.log(1.0 + 15.0**2 / 20.0**2) / 15.0**2 * 3600.0
    assert found == pytest.approx(exact, rel=5e-3)


def test_far_from_any_shape_it_is_a_point():
    """A kilometre away, a line of 10 m is one."""
    line = LineShape(corners=(offset(WRECK, -5.0, 0.0), offset(WRECK, 5.0, 0.0)))
    found = rate_usvh(field_of(line), 0.0, 1000.0, 0.0)
    assert found == pytest.approx(rate_usvh(field_of(None), 0.0, 1000.0, 0.0), rel=1e-4)


def test_a_moving_source_is_where_its_track_says():
    """It waits before the first time, moves evenly, and stays at the end."""
    track = TrackShape(times_s=(10.0, 20.0), stops=(WRECK, offset(WRECK, 100.0, 0.0)))
    field = field_of(track)
    for time_s, east in ((0.0, 0.0), (10.0, 0.0), (15.0, 50.0), (20.0, 100.0), (99.0, 100.0)):
        found = rate_usvh(field, east, 0.0, 10.0, time_s)
        assert found == pytest.approx(36.0, rel=1e-4)


def test_a_tiny_area_is_still_there():
    """Even one that no node of the grid hits."""
    corners = tuple(offset(WRECK, e, n) for e, n in ((0, 0), (0.02, 0), (0, 0.02)))
    assert rate_usvh(field_of(AreaShape(corners=corners)), 0.0, 0.0, 10.0) == pytest.approx(
        36.0, rel=1e-3
    )


@pytest.mark.parametrize(
    ('make', 'message'),
    [
        (lambda: LineShape(corners=(WRECK,)), 'a line has 1 corners'),
        (lambda: LineShape(corners=(WRECK, WRECK)), 'longer than 0 m'),
        (lambda: AreaShape(corners=(WRECK, WRECK)), 'an area has 2 corners'),
        (lambda: AreaShape(corners=(WRECK,) * 3), 'must not cross or coincide'),
        (lambda: TrackShape(times_s=(1.0, 1.0), stops=(WRECK, WRECK)), 'must rise'),
        (lambda: TrackShape(times_s=(1.0,), stops=(WRECK, WRECK)), '1 times and 2 stops'),
    ],
)
def test_a_wrong_shape_is_refused(make, message):
    """Saying what is wrong."""
    with pytest.raises(ValueError, match=message):
        make()
