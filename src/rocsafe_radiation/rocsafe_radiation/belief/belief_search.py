# SPDX-License-Identifier: Apache-2.0
"""The method ``belief-grid``: sources from readings that say yes or no about the cell below.

A reading says yes when it has more counts than the background and half of the smallest source
below would give, and no reading around has far more. It counts for the cell below it only. Its
error rates follow from the Poisson distribution. Probable cells that touch make one source, at
their centre of mass. The method does not depend on the law of the dose rate; it knows places to a
cell.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_radiation.belief.belief_grid import BeliefGrid, YesNoSensor
from rocsafe_radiation.localization.estimates import BELIEF_METHOD, Localization, SourceEstimate
from rocsafe_radiation.localization.localize import LocalizationOptions, require_enough
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.readings.survey import RadiationSurvey

CELL_HEIGHTS = 0.5
SMALLEST_CELL_M = 2.0
LARGEST_GRID = 40_000
# Expected number of sources on the whole ground before any reading.
EXPECTED_SOURCES = 1.0
# Least error rates: real readings are less certain than Poisson statistics.
SMALLEST_ERROR, LARGEST_ERROR = 1e-5, 0.45
# With background alone, 2e-5 of the readings say yes.
YES_DEVIATIONS = 4.1
# Counts of a block of readings, whose median is within 0.01 of their mean.
BLOCK_COUNTS = 25.0
# A reading that says yes has at least this share of the highest excess within so many heights.
PEAK_SHARE, PEAK_HEIGHTS = 0.5, 2.0
BLOCK = 1024
BELIEVED = 0.9
SMALLEST_USVH = 92.0


@dataclass(frozen=True, slots=True, kw_only=True)
class BeliefMap:
    """Probability of a source in each cell, shape (rows, columns)."""

    corner_m: tuple[float, float]
    cell_m: float
    probabilities: FloatArray


def believe(
    survey: RadiationSurvey,
    options: LocalizationOptions,
    agents: Sequence[str] = (),
    smallest_usvh: float = SMALLEST_USVH,
) -> tuple[Localization, BeliefMap]:
    """Return the probable sources of `survey` and the probability of each cell.

    Parameters
    ----------
    survey
        Readings.
    options
        Law of the dose rate and height of sources.
    agents
        Agent of each reading; each has a grid of its own, and all are merged.
    smallest_usvh
        Dose rate at 1 m of the weakest source that matters.

    Raises
    ------
    TooFewReadingsError
        With too few readings.
    """
    require_enough(survey)
    height_m = np.array([survey.height_m(options.source_up_m)])
    options = replace(options, kernel=options.kernel.at_heights(height_m))
    grid = _Grid.over(survey, options.source_up_m)
    names = list(agents) if len(agents) == survey.size else ['all'] * survey.size
    beliefs = _beliefs(survey, options, grid, names, smallest_usvh)
    merged = beliefs[0]
    for other in beliefs[1:]:
        merged.merge(other)
    probabilities = merged.probabilities()
    clusters = _clusters(probabilities > BELIEVED)
    sources = [_source(one, probabilities, grid, survey, options) for one in clusters]
    # Within this distance, a further source cannot be told from one that is found.
    apart = round(PEAK_HEIGHTS * survey.height_m(options.source_up_m) / grid.cell_m)
    others = probabilities[~_about(clusters, grid.shape, apart)]
    return _localization(survey, sources, others), BeliefMap(
        corner_m=grid.corner_m, cell_m=grid.cell_m, probabilities=probabilities
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Grid:
    """Square cells over the readings; `corner_m` is the centre of the south-western one."""

    corner_m: tuple[float, float]
    cell_m: float
    shape: tuple[int, int]

    @classmethod
    def over(cls, survey: RadiationSurvey, source_height_m: float) -> '_Grid':
        places = survey.positions_enu_m[:, :2]
        low, extent = places.min(axis=0), np.ptp(places, axis=0)
        cell = max(
            CELL_HEIGHTS * survey.height_m(source_height_m),
            math.sqrt(float(np.prod(extent + 1.0)) / LARGEST_GRID),
            SMALLEST_CELL_M,
        )
        columns, rows = (int(n) for n in np.floor(extent / cell) + 1)
        corner = (float(low[0] + cell / 2.0), float(low[1] + cell / 2.0))
        return cls(corner_m=corner, cell_m=cell, shape=(rows, columns))

    def cells(self, places: FloatArray) -> list[tuple[int, int]]:
        """Return row and column of the cell below each place, shape (n, 2)."""
        offsets = (places - np.array(self.corner_m)) / self.cell_m + 0.5
        columns = np.clip(offsets[:, 0].astype(int), 0, self.shape[1] - 1)
        rows = np.clip(offsets[:, 1].astype(int), 0, self.shape[0] - 1)
        return list(zip(rows.tolist(), columns.tolist(), strict=True))


def _beliefs(
    survey: RadiationSurvey,
    options: LocalizationOptions,
    grid: _Grid,
    names: list[str],
    smallest_usvh: float,
) -> list[BeliefGrid]:
    """Return the grid of each agent."""
    prior: FloatArray = np.full(grid.shape, min(0.1, EXPECTED_SOURCES / math.prod(grid.shape)))
    beliefs = {name: BeliefGrid(prior, name) for name in dict.fromkeys(names)}
    background = survey.exposures * _median_level_usvh(survey) + survey.dark_counts
    height = survey.height_m(options.source_up_m)
    # A source at the edge of a cell gives the weakest signal.
    square = np.array([height**2 + 0.5 * grid.cell_m**2])
    added = survey.exposures * smallest_usvh * options.kernel.values(square)[0]
    # Half of the signal is the best limit for both errors, but with many readings false alarms
    # must be rarer.
    surely = background + YES_DEVIATIONS * np.sqrt(background) + YES_DEVIATIONS**2 / 6.0
    limits = np.ceil(np.maximum(background + added / 2.0 + 0.5, surely))
    missed = poisson_below(limits, background + added)
    lied = 1.0 - poisson_below(limits, background)
    is_peak = _are_peaks(survey, background, PEAK_HEIGHTS * height)
    answers = ((survey.counts >= limits) & is_peak).tolist()
    rates = np.clip([lied, missed], SMALLEST_ERROR, LARGEST_ERROR).T.tolist()
    cells = grid.cells(survey.positions_enu_m[:, :2])
    for name, cell, is_yes, (lie, miss) in zip(names, cells, answers, rates, strict=True):
        beliefs[name].observe(YesNoSensor(false_positive=lie, false_negative=miss), cell, is_yes)
    return list(beliefs.values())


def _median_level_usvh(survey: RadiationSurvey) -> float:
    """Return the median rate as background: sources raise fewer than half of the readings.

    That of blocks of readings in their order, of `BLOCK_COUNTS` on average: the median of few
    counts is far from their mean, 0 for 0.5 counts a reading.
    """
    size = math.ceil(BLOCK_COUNTS * survey.size / max(float(survey.counts.sum()), BLOCK_COUNTS))
    starts = np.arange(0, survey.size, size)
    net, exposures = (
        np.add.reduceat(values, starts) for values in (survey.net_counts, survey.exposures)
    )
    return max(float(np.median(net / exposures)), 1e-6)


def poisson_below(limits: FloatArray, means: FloatArray) -> FloatArray:
    """Return the probability of fewer counts than `limits`, to 0.006.

    The time of the n-th count has a gamma distribution, whose cube root is nearly normal (Wilson
    and Hilferty 1931).
    """
    orders = np.maximum(limits, 1.0)
    scores = 3.0 * np.sqrt(orders) * (np.cbrt(means / orders) - 1.0 + 1.0 / (9.0 * orders))
    below = np.array([0.5 * math.erfc(score / math.sqrt(2.0)) for score in scores.tolist()])
    return np.where(limits < 0.5, 0.0, below)


def _are_peaks(survey: RadiationSurvey, background: FloatArray, radius_m: float) -> BoolArray:
    """Return which readings exceed the background at least half as much as any around them.

    A strong source raises readings far away, too: only the highest of them is above it.
    """
    rates = (survey.counts - background) / survey.exposures
    places = survey.positions_enu_m[:, :2]
    peaks: BoolArray = np.empty(survey.size, dtype=bool)
    for start in range(0, survey.size, BLOCK):
        block = slice(start, start + BLOCK)
        squares = ((places[block, None] - places[None]) ** 2).sum(axis=2)
        highest = np.where(squares <= radius_m**2, rates, -np.inf).max(axis=1)
        peaks[block] = rates[block] >= PEAK_SHARE * highest
    return peaks


def _clusters(believed: BoolArray) -> list[list[tuple[int, int]]]:
    """Return the cells of each connected patch; cells that share a corner are connected."""
    left = set(map(tuple, np.argwhere(believed).tolist()))
    clusters = []
    while left:
        edge = [left.pop()]
        cluster = list(edge)
        while edge:
            row, column = edge.pop()
            near = {(row + i, column + j) for i in (-1, 0, 1) for j in (-1, 0, 1)} & left
            left -= near
            edge += near
            cluster += near
        clusters.append(cluster)
    return clusters


def _about(
    clusters: list[list[tuple[int, int]]], shape: tuple[int, int], margin: int
) -> BoolArray:
    """Return which cells lie at most `margin` cells from a patch, shape (rows, columns)."""
    near: BoolArray = np.zeros(shape, dtype=bool)
    for row, column in itertools.chain.from_iterable(clusters):
        top, left = max(row - margin, 0), max(column - margin, 0)
        near[top : row + margin + 1, left : column + margin + 1] = True
    return near


def _source(
    cluster: list[tuple[int, int]],
    probabilities: FloatArray,
    grid: _Grid,
    survey: RadiationSurvey,
    options: LocalizationOptions,
) -> SourceEstimate:
    """Return the source of one patch, at the mean of its readings weighted by their excess."""
    cells = np.array(cluster)
    centres = np.array(grid.corner_m) + cells[:, ::-1] * grid.cell_m
    below = grid.cells(survey.positions_enu_m[:, :2])
    own = np.array([cell in set(cluster) for cell in below])
    excess = np.maximum(survey.net_counts / survey.exposures - _median_level_usvh(survey), 0.0)
    weights = np.where(own, excess, 0.0)
    places = survey.positions_enu_m[:, :2]
    centre = np.average(places, axis=0, weights=weights) if weights.any() else centres.mean(axis=0)
    strength, log_std = _strength(centre, survey, options)
    spread = grid.cell_m**2 / 12.0 + centres.var(axis=0) / len(cluster)
    aside = np.diag(np.sqrt(spread))
    moved = [_strength(centre + way, survey, options)[0] for way in (*aside, *-aside)]
    # The place is uncertain, and so is the strength: half the squared change to both sides of an
    # axis.
    log_std = math.hypot(
        log_std, float(np.linalg.norm(np.log(np.array(moved) / strength))) / 2**0.5
    )
    covariance = np.diag([*spread.tolist(), options.source_up_std_m**2, log_std**2])
    place = survey.ground.raised(np.array([[*centre.tolist(), options.source_up_m]]))[0]
    log_odds = [math.log(p / (1.0 - p)) for p in probabilities[tuple(cells.T)].tolist() if p < 1.0]
    return SourceEstimate(
        position_enu_m=place,
        dose_rate_at_1m_usvh=strength,
        joint_covariance=survey.ground.tilted(covariance, place),
        detection_llr=max(log_odds, default=math.inf) if len(log_odds) == len(cells) else 700.0,
    )


def _strength(
    centre: FloatArray, survey: RadiationSurvey, options: LocalizationOptions
) -> tuple[float, float]:
    """Return the strength by the readings around, and the standard deviation of its logarithm.

    Farther readings are left out: they depend more on the background, which the median
    overestimates.
    """
    place = survey.ground.raised(np.array([[*centre.tolist(), options.source_up_m]]))[0]
    kernel: Kernel = options.kernel
    squares = ((survey.positions_enu_m - place) ** 2).sum(axis=1)
    added = survey.exposures * kernel.values(squares)
    excess = survey.net_counts - survey.exposures * _median_level_usvh(survey)
    reach = PEAK_HEIGHTS * survey.height_m(options.source_up_m)
    near = squares <= squares.min() + reach**2
    weights = near * added / np.maximum(survey.counts, 1.0)
    strength = max(float(weights @ excess) / float(weights @ added), 1e-3)
    return strength, 1.0 / math.sqrt(max(strength**2 * float(weights @ added), 1e-9))


def _localization(
    survey: RadiationSurvey, sources: list[SourceEstimate], others: FloatArray
) -> Localization:
    """Return the result; `others` are the probabilities of the cells away from all `sources`."""
    count = len(sources)
    # Cells are independent: there is no further source if none of the others has one.
    surely = float(np.exp(np.log1p(-np.minimum(others, 0.999)).sum()))
    order = [0.0] * count + [surely, 1.0 - surely]
    background = _median_level_usvh(survey)
    return Localization(
        sources=tuple(sorted(sources, key=lambda one: one.detection_llr, reverse=True)),
        order_probabilities=tuple(order),
        background_usvh=background,
        background_std_usvh=math.sqrt(background / float(survey.exposures.sum())),
        reading_count=survey.size,
        dispersion=0.0,
        rho=0.0,
        is_structured=False,
        caveats=survey.caveats,
        method=BELIEF_METHOD,
    )
