# SPDX-License-Identifier: Apache-2.0
"""The dose rate of a source of unit strength, and how it changes with distance."""

from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.physics.nuclide import DEFAULT_NUCLIDE
from rocsafe_radiation.physics.transmission import air_transmission, air_transmission_and_slope


@dataclass(frozen=True, slots=True, kw_only=True)
class Kernel:
    """Dose rate of a source with 1 uSv/h at 1 m by distance.

    Attributes
    ----------
    is_lossy
        Whether air attenuates and scatters (model ``air``); else 1/d^2 (model ``paper``).
    nuclide
        Nuclide whose lines air attenuates.
    source_radius_m
        Distance below which the dose rate grows no further.
    """

    is_lossy: bool = True
    nuclide: str = DEFAULT_NUCLIDE
    source_radius_m: float = 0.1

    def values(self, squares_m2: FloatArray) -> FloatArray:
        """Return the dose rate at each squared distance, uSv/h."""
        squares = np.maximum(squares_m2, self.source_radius_m**2)
        if not self.is_lossy:
            return np.asarray(1.0 / squares)
        values = air_transmission(self.nuclide, np.sqrt(squares))
        values /= squares
        return values

    def values_and_slopes(self, squares_m2: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the dose rate at each squared distance and its derivative by that."""
        squares = np.maximum(squares_m2, self.source_radius_m**2)
        if not self.is_lossy:
            values = 1.0 / squares
            return values, -values / squares
        distances = np.sqrt(squares)
        kept, slopes = air_transmission_and_slope(self.nuclide, distances)
        values = kept / squares
        return values, (slopes / (2.0 * distances) - values) / squares
