# SPDX-License-Identifier: Apache-2.0
"""Sources found in readings: where, how strong, how sure."""

import math
from dataclasses import dataclass, field

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.errors import RadiationError
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.hypothesis import ELLIPSE_95
from rocsafe_radiation.localization.hypothesis_values import OrderSearch
from rocsafe_radiation.localization.likelihood import SOURCE_PARAMETERS, UP, Fit, Likelihood
from rocsafe_radiation.localization.mirror_image import covariance_with_images
from rocsafe_radiation.localization.source_count import LARGEST_DISPERSION, LARGEST_ORDER, search
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.readings.survey import Survey

ML_METHOD, BELIEF_METHOD = 'poisson-ml', 'belief-grid'
METHODS = (ML_METHOD, BELIEF_METHOD)
NORMAL_95 = 1.96
FEWEST_READINGS = 8
# Cells of this share of the height lose nothing that matters, and bound the time of a fit.
CELL_HEIGHTS = 0.125
# Measured of tank cars: benchmarks/localisation.py --only mismatched.
WALL_ERROR_HEIGHTS = 0.04


class TooFewReadingsError(RadiationError):
    """There is nothing to localise from."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalizationOptions:
    """What is known before the readings.

    Attributes
    ----------
    kernel
        Law of the dose rate.
    source_up_m, source_up_std_m
        Height of sources above the ground and its standard deviation; 0: exactly there.
    largest_order
        Most sources looked for.
    """

    kernel: Kernel = field(default_factory=Kernel)
    source_up_m: float = 0.5
    source_up_std_m: float = 1.0
    largest_order: int = LARGEST_ORDER

    def __post_init__(self) -> None:
        if not 0.0 <= self.source_up_std_m < math.inf:
            raise ValueError(f'source_up_std_m = {self.source_up_std_m} must be at least 0')
        if not 0 <= self.largest_order <= LARGEST_ORDER:
            raise ValueError(
                f'largest_order = {self.largest_order} must be within 0 and {LARGEST_ORDER}'
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceEstimate:
    """A source found.

    Attributes
    ----------
    position_enu_m
        Where, shape (3,).
    dose_rate_at_1m_usvh
        Strength, without air.
    joint_covariance
        Of east, north, up in metres and the logarithm of the strength, (4, 4).
    detection_llr
        What the logarithm of the likelihood loses without it, all else unchanged.
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
        """Return the bounds that hold the strength with a probability of 0.95."""
        factor = math.exp(min(NORMAL_95 * self.log_std, 50.0))
        return self.dose_rate_at_1m_usvh / factor, self.dose_rate_at_1m_usvh * factor

    def ellipse_95(self) -> tuple[float, float, float]:
        """Return half axes in metres, long first, and the angle of the long one from east, rad."""
        values, vectors = np.linalg.eigh(self.covariance_m2[:2, :2])
        axes = np.sqrt(np.maximum(values, 0.0) * ELLIPSE_95)
        return float(axes[1]), float(axes[0]), math.atan2(vectors[1, 1], vectors[0, 1])


@dataclass(frozen=True, slots=True, kw_only=True)
class Localization:
    """All sources that the readings support.

    Attributes
    ----------
    sources
        Strongest evidence first.
    order_probabilities
        Of 0, 1, 2 ... sources.
    background_usvh, background_std_usvh
        Mean background at the readings and its uncertainty.
    reading_count
        Readings used.
    dispersion
        By how many standard deviations the misfit exceeds what the model allows.
    rho
        Share of the excess by which readings scatter beyond their counts.
    is_structured
        The background varies from place to place.
    is_shielded
        Something beside the sources takes part of their dose rate.
    method
        Name of the way it was found, one of `METHODS`.
    """

    sources: tuple[SourceEstimate, ...]
    order_probabilities: tuple[float, ...]
    background_usvh: float
    background_std_usvh: float
    reading_count: int
    dispersion: float
    rho: float
    is_structured: bool
    is_shielded: bool = False
    method: str = ML_METHOD

    @property
    def doubts(self) -> tuple[str, ...]:
        """What is not as assumed, in words; empty: counts of sources over an even background."""
        found = []
        if self.is_shielded:
            found.append('something beside the sources takes part of their dose rate')
        if self.is_structured:
            found.append('the background is uneven')
        if self.rho > 0.0:
            found.append(f'readings scatter by {self.rho:.0%} of the excess beyond their counts')
        if self.dispersion >= LARGEST_DISPERSION:
            found.append(
                f'the readings differ from this by {self.dispersion:.0f} standard deviations more '
                'than they may: ellipses are widened'
            )
        return tuple(found)


def localize(survey: Survey, options: LocalizationOptions | None = None) -> Localization:
    """Return the sources that `survey` supports.

    Raises
    ------
    TooFewReadingsError
        With fewer than 8 readings, or all of them at one place.
    """
    options = options or LocalizationOptions()
    require_enough(survey)
    cell_m = CELL_HEIGHTS * survey.height_m(options.source_up_m)
    merged = survey.merged(cell_m)
    require_enough(merged)
    setting = Setting(
        kernel=options.kernel,
        source_up_m=options.source_up_m,
        source_up_std_m=options.source_up_std_m,
    )
    return _described(search(merged, setting, options.largest_order), survey.size)


def require_enough(survey: Survey) -> None:
    """Raise TooFewReadingsError if `survey` is too small to localise from."""
    if survey.size < FEWEST_READINGS:
        raise TooFewReadingsError(
            f'{survey.size} readings at different places: at least {FEWEST_READINGS} are needed'
        )


def _described(found: OrderSearch, reading_count: int) -> Localization:
    likelihood, fit = found.likelihood, found.best
    covariance = _stated_covariance(likelihood, fit)
    estimates = [
        _estimate(likelihood, found, covariance, index)
        for index in range(likelihood.source_count(fit.parameters))
    ]
    background = likelihood.background_usvh(fit.parameters)
    setting = likelihood.setting
    return Localization(
        sources=tuple(sorted(estimates, key=lambda one: one.detection_llr, reverse=True)),
        order_probabilities=found.probabilities(),
        background_usvh=float(background.mean()),
        background_std_usvh=float(background.mean() * math.sqrt(min(covariance[0, 0], 100.0))),
        reading_count=reading_count,
        dispersion=likelihood.dispersion(fit.parameters),
        rho=setting.rho,
        is_structured=setting.background_std > 0.0,
        is_shielded=setting.has_shield or setting.shade > 0.0,
    )


def _stated_covariance(likelihood: Likelihood, fit: Fit) -> FloatArray:
    """Return the covariance of the parameters, larger where the model does not explain enough.

    Misfits beyond what the model allows make the place less sure by their variance, as if all
    readings scattered so much (quasi-likelihood, McCullagh and Nelder 1989, section 9.2). Beside
    a wall, they add how far a real one moves sources that a straight one explains.
    """
    covariance = covariance_with_images(likelihood, fit)
    if likelihood.dispersion(fit.parameters) >= LARGEST_DISPERSION:
        covariance = covariance * max(1.0, likelihood.misfit(fit.parameters)[1])
    if likelihood.setting.has_shield:
        moved_m = WALL_ERROR_HEIGHTS * likelihood.survey.height_m(likelihood.setting.source_up_m)
        for axis in range(2):
            places = slice(likelihood.head_size + axis, None, SOURCE_PARAMETERS)
            covariance[places, places] += moved_m**2 * np.eye(covariance[places, places].shape[0])
    return covariance


def _estimate(
    likelihood: Likelihood, found: OrderSearch, covariance: FloatArray, index: int
) -> SourceEstimate:
    start = likelihood.head_size + SOURCE_PARAMETERS * index
    own = covariance[start : start + SOURCE_PARAMETERS, start : start + SOURCE_PARAMETERS]
    source = likelihood.sources(found.best.parameters)[index]
    others = np.delete(found.best.parameters, range(start, start + SOURCE_PARAMETERS))
    without = likelihood.objective(others)
    if found.order == 1:
        without = found.fits[0].log_likelihood
    position = source[:3].copy()
    if likelihood.setting.source_up_std_m == 0.0:
        position[UP] = likelihood.setting.source_up_m
    ground = likelihood.survey.ground
    position = ground.raised(position[None])[0]
    return SourceEstimate(
        position_enu_m=position,
        dose_rate_at_1m_usvh=float(np.exp(source[3])),
        joint_covariance=ground.tilted(own, position),
        detection_llr=found.best.log_likelihood - without,
    )
