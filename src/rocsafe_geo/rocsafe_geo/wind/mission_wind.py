# SPDX-License-Identifier: Apache-2.0
"""The wind of a mission, as one block of settings: it pushes the vehicles and carries the gas."""

import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from rocsafe_geo.limits import require_between
from rocsafe_geo.wind.anemometer_file import read_wind
from rocsafe_geo.wind.gusts import GustyWind
from rocsafe_geo.wind.similarity import SurfaceLayer
from rocsafe_geo.wind.site_wind import SitePattern, SiteWind
from rocsafe_geo.wind.site_wind_file import read_pattern
from rocsafe_geo.wind.stability import StabilityClass, layer_of_class
from rocsafe_geo.wind.wind_field import ProfileWind, UniformWind, WindField
from rocsafe_geo.wind.wind_vector import WindVector

# In less wind nothing is released: no plume is carried anywhere.
LEAST_WIND_MPS = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class WindSettings:
    """The mean wind, which vehicles plan with, and how the air differs from it.

    Attributes
    ----------
    towards_east_mps, towards_north_mps
        Velocity of the air at `height_m`: where it goes to, m/s.
    height_m
        Height above the ground of these and of the record, metres.
    roughness_m
        Roughness length of the ground, metres.
    stability
        Pasquill class, A very unstable to F stable.
    gust_std_mps, gust_scale_s
        Standard deviation of the gusts along each horizontal axis, m/s, and their time scale, s.
    record_file
        Record of an anemometer, whose wind takes the place of the mean wind; empty: none.
    site_file
        File of ``rocsafe site-wind``, how a site changes the wind; empty: open ground.
    """

    towards_east_mps: float = 0.0
    towards_north_mps: float = 0.0
    height_m: float = 10.0
    roughness_m: float = 0.03
    stability: StabilityClass = 'D'
    gust_std_mps: float = 0.0
    gust_scale_s: float = 20.0
    record_file: str = ''
    site_file: str = ''

    def __post_init__(self) -> None:
        for name in ('towards_east_mps', 'towards_north_mps'):
            require_between(name, getattr(self, name), -50.0, 50.0, 'm/s')
        require_between('height_m', self.height_m, 1.0, 200.0, 'm')
        require_between('roughness_m', self.roughness_m, 1e-3, 0.5, 'm')
        require_between('gust_std_mps', self.gust_std_mps, 0.0, 20.0, 'm/s')
        require_between('gust_scale_s', self.gust_scale_s, 1.0, 3600.0, 's')

    @property
    def is_steady(self) -> bool:
        """Whether it is everywhere and always the mean wind, up to its profile."""
        return not (self.gust_std_mps or self.record_file or self.site_file)

    def layer(self) -> SurfaceLayer | None:
        """Return the profile of the mean wind; None in less wind than `LEAST_WIND_MPS`."""
        speed = math.hypot(self.towards_east_mps, self.towards_north_mps)
        if speed < LEAST_WIND_MPS:
            return None
        return layer_of_class(self.stability, speed, self.height_m, self.roughness_m)


def mission_wind(settings: WindSettings, seed: int) -> WindField:
    """Return the wind of settings; `seed` is that of the gusts.

    Raises
    ------
    ValueError
        In one line, if a file cannot be read.
    """
    wind = _open_wind(settings)
    if settings.gust_std_mps:
        wind = GustyWind(
            mean=wind,
            sigma_east_mps=settings.gust_std_mps,
            sigma_north_mps=settings.gust_std_mps,
            time_scale_s=settings.gust_scale_s,
            seed=seed,
        )
    if settings.site_file:
        wind = SiteWind(pattern=_pattern_of(settings.site_file), open_wind=wind)
    return wind


@lru_cache(maxsize=1)
def _pattern_of(file: str) -> SitePattern:
    # Vehicles of one process have it in common: it is large, and no run changes it.
    return read_pattern(Path(file))


def _open_wind(settings: WindSettings) -> WindField:
    layer = settings.layer()
    if settings.record_file:
        return read_wind(Path(settings.record_file), layer, settings.height_m)
    mean = WindVector(
        towards_east_mps=settings.towards_east_mps, towards_north_mps=settings.towards_north_mps
    )
    if layer is None:
        return UniformWind(wind=mean)
    return ProfileWind(layer=layer, wind=mean, reference_height_m=settings.height_m)
