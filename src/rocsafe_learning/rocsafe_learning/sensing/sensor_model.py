# SPDX-License-Identifier: Apache-2.0
"""The interface of a sensor: readings of a source, on a scale on which their noise is normal."""

from typing import Protocol

import numpy as np

from rocsafe_geo.arrays import FloatArray


class SensorModel(Protocol):
    """What a drone reads near a source that is alone on flat, homogeneous ground.

    A reading is a number on a scale of the sensor's own on which its errors are normal.
    """

    def strengths(self, shares: FloatArray) -> FloatArray:
        """Return the source strengths at shares of the range of strengths, 0 to 1, (n,)."""

    def expected(self, offsets_m: FloatArray, strength: float) -> tuple[FloatArray, FloatArray]:
        """Return mean and variance of readings.

        Parameters
        ----------
        offsets_m : (n, 2)
            From the source to the drone, east and north, metres.
        strength
            Strength of the source, in the unit of the sensor's law.

        Returns
        -------
        mean, variance : (n,)
            On the scale of the readings.
        """

    def draw(
        self, offset_m: tuple[float, float], strength: float, generator: np.random.Generator
    ) -> float:
        """Return one random reading of a source at an offset, on the scale of the readings."""
