# SPDX-License-Identifier: Apache-2.0
"""Estimation of releases of gas: number, places, rates, and regions that hold the places."""

import math
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from scipy.special import logsumexp

from rocsafe_dispersion.estimation.amount import Amount
from rocsafe_dispersion.estimation.background_filter import BackgroundFilter
from rocsafe_dispersion.estimation.fluctuating_plume import LEAST_SPEED_MPS, PlumeReadings
from rocsafe_dispersion.estimation.found_release import (
    FoundRelease,
    ReleaseSamples,
    found_release,
)
from rocsafe_dispersion.estimation.gas_survey import GasSurvey
from rocsafe_dispersion.estimation.hidden import HiddenReleases, hidden_releases
from rocsafe_dispersion.estimation.placeless import gain_of_places
from rocsafe_dispersion.estimation.release_options import LocateOptions, SearchArea
from rocsafe_dispersion.estimation.release_sampler import (
    KIND,
    Bounds,
    Kind,
    Population,
    ReleaseSampler,
)
from rocsafe_dispersion.plume.losses import NO_LOSSES, Losses
from rocsafe_dispersion.plume.spread import Travel, similarity_travel, vertical_shape
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.wind.similarity import SurfaceLayer

# Rates before readings: even in their logarithm over four decades, from the one whose mean plume
# is three times the noise where it is strongest at the height of the readings.
_DECADES, _LEAST_NOISES, _LEAST_PEAK_S_M3 = 1e4, 3.0, 1e-9
_LABEL_ROUNDS = 5
_SEED = 1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LocatedReleases:
    """What was found.

    Attributes
    ----------
    releases
        Releases, the strongest first; none: nothing but background.
    number_probabilities
        Probability of 0, 1, 2, ... releases, equally probable before.
    gains
        Logarithm of the odds of any release against none, less `LocateOptions.least_gain`; then
        of 2, 3, ... releases against one fewer, less `LocateOptions.least_gain_more`. The number
        told is that before the first which is not above 0.
    gain_of_places
        Logarithm of the odds of what is told against readings that have nothing to do with the
        places where they were taken.
    background_g_m3
        Backgrounds of the instruments at their last readings.
    turn_rad
        Mean angle by which the true wind is turned from the one told, as in `Shapes`.
    wrong_wind
        Probability that the direction of the wind told is wrong altogether.
    spread_y, spread_z
        Medians of `Shapes`.
    hidden
        Where a release may still be that was not found, beside those that were.
    amount
        What is released: grams, or particles.
    """

    releases: tuple[FoundRelease, ...]
    number_probabilities: tuple[float, ...]
    gains: tuple[float, ...]
    gain_of_places: float
    background_g_m3: FloatArray
    turn_rad: float
    wrong_wind: float
    spread_y: float
    spread_z: float
    hidden: HiddenReleases
    amount: Amount


def locate_releases(
    survey: GasSurvey,
    area: SearchArea,
    layer: SurfaceLayer,
    *,
    sigma_theta_rad: float | None = None,
    anemometer_m: float = 10.0,
    losses: Losses = NO_LOSSES,
    options: LocateOptions | None = None,
) -> LocatedReleases:
    r"""Return the releases that readings tell of; the same readings give the same answer.

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
    losses
        What takes it out of the air on its way.
    options
        How.

    Raises
    ------
    ValueError
        If there is no wind, or a value is out of range.

    Examples
    --------
    Readings of a grid 3 m above the ground, simulated for 5 g/s at 20 m west and 5 m north of the
    origin, in a wind from the west:

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from rocsafe_dispersion.estimation.gas_csv import read_gas
    >>> from rocsafe_geo.wind.stability import layer_of_class
    >>> head = 'east_m,north_m,height_m,value_g_m3,std_g_m3,wind_speed_mps,wind_from_deg\n'
    >>> milligrams = {0: [0, 0, 38, 0, 0], 20: [0, 1.6, 23, 2.1, 0], 40: [0.1, 7.7, 8, 4.9, 0.1]}
    >>> rows = [
    ...     f'{east},{north},3,{value / 1000},0.00015,4,270\n'
    ...     for east, values in milligrams.items()
    ...     for north, value in zip(range(-15, 35, 10), values)
    ... ]
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, 'readings.csv')
    ...     _ = path.write_text(head + ''.join(rows))
    ...     survey = read_gas(path).survey
    >>> area = SearchArea(west_m=-60.0, south_m=-40.0, east_m=40.0, north_m=50.0)
    >>> layer = layer_of_class('D', 4.0, 10.0, 0.03)
    >>> options = LocateOptions(most_releases=1)
    >>> found = locate_releases(survey, area, layer, options=options)
    >>> (release,) = found.releases
    >>> release.holds(-20.0, 5.0)
    True
    >>> bool(release.rate_low_g_s < 5.0 < release.rate_high_g_s)
    True
    """
    options = options or LocateOptions()
    speed = usual_speed_mps(survey)
    travel = similarity_travel(
        layer, area.height_m, sigma_theta_rad=sigma_theta_rad, losses=losses
    )
    reference = float(layer.speed_mps(anemometer_m))
    bounds = Bounds(
        edges_m=(area.west_m, area.south_m, area.east_m, area.north_m),
        rates_g_s=_rates(survey, area, travel, reference / speed),
        times_s=(
            (float(survey.times_s.min()), float(survey.times_s.max()))
            if survey.has_times
            else None
        ),
    )
    sampler = ReleaseSampler(
        PlumeReadings(survey, area.height_m, travel, reference),
        BackgroundFilter(survey),
        bounds,
        options,
        np.random.default_rng(_SEED),
    )
    made = [sampler.sample(number) for number in range(options.most_releases + 1)]
    # The number told is that of hypotheses of all kinds. Where none is told, one was tried so.
    number, tried = min(1, options.most_releases), {0}
    while number not in tried:
        tried.add(number)
        made[number] = _of_all_kinds(sampler, made[number], number)
        number = _number(_evidence(made), options)
    return _located(sampler, made[number][0], survey, area, _evidence(made), options)


def _of_all_kinds(
    sampler: ReleaseSampler, told: tuple[Population, float], number: int
) -> tuple[Population, float]:
    """Return hypotheses of all kinds by their evidence, and the logarithm of all."""
    kinds = sampler.kinds(number)
    made = [told, *(sampler.sample(number, kind) for kind in kinds)]
    logs = np.log([1.0 - sum(kinds.values()), *kinds.values()]) + _evidence(made)
    shares = np.exp(logs - logsumexp(logs))
    return Population.mixed([each for each, _ in made], shares), float(logsumexp(logs))


def _evidence(made: list[tuple[Population, float]]) -> FloatArray:
    return np.array([evidence for _, evidence in made])


def _number(evidence: FloatArray, options: LocateOptions) -> int:
    """Return the number of releases told."""
    gains = _gains(evidence, options)
    return next((index for index, gain in enumerate(gains) if gain <= 0.0), len(gains))


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


def _rates(
    survey: GasSurvey, area: SearchArea, travel: Travel, factor: float
) -> tuple[float, float]:
    """Return the smallest and the largest rate before readings, g/s."""
    width = max(area.east_m - area.west_m, area.north_m - area.south_m)
    near = travel.distances_m <= width
    height = np.full(int(near.sum()), float(np.median(survey.places_m[:, :, 2])))
    upwards = vertical_shape(height, travel.heights_m()[near], travel.sigma_z_m[near])
    flow = (travel.airborne / travel.speeds_mps / travel.sigma_y_m)[near]
    peak = factor * float((flow * upwards).max()) / math.sqrt(2.0 * math.pi)
    least = _LEAST_NOISES * float(np.median(survey.std_g_m3)) / max(peak, _LEAST_PEAK_S_M3)
    return least, _DECADES * least


def _gains(evidence: FloatArray, options: LocateOptions) -> tuple[float, ...]:
    """Return the gains of `LocatedReleases`."""
    if len(evidence) == 1:
        return ()
    any_one = logsumexp(evidence[1:]) - np.log(len(evidence) - 1) - evidence[0]
    more = np.diff(evidence)[1:] - options.least_gain_more
    return (float(any_one) - options.least_gain, *more.tolist())


def _located(
    sampler: ReleaseSampler,
    found: Population,
    survey: GasSurvey,
    area: SearchArea,
    evidence: FloatArray,
    options: LocateOptions,
) -> LocatedReleases:
    own, shapes = _labelled(found.own), sampler.shapes_of(found.shared)
    releases = [
        found_release(
            ReleaseSamples(
                places_m=sampler.places_of(own[:, number]),
                rates_g_s=sampler.rates_of(own[:, number]),
                shapes=shapes,
                spans_s=sampler.spans_of(found.shared),
                velocities_mps=_velocities_mps(sampler, own[:, number], found.shared, survey),
            ),
            area,
        )
        for number in range(own.shape[1])
    ]
    backgrounds = np.median(found.backgrounds, axis=0)
    smallest = options.smallest_g_s
    if survey.amount.is_particles:
        smallest = options.smallest_per_s
    return LocatedReleases(
        releases=tuple(sorted(releases, key=lambda one: -one.rate_g_s)),
        number_probabilities=tuple(np.exp(evidence - logsumexp(evidence)).tolist()),
        gains=_gains(evidence, options),
        gain_of_places=gain_of_places(survey, backgrounds, sampler.reading_logs(found)),
        background_g_m3=backgrounds,
        turn_rad=shapes.mean_turn_rad,
        wrong_wind=float((found.shared[:, KIND] == Kind.WRONG_WIND).mean()),
        spread_y=float(np.median(shapes.spread_y)),
        spread_z=float(np.median(shapes.spread_z)),
        hidden=hidden_releases(sampler, found, area.cells_m(), smallest),
        amount=survey.amount,
    )


def _velocities_mps(
    sampler: ReleaseSampler, own: FloatArray, shared: FloatArray, survey: GasSurvey
) -> FloatArray | None:
    """Return velocities of one release of each hypothesis, (p, 2); None: all stand."""
    ways_m = sampler.ways_of(own, shared)
    return None if ways_m is None else ways_m / max(float(np.ptp(survey.times_s)), 1e-9)


def _labelled(own: FloatArray) -> FloatArray:
    """Return releases (p, k, coordinates), those of each hypothesis in a common order.

    The order of each hypothesis is the one nearest to the medians of all (Stephens 2000).
    """
    orders = [list(order) for order in permutations(range(own.shape[1]))]
    for _ in range(_LABEL_ROUNDS if len(orders) > 1 else 0):
        middle = np.median(own[:, :, :2], axis=0)
        costs = [((own[:, order, :2] - middle) ** 2).sum(axis=(1, 2)) for order in orders]
        best = np.array(orders)[np.argmin(costs, axis=0)]
        own = np.take_along_axis(own, best[:, :, None], axis=1)
    return own
