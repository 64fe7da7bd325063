# SPDX-License-Identifier: Apache-2.0
"""The sun stands where almanacs say, and weather takes of its light."""

import math
from datetime import datetime, timezone

import numpy as np
import pytest

from rocsafe_scene.scene.sunlight import WEATHERS, lighting, sun_direction

# Time, latitude, longitude; height and azimuth, degrees: solstices and an equinox at culmination
# follow from the declination alone (90 - latitude +- 23.44).
NOONS = [
    (datetime(2025, 6, 21, 12, 2, tzinfo=timezone.utc), 51.4779, 0.0, 61.96, 180.0),
    (datetime(2025, 12, 21, 11, 58, tzinfo=timezone.utc), 51.4779, 0.0, 15.08, 180.0),
    (datetime(2025, 3, 20, 12, 7, tzinfo=timezone.utc), 0.0, 0.0, 89.95, None),
    (datetime(2025, 6, 21, 12, 2, tzinfo=timezone.utc), -33.0, 0.0, 33.56, 0.0),
]


@pytest.mark.parametrize(('time', 'latitude', 'longitude', 'height', 'azimuth'), NOONS)
def test_the_sun_culminates_where_it_should(time, latitude, longitude, height, azimuth):
    """Within a tenth of a degree in height and half a degree in azimuth."""
    east, north, up = sun_direction(time, latitude, longitude)
    assert math.degrees(math.asin(up)) == pytest.approx(height, abs=0.1)
    if azimuth is not None:
        turned = (math.degrees(math.atan2(east, north)) - azimuth + 180.0) % 360.0 - 180.0
        assert abs(turned) < 0.5


def test_the_sun_rises_in_the_east():
    """In the morning it stands east, in the evening west."""
    morning = sun_direction(datetime(2025, 6, 1, 7, tzinfo=timezone.utc), 53.28, -9.06)
    evening = sun_direction(datetime(2025, 6, 1, 19, tzinfo=timezone.utc), 53.28, -9.06)
    assert morning[0] > 0.5 > -0.5 > evening[0]


@pytest.mark.parametrize('weather', WEATHERS)
def test_every_weather_is_usable_at_every_hour(weather):
    """Light is finite and never dark, the sun never below the horizon that shadows need."""
    for hour in range(0, 24, 3):
        direction = sun_direction(datetime(2025, 1, 5, hour, tzinfo=timezone.utc), 53.0, -9.0)
        light = lighting(direction, weather)
        assert np.isfinite(light.sun).all()
        assert light.sun_direction[2] > 0.05
        assert max(light.zenith) > 0.0
        assert np.linalg.norm(light.sun_direction) == pytest.approx(1.0)


def test_an_unknown_weather_is_refused():
    """The line names the weathers there are."""
    with pytest.raises(ValueError, match="weather is 'hail': must be one of clear"):
        lighting(np.array([0.0, 0.0, 1.0]), 'hail')
