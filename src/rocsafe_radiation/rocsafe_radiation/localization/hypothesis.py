# SPDX-License-Identifier: Apache-2.0
"""Fits with 0, 1, 2 ... sources to one survey in one setting, and the starts of these fits."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.background_basis import smooth_basis
from rocsafe_radiation.localization.candidates import (
    best_separated,
    candidate_grid,
    grid_kernel,
    score_candidates,
)
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.hypothesis_values import OrderSearch, source_penalty
from rocsafe_radiation.localization.likelihood import (
    HEIGHT_MEAN,
    LEVEL_PARAMETERS,
    SOURCE_PARAMETERS,
    Fit,
    Likelihood,
)
from rocsafe_radiation.localization.mirror_image import mirror_images
from rocsafe_radiation.localization.reading_weights import background_level_usvh
from rocsafe_radiation.localization.wall_shadow import LINE
from rocsafe_radiation.readings.survey import RadiationSurvey

# Fields of a setting that are replaced, with their values.
Nuisance = dict[str, Any]
# Quantile 0.95 of chi-square with two degrees of freedom.
ELLIPSE_95 = 5.991
SPLIT_ANGLES_RAD = (0.0, math.pi / 3.0, 2.0 * math.pi / 3.0)
# A fit without the wall places the source too far from it, by up to so many heights.
WALL_ANGLES_RAD = tuple(math.pi * turn / 3.0 for turn in range(6))
WALL_LINE, WALL_SHIFTS_HEIGHTS = 3.5, (0.0, 0.3)
EDGE_FACTORS = (0.7, 0.85, 1.0, 1.2, 1.45)


class Trial:
    """Fits to one survey in different settings."""

    def __init__(self, survey: RadiationSurvey, setting: Setting) -> None:
        self._survey = survey
        self.setting = setting
        self._bases: dict[float, FloatArray] = {}
        self._grid = candidate_grid(survey, setting)
        self._kernel = grid_kernel(survey, setting, self._grid)

    def orders(
        self, nuisance: Nuisance, largest_order: int, hints: OrderSearch | None = None
    ) -> OrderSearch:
        """Return the best fit with each number of sources, until one more source is worse.

        The sources of `hints` are further starts: if a smooth background has taken the shape of a
        source, the grid of places alone may not find that source.
        """
        likelihood = self._likelihood(nuisance)
        start = np.zeros(likelihood.head_size)
        start[0], start[1] = math.log(background_level_usvh(self._survey)), HEIGHT_MEAN
        fits = [likelihood.fit(start)]
        scores = [_score(likelihood, fits[0])]
        # One more source may be worse where two more are better. Splitting tries pairs, so one
        # worse step is enough.
        while len(fits) <= largest_order and scores[-1] >= max(scores) - 1.0:
            known = _hinted(likelihood, hints, len(fits))
            fit = _with_one_more(likelihood, fits[-1], known, self._grid, self._kernel)
            if fit is None or not is_placed(likelihood, fit):
                break
            fits.append(fit)
            scores.append(_score(likelihood, fit))
        return OrderSearch(likelihood=likelihood, fits=tuple(fits), scores=tuple(scores))

    def glance(self, nuisance: Nuisance, hints: OrderSearch, largest_order: int) -> float:
        """Return an estimate of the best score of `orders`, in a tenth of its time.

        The only starts are the sources of `hints`.
        """
        likelihood = self._likelihood(nuisance)
        most = min(largest_order, len(hints.fits) - 1)
        starts = [
            start for order in range(most + 1) for start in _hinted(likelihood, hints, order)
        ]
        rough = self.setting.search.rough_iterations
        fits = (likelihood.fit(start, rough) for start in starts)
        return max(_score(likelihood, fit) for fit in fits)

    def _likelihood(self, nuisance: Nuisance) -> Likelihood:
        setting = replace(self.setting, **nuisance)
        spacing = setting.background_spacing_heights
        if spacing not in self._bases:
            height = self._survey.height_m(setting.source_up_m)
            self._bases[spacing] = smooth_basis(self._survey.positions_enu_m, height, spacing)
        return Likelihood(self._survey, setting, self._bases[spacing])


def _hinted(likelihood: Likelihood, hints: OrderSearch | None, order: int) -> list[FloatArray]:
    """Return starts with the sources of `hints`, a constant background, and a wall if any."""
    if hints is None or order >= len(hints.fits):
        return []
    fit = hints.fits[order]
    background = np.zeros(likelihood.head_size)
    background[:LEVEL_PARAMETERS] = fit.parameters[:LEVEL_PARAMETERS]
    sources = hints.likelihood.sources(fit.parameters)
    if hints.likelihood.setting.has_shield:
        background[likelihood.law] = fit.parameters[hints.likelihood.law]
        return list(_moved_edges(likelihood, background, sources))
    if likelihood.setting.has_shield:
        return list(_walled(likelihood, background, sources))
    return [np.concatenate([background, sources.ravel()])]


def _walled(
    likelihood: Likelihood, background: FloatArray, sources: FloatArray
) -> Iterator[FloatArray]:
    """Yield starts with a wall on each side of the sources, which are moved towards it or not."""
    height = likelihood.survey.height_m(likelihood.setting.source_up_m)
    for angle, shift in itertools.product(WALL_ANGLES_RAD, WALL_SHIFTS_HEIGHTS):
        towards = np.array([math.cos(angle), math.sin(angle)])
        head, moved = background.copy(), sources.copy()
        head[likelihood.law][LINE] = WALL_LINE * towards
        moved[:, :2] += shift * height * towards
        yield np.concatenate([head, moved.ravel()])


def _moved_edges(
    likelihood: Likelihood, head: FloatArray, sources: FloatArray
) -> Iterator[FloatArray]:
    """Yield starts with the edge of the wall's shadow nearer and farther."""
    for factor in EDGE_FACTORS:
        moved = head.copy()
        moved[likelihood.law][LINE] *= factor
        yield np.concatenate([moved, sources.ravel()])


def _with_one_more(
    likelihood: Likelihood, fit: Fit, hints: list[FloatArray], grid: FloatArray, kernel: FloatArray
) -> Fit | None:
    """Return the best fit with one more source, None if there is no start."""
    height = likelihood.survey.height_m(likelihood.setting.source_up_m)
    is_known = bool(hints) and likelihood.setting.has_shield
    added = [] if is_known else _added(likelihood, fit.parameters, grid, kernel, height)
    starts = [
        *hints,
        *added,
        *_split(likelihood, fit.parameters, 0.4 * height),
    ]
    if not starts:
        return None
    options = likelihood.setting.search
    rough = (likelihood.fit(start, options.rough_iterations) for start in starts)
    ranked = sorted(rough, key=_evidence, reverse=True)
    best = max(
        (likelihood.fit(one.parameters) for one in ranked[: options.refined_candidates]),
        key=_evidence,
    )
    images = (likelihood.fit(start) for start in mirror_images(likelihood, best.parameters))
    return max((best, *images), key=_evidence)


def _evidence(fit: Fit) -> float:
    return fit.log_likelihood


def _added(
    likelihood: Likelihood,
    parameters: FloatArray,
    grid: FloatArray,
    kernel: FloatArray,
    height: float,
) -> list[FloatArray]:
    tried = likelihood.setting.search.tried_candidates
    gains, strengths = score_candidates(likelihood, parameters, kernel)
    up = likelihood.setting.source_up_m
    return [
        np.concatenate([parameters, [*grid[index], up, math.log(strengths[index])]])
        for index in best_separated(grid, gains, tried, height)
    ]


def _split(likelihood: Likelihood, parameters: FloatArray, distance_m: float) -> list[FloatArray]:
    """Return starts with one source replaced by a pair of half its strength."""
    sources = likelihood.sources(parameters)
    starts = []
    for index, angle in itertools.product(range(len(sources)), SPLIT_ANGLES_RAD):
        offset = distance_m * np.array([math.cos(angle), math.sin(angle)])
        pair = np.stack([sources[index], sources[index]])
        pair[:, :2] += np.stack([offset, -offset])
        pair[:, 3] -= math.log(2.0)
        others = np.delete(sources, index, axis=0)
        background = parameters[: likelihood.head_size]
        starts.append(np.concatenate([background, others.ravel(), pair.ravel()]))
    return starts


def is_placed(likelihood: Likelihood, fit: Fit) -> bool:
    """Return whether the place of each source is known to a part of the survey.

    A source that may be anywhere raises all readings alike: it is background.
    """
    places = likelihood.survey.positions_enu_m[:, :2]
    diagonal_m = float(np.linalg.norm(np.ptp(places, axis=0)))
    longest_m = likelihood.setting.search.largest_ellipse_share * diagonal_m
    covariance = np.linalg.inv(fit.information)
    starts = range(likelihood.head_size, len(covariance), SOURCE_PARAMETERS)
    blocks = [covariance[start : start + 2, start : start + 2] for start in starts]
    variances = [float(np.linalg.eigvalsh(block)[-1]) for block in blocks]
    return all(ELLIPSE_95 * variance < longest_m**2 for variance in variances)


def _score(likelihood: Likelihood, fit: Fit) -> float:
    """Return the logarithm of the evidence of `fit`, without constants of the survey."""
    order = likelihood.source_count(fit.parameters)
    options = likelihood.setting.search
    penalty = order * source_penalty(likelihood)
    if order > 0:
        penalty -= options.log_prior_odds_first
    if likelihood.has_narrow_hills:
        penalty -= options.log_prior_odds_narrow
    for part in (likelihood.bumps, likelihood.law):
        stds = likelihood.nuisance_stds[
            part.start - LEVEL_PARAMETERS : part.stop - LEVEL_PARAMETERS
        ]
        _, volume = np.linalg.slogdet(fit.information[part, part] * np.outer(stds, stds))
        penalty += 0.5 * float(volume)
    return fit.log_likelihood - penalty
