# SPDX-License-Identifier: Apache-2.0
"""Gusts: an Ornstein-Uhlenbeck process that is a pure function of seed and time."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_count, require_not_negative, require_positive
from rocsafe_geo.wind.wind_field import WindField

# Steps of the process within its time scale, and time scales after which noise is forgotten.
STEPS_A_SCALE, SCALES_KEPT = 20, 12
BLOCK = 512


@dataclass(frozen=True, slots=True, kw_only=True)
class GustyWind:
    """Another wind with gusts, which are the same everywhere at one time.

    Attributes
    ----------
    mean
        The wind without gusts.
    sigma_east_mps, sigma_north_mps, sigma_up_mps
        Standard deviations of the gusts, m/s.
    time_scale_s
        Time in which the correlation of the gusts falls to 1/e, seconds.
    seed
        Which gusts; the same seed gives the same gusts at the same times.
    """

    mean: WindField
    sigma_east_mps: float
    sigma_north_mps: float
    sigma_up_mps: float = 0.0
    time_scale_s: float = 20.0
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ('sigma_east_mps', 'sigma_north_mps', 'sigma_up_mps'):
            require_not_negative(name, getattr(self, name), 'm/s')
        require_positive('time_scale_s', self.time_scale_s, 's')
        require_count('seed', self.seed, 0, 2**63 - 1)

    def velocities_mps(self, time_s: float, places_m: FloatArray) -> FloatArray:
        """Return the velocity of the air, see `WindField`."""
        sigmas = np.array([self.sigma_east_mps, self.sigma_north_mps, self.sigma_up_mps])
        gust = sigmas * correlated_noise(self.seed, time_s / self.time_scale_s)
        return self.mean.velocities_mps(time_s, places_m) + gust


def correlated_noise(seed: int, time: float) -> FloatArray:
    """Return three independent stationary noises of variance 1, (3,), at a time.

    Parameters
    ----------
    seed
        Which noise.
    time
        In units of the time scale of the correlation exp(-|difference|).
    """
    step = time * STEPS_A_SCALE
    index = math.floor(step)
    share = step - index
    low, high = _value(seed, index), _value(seed, index + 1)
    # Between two steps the process keeps its variance.
    rho = math.exp(-1.0 / STEPS_A_SCALE)
    scale = math.sqrt(1.0 - 2.0 * share * (1.0 - share) * (1.0 - rho))
    return np.asarray(((1.0 - share) * low + share * high) / scale)


def _value(seed: int, index: int) -> FloatArray:
    block, place = divmod(index, BLOCK)
    return np.asarray(_block(seed, block)[place])


@lru_cache(maxsize=64)
def _block(seed: int, block: int) -> FloatArray:
    """Return the values of one block of steps, (BLOCK, 3).

    A value is the sum of all noise before it, each weighted by its age; noise older than
    `SCALES_KEPT` time scales has no weight left.
    """
    warm = SCALES_KEPT * STEPS_A_SCALE
    noise = np.concatenate([_noise(seed, block - 1)[-warm:], _noise(seed, block)])
    rho = math.exp(-1.0 / STEPS_A_SCALE)
    values = noise * math.sqrt(1.0 - rho * rho)
    for index in range(1, len(values)):
        values[index] += rho * values[index - 1]
    values.setflags(write=False)
    return np.asarray(values[warm:])


def _noise(seed: int, block: int) -> FloatArray:
    # Seeds are not negative; blocks before the start of the mission are odd numbers.
    number = 2 * block if block >= 0 else -2 * block - 1
    return np.random.default_rng([seed, number]).standard_normal((BLOCK, 3))
