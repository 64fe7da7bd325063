# SPDX-License-Identifier: Apache-2.0
"""Sources from readings: places, strengths, uncertainties."""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.errors import TooFewReadingsError
from rocsafe_radiation.localization.counts_model import SOURCE_PARAMETERS, STRENGTH, UP
from rocsafe_radiation.localization.estimates import Localization, SourceEstimate
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.mirror_image import covariance_with_images
from rocsafe_radiation.localization.search_options import SearchOptions
from rocsafe_radiation.localization.smoothing import as_counted
from rocsafe_radiation.localization.source_count import (
    LARGEST_ORDER,
    OrderSearch,
    Weighed,
    first_fit,
    search,
)
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.readings.survey import RadiationSurvey

FEWEST_READINGS = 8
# Settings less likely than this do not widen ellipses.
LEAST_CHANCE = 1e-3
# More readings than this share that fit nothing are no spikes but a field that is not understood.
MOST_SPIKES_SHARE = 0.01
# With a wall more likely than this, an ellipse of 95 % cannot be trusted.
LARGEST_WALL_CHANCE = 0.05
# One source that is spread along 1.2 to 3.3 heights reads as two, 0.8 to 1.9 heights apart.
LEAST_APART_HEIGHTS = 2.0
# Clocks and gains that differ by more standard deviations are told.
SURE_STDS = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalizationOptions:
    """What is known before the readings.

    Attributes
    ----------
    kernel
        Law of the dose rate, and the response of the detector.
    source_up_m, source_up_std_m
        Expected height of sources above the ground and its standard deviation, metres; 0: fixed.
    position_std_m
        Standard deviation of each coordinate of the fixes, metres. The readings decide between
        none, half of it, it and twice it.
    response_std
        Standard deviation of the logarithm of what the detector reads of a source, and of what
        the ground scatters, which the law leaves out: 6 to 8 % at 100 m over soil. It is the same
        for all readings: it widens the intervals of strengths, not the ellipses.
    largest_order
        Most sources looked for.
    search
        Numbers that tune the search.
    """

    kernel: Kernel = field(default_factory=Kernel)
    source_up_m: float = 0.5
    source_up_std_m: float = 1.0
    position_std_m: float = 1.5
    response_std: float = 0.05
    largest_order: int = LARGEST_ORDER
    search: SearchOptions = field(default_factory=SearchOptions)

    def __post_init__(self) -> None:
        if not 0.0 <= self.source_up_std_m < math.inf:
            raise ValueError(f'source_up_std_m = {self.source_up_std_m} must be at least 0')
        if not 0.0 <= self.position_std_m < math.inf:
            raise ValueError(f'position_std_m = {self.position_std_m} must be at least 0')
        if not 0.0 <= self.response_std < math.inf:
            raise ValueError(f'response_std = {self.response_std} must be at least 0')
        if not 0 <= self.largest_order <= LARGEST_ORDER:
            raise ValueError(
                f'largest_order = {self.largest_order} must be within 0 and {LARGEST_ORDER}'
            )


def localize(survey: RadiationSurvey, options: LocalizationOptions | None = None) -> Localization:
    """Return the sources that `survey` supports.

    Raises
    ------
    TooFewReadingsError
        If there are fewer than 8 readings, all of them are at one place, or none has a count.

    Examples
    --------
    Counts 10 m above a square of 100 m, of a source at east 20 m, north -10 m:

    >>> import numpy as np
    >>> from rocsafe_radiation.physics.kernel import Kernel
    >>> east, north = np.meshgrid(np.arange(-50.0, 51.0, 10.0), np.arange(-50.0, 51.0, 10.0))
    >>> places = np.column_stack([east.ravel(), north.ravel(), np.full(east.size, 10.0)])
    >>> squares = ((places - [20.0, -10.0, 0.5]) ** 2).sum(axis=1)
    >>> counts = np.random.default_rng(1).poisson(100.0 * (0.1 + 5000.0 / squares))
    >>> survey = RadiationSurvey(
    ...     positions_enu_m=places,
    ...     counts=counts.astype(float),
    ...     exposures=np.full(len(places), 100.0),
    ... )
    >>> found = localize(survey, LocalizationOptions(kernel=Kernel(is_lossy=False)))
    >>> [tuple(float(x) for x in source.position_enu_m[:2].round()) for source in found.sources]
    [(20.0, -10.0)]
    """
    options = options or LocalizationOptions()
    require_enough(survey)
    merged, setting = _prepared(survey, options)
    require_enough(merged)
    counted, smoothing_s = as_counted(
        survey,
        lambda one, has_clock, start: first_fit(*_prepared(one, options), has_clock, start),
    )
    if counted is not survey:
        merged, setting = _prepared(counted, options)
    found = search(merged, setting, options.largest_order)
    return replace(_described(found, survey, options), smoothing_s=smoothing_s)


def _prepared(
    survey: RadiationSurvey, options: LocalizationOptions
) -> tuple[RadiationSurvey, Setting]:
    """Return the survey in cells, and what is known before."""
    cell_m = options.search.cell_heights * survey.height_m(options.source_up_m)
    merged = survey.merged(cell_m, options.search.most_readings)
    return merged, Setting(
        kernel=options.kernel.at_heights(merged.heights_m - options.source_up_m),
        source_up_m=options.source_up_m,
        source_up_std_m=options.source_up_std_m,
        position_std_m=options.position_std_m,
        search=options.search,
    )


def require_enough(survey: RadiationSurvey) -> None:
    """Raise TooFewReadingsError if `survey` is too small to localise from, or has no count."""
    if survey.size and not survey.counts.any():
        raise TooFewReadingsError(
            f'{survey.size} readings without a count: a dead detector proves no absence'
        )
    if survey.size < FEWEST_READINGS:
        raise TooFewReadingsError(
            f'{survey.size} readings at different places: at least {FEWEST_READINGS} are needed'
        )


def _described(
    found: OrderSearch, survey: RadiationSurvey, options: LocalizationOptions
) -> Localization:
    best = found.found[0]
    likelihood, fit = best.likelihood, best.fit
    means, covariance = _over_settings(found.found, options.position_std_m)
    shares = likelihood.regular_shares(
        likelihood.expected(fit.parameters), likelihood.weights(fit.parameters)
    )
    spikes = int((shares < 0.5).sum())
    are_few = spikes <= max(1.0, MOST_SPIKES_SHARE * likelihood.survey.size)
    dispersion, ratio = likelihood.misfit(fit.parameters, are_few)
    is_misfit = dispersion >= likelihood.setting.search.largest_dispersion
    if is_misfit:
        # As if all readings scattered so much (quasi-likelihood, McCullagh and Nelder 1989, 9.2).
        covariance = covariance * max(1.0, ratio)
    # The response is common to all sources.
    covariance[STRENGTH::SOURCE_PARAMETERS, STRENGTH::SOURCE_PARAMETERS] += options.response_std**2
    estimates = [
        _estimate(best, source, covariance[own, own])
        for source, own in zip(means, _blocks(len(means)), strict=True)
    ]
    rates = likelihood.background_usvh(fit.parameters)
    background_usvh = float(np.average(rates, weights=likelihood.survey.exposures))
    level_std = math.sqrt(min(fit.covariance[0, 0], 100.0))
    return Localization(
        sources=tuple(sorted(estimates, key=lambda one: one.detection_llr, reverse=True)),
        order_probabilities=found.probabilities(),
        background_usvh=background_usvh,
        background_std_usvh=background_usvh * level_std,
        reading_count=survey.size,
        caveats=survey.caveats,
        dispersion=dispersion,
        rho=likelihood.setting.rho,
        is_structured=likelihood.setting.background_std > 0.0,
        is_misfit=is_misfit,
        is_lopsided=found.wall_chance > LARGEST_WALL_CHANCE,
        may_be_spread=_least_apart_m(means)
        < LEAST_APART_HEIGHTS * survey.height_m(likelihood.setting.source_up_m),
        spike_count=spikes,
        is_understood=are_few and not is_misfit,
        allowed_for=tuple(_allowed_for(best)),
    )


def _least_apart_m(sources: FloatArray) -> float:
    """Return the least distance of two of the places, inf if there are no two."""
    pairs = itertools.combinations(sources[:, :UP].tolist(), 2)
    return min(itertools.starmap(math.dist, pairs), default=math.inf)


def _allowed_for(best: Weighed) -> Iterator[str]:
    """Yield in words what a fit allows for in clock and detectors."""
    values, stds = best.likelihood.clock_and_gains(best.fit.parameters, best.fit.covariance)
    for index, (value, std) in enumerate(zip(values.tolist(), stds.tolist(), strict=True)):
        if abs(value) < SURE_STDS * std:
            continue
        if index == 0:
            side = 'before' if value > 0.0 else 'after'
            yield f'the places are those of about {abs(value):.1f} s {side} the readings'
        else:
            more = 'more' if value > 0.0 else 'less'
            share = abs(math.expm1(value))
            yield f'a detector shows about {share:.0%} {more} at the end than at the start'


def _over_settings(fits: Sequence[Weighed], fix_error_m: float) -> tuple[FloatArray, FloatArray]:
    """Return mean (sources, 4) and covariance of all sources over the settings, by evidence."""
    chances = np.exp(np.array([one.evidence - fits[0].evidence for one in fits]))
    chances /= chances.sum()
    means = [
        one.likelihood.sources(one.fit.parameters)[:, :SOURCE_PARAMETERS].ravel() for one in fits
    ]
    mean = np.asarray(chances @ np.array(means), np.float64)
    covariance = np.zeros((mean.size, mean.size))
    for chance, one, own in zip(chances, fits, means, strict=True):
        if chance < LEAST_CHANCE:
            continue
        whole = covariance_with_images(one.likelihood, one.fit, fix_error_m)
        places = one.likelihood.source_rows(len(whole))[:, :SOURCE_PARAMETERS].ravel()
        covariance += chance * (whole[np.ix_(places, places)] + np.outer(own - mean, own - mean))
    return mean.reshape(-1, SOURCE_PARAMETERS), covariance


def _blocks(count: int) -> list[slice]:
    return [
        slice(start, start + SOURCE_PARAMETERS)
        for start in range(0, SOURCE_PARAMETERS * count, SOURCE_PARAMETERS)
    ]


def _estimate(best: Weighed, source: FloatArray, covariance: FloatArray) -> SourceEstimate:
    likelihood, parameters = best.likelihood, best.fit.parameters
    sources = likelihood.sources(parameters)
    index = int(np.argmin(((sources[:, :UP] - source[:UP]) ** 2).sum(axis=1)))
    start = likelihood.head_size + likelihood.source_size * index
    others = np.delete(parameters, range(start, start + likelihood.source_size))
    # All else unchanged, the variance of the readings too.
    weights = likelihood.weights(parameters)
    gain = likelihood.objective(parameters, weights) - likelihood.objective(others, weights)
    ground = likelihood.survey.ground
    position = source[:3].copy()
    if likelihood.setting.source_up_std_m == 0.0:
        position[UP] = likelihood.setting.source_up_m
    position = ground.raised(position[None])[0]
    return SourceEstimate(
        position_enu_m=position,
        dose_rate_at_1m_usvh=float(np.exp(source[3])),
        joint_covariance=ground.tilted(covariance, position),
        detection_llr=gain,
    )
