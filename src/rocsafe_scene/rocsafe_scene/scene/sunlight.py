# SPDX-License-Identifier: Apache-2.0
"""Direction of the sun, and the light by weather."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from datetime import datetime, timezone

import numpy as np

from rocsafe_geo.limits import require_between
from rocsafe_scene.mesh.mesh import Floats

# Time of the sun in scenes that give none.
DEFAULT_TIME = datetime(2025, 6, 1, 14, 0, tzinfo=timezone.utc)
_J2000 = datetime(2000, 1, 1, 12, tzinfo=timezone.utc)
# Sine of the sun's elevation at dusk, and the least one with which shadows are drawn.
_DUSK_UP, _LEAST_UP = 0.12, 0.06
Light = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Weather:
    """Effect of a kind of weather on the light.

    Attributes
    ----------
    sun
        Share of the direct sunlight that arrives.
    sky
        Brightness of the sky's diffuse light.
    greyness
        How grey the sky is, 0 blue to 1 grey.
    haze_per_m
        Extinction along the line of sight.
    wetness
        How wet surfaces are, 0 to 1.
    clouds
        How distinct the clouds are in the sky.
    exposure
        Exposure factor of the camera.
    """

    sun: float
    sky: float
    greyness: float
    haze_per_m: float
    clouds: float
    wetness: float = 0.0
    exposure: float = 1.0


WEATHERS: Mapping[str, Weather] = {
    'clear': Weather(sun=1.0, sky=1.0, greyness=0.0, haze_per_m=0.00022, clouds=0.8),
    'overcast': Weather(
        sun=0.07, sky=1.5, greyness=0.9, haze_per_m=0.0005, clouds=0.25, exposure=1.15
    ),
    'wet': Weather(
        sun=0.05,
        sky=1.25,
        greyness=0.85,
        haze_per_m=0.0012,
        clouds=0.2,
        wetness=0.9,
        exposure=1.15,
    ),
    'fog': Weather(
        sun=0.03, sky=1.3, greyness=1.0, haze_per_m=0.011, clouds=0.0, wetness=0.3, exposure=1.1
    ),
    'dusk': Weather(
        sun=0.55, sky=0.55, greyness=0.15, haze_per_m=0.0006, clouds=0.9, exposure=1.35
    ),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Lighting:
    """The light of a scene; colours are linear, 1 is a white surface in full sun.

    Attributes
    ----------
    sun_direction
        Unit vector towards the sun, east, north, up.
    sun
        Direct light on a surface that faces it.
    zenith, horizon
        Colours of the sky.
    bounce
        Light from the ground on surfaces that face down.
    haze_per_m
        Extinction along the line of sight; distant objects take on the colour of the horizon.
    clouds
        How distinct the clouds are in the sky.
    wetness
        Wetness of surfaces, 0 to 1.
    exposure
        Factor before the tone curve.
    """

    sun_direction: Light
    sun: Light
    zenith: Light
    horizon: Light
    bounce: Light
    haze_per_m: float
    clouds: float
    wetness: float
    exposure: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Air:
    """What is added to the weather of a scene.

    Attributes
    ----------
    fog
        0: none, to 1: as in the weather ``fog``.
    wetness
        Least wetness of surfaces, 0 to 1.
    """

    fog: float = 0.0
    wetness: float = 0.0

    def __post_init__(self) -> None:
        require_between('fog', self.fog, 0.0, 1.0)
        require_between('wetness', self.wetness, 0.0, 1.0)

    def added_to(self, weather: Weather) -> Weather:
        """Return the weather with this fog and wetness."""
        foggy = WEATHERS['fog']
        mixed = {
            each.name: (1.0 - self.fog) * getattr(weather, each.name)
            + self.fog * getattr(foggy, each.name)
            for each in fields(Weather)
        }
        return Weather(**{**mixed, 'wetness': max(self.wetness, mixed['wetness'])})


def sun_direction(time: datetime, latitude_deg: float, longitude_deg: float) -> Floats:
    """Return the unit vector towards the sun, east, north, up, (3,).

    Low precision formulas of the Astronomical Almanac (page C5): error below 0.01 deg between 1950
    and 2050, without refraction.
    """
    days = (time - _J2000).total_seconds() / 86_400.0
    anomaly = math.radians(357.528 + 0.9856003 * days)
    longitude = math.radians(
        280.460 + 0.9856474 * days + 1.915 * math.sin(anomaly) + 0.020 * math.sin(2.0 * anomaly)
    )
    tilt = math.radians(23.439 - 4e-7 * days)
    ascension = math.atan2(math.cos(tilt) * math.sin(longitude), math.cos(longitude))
    declination = math.asin(math.sin(tilt) * math.sin(longitude))
    sidereal = math.radians(280.46062 + 360.98564737 * days + longitude_deg)
    hour, latitude = sidereal - ascension, math.radians(latitude_deg)
    east = -math.cos(declination) * math.sin(hour)
    north = math.cos(latitude) * math.sin(declination) - math.sin(latitude) * math.cos(
        declination
    ) * math.cos(hour)
    up = math.sin(latitude) * math.sin(declination) + math.cos(latitude) * math.cos(
        declination
    ) * math.cos(hour)
    return np.array([east, north, up])


def lighting(direction: Floats, weather: str, air: Air | None = None) -> Lighting:
    """Return the light of a sun in `direction` (3,) in `weather`, with what `air` adds.

    When the sun is below the horizon, a dim light just above it takes its place.

    Raises
    ------
    ValueError
        If there is no such weather.
    """
    if weather not in WEATHERS:
        raise ValueError(f'weather is {weather!r}: must be one of {", ".join(WEATHERS)}')
    kind = (air or Air()).added_to(WEATHERS[weather])
    height = _DUSK_UP if weather == 'dusk' else float(direction[2])
    if weather == 'dusk':
        direction = _at_height(direction, _DUSK_UP)
    elif direction[2] < _LEAST_UP:
        direction = _at_height(direction, _LEAST_UP)
    day = min(1.0, max(0.0, (height + 0.05) / 0.3))
    redness = math.exp(-max(height, 0.0) / 0.16)
    sun = _mix((3.1, 2.95, 2.68), (2.5, 1.15, 0.45), redness)
    strength = kind.sun * max(0.03, min(1.0, (height + 0.02) / 0.1))
    zenith = _mix(
        _mix((0.13, 0.27, 0.6), (0.3, 0.3, 0.46), redness), (0.5, 0.53, 0.57), kind.greyness
    )
    horizon = _mix(
        _mix((0.6, 0.74, 0.88), (1.0, 0.58, 0.34), redness), (0.66, 0.68, 0.7), kind.greyness
    )
    sky = kind.sky * (0.04 + 0.96 * day)
    bounce = _times(_mix((0.16, 0.16, 0.1), (0.14, 0.14, 0.13), kind.greyness), sky)
    return Lighting(
        sun_direction=_light(direction),
        sun=_times(sun, strength),
        zenith=_times(zenith, sky),
        horizon=_times(horizon, sky),
        bounce=bounce,
        haze_per_m=kind.haze_per_m,
        clouds=kind.clouds,
        wetness=kind.wetness,
        exposure=kind.exposure,
    )


def _at_height(direction: Floats, up: float) -> Floats:
    """Return the direction with the same azimuth whose third component is `up`."""
    flat = direction[:2] / max(1e-6, float(np.hypot(*direction[:2])))
    return np.array([*(flat * math.sqrt(1.0 - up**2)), up])


def _light(values: Floats) -> Light:
    first, second, third = (float(value) for value in values)
    return first, second, third


def _mix(one: Light, two: Light, share: float) -> Light:
    return _light(np.array(one) * (1.0 - share) + np.array(two) * share)


def _times(light: Light, factor: float) -> Light:
    return _light(np.array(light) * factor)
