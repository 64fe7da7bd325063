# SPDX-License-Identifier: Apache-2.0
"""What is measured of a source of unit strength, and how it changes with distance."""

import math
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.physics.nuclide import DEFAULT_NUCLIDE
from rocsafe_radiation.physics.scatter import Response, counted_table
from rocsafe_radiation.physics.transmission import (
    Table,
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
    height_m
        Of this detector above the source, to the nearest metre.
    """

    is_lossy: bool = True
    nuclide: str = DEFAULT_NUCLIDE
    source_radius_m: float = 0.1
    response: Response = ()
    height_m: float = 30.0

    def at_height(self, height_m: float) -> 'Kernel':
        """Return the kernel of a detector at a height above the source."""
        return replace(self, height_m=float(round(height_m))) if self.response else self

    @property
    def of_dose(self) -> 'Kernel':
        """The kernel of the dose rate itself."""
        return replace(self, response=())

    @property
    def _table(self) -> Table:
        if self.response:
            return counted_table(self.nuclide, self.response, self.height_m)
        return transmission_table(self.nuclide)

    def values(self, squares_m2: FloatArray) -> FloatArray:
        """Return the dose rate at each squared distance, uSv/h."""
        squares = np.maximum(squares_m2, self.source_radius_m**2)
        if not self.is_lossy:
            return np.asarray(1.0 / squares)
        values = interpolated(self._table, np.sqrt(squares))
        values /= squares
        return values

    def value(self, square_m2: float) -> float:
        """Return `values` of one squared distance, without arrays and ten times as fast."""
        square = max(square_m2, self.source_radius_m**2)
        kept = interpolated_at(self._table, math.sqrt(square)) if self.is_lossy else 1.0
        return kept / square

    def values_and_slopes(self, squares_m2: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the dose rate at each squared distance and its derivative by that."""
        squares = np.maximum(squares_m2, self.source_radius_m**2)
        if not self.is_lossy:
            values = 1.0 / squares
            return values, -values / squares
        distances = np.sqrt(squares)
        kept, slopes = interpolated_with_slope(self._table, distances)
        values = kept / squares
        return values, (slopes / (2.0 * distances) - values) / squares
