# SPDX-License-Identifier: Apache-2.0
"""A gamma detector above a source on the ground."""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_not_negative, require_positive
from rocsafe_radiation.detection.detector import DETECTORS
from rocsafe_radiation.physics.kernel import Kernel

# With it, the square root of a Poisson count has nearly the same variance for any mean
# (Anscombe 1948, Biometrika 35, 246).
_ANSCOMBE = 0.375
_KERNEL = Kernel()


@dataclass(frozen=True, slots=True, kw_only=True)
class GammaSensor:
    """A counting detector that hovers.

    Readings are 2 sqrt(counts + 3/8), whose standard deviation is 1 for Poisson counts.

    Attributes
    ----------
    detector
        Name of a detector in `rocsafe_radiation.detection.detector.DETECTORS`.
    height_m
        Height of the drone above the ground, metres.
    window_s
        Time of one reading, seconds.
    background_usvh
        Dose rate without a source, microsievert per hour.
    weakest_usvh, strongest_usvh
        Range of the dose rate of the source at 1 m, microsievert per hour.
    relative_error
        Standard deviation in proportion to the signal of the source: errors of positions.
    """

    detector: str = 'csi_33cm3'
    height_m: float = 10.0
    window_s: float = 2.0
    background_usvh: float = 0.1
    weakest_usvh: float = 5.0
    strongest_usvh: float = 500.0
    relative_error: float = 0.05

    def __post_init__(self) -> None:
        if self.detector not in DETECTORS:
            raise ValueError(
                f'detector = {self.detector!r} must be one of: {", ".join(DETECTORS)}'
            )
        for name in ('height_m', 'window_s', 'background_usvh', 'weakest_usvh'):
            require_positive(name, getattr(self, name))
        require_not_negative('relative_error', self.relative_error)
        if not self.weakest_usvh <= self.strongest_usvh <= 1e6:
            raise ValueError(
                f'strongest_usvh = {self.strongest_usvh:g} must be within weakest_usvh = '
                f'{self.weakest_usvh:g} and 1e6'
            )

    def strengths(self, shares: FloatArray) -> FloatArray:
        """Return dose rates at 1 m; equal shares are equal ratios, (n,), uSv/h."""
        ratio = self.strongest_usvh / self.weakest_usvh
        return np.asarray(self.weakest_usvh * ratio ** np.asarray(shares))

    def expected(self, offsets_m: FloatArray, strength: float) -> tuple[FloatArray, FloatArray]:
        """Return mean and variance of readings, see `SensorModel`."""
        squares = (np.asarray(offsets_m) ** 2).sum(axis=-1) + self.height_m**2
        signal = strength * _KERNEL.values(squares)
        counts = self._counts(signal + self.background_usvh)
        spread = self.relative_error * (counts - self._counts(self.background_usvh))
        # The slope of 2 sqrt(c) turns an error of the counts into one of the reading.
        return 2.0 * np.sqrt(counts + _ANSCOMBE), 1.0 + spread**2 / (counts + _ANSCOMBE)

    def draw(
        self, offset_m: tuple[float, float], strength: float, generator: np.random.Generator
    ) -> float:
        """Return a random reading, see `SensorModel`."""
        square = offset_m[0] ** 2 + offset_m[1] ** 2 + self.height_m**2
        level = strength * _KERNEL.value(square) + self.background_usvh
        counts = generator.poisson(float(self._counts(level)))
        return 2.0 * math.sqrt(counts + _ANSCOMBE)

    def _counts(self, dose_rate_usvh: FloatArray | float) -> FloatArray:
        """Return the mean counts of a reading at a dose rate."""
        kind = DETECTORS[self.detector]
        rate = kind.sensitivity_cps_per_usvh * np.asarray(dose_rate_usvh) + kind.dark_rate_cps
        return np.asarray(rate * self.window_s * kind.live_share(rate))
