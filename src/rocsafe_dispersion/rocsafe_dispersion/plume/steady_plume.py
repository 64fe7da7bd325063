# SPDX-License-Identifier: Apache-2.0
"""The mean concentration downwind of a steady release: a Gaussian plume."""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import Travel, at_rows, vertical_shape
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.wind.wind_vector import WindVector


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SteadyPlume:
    """A plume that has reached everywhere; concentrations are means over about 10 minutes.

    Attributes
    ----------
    release
        A steady release.
    travel
        How it spreads.
    wind
        Where it goes; its speed does not count, `travel` has it.

    Examples
    --------
    Downwind of a leak of 1 g/s the air gets cleaner with distance; upwind it stays clean:

    >>> from rocsafe_dispersion.plume.spread import similarity_travel
    >>> from rocsafe_geo.wind.similarity import SurfaceLayer
    >>> layer = SurfaceLayer(friction_velocity_mps=0.35, roughness_m=0.03)
    >>> plume = SteadyPlume(
    ...     release=Release(place_m=(0.0, 0.0), height_m=1.0, rate_g_s=1.0),
    ...     travel=similarity_travel(layer, 1.0),
    ...     wind=WindVector(towards_east_mps=5.0, towards_north_mps=0.0),
    ... )
    >>> upwind, near, far = plume.concentrations_g_m3(
    ...     np.array([[-50.0, 0.0, 1.5], [50.0, 0.0, 1.5], [200.0, 0.0, 1.5]])
    ... )
    >>> bool(near > far > upwind == 0.0)
    True
    """

    release: Release
    travel: Travel
    wind: WindVector

    def __post_init__(self) -> None:
        if not self.release.rate_g_s > 0.0:
            raise ValueError('a plume needs a release with a rate; a burst makes puffs')
        if not self.wind.speed_mps > 0.0:
            raise ValueError('a plume needs a wind above 0 m/s')

    def concentrations_g_m3(self, places_m: FloatArray) -> FloatArray:
        """Return the concentrations at places (n, 3), heights above the ground, (n,), g/m^3."""
        along, across = self.along_across_m(places_m[:, :2])
        rows = self.travel.rows(along)
        columns = (self.travel.sigma_y_m, self.travel.sigma_z_m, self.travel.speeds_mps)
        sigma_y, sigma_z, speed = (at_rows(column, rows) for column in columns)
        flow = self.release.rate_g_s * at_rows(self.travel.airborne, rows) / speed
        middle = at_rows(self.travel.heights_m(), rows)
        sideways = np.exp(-0.5 * (across / sigma_y) ** 2) / (math.sqrt(2.0 * math.pi) * sigma_y)
        return np.where(
            along > 0.0, flow * sideways * vertical_shape(places_m[:, 2], middle, sigma_z), 0.0
        )

    def concentration_g_m3(self, east_m: float, north_m: float, height_m: float) -> float:
        """Return the concentration at one place, g/m^3: as of many, in a tenth of the time."""
        wind, (east0_m, north0_m) = self.wind, self.release.place_m
        east, north = (east_m - east0_m) / wind.speed_mps, (north_m - north0_m) / wind.speed_mps
        along = east * wind.towards_east_mps + north * wind.towards_north_mps
        if along <= 0.0:
            return 0.0
        across = north * wind.towards_east_mps - east * wind.towards_north_mps
        sigma_y, sigma_z, speed, airborne, fallen = self.travel.at(along)
        middle = max(self.travel.height_m - fallen, 0.0)
        heights = ((height_m - middle) / sigma_z, (height_m + middle) / sigma_z)
        upright = sum(math.exp(-0.5 * height * height) for height in heights)
        sideways = math.exp(-0.5 * (across / sigma_y) ** 2)
        flow = self.release.rate_g_s * airborne / speed
        return flow * sideways * upright / (2.0 * math.pi * sigma_y * sigma_z)

    def along_across_m(self, places_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how far places (n, 2) lie downwind of the release and to the left, metres."""
        east = self.wind.towards_east_mps / self.wind.speed_mps
        north = self.wind.towards_north_mps / self.wind.speed_mps
        offset = places_m - np.array(self.release.place_m)
        along = offset[:, 0] * east + offset[:, 1] * north
        return along, offset[:, 1] * east - offset[:, 0] * north
