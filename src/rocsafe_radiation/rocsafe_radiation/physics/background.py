# SPDX-License-Identifier: Apache-2.0
"""Natural background: radiation of the ground, which varies by place, and of the sky."""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.solids.ground_heights import GroundHeights

METRES_PER_DEGREE = 111_320.0
# Dose rate of cosmic rays at sea level, and the height over which it grows by a factor of e
# (UNSCEAR 2000: it doubles every 1.5 to 2 km).
COSMIC_USVH, COSMIC_GROWTH_M = 0.033, 2500.0
# Height over which the terrestrial dose rate falls by a factor of e.
TERRESTRIAL_DECAY_M = 120.0
WAVES = 24


@dataclass(frozen=True, slots=True, kw_only=True)
class Background:
    """A smooth random background, the same for the same `seed`.

    The terrestrial part has the mean `terrestrial_usvh` at the ground, times exp of a sum of
    waves with standard deviation `variation` and lengths about 2 pi `length_m`.

    Attributes
    ----------
    terrestrial_usvh
        Mean at the ground, microsievert per hour; 0: none.
    variation
        Standard deviation of its logarithm.
    length_m
        Length over which it varies, metres.
    ground_altitude_m
        Altitude of the ground above the ellipsoid, where `ground` is None or has no height.
    is_cosmic
        Whether cosmic rays are added.
    seed
        Seed of the waves.
    ground
        Heights of ground that is not level.
    """

    terrestrial_usvh: float = 0.0
    variation: float = 0.0
    length_m: float = 60.0
    ground_altitude_m: float = 0.0
    is_cosmic: bool = False
    seed: int = 0
    ground: GroundHeights | None = None

    def __post_init__(self) -> None:
        if not 0.0 <= self.terrestrial_usvh <= 1e6:
            raise ValueError(
                f'terrestrial_usvh = {self.terrestrial_usvh} must be within 0 and 1e6'
            )
        if not 0.0 <= self.variation <= 2.0:
            raise ValueError(f'variation = {self.variation} must be within 0 and 2')
        if not 1.0 <= self.length_m <= 1e5:
            raise ValueError(f'length_m = {self.length_m} must be within 1 and 1e5')

    def dose_rates_usvh(
        self, latitudes_deg: FloatArray, longitudes_deg: FloatArray, altitudes_m: FloatArray
    ) -> FloatArray:
        """Return the background at n points, microsievert per hour, shape (n,)."""
        altitudes = np.asarray(altitudes_m, np.float64)
        heights = np.maximum(altitudes - self._ground_m(latitudes_deg, longitudes_deg), 0.0)
        ground = np.exp(self._waves(latitudes_deg, longitudes_deg) - self.variation**2 / 2.0)
        rates = self.terrestrial_usvh * ground * np.exp(-heights / TERRESTRIAL_DECAY_M)
        if self.is_cosmic:
            rates = rates + COSMIC_USVH * np.exp(np.clip(altitudes / COSMIC_GROWTH_M, -1.0, 6.0))
        return np.asarray(rates)

    def _ground_m(
        self, latitudes_deg: FloatArray, longitudes_deg: FloatArray
    ) -> FloatArray | float:
        """Return the altitude of the ground below points."""
        if self.ground is None:
            return self.ground_altitude_m
        known = self.ground.altitudes_m(latitudes_deg, longitudes_deg)
        return np.where(np.isfinite(known), known, self.ground_altitude_m)

    def _waves(self, latitudes_deg: FloatArray, longitudes_deg: FloatArray) -> FloatArray:
        """Return a sum of plane waves of random direction, length and phase, shape (n,)."""
        latitudes = np.atleast_1d(np.asarray(latitudes_deg, np.float64))
        longitudes = np.atleast_1d(np.asarray(longitudes_deg, np.float64))
        if self.variation == 0.0:
            return np.zeros_like(latitudes)
        numbers, phases = _drawn_waves(self.seed)
        numbers = numbers / self.length_m
        east = longitudes * METRES_PER_DEGREE * np.cos(np.radians(latitudes))
        north = latitudes * METRES_PER_DEGREE
        # The origin of the waves does not matter: only their phases at the site do.
        turns = np.multiply.outer(east, numbers[:, 0]) + np.multiply.outer(north, numbers[:, 1])
        return np.asarray(
            self.variation * math.sqrt(2.0 / WAVES) * np.cos(turns + phases).sum(axis=-1)
        )


@cache
def _drawn_waves(seed: int) -> tuple[FloatArray, FloatArray]:
    """Return wave numbers for a length of 1 m, shape (WAVES, 2), and phases, shape (WAVES,)."""
    generator = np.random.default_rng([seed, 0xBAC6])
    numbers = generator.normal(size=(WAVES, 2))
    return numbers, generator.uniform(0.0, 2.0 * math.pi, WAVES)
