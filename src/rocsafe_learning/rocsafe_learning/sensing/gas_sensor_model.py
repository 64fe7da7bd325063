# SPDX-License-Identifier: Apache-2.0
"""A gas sensor in the plume of a steady release near the ground."""

import math
from dataclasses import dataclass, field

import numpy as np

from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_dispersion.plume.steady_plume import SteadyPlume
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_positive
from rocsafe_geo.wind.similarity import surface_layer
from rocsafe_geo.wind.wind_vector import wind_from

RELEASE_HEIGHT_M = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class PlumeSensor:
    """A sensor that reads concentrations, in mg/m^3.

    Attributes
    ----------
    height_m
        Height of the drone above the ground, metres.
    wind_mps, wind_from_deg
        Wind at 10 m: speed, m/s, and where it comes from, degrees clockwise from north.
    weakest_g_s, strongest_g_s
        Range of the rate of the release, grams per second.
    noise_mg_m3
        Standard deviation without gas, mg/m^3.
    relative_error
        Standard deviation in proportion to the concentration: gusts.
    """

    height_m: float = 3.0
    wind_mps: float = 3.0
    wind_from_deg: float = 240.0
    weakest_g_s: float = 0.5
    strongest_g_s: float = 50.0
    noise_mg_m3: float = 0.2
    relative_error: float = 0.3
    _plume_of_1_g_s: SteadyPlume = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in ('height_m', 'wind_mps', 'weakest_g_s', 'noise_mg_m3', 'relative_error'):
            require_positive(name, getattr(self, name))
        if not self.weakest_g_s <= self.strongest_g_s <= 1e6:
            raise ValueError(
                f'strongest_g_s = {self.strongest_g_s:g} must be within weakest_g_s = '
                f'{self.weakest_g_s:g} and 1e6'
            )
        layer = surface_layer(self.wind_mps, 10.0)
        plume = SteadyPlume(
            release=Release(place_m=(0.0, 0.0), height_m=RELEASE_HEIGHT_M, rate_g_s=1.0),
            travel=similarity_travel(layer, RELEASE_HEIGHT_M),
            wind=wind_from(self.wind_mps, self.wind_from_deg),
        )
        object.__setattr__(self, '_plume_of_1_g_s', plume)

    def strengths(self, shares: FloatArray) -> FloatArray:
        """Return rates of the release; equal shares are equal ratios, (n,), g/s."""
        ratio = self.strongest_g_s / self.weakest_g_s
        return np.asarray(self.weakest_g_s * ratio ** np.asarray(shares))

    def expected(self, offsets_m: FloatArray, strength: float) -> tuple[FloatArray, FloatArray]:
        """Return mean and variance of readings, see `SensorModel`."""
        flat = np.asarray(offsets_m, float).reshape(-1, 2)
        places = np.column_stack([flat, np.full(len(flat), self.height_m)])
        shares = self._plume_of_1_g_s.concentrations_g_m3(places)
        values = 1e3 * strength * shares.reshape(offsets_m.shape[:-1])
        return values, self.noise_mg_m3**2 + (self.relative_error * values) ** 2

    def draw(
        self, offset_m: tuple[float, float], strength: float, generator: np.random.Generator
    ) -> float:
        """Return a random reading, see `SensorModel`."""
        share = self._plume_of_1_g_s.concentration_g_m3(*offset_m, self.height_m)
        mean = 1e3 * strength * share
        return generator.normal(mean, math.hypot(self.noise_mg_m3, self.relative_error * mean))
