# SPDX-License-Identifier: Apache-2.0
"""By how much the law of the dose rate may differ from that of the kernel, by few numbers.

The dose rate of a source is s g(d) exp(sum of p_j f_j), with up to three features f_j of the way
from the source to the reading:

* the tilt, (h - d) / 100 m at the distance d from h above: another nuclide, other air, none;
* the shadow, east and north of the way over sqrt(r^2 + h^2/4) with the ground distance r: a
  train, a wall or a flask lets less through to one side than to the other.

They are the same for all sources.
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
    """Which features there are.

    Attributes
    ----------
    height_m: of the readings above the sources.
    tilt_std, shadow_std: of their numbers as known before; 0: left out.
    """

    height_m: float
    tilt_std: float = 0.0
    shadow_std: float = 0.0

    @property
    def stds(self) -> Array:
        """Standard deviation of each number as known before, shape (features,)."""
        tilt = [self.tilt_std] if self.tilt_std > 0.0 else []
        return np.array(tilt + [self.shadow_std] * (2 * (self.shadow_std > 0.0)), np.float64)

    @property
    def limits(self) -> Array:
        """Largest size of each number that a law can have, shape (features,)."""
        return LARGEST_STDS * self.stds

    def features(self, offsets: Array) -> Array:
        """Return the features of ways of shape (sources, 3, n): (features, sources, n)."""
        parts = []
        if self.tilt_std > 0.0:
            distances = np.sqrt(np.einsum('kcn,kcn->kn', offsets, offsets))
            parts.append((self.height_m - distances) / TILT_LENGTH_M)
        if self.shadow_std > 0.0:
            parts.extend(offsets[:, axis] / self._reach(offsets) for axis in range(2))
        return np.stack(parts)

    def slopes(self, numbers: Array, offsets: Array) -> Array:
        """Return how sum of p_j f_j changes with the place of each source, (sources, 3, n)."""
        total = np.zeros_like(offsets)
        if self.tilt_std > 0.0:
            distances = np.sqrt(np.einsum('kcn,kcn->kn', offsets, offsets))
            total += (numbers[0] / TILT_LENGTH_M) * offsets / distances[:, None]
        if self.shadow_std > 0.0:
            reach = self._reach(offsets)
            east, north = numbers[-2:]
            along = (east * offsets[:, 0] + north * offsets[:, 1]) / reach**3
            total[:, 0] += offsets[:, 0] * along - east / reach
            total[:, 1] += offsets[:, 1] * along - north / reach
        return total

    def factors(self, numbers: Array, offsets: Array) -> Array:
        """Return exp(sum of p_j f_j), shape (sources, n)."""
        logs = np.tensordot(numbers, self.features(offsets), axes=1)
        return np.asarray(np.exp(np.clip(logs, -LARGEST_LOG, LARGEST_LOG)))

    def _reach(self, offsets: Array) -> Array:
        squares = offsets[:, 0] ** 2 + offsets[:, 1] ** 2
        return np.asarray(np.sqrt(squares + 0.25 * self.height_m**2))
