# SPDX-License-Identifier: Apache-2.0
"""What is measured of a source of unit strength, and how it changes with distance."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.physics.nuclide import DEFAULT_NUCLIDE
from rocsafe_radiation.physics.scatter import CountedTable, Response, counted_table
from rocsafe_radiation.physics.transmission import (
    interpolated,
    interpolated_at,
    interpolated_with_slope,
    transmission_table,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Kernel:
    """Dose rate of a source with 1 uSv/h at 1 m by distance, or what a detector makes of it.

    Attributes
    ----------
    is_lossy
        Whether air attenuates and scatters (model ``air``); else 1/d^2 (model ``paper``).
    nuclide
        Nuclide whose lines air attenuates.
    source_radius_m
        Distance below which the dose rate grows no further.
    response
        Of the detector, which counts what air and soil scatter, too; empty: it reads the dose
        rate. Without losses there is no scatter.
    counted
        What this detector counts for a dose at the heights of some readings; None: `at_heights`
        was not called, it reads the dose rate.
    """

    is_lossy: bool = True
    nuclide: str = DEFAULT_NUCLIDE
    source_radius_m: float = 0.1
    response: Response = ()
    counted: CountedTable | None = field(default=None, repr=False)

    def at_heights(self, heights_m: FloatArray) -> 'Kernel':
        """Return the kernel of readings at heights above the source, shape (n,), or (1,) for all.

        It takes squared distances of shape (..., n).
        """
        if not (self.response and self.is_lossy):
            return self
        return replace(self, counted=counted_table(self.nuclide, self.response, heights_m))

    @property
    def of_dose(self) -> 'Kernel':
        """The kernel of the dose rate itself."""
        return replace(self, response=(), counted=None)

    def values(self, squares_m2: FloatArray) -> FloatArray:
        """Return the dose rate at each squared distance, uSv/h."""
        squares = np.maximum(squares_m2, self.source_radius_m**2)
        if not self.is_lossy:
            return np.asarray(1.0 / squares)
        distances = np.sqrt(squares)
        values = interpolated(transmission_table(self.nuclide), distances)
        values /= squares
        if self.counted is not None:
            values *= self.counted.at(distances)
        return values

    def value(self, square_m2: float) -> float:
        """Return the dose rate at one squared distance, without arrays and ten times as fast."""
        square = max(square_m2, self.source_radius_m**2)
        table = transmission_table(self.nuclide)
        kept = interpolated_at(table, math.sqrt(square)) if self.is_lossy else 1.0
        return kept / square

    def values_and_slopes(self, squares_m2: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the dose rate at each squared distance and its derivative by that."""
        squares = np.maximum(squares_m2, self.source_radius_m**2)
        if not self.is_lossy:
            values = 1.0 / squares
            return values, -values / squares
        distances = np.sqrt(squares)
        kept, slopes = interpolated_with_slope(transmission_table(self.nuclide), distances)
        if self.counted is not None:
            counted, rises = self.counted.at_with_slope(distances)
            slopes = slopes * counted + kept * rises
            kept = kept * counted
        values = kept / squares
        return values, (slopes / (2.0 * distances) - values) / squares
