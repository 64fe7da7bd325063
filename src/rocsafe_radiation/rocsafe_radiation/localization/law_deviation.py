# SPDX-License-Identifier: Apache-2.0
"""By how much the law of the dose rate may differ from that of the kernel, by few numbers.

The dose rate of a source is s g(d) exp(t f - w), the same for all sources.

The tilt t, with the feature f = (h - d) / 100 m at the distance d, from h above: another nuclide,
other air, none.

The shield takes w, what a `WallShadow` with five numbers says.
"""

from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.fit_setting import SHARP_EDGE
from rocsafe_radiation.localization.wall_shadow import SHIELD_STDS, WallShadow

TILT_LENGTH_M = 100.0
LARGEST_LOG = 30.0
# Beyond, it would be no law of a source any more.
LARGEST_STDS = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LawDeviation:
    """Tilt and shield as known before any reading.

    Attributes
    ----------
    height_m
        Of the readings above the sources.
    tilt_std
        Standard deviation of the tilt; 0: there is none.
    has_shield
        A wall may stand beside the sources.
    edge_sharpness
        Of its shadow.
    """

    height_m: float
    tilt_std: float = 0.0
    has_shield: bool = False
    edge_sharpness: float = SHARP_EDGE

    @property
    def stds(self) -> FloatArray:
        """Standard deviation of each number as known before: the tilt, the shield."""
        tilt = [self.tilt_std] * (self.tilt_std > 0.0)
        return np.array([*tilt, *(SHIELD_STDS * self.has_shield)], np.float64)

    @property
    def limits(self) -> FloatArray:
        """Largest size of each number that a law can have."""
        return LARGEST_STDS * self.stds

    def features(self, numbers: FloatArray, offsets: FloatArray) -> FloatArray:
        """Return the slope of the logarithm by each number, (numbers, sources, n).

        `offsets` are the ways from sources to readings, (sources, 3, n).
        """
        found = []
        if self.tilt_std > 0.0:
            found.append((self.height_m - _distances(offsets)) / TILT_LENGTH_M)
        if self.has_shield:
            wall = self._wall(numbers, offsets)
            found += [*-wall.by_line(offsets), -wall.by_depth, -wall.by_reach, -wall.by_shape]
        return np.stack(found)

    def slopes(self, numbers: FloatArray, offsets: FloatArray) -> FloatArray:
        """Return how the logarithm changes with the place of each source, (sources, 3, n)."""
        distances = _distances(offsets)[:, None]
        total = np.zeros(offsets.shape)
        if self.tilt_std > 0.0:
            total += numbers[0] / TILT_LENGTH_M * offsets / distances
        if self.has_shield:
            wall = self._wall(numbers, offsets)
            total += wall.by_distance[:, None] * offsets / distances
            total[:, :2] += wall.by_way()
        return total

    def factors(self, numbers: FloatArray, offsets: FloatArray) -> FloatArray:
        """Return by what the dose rates are multiplied, shape (sources, n)."""
        logs = np.zeros((len(offsets), offsets.shape[2]))
        if self.tilt_std > 0.0:
            logs += numbers[0] * (self.height_m - _distances(offsets)) / TILT_LENGTH_M
        if self.has_shield:
            logs -= self._wall(numbers, offsets).losses
        return np.asarray(np.exp(np.clip(logs, -LARGEST_LOG, LARGEST_LOG)))

    def _wall(self, numbers: FloatArray, offsets: FloatArray) -> WallShadow:
        shield = numbers[-len(SHIELD_STDS) :]
        return WallShadow(shield, offsets, self.height_m, self.edge_sharpness)


def _distances(offsets: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.einsum('kcn,kcn->kn', offsets, offsets)))
