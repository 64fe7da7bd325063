# SPDX-License-Identifier: Apache-2.0
"""By how much the law of the dose rate may differ from that of the kernel, by few numbers.

The dose rate of a source is s g(d) exp(t f - e^w p q), the same for all sources.

The tilt t, with the feature f = (h - d) / 100 m at the distance d, from h above: another nuclide,
other air, none.

The shield: an upright wall stands beside the source, so that readings on that side get less, but
for those so far above that they look over it. It begins where the line l x = b is crossed, with x
the horizontal way from source to reading in heights: p = 1 / (1 + exp(b - l x)). A ray is the
longer within the wall the steeper it is: q = d / r at the horizontal distance r. Four numbers: l,
east and north; b beyond the usual; w beyond the usual, the logarithm of the wall's thickness in
mean free paths.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TILT_LENGTH_M = 100.0
LARGEST_LOG = 30.0
# Beyond, it would be no law of a source any more.
LARGEST_STDS = 3.0
# Standard deviations of the numbers of a shield as known before.
SHIELD_STDS = (10.0, 10.0, 5.0, 1.5)
USUAL_BEGINNING, USUAL_LOG_DEPTH = 2.0, -0.5
# Nearer than so many heights, a ray goes over a wall of any height that stands there.
STEEPEST_HEIGHTS = 0.25


@dataclass(frozen=True, slots=True, kw_only=True)
class LawDeviation:
    """Tilt and shield as known before any reading.

    Attributes
    ----------
    height_m: of the readings above the sources.
    tilt_std: standard deviation of the tilt; 0: there is none.
    has_shield: a wall may stand beside the sources.
    """

    height_m: float
    tilt_std: float = 0.0
    has_shield: bool = False

    @property
    def stds(self) -> Array:
        """Standard deviation of each number as known before: the tilt, the shield."""
        tilt = [self.tilt_std] * (self.tilt_std > 0.0)
        return np.array([*tilt, *(SHIELD_STDS * self.has_shield)], np.float64)

    @property
    def limits(self) -> Array:
        """Largest size of each number that a law can have."""
        return LARGEST_STDS * self.stds

    def features(self, numbers: Array, offsets: Array) -> Array:
        """Return the slope of the logarithm by each number, (numbers, sources, n).

        `offsets` are the ways from sources to readings, (sources, 3, n).
        """
        found = []
        if self.tilt_std > 0.0:
            found.append((self.height_m - _distances(offsets)) / TILT_LENGTH_M)
        if self.has_shield:
            depths, share = self._depths(numbers, offsets)
            steep = -depths * (1.0 - share)
            found += [steep * offsets[:, axis] / self.height_m for axis in range(2)]
            found += [-steep, -depths]
        return np.stack(found)

    def slopes(self, numbers: Array, offsets: Array) -> Array:
        """Return how the logarithm changes with the place of each source, (sources, 3, n)."""
        distances = _distances(offsets)[:, None]
        total = np.zeros(offsets.shape)
        if self.tilt_std > 0.0:
            total += numbers[0] / TILT_LENGTH_M * offsets / distances
        if self.has_shield:
            depths, share = (part[:, None] for part in self._depths(numbers, offsets))
            total += depths * offsets / distances**2
            aside = depths * offsets[:, :2] / self._lengths(offsets)[:, None] ** 2
            total[:, :2] += depths * (1.0 - share) * numbers[-4:-2, None] / self.height_m - aside
        return total

    def factors(self, numbers: Array, offsets: Array) -> Array:
        """Return by what the dose rates are multiplied, shape (sources, n)."""
        logs = np.zeros((len(offsets), offsets.shape[2]))
        if self.tilt_std > 0.0:
            logs += numbers[0] * (self.height_m - _distances(offsets)) / TILT_LENGTH_M
        if self.has_shield:
            logs -= self._depths(numbers, offsets)[0]
        return np.asarray(np.exp(np.clip(logs, -LARGEST_LOG, LARGEST_LOG)))

    def _depths(self, numbers: Array, offsets: Array) -> tuple[Array, Array]:
        """Return the depth of each ray in the wall, mean free paths, and how far it is behind."""
        beside = np.einsum('c,kcn->kn', numbers[-4:-2], offsets[:, :2]) / self.height_m
        logs = np.clip(beside - USUAL_BEGINNING - numbers[-2], -LARGEST_LOG, LARGEST_LOG)
        share = 1.0 / (1.0 + np.exp(-logs))
        depth = float(np.exp(USUAL_LOG_DEPTH + numbers[-1]))
        return depth * share * _distances(offsets) / self._lengths(offsets), share

    def _lengths(self, offsets: Array) -> Array:
        """Return the horizontal ways, at least about a share of the height, (sources, n)."""
        squares = np.einsum('kcn,kcn->kn', offsets[:, :2], offsets[:, :2])
        return np.asarray(np.sqrt(squares + (STEEPEST_HEIGHTS * self.height_m) ** 2))


def _distances(offsets: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum('kcn,kcn->kn', offsets, offsets)))
