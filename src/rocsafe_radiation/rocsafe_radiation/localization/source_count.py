# SPDX-License-Identifier: Apache-2.0
"""How many sources there are: the evidence of 0, 1, 2 ... sources, summed over settings.

A setting is how uneven the background is and over which lengths, how large the errors of the fixes
are, how much readings scatter in proportion to the sources, and whether there are walls beside
these. The readings decide: for each number of sources, settings beside the best one are fitted
until they add nothing, and their evidence is added up.

Settings are alike likely before, but for steep backgrounds: a field that rises and falls within a
height as much as sources do explains any number of these.
"""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.background_basis import smooth_basis
from rocsafe_radiation.localization.candidates import candidate_grid, grid_kernel
from rocsafe_radiation.localization.counts_model import HEAD_SIZE
from rocsafe_radiation.localization.estimates import ELLIPSE_95
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.likelihood import Fit, Likelihood
from rocsafe_radiation.localization.starts import with_one_more, with_shades, without_sources
from rocsafe_radiation.readings.survey import RadiationSurvey

LARGEST_ORDER = 4
# Indices of background_slopes, background_spacings, standard deviations of the fixes, rhos,
# whether there are shades, and standard deviations of what fixes of a leg have in common.
Index = tuple[int, int, int, int, int, int]
# A fairly uneven background; sources are looked for there, with fixes as good as stated.
FIRST: Index = (2, 1, 0, 0, 0, 0)
# Settings are not fitted whose evidence is lower than that of the best by so many times the
# difference at which none is looked beyond: together they weigh less than a thousandth of it.
HOPELESS = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Weighed:
    """A fit in the setting at `index`, and its evidence."""

    index: Index
    likelihood: Likelihood
    fit: Fit
    evidence: float


@dataclass(frozen=True, slots=True, kw_only=True)
class OrderSearch:
    """Fits with 0, 1, 2 ... sources, each in several settings, the best first."""

    settings: tuple[tuple[Weighed, ...], ...]

    @property
    def evidences(self) -> FloatArray:
        """Evidence of each number of sources, the prior included."""
        odds = self.settings[0][0].likelihood.setting.search.log_odds_of_source
        return np.array([_summed(fits) + odds * k for k, fits in enumerate(self.settings)])

    @property
    def order(self) -> int:
        """The number of sources with the most evidence."""
        return int(np.argmax(self.evidences))

    @property
    def found(self) -> tuple[Weighed, ...]:
        """The fits with that number, the best first."""
        return self.settings[self.order]

    @property
    def wall_chance(self) -> float:
        """The probability that something beside the sources takes part of their dose rate."""
        chances = np.exp([one.evidence - self.found[0].evidence for one in self.found])
        are_shaded = [one.likelihood.setting.has_shades for one in self.found]
        return float(chances[are_shaded].sum() / chances.sum())

    def probabilities(self) -> tuple[float, ...]:
        """Return the probability of each number of sources."""
        logs = self.evidences - self.evidences.max()
        return tuple((np.exp(logs) / np.exp(logs).sum()).tolist())


def _summed(fits: tuple[Weighed, ...]) -> float:
    """Return the logarithm of the sum of evidences, -inf if no fit places all sources."""
    if not fits:
        return -math.inf
    logs = np.array([one.evidence for one in fits])
    return float(logs.max() + math.log(np.exp(logs - logs.max()).sum()))


def search(
    survey: RadiationSurvey, setting: Setting, largest_order: int = LARGEST_ORDER
) -> OrderSearch:
    """Return the fits to `survey` with each number of sources, until more are worse.

    Parameters
    ----------
    survey
        Readings, merged into cells.
    setting
        What is known before; `position_std_m` is that stated for the fixes.
    largest_order
        Most sources looked for.
    """
    settings = _Settings(survey, setting)
    odds, near = setting.search.log_odds_of_source, setting.search.near_evidence
    grid = candidate_grid(survey, setting)
    kernel = grid_kernel(survey, setting, grid)
    first = settings.likelihood(settings.first)
    fit = without_sources(first)
    found = [settings.around(settings.first, fit, -math.inf)]
    while len(found) <= largest_order:
        more = with_one_more(first, fit, grid, kernel)
        if more is None:
            break
        gain = first.evidence(more) - first.evidence(fit) + odds
        fit = more
        best = max(fits[0].evidence + odds * k for k, fits in enumerate(found) if fits)
        floor = best - odds * len(found) - 2.0 * near
        found.append(settings.around(settings.first, fit, floor))
        found[-2] = settings.without_one(found[-1], found[-2])
        evidences = OrderSearch(settings=tuple(found)).evidences
        # A background that is steep enough explains any source: one source more may be worse than
        # that, and all of them better. In the first setting it is not as steep.
        if gain < 0.0 and evidences[-1] < evidences.max() - near:
            break
    return OrderSearch(settings=tuple(found))


def first_fit(
    survey: RadiationSurvey, setting: Setting, has_clock: bool, start: Fit | None
) -> tuple[Likelihood, Fit]:
    """Return the fit with as many sources as are worth it in one setting.

    Parameters
    ----------
    survey, setting
        As for `search`.
    has_clock
        Whether errors that the fixes have in common, and that of their clock, are fitted.
    start
        A fit to begin at, with the same clock and number of sources; None: sources are looked for.
    """
    settings = _Settings(survey, setting)
    likelihood = settings.likelihood(settings.with_clock if has_clock else settings.first)
    if start is not None:
        return likelihood, likelihood.fit(start.parameters)
    grid = candidate_grid(survey, setting)
    kernel = grid_kernel(survey, setting, grid)
    fit = without_sources(likelihood)
    for _ in range(LARGEST_ORDER):
        more = with_one_more(likelihood, fit, grid, kernel)
        gain = -math.inf if more is None else likelihood.evidence(more) - likelihood.evidence(fit)
        if more is None or gain + setting.search.log_odds_of_source < 0.0:
            break
        fit = more
    return likelihood, fit


def _is_placed(likelihood: Likelihood, fit: Fit) -> bool:
    """Return whether the place of each source is known to a part of the survey.

    A source that may be anywhere raises all readings alike: it is background.
    """
    places = likelihood.survey.positions_enu_m[:, :2]
    diagonal_m = float(np.linalg.norm(np.ptp(places, axis=0)))
    longest_m = likelihood.setting.search.largest_ellipse_share * diagonal_m
    covariance = fit.covariance
    starts = range(likelihood.head_size, len(covariance), likelihood.source_size)
    blocks = [covariance[start : start + 2, start : start + 2] for start in starts]
    variances = [float(np.linalg.eigvalsh(block)[-1]) for block in blocks]
    return all(ELLIPSE_95 * variance < longest_m**2 for variance in variances)


def _is_without_wall(found: dict[Index, Weighed], near: float) -> bool:
    """Return whether all walls tried lose to the same settings without by more than `near`."""
    gains = [
        one.evidence - found[plain].evidence
        for key, one in found.items()
        if key[4] and (plain := (key[0], key[1], key[2], key[3], 0, key[5])) in found
    ]
    return bool(gains) and max(gains) < -near


class _Settings:
    """The settings over which evidence is summed."""

    def __init__(self, survey: RadiationSurvey, known: Setting) -> None:
        self._survey, self._known = survey, known
        options = known.search
        stds_m = sorted({factor * known.position_std_m for factor in options.position_factors})
        drifts_m = sorted({factor * known.position_std_m for factor in options.drift_factors})
        self._axes = (
            options.background_slopes,
            options.background_spacings,
            tuple(stds_m),
            options.rhos,
            (False, True)[: 1 + options.are_shades_tried],
            tuple(drifts_m) if survey.flight is not None else (0.0,),
        )
        height = survey.height_m(known.source_up_m)
        self._bases = [
            smooth_basis(survey.positions_enu_m, height, spacing) for spacing in self._axes[1]
        ]
        self.first: Index = (*FIRST[:2], stds_m.index(known.position_std_m), *FIRST[3:])
        self.with_clock: Index = (*self.first[:5], min(1, len(self._axes[5]) - 1))

    def likelihood(self, index: Index) -> Likelihood:
        """Return the likelihood in the setting at `index`."""
        slope, spacing, position_std_m, rho, has_shades, drift_std_m = (
            axis[k] for axis, k in zip(self._axes, index, strict=True)
        )
        setting = replace(
            self._known,
            background_std=slope * spacing,
            background_spacing_heights=spacing,
            position_std_m=position_std_m,
            drift_std_m=drift_std_m,
            rho=rho,
            has_shades=bool(has_shades),
        )
        return Likelihood(self._survey, setting, self._bases[index[1]])

    def around(self, first: Index, fit: Fit, floor: float) -> tuple[Weighed, ...]:
        """Return fits in all settings that add to the evidence, the best first.

        From the best setting so far, its neighbours are tried, until none is left whose evidence
        is near to that of the best, or until none is better where the best is below `floor`. `fit`
        is that in the setting `first`.
        """
        near = self._known.search.near_evidence
        likelihood = self.likelihood(first)
        found = {first: self._weighed(first, likelihood, fit)}
        left = {first}
        while left:
            index = max(left, key=lambda one: found[one].evidence)
            best = max(one.evidence for one in found.values())
            if found[index].evidence < (best if best < floor else best - near):
                break
            left.remove(index)
            is_empty = likelihood.source_count(fit.parameters) == 0
            for neighbour in self._neighbours(index, 2 if is_empty else len(self._axes)):
                is_new_wall = neighbour[4] > index[4]
                if neighbour in found or (is_new_wall and _is_without_wall(found, near)):
                    continue
                best = max(one.evidence for one in found.values())
                start = self._start(found, index, neighbour)
                moved = self._moved(start, neighbour, best - HOPELESS * near)
                if moved is not None:
                    found[neighbour] = moved
                    if moved.evidence > -math.inf:
                        left.add(neighbour)
        placed = (one for one in found.values() if one.evidence > -math.inf)
        return tuple(sorted(placed, key=lambda one: one.evidence, reverse=True))

    def without_one(
        self, fits: tuple[Weighed, ...], fewer: tuple[Weighed, ...]
    ) -> tuple[Weighed, ...]:
        """Return fits with a source fewer than `fits`: `fewer`, or better ones.

        A further source leads the others to places and walls that explain more, too: what these
        explain without it is no evidence for it.
        """
        best = _summed(fewer)
        if not fits or fits[0].evidence + self._known.search.log_odds_of_source < best:
            return fewer
        index, likelihood = fits[0].index, fits[0].likelihood
        parameters = fits[0].fit.parameters
        left = [
            self._weighed(index, likelihood, likelihood.fit(np.delete(parameters, rows)))
            for rows in likelihood.source_rows(len(parameters))
        ]
        better = max(left, key=lambda one: one.evidence)
        return fewer if better.evidence < best else self.around(index, better.fit, best)

    @staticmethod
    def _start(found: dict[Index, Weighed], index: Index, new: Index) -> Weighed:
        """Return the fit to begin at: that at `index`, or the best one with shades for another."""
        alike = [one for key, one in found.items() if key[4] == new[4]]
        if index[4] or not new[4] or not alike:
            return found[index]
        return max(alike, key=lambda one: one.evidence)

    def _neighbours(self, index: Index, axes: int) -> Iterator[Index]:
        """Yield settings one step away along the first `axes`; an even background has no bumps."""
        for axis, step in itertools.product(range(axes), (-1, 1)):
            moved = list(index)
            moved[axis] += step
            if not 0 <= moved[axis] < len(self._axes[axis]):
                continue
            if self._axes[0][moved[0]] == 0.0:
                moved[1] = FIRST[1]
            yield (moved[0], moved[1], moved[2], moved[3], moved[4], moved[5])

    def _moved(self, one: Weighed, index: Index, least: float) -> Weighed | None:
        """Return the fit at `index`, begun at that of a neighbour.

        None: its evidence is surely below `least`.
        """
        old, new = one.likelihood, self.likelihood(index)
        if new.setting.has_shades and not old.setting.has_shades:
            return self._weighed(index, new, with_shades(old, one.fit, new))
        sources = old.sources(one.fit.parameters)
        start = np.zeros(new.head_size + new.source_size * len(sources))
        same = min(old.source_size, new.source_size)
        new.sources(start)[:, :same] = sources[:, :same]
        is_alike = old.background_size == new.background_size
        kept = old.background_size if is_alike else HEAD_SIZE
        start[:kept] = one.fit.parameters[:kept]
        if self._evidence(new, new.hoped_for(start)) < least:
            return None
        return self._weighed(index, new, new.fit(start))

    def _weighed(self, index: Index, likelihood: Likelihood, fit: Fit) -> Weighed:
        """Return `fit` with its evidence, that of the setting included; -inf if not placed."""
        is_placed = _is_placed(likelihood, fit)
        evidence = self._evidence(likelihood, fit) if is_placed else -math.inf
        return Weighed(index=index, likelihood=likelihood, fit=fit, evidence=evidence)

    def _evidence(self, likelihood: Likelihood, fit: Fit) -> float:
        """Return the evidence of a fit, that of the setting included."""
        setting = likelihood.setting
        sizes = [len(axis) for axis in self._axes]
        equals = sizes[0] * (sizes[1] if setting.background_std > 0.0 else 1)
        if likelihood.source_count(fit.parameters):
            equals *= math.prod(sizes[2:])
        slope = setting.background_std / setting.background_spacing_heights
        rareness = 0.5 * (slope / setting.search.background_slope_std) ** 2
        return likelihood.evidence(fit) - math.log(equals) - rareness
