# SPDX-License-Identifier: Apache-2.0
"""By how much the law of the dose rate may differ from that of the kernel, by one number.

The dose rate of a source is s g(d) exp(t f), with the tilt t and the feature f = (h - d) / 100 m
at the distance d, from h above: another nuclide, other air, none. The tilt is the same for all
sources.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TILT_LENGTH_M = 100.0
LARGEST_LOG = 30.0
# Beyond, it would be no law of a source any more.
LARGEST_STDS = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LawDeviation:
    """The tilt as known before any reading.

    Attributes
    ----------
    height_m: of the readings above the sources.
    tilt_std: its standard deviation; 0: there is none.
    """

    height_m: float
    tilt_std: float = 0.0

    @property
    def stds(self) -> Array:
        """Standard deviation of each number as known before: none or one."""
        return np.array([self.tilt_std] * (self.tilt_std > 0.0), np.float64)

    @property
    def limits(self) -> Array:
        """Largest size of each number that a law can have."""
        return LARGEST_STDS * self.stds

    def features(self, offsets: Array) -> Array:
        """Return the feature of ways of shape (sources, 3, n): (1, sources, n)."""
        return np.asarray((self.height_m - _distances(offsets)) / TILT_LENGTH_M)[None]

    def slopes(self, numbers: Array, offsets: Array) -> Array:
        """Return how t f changes with the place of each source, (sources, 3, n)."""
        return np.asarray(numbers[0] / TILT_LENGTH_M * offsets / _distances(offsets)[:, None])

    def factors(self, numbers: Array, offsets: Array) -> Array:
        """Return exp(t f), shape (sources, n)."""
        logs = numbers[0] * self.features(offsets)[0]
        return np.asarray(np.exp(np.clip(logs, -LARGEST_LOG, LARGEST_LOG)))


def _distances(offsets: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum('kcn,kcn->kn', offsets, offsets)))
