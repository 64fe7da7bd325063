# SPDX-License-Identifier: Apache-2.0
"""Wald's sequential test for a source anywhere; valid for any number of looks at the data.

Counts are Poisson about the background, or about background plus source. Place and strength of the
source are not known: its likelihood is the mean over the ground surveyed and over a range of
strengths (Wald's weight functions; a mixture). Without a source, the mean likelihood ratio M is a
martingale of mean 1 for any order of readings. By Ville's inequality, the probability that M ever
reaches 1/a is at most a. The test decides for a source at M >= (1 - missed) / false_alarm, and
against one of at least a given strength at M <= missed / (1 - false_alarm). Its error rates hold
for any number of looks, if a decision against a source means against the mean over ground and
strengths, and if the background is known.

The background is estimated from the same readings. The error rates are therefore also measured:
``benchmarks/localisation.py --only stopping``.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.candidates import candidate_grid, grid_kernel
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.readings.survey import RadiationSurvey

STRENGTHS = 9
# The range of strengths spans so many decades above the smallest one looked for.
DECADES = 4.0
# Rounds of Newton's method for the background beside a source: good to 1e-4.
ROUNDS = 5
# Least background beside a source, as a share of the background without one.
LOWEST_LEVEL = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class SequentialEvidence:
    """Logarithms of mean likelihood ratios of a source to no source.

    Attributes
    ----------
    log_ratio
        For a source of any strength anywhere.
    log_ratio_smallest
        For a source of the smallest strength looked for, anywhere.
    places_m
        East and north of the places tried, shape (m, 2).
    doubts
        Log ratio of a source of the smallest strength at each place, shape (m,); such a source is
        most likely where it is highest.
    """

    log_ratio: float
    log_ratio_smallest: float
    places_m: FloatArray = field(
        default_factory=lambda: np.empty((0, 2)), compare=False, repr=False
    )
    doubts: FloatArray = field(default_factory=lambda: np.empty(0), compare=False, repr=False)


def sequential_evidence(
    survey: RadiationSurvey, setting: Setting, smallest_usvh: float
) -> SequentialEvidence:
    """Return the evidence of `survey` for a source of at least `smallest_usvh` at 1 m.

    Parameters
    ----------
    survey
        Readings.
    setting
        Law of the dose rate and height of sources; a rho above 0 reduces the weight of readings.
    smallest_usvh
        Dose rate at 1 m of the weakest source that matters.

    Raises
    ------
    ValueError
        If `smallest_usvh` is not above 0.
    """
    if not 0.0 < smallest_usvh < math.inf:
        raise ValueError(f'smallest_usvh = {smallest_usvh} must be above 0 and finite')
    grid = _within(candidate_grid(survey, setting), survey)
    kernel = grid_kernel(survey, setting, grid)
    shape = np.ones(survey.size) if survey.background_shape is None else survey.background_shape
    natural = survey.exposures * shape
    mean = max(float(survey.net_counts.sum() / natural.sum()), 1e-9)
    dark = np.broadcast_to(survey.dark_counts, survey.size)
    level = float(_levels(survey, dark[None], natural, mean)[0])
    strengths = smallest_usvh * np.geomspace(1.0, 10.0**DECADES, STRENGTHS)
    logs = np.stack([_log_ratios(survey, kernel * s + dark, natural, level) for s in strengths])
    return SequentialEvidence(
        log_ratio=_log_mean(logs),
        log_ratio_smallest=_log_mean(logs[0]),
        places_m=grid,
        doubts=logs[0],
    )


def _within(grid: FloatArray, survey: RadiationSurvey) -> FloatArray:
    """Return the places of `grid` over the ground surveyed, at least one."""
    places = survey.positions_enu_m[:, :2]
    inside = ((grid >= places.min(axis=0)) & (grid <= places.max(axis=0))).all(axis=1)
    return grid[inside] if inside.any() else grid


def _levels(
    survey: RadiationSurvey, added: FloatArray, natural: FloatArray, level: float
) -> FloatArray:
    """Return the background beside each of `added` (k, n) by maximum likelihood, uSv/h, (k,)."""
    counts = survey.counts
    levels = np.full(len(added), level)
    for _ in range(ROUNDS):
        inverse = 1.0 / (np.outer(levels, natural) + added)
        # The derivative by the level is convex: from below, Newton's step never goes too far.
        slopes = inverse @ (counts * natural) - natural.sum()
        bends = np.square(inverse, out=inverse) @ (counts * natural**2)
        levels = np.maximum(levels + slopes / np.maximum(bends, 1e-300), LOWEST_LEVEL * level)
    return levels


def _log_ratios(
    survey: RadiationSurvey, added: FloatArray, natural: FloatArray, level: float
) -> FloatArray:
    """Return the log likelihood ratio of each place, each hypothesis with its best background.

    `added` are the counts of a source at each place and dark ones, shape (places, n).
    """
    expected = np.outer(_levels(survey, added, natural, level), natural) + added
    null = level * natural + survey.dark_counts
    excess = expected.sum(axis=1) - null.sum()
    return np.asarray(np.log(expected / null) @ survey.counts - excess)


def _log_mean(logs: FloatArray) -> float:
    """Return the logarithm of the mean of exponentials."""
    top = float(logs.max())
    return top + math.log(float(np.exp(logs - top).mean()))
