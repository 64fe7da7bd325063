# SPDX-License-Identifier: Apache-2.0
"""Sources from readings: places, strengths, uncertainties."""

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
from rocsafe_radiation.localization.search_options import SearchOptions
from rocsafe_radiation.localization.source_count import LARGEST_ORDER, search
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.readings.survey import RadiationSurvey

ML_METHOD, BELIEF_METHOD = 'poisson-ml', 'belief-grid'
METHODS = (ML_METHOD, BELIEF_METHOD)
NORMAL_95 = 1.96
FEWEST_READINGS = 8
# Error of the place beside a wall, heights; measured beside tank cars: benchmarks/localisation.py
# --only mismatched.
WALL_ERROR_HEIGHTS = 0.04


class TooFewReadingsError(RadiationError):
    """There are too few readings to localise sources."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalizationOptions:
    """What is known before the readings.

    Attributes
    ----------
    kernel
        Law of the dose rate.
    source_up_m, source_up_std_m
        Expected height of sources above the ground and its standard deviation, metres; 0: fixed.
    largest_order
        Most sources looked for.
    search
        Numbers that tune the search.
    """

    kernel: Kernel = field(default_factory=Kernel)
    source_up_m: float = 0.5
    source_up_std_m: float = 1.0
    largest_order: int = LARGEST_ORDER
    search: SearchOptions = field(default_factory=SearchOptions)

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
    is_shielded
        Whether something beside the sources takes part of their dose rate.
    is_misfit
        Whether the misfit is so large that ellipses are widened.
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
    is_shielded: bool = False
    is_misfit: bool = False
    method: str = ML_METHOD

    @property
    def doubts(self) -> tuple[str, ...]:
        """What differs from counts of sources over a constant background, in words."""
        found = []
        if self.is_shielded:
            found.append('something beside the sources takes part of their dose rate')
        if self.is_structured:
            found.append('the background is uneven')
        if self.rho > 0.0:
            found.append(f'readings scatter by {self.rho:.0%} of the excess beyond their counts')
        if self.is_misfit:
            found.append(
                f'the readings differ from this by {self.dispersion:.0f} standard deviations more '
                'than they may: ellipses are widened'
            )
        return tuple(found)


def localize(survey: RadiationSurvey, options: LocalizationOptions | None = None) -> Localization:
    """Return the sources that `survey` supports.

    Raises
    ------
    TooFewReadingsError
        If there are fewer than 8 readings, or all of them are at one place.
    """
    options = options or LocalizationOptions()
    require_enough(survey)
    cell_m = options.search.cell_heights * survey.height_m(options.source_up_m)
    merged = survey.merged(cell_m)
    require_enough(merged)
    setting = Setting(
        kernel=options.kernel,
        source_up_m=options.source_up_m,
        source_up_std_m=options.source_up_std_m,
        search=options.search,
    )
    return _described(search(merged, setting, options.largest_order), survey.size)


def require_enough(survey: RadiationSurvey) -> None:
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
        is_misfit=_is_misfit(likelihood, fit),
    )


def _is_misfit(likelihood: Likelihood, fit: Fit) -> bool:
    return likelihood.dispersion(fit.parameters) >= likelihood.setting.search.large_dispersion


def _stated_covariance(likelihood: Likelihood, fit: Fit) -> FloatArray:
    """Return the covariance of the parameters, enlarged where the model does not fit.

    A misfit scales the covariance, as if all readings scattered so much (quasi-likelihood,
    McCullagh and Nelder 1989, section 9.2). Beside a wall, the error that comes from its unknown
    shape is added.
    """
    covariance = covariance_with_images(likelihood, fit)
    if _is_misfit(likelihood, fit):
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
