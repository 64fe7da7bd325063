# SPDX-License-Identifier: Apache-2.0
"""Deviations of the law of the dose rate from the kernel, with few parameters.

The dose rate of a source is s g(d) exp(t f - w), the same for all sources.

The tilt t multiplies f = (h - d) / 100 m, with the distance d and the height h. It stands for
another nuclide, other air or none.

The shield takes w, which a `WallShadow` gives from five parameters.
"""

from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.fit_setting import SHARP_EDGE
from rocsafe_radiation.localization.wall_shadow import SHIELD_STDS, WallShadow

TILT_LENGTH_M = 100.0
LARGEST_LOG = 30.0
# Limit of each parameter in prior standard deviations.
LARGEST_STDS = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LawDeviation:
    """Prior of tilt and shield.

    Attributes
    ----------
    height_m
        Height of the readings above the sources, metres.
    tilt_std
        Prior standard deviation of the tilt; 0: there is none.
    has_shield
        Whether a wall may stand beside the sources.
    edge_sharpness
        Sharpness of the edge of its shadow.
    """

    height_m: float
    tilt_std: float = 0.0
    has_shield: bool = False
    edge_sharpness: float = SHARP_EDGE

    @property
    def stds(self) -> FloatArray:
        """Prior standard deviation of each parameter: the tilt, then the shield."""
        tilt = [self.tilt_std] * (self.tilt_std > 0.0)
        return np.array([*tilt, *(SHIELD_STDS * self.has_shield)], np.float64)

    @property
    def limits(self) -> FloatArray:
        """Largest size of each parameter."""
        return LARGEST_STDS * self.stds

    def features(self, numbers: FloatArray, offsets: FloatArray) -> FloatArray:
        """Return the derivative of the log dose rate by each parameter, (parameters, sources, n).

        `offsets` lead from sources to readings, (sources, 3, n), metres.
        """
        found = []
        if self.tilt_std > 0.0:
            found.append((self.height_m - _distances(offsets)) / TILT_LENGTH_M)
        if self.has_shield:
            wall = self._wall(numbers, offsets)
            found += [*-wall.by_line(offsets), -wall.by_depth, -wall.by_reach, -wall.by_shape]
        return np.stack(found)

    def slopes(self, numbers: FloatArray, offsets: FloatArray) -> FloatArray:
        """Return the derivative of the log dose rate by the place of sources, (sources, 3, n)."""
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
        """Return the factors of the dose rates, shape (sources, n)."""
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
