# SPDX-License-Identifier: Apache-2.0
"""What a localisation finds: sources with their uncertainty, their number, and doubts."""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray

ML_METHOD, BELIEF_METHOD = 'poisson-ml', 'belief-grid'
METHODS = (ML_METHOD, BELIEF_METHOD)
SPREAD = 'sources less than two heights apart may be one that is spread out'
NORMAL_95 = 1.96
# Quantile 0.95 of chi-square with two degrees of freedom.
ELLIPSE_95 = 5.991


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceEstimate:
    """A source found.

    Attributes
    ----------
    position_enu_m
        Its place, shape (3,), metres.
    dose_rate_at_1m_usvh
        Its strength, without air.
    joint_covariance
        Covariance of east, north, up in metres and the logarithm of the strength, (4, 4).
    detection_llr
        Decrease of the log likelihood without it, all else unchanged.
    """

    position_enu_m: FloatArray
    dose_rate_at_1m_usvh: float
    joint_covariance: FloatArray
    detection_llr: float

    @property
    def covariance_m2(self) -> FloatArray:
        """Covariance of the position, shape (3, 3)."""
        return self.joint_covariance[:3, :3]

    @property
    def log_std(self) -> float:
        """Standard deviation of the natural logarithm of the strength."""
        return math.sqrt(max(float(self.joint_covariance[3, 3]), 0.0))

    @property
    def dose_rate_at_1m_std_usvh(self) -> float:
        """Standard deviation of the strength."""
        return self.dose_rate_at_1m_usvh * self.log_std

    def interval_95_usvh(self) -> tuple[float, float]:
        """Return the bounds of the strength with a probability of 0.95."""
        factor = math.exp(min(NORMAL_95 * self.log_std, 50.0))
        return self.dose_rate_at_1m_usvh / factor, self.dose_rate_at_1m_usvh * factor

    def ellipse_95(self) -> tuple[float, float, float]:
        """Return half axes in metres, long first, and the angle of the long one from east, rad."""
        values, vectors = np.linalg.eigh(self.covariance_m2[:2, :2])
        axes = np.sqrt(np.maximum(values, 0.0) * ELLIPSE_95)
        return float(axes[1]), float(axes[0]), math.atan2(vectors[1, 1], vectors[0, 1])


@dataclass(frozen=True, slots=True, kw_only=True)
class Localization:
    """The sources that the readings support.

    Attributes
    ----------
    sources
        The sources, the one with the most evidence first.
    order_probabilities
        Probability of 0, 1, 2 ... sources.
    background_usvh, background_std_usvh
        Mean background at the readings and its uncertainty.
    reading_count
        Number of readings used.
    dispersion
        Standard deviations by which the misfit exceeds that of the model.
    rho
        Share of the excess by which readings scatter beyond Poisson.
    is_structured
        Whether the background varies from place to place.
    is_misfit
        Whether the misfit is so large that ellipses are widened.
    spike_count
        Readings that fit neither sources nor background, and count for nothing.
    is_understood
        Whether sources and background explain the readings, but for few spikes.
    is_lopsided
        Whether something beside the sources may take part of their dose rate on one side.
    may_be_spread
        Whether two sources are so near to each other that they may be one that is spread out.
    caveats
        Why the readings prove nothing, in words.
    smoothing_s
        Time constant of the running means that the readings are; 0: they are none.
    allowed_for
        What clock and detectors do that the fit allows for, in words.
    method
        Method by which they were found, one of `METHODS`.
    """

    sources: tuple[SourceEstimate, ...]
    order_probabilities: tuple[float, ...]
    background_usvh: float
    background_std_usvh: float
    reading_count: int
    dispersion: float
    rho: float
    is_structured: bool
    is_misfit: bool = False
    spike_count: int = 0
    is_understood: bool = True
    is_lopsided: bool = False
    may_be_spread: bool = False
    caveats: tuple[str, ...] = ()
    smoothing_s: float = 0.0
    allowed_for: tuple[str, ...] = ()
    method: str = ML_METHOD

    @property
    def doubts(self) -> tuple[str, ...]:
        """What differs from counts of sources over a constant background, in words."""
        found = [*self.caveats]
        if self.is_lopsided:
            found.append('something beside the sources may take part of their dose rate')
        if self.may_be_spread:
            found.append(SPREAD)
        if self.smoothing_s:
            found.append(
                f'the readings are running means over about {self.smoothing_s:.2g} s: undone'
            )
        found += [f'{one}: allowed for' for one in self.allowed_for]
        if self.is_structured:
            found.append('the background is uneven')
        if self.rho > 0.0:
            found.append(f'readings scatter by {self.rho:.0%} of the excess beyond their counts')
        if self.spike_count:
            found.append(f'{self.spike_count} readings fit nothing and are left out as spikes')
        if self.is_misfit:
            found.append(
                f'the readings differ from this by {self.dispersion:.0f} standard deviations more '
                'than they may: ellipses are widened'
            )
        return tuple(found)
