# SPDX-License-Identifier: Apache-2.0
"""A beam through the gas: what an open-path sensor reads is a mean along its way."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_finite, require_positive

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True, slots=True, kw_only=True)
class Beam:
    """A beam between two places.

    Attributes
    ----------
    start_m, end_m
        East, north and height above the ground, metres.
    piece_m
        Length of the pieces that are integrated, metres; shorter than the gas is wide.
    """

    start_m: tuple[float, float, float]
    end_m: tuple[float, float, float]
    piece_m: float = 2.0

    def __post_init__(self) -> None:
        for value in (*self.start_m, *self.end_m):
            require_finite('end of a beam', value, 'm')
        require_positive('length of a beam', self.length_m, 'm')
        require_positive('piece_m', self.piece_m, 'm')

    @property
    def length_m(self) -> float:
        """Length, metres."""
        return math.dist(self.start_m, self.end_m)

    def integral(self, values: Callable[[FloatArray], FloatArray]) -> float:
        """Return the integral along the beam of a field given at places (n, 3): unit times m."""
        count = max(math.ceil(self.length_m / self.piece_m), 1)
        shares = ((np.arange(count)[:, None] + (_NODES + 1.0) / 2.0) / count).ravel()
        start, end = np.array(self.start_m), np.array(self.end_m)
        weights = np.tile(_WEIGHTS / 2.0, count) * (self.length_m / count)
        return float(values(start + shares[:, None] * (end - start)) @ weights)

    def mean(self, values: Callable[[FloatArray], FloatArray]) -> float:
        """Return the mean along the beam of a field given at places (n, 3)."""
        return self.integral(values) / self.length_m
