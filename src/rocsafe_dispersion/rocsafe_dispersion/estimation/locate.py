# SPDX-License-Identifier: Apache-2.0
"""Estimation of releases of gas: number, places, rates, and regions that hold the places."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from rocsafe_dispersion.estimation.evidence import (
    RATE_PRIOR_SHARE,
    independent_share,
    log_evidence,
    plume_share,
)
from rocsafe_dispersion.estimation.found_release import FoundRelease, drawn, found_release
from rocsafe_dispersion.estimation.gas_survey import GasSurvey
from rocsafe_dispersion.estimation.hidden import HIDDEN_MULTIPLES, HiddenReleases
from rocsafe_dispersion.estimation.plume_kernel import (
    LEAST_SPEED_MPS,
    PlumeShape,
)
from rocsafe_dispersion.estimation.rate_fit import (
    AS_FITTED,
    MULTIPLE_WEIGHTS,
    MULTIPLES,
    RateFits,
    fit_rates,
    log_likelihoods,
)
from rocsafe_dispersion.estimation.release_options import LocateOptions, SearchArea
from rocsafe_dispersion.estimation.shape_cases import CaseMaker, ShapeCase
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.wind.similarity import SurfaceLayer

_EXCHANGES = 4
# Shapes of which less is believed than this share of the most probable one tell nothing more.
_LEAST_PRIOR = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LocatedReleases:
    """What was found.

    Attributes
    ----------
    releases
        Releases, the strongest first; none: nothing but background.
    gains
        For 1, 2, ... releases: logarithm of the odds of one release more against none more,
        less `LocateOptions.least_gain`; above 0 it was accepted.
    background_g_m3
        Backgrounds of the instruments.
    shape
        The most probable shape of the plume.
    scatter
        The most probable scatter.
    hidden
        Where a release may still be that was not found, beside those that were.
    """

    releases: tuple[FoundRelease, ...]
    gains: tuple[float, ...]
    background_g_m3: FloatArray
    shape: PlumeShape
    scatter: float
    hidden: HiddenReleases


class _Fits:
    """Fits of all places for one release beside others, each made once."""

    def __init__(self, survey: GasSurvey, options: LocateOptions) -> None:
        self._survey, self._options = survey, options
        self._made: dict[tuple[ShapeCase, tuple[int, ...]], RateFits] = {}

    def of(self, case: ShapeCase, fixed: Sequence[int]) -> RateFits:
        """Return the fits of all places for one release beside `fixed` ones, which come first."""
        key = (case, tuple(fixed))
        if key not in self._made:
            units = beside(case, fixed)
            self._made[key] = fit_rates(self._survey, units, case.scatter, self._options)
        return self._made[key]

    def log_weights(self, case: ShapeCase, fixed: Sequence[int]) -> FloatArray:
        """Return the logarithms of the posterior of all places, up to a constant, (m,)."""
        return self.of(case, fixed).averaged(self._options.information_share) + case.log_prior


def beside(case: ShapeCase, fixed: Sequence[int]) -> FloatArray:
    """Return the readings for 1 g/s at `fixed` places and at any other, the last one."""
    size = (*case.units.shape, len(fixed))
    others = np.broadcast_to(case.units[:, :, None, list(fixed)], size)
    return np.concatenate([others, case.units[..., None]], axis=3)


def locate_releases(
    survey: GasSurvey,
    area: SearchArea,
    layer: SurfaceLayer,
    *,
    sigma_theta_rad: float | None = None,
    anemometer_m: float = 10.0,
    options: LocateOptions | None = None,
) -> LocatedReleases:
    """Return the releases that readings tell of.

    Parameters
    ----------
    survey
        Readings with the wind.
    area
        Where releases may be.
    layer
        The air; its wind at `anemometer_m` is that of the survey up to a factor.
    sigma_theta_rad
        Standard deviation of the wind direction, radians; None: from the layer.
    anemometer_m
        Height of the wind of the survey above the ground, metres.
    options
        How.

    Raises
    ------
    ValueError
        If there is no wind, or a value is out of range.
    """
    options = options or LocateOptions()
    usual_speed_mps(survey)
    places = _places(area)
    travel = similarity_travel(layer, area.height_m, sigma_theta_rad=sigma_theta_rad)
    reference = float(layer.speed_mps(anemometer_m))
    maker = CaseMaker(survey, places, area.height_m, travel, reference, options)
    fits = _Fits(survey, options)
    cases = maker.cases(lambda case: float(logsumexp(fits.log_weights(case, ()))))
    gains: list[float] = []
    chosen: list[int] = []
    case = cases[0]
    background = _at(survey, case, chosen, options).backgrounds_g_m3[0]
    # Without a release only the noise is left; beside one, its eddies are.
    share = independent_share(survey, background, options.information_share)
    for _ in range(options.most_releases):
        before = _evidence_of(survey, cases, chosen, share, options)
        found, own, evidence = _one_more(fits, cases, chosen, share)
        gains.append(evidence + math.log(RATE_PRIOR_SHARE) - before - options.least_gain)
        if gains[-1] <= 0.0:
            break
        chosen, case, share = found, own, options.information_share
        background = _at(survey, case, chosen, options).backgrounds_g_m3[0]
    within = plume_share(survey, options, len(chosen))
    of_places = replace(options, information_share=within)
    releases = _regions(fits, cases, case, chosen, places, area, of_places)
    return LocatedReleases(
        releases=tuple(sorted(releases, key=lambda one: -one.rate_g_s)),
        gains=tuple(gains),
        background_g_m3=background,
        shape=case.shape,
        scatter=case.scatter,
        hidden=_hidden(survey, cases, chosen, places, options),
    )


def usual_speed_mps(survey: GasSurvey) -> float:
    """Return the median speed of the wind, m/s.

    Raises
    ------
    ValueError
        If it is too weak to carry a plume anywhere.
    """
    found = float(np.median(survey.speeds_mps))
    if found < LEAST_SPEED_MPS:
        raise ValueError(
            f'the wind is below {LEAST_SPEED_MPS:g} m/s in most readings: must be above; '
            'without a wind no plume tells where it comes from'
        )
    return found


def _places(area: SearchArea) -> FloatArray:
    """Return the middles of all cells, (m, 2)."""
    east = np.arange(area.west_m + area.cell_m / 2.0, area.east_m, area.cell_m)
    north = np.arange(area.south_m + area.cell_m / 2.0, area.north_m, area.cell_m)
    return np.stack(np.meshgrid(east, north), axis=-1).reshape(-1, 2)


def _at(survey: GasSurvey, case: ShapeCase, chosen: list[int], options: LocateOptions) -> RateFits:
    """Return the fit for releases at chosen places."""
    return fit_rates(survey, case.units[:, :, None, chosen], case.scatter, options)


def _evidence_of(
    survey: GasSurvey,
    cases: list[ShapeCase],
    chosen: list[int],
    share: float,
    options: LocateOptions,
) -> float:
    """Return the logarithm of the evidence of releases at chosen places."""
    fits = [_at(survey, case, chosen, options) for case in cases]
    return log_evidence(fits, [case.log_prior for case in cases], share)


def _one_more(
    fits: _Fits,
    cases: list[ShapeCase],
    chosen: list[int],
    share: float,
) -> tuple[list[int], ShapeCase, float]:
    """Return the best places with one release more, their case, and the evidence of one more.

    The new one is tried everywhere beside the others; then each in turn is tried everywhere
    again until none moves. `share` of the information counts for the evidence.
    """
    likely = np.array([fits.log_weights(case, chosen) for case in cases])
    best, index = np.unravel_index(int(likely.argmax()), likely.shape)
    found, case = [*chosen, int(index)], cases[int(best)]
    for _ in range(_EXCHANGES if len(found) > 1 else 0):
        before = list(found)
        for number in range(len(found)):
            others = found[:number] + found[number + 1 :]
            place = int(fits.log_weights(case, others).argmax())
            found = [*found[:number], place, *found[number + 1 :]]
        if found == before:
            break
    made = [fits.of(case, chosen) for case in cases]
    return found, case, log_evidence(made, [case.log_prior for case in cases], share)


def _regions(
    fits: _Fits,
    cases: list[ShapeCase],
    best: ShapeCase,
    chosen: list[int],
    places: FloatArray,
    area: SearchArea,
    options: LocateOptions,
) -> list[FoundRelease]:
    """Return the releases with their regions, each given the places of the others."""
    found = []
    for number in range(len(chosen)):
        others = chosen[:number] + chosen[number + 1 :]
        # Beside others only the best case is looked at: they were placed in it.
        own = cases if not others else [case for case in cases if case.shape == best.shape]
        made = [fits.of(case, others) for case in own]
        logs = np.array(
            [
                options.information_share * fit.log_likelihoods + case.log_prior
                for fit, case in zip(made, own, strict=True)
            ]
        )
        rates = np.array([fit.rates_g_s[:, -1:] * MULTIPLES for fit in made])
        weights = np.exp(logs - logs.max()) * MULTIPLE_WEIGHTS
        shapes = [case.shape for case in own]
        found.append(found_release(weights, rates, places, shapes, area.cell_m))
    return found


def _hidden(
    survey: GasSurvey,
    cases: list[ShapeCase],
    chosen: list[int],
    places: FloatArray,
    options: LocateOptions,
) -> HiddenReleases:
    """Return what the readings say of a release more that they may have missed."""
    share = options.information_share
    base = [_at(survey, case, chosen, options) for case in cases]
    likely = np.array([fit.log_likelihoods[0, AS_FITTED] for fit in base])
    priors = share * likely + [case.log_prior for case in cases]
    priors = np.exp(priors - logsumexp(priors))
    own = np.flatnonzero(priors > _LEAST_PRIOR * priors.max()).tolist()
    weights = np.array(
        [priors[i] * _hidden_ratios(survey, cases[i], chosen, base[i], options) for i in own]
    )
    amounts = np.broadcast_to(options.smallest_g_s * HIDDEN_MULTIPLES, weights.shape)
    return HiddenReleases(
        smallest_g_s=options.smallest_g_s,
        places_m=places,
        ratios=weights[:, :, 0].sum(axis=0) / priors[own].sum(),
        samples=drawn(weights, amounts, places, [cases[i].shape for i in own]),
    )


def _hidden_ratios(
    survey: GasSurvey, case: ShapeCase, chosen: list[int], base: RateFits, options: LocateOptions
) -> FloatArray:
    """Return the likelihoods of a release more over that of none, (places, multiples)."""
    # Rates and background are those without it: a hidden one adds little to them.
    units = beside(case, chosen)
    count = units.shape[2]
    rates = np.full((count, len(chosen) + 1), options.smallest_g_s)
    rates[:, :-1] = base.rates_g_s
    background = base.backgrounds_g_m3[0][survey.instruments]
    background = np.broadcast_to(background[:, None], (len(background), count))
    logs = log_likelihoods(
        survey, units, rates, background, case.scatter, options, HIDDEN_MULTIPLES
    )
    gained = options.information_share * (logs - base.log_likelihoods[0, AS_FITTED])
    return np.exp(np.minimum(gained, 50.0))
