# SPDX-License-Identifier: Apache-2.0
"""How well sources are found: a table of targets and measured values.

    python benchmarks/localisation.py [--trials N] [--only NAME ...]

The surveys are simulated: 300 x 300 m, readings each 15 m at 32 m, one second each with 550 cps
per uSv/h, background 0.1 uSv/h, Cs-137. Truth and estimator share the tables of
attenuation, but where the table says otherwise. One core is used.
"""

import argparse
import os

# Threads of the linear algebra would only wait for each other on matrices this small.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rocsafe_radiation.detector import DETECTORS, measure, window_generator
from rocsafe_radiation.dose_map import grid_dose_rates_usvh
from rocsafe_radiation.field import dose_rate_usvps
from rocsafe_radiation.kernel import Kernel
from rocsafe_radiation.likelihood import Likelihood, Setting
from rocsafe_radiation.localization import (
    Localization,
    LocalizationOptions,
    SourceEstimate,
    localize,
)
from rocsafe_radiation.nuclide import nuclide
from rocsafe_radiation.photons import material
from rocsafe_radiation.survey import Survey
from rocsafe_radiation.transmission import air_transmission
from rocsafe_radiation.waypoint_choice import log_volume, next_waypoints

Array = NDArray[np.float64]
EXTENT_M, PITCH_M, HEIGHT_M = 300.0, 15.0, 32.0
SENSITIVITY, BACKGROUND_USVH = 550.0, 0.1
OPTIONS = LocalizationOptions(source_up_m=0.0, source_up_std_m=0.0)
# Roentgen cm^2/(h mCi) of one microgray m^2/(h GBq).
EXPOSURE = 0.037 * 1e4 / 8760.0
CAESIUM_USVH_PER_GBQ = nuclide('Cs-137').dose_constant_usvh()


@dataclass(frozen=True, slots=True, kw_only=True)
class World:
    """What the truth is like where it differs from the estimator's model."""

    kernel: Kernel = OPTIONS.kernel
    sensitivity: float = SENSITIVITY
    position_noise_m: float = 0.0
    gain_noise: float = 0.0
    background_variation: float = 0.0
    attenuation: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """A survey with its truth and what was made of it."""

    truth: Array
    found: Localization
    survey: Survey
    seconds: float

    def errors_m(self) -> list[float]:
        """Return for each true source the distance to the nearest one found."""
        if not self.found.sources:
            return []
        places = np.array([source.position_enu_m[:2] for source in self.found.sources])
        return [float(np.hypot(*(places - place[:2]).T).min()) for place in self.truth]


def flown(generator: np.random.Generator, world: World, sources: Array) -> Survey:
    """Return the readings of a survey of `sources`: east, north, dose rate at 1 m in uSv/h."""
    axis = np.arange(0.0, EXTENT_M + 0.1, PITCH_M)
    east, north = (part.ravel() for part in np.meshgrid(axis, axis))
    places = np.stack([east, north, np.full(east.size, HEIGHT_M)], axis=1)
    rates = BACKGROUND_USVH * np.exp(world.background_variation * uneven(generator, places))
    for x, y, strength in sources:
        squares = (east - x) ** 2 + (north - y) ** 2 + HEIGHT_M**2
        rates = rates + world.attenuation * strength * world.kernel.values(squares)
    gains = np.exp(generator.normal(0.0, world.gain_noise, east.size))
    counts = generator.poisson(world.sensitivity * rates * gains).astype(float)
    places[:, :2] += generator.normal(0.0, world.position_noise_m, (east.size, 2))
    exposures = np.full(east.size, world.sensitivity)
    return Survey(positions_enu_m=places, counts=counts, exposures=exposures)


def uneven(generator: np.random.Generator, places: Array) -> Array:
    """Return a smooth random field of unit variance, made of waves of 150 to 400 m."""
    waves = 12
    lengths = generator.uniform(150.0, 400.0, waves)
    angles, phases = generator.uniform(0.0, 2.0 * math.pi, (2, waves))
    turns = places[:, :1] * np.cos(angles) + places[:, 1:2] * np.sin(angles)
    field = np.cos(2.0 * math.pi * turns / lengths + phases).sum(axis=1)
    return np.asarray(field * math.sqrt(2.0 / waves))


def drawn(generator: np.random.Generator, count: int, low_gbq: float, high_gbq: float) -> Array:
    """Return sources at random, at least 30 m apart and 30 m inside, log-uniform in activity."""
    places: list[Array] = []
    while len(places) < count:
        place = generator.uniform(30.0, EXTENT_M - 30.0, 2)
        if all(np.hypot(*(place - other)) >= 30.0 for other in places):
            places.append(place)
    logs = generator.uniform(math.log(low_gbq), math.log(high_gbq), count)
    strengths = np.exp(logs) * CAESIUM_USVH_PER_GBQ
    return np.column_stack([np.array(places).reshape(count, 2), strengths])


def trials(
    seed: int, count: int, order: int, world: World, low_gbq: float = 1.0, high_gbq: float = 100.0
) -> Iterator[Trial]:
    """Yield `count` surveys of `order` sources, localised."""
    for index in range(count):
        generator = np.random.default_rng([seed, order, index])
        truth = drawn(generator, order, low_gbq, high_gbq)
        survey = flown(generator, world, truth)
        begin = time.process_time()
        found = localize(survey, OPTIONS)
        yield Trial(truth=truth, found=found, survey=survey, seconds=time.process_time() - begin)


def bound_m2(trial: Trial) -> Array:
    """Return the Cramer-Rao bound of the place of the only true source, shape (2, 2)."""
    likelihood = Likelihood(trial.survey, Setting(), np.empty((trial.survey.size, 0)))
    x, y, strength = trial.truth[0]
    truth = np.array([math.log(BACKGROUND_USVH), 0.0, x, y, 0.0, math.log(strength)])
    information, _ = likelihood.information_and_gradient(truth)
    return np.asarray(np.linalg.inv(information)[2:4, 2:4])


Row = tuple[str, str, str]


def physics(_: int) -> Iterator[Row]:
    """Target 1."""
    distances: Array = np.asarray(np.geomspace(0.1, 1e4, 1000), np.float64)
    exact = 2.57 / distances**2
    worst = np.abs(dose_rate_usvps(2.57, distances, 0.1) / exact - 1.0).max()
    yield 'paper: largest relative error', '<= 1e-12', f'{worst:.1e}'
    distances = np.asarray(np.geomspace(10.0, 1000.0, 60), np.float64)
    air, worst = material('air'), 0.0
    for name in ('Am-241', 'Co-57', 'Cs-137', 'Co-60', 'I-131', 'Ir-192'):
        kind = nuclide(name)
        total = np.zeros_like(distances)
        for energy, share in zip(kind.energies_kev, kind.dose_shares(), strict=True):
            depth = float(air.attenuation_per_m(energy)) * distances
            total += share * np.exp(-depth) * air.buildup(float(energy), depth)
        worst = max(worst, float(np.abs(air_transmission(name, distances) / total - 1.0).max()))
    yield 'air: table against exp x build-up', '<= 2 %', f'{worst:.2%}'
    published = {'Cs-137': 3.43 * 0.944, 'Co-60': 12.9, 'Ir-192': 4.60, 'I-131': 2.20}
    ratios = [
        nuclide(name).kerma_constants_ugy(15.0).sum() * EXPOSURE / value
        for name, value in published.items()
    ]
    yield (
        'dose constants against Smith and Stabin',
        '<= 2 %',
        f'{max(abs(r - 1) for r in ratios):.2%}',
    )


def counting(_: int) -> Iterator[Row]:
    """Target 2."""
    generator = np.random.default_rng(1)
    kind = DETECTORS['gm_sbm20']
    counts = np.array([measure(kind, 8.0, 1.0, generator).counts for _ in range(100_000)])
    rate = 8.0 * kind.sensitivity_cps_per_usvh + kind.dark_rate_cps
    mean = rate / (1.0 + rate * kind.dead_time_s)
    yield 'Poisson: p of chi-square, 1e5 draws', '> 0.01', f'{_poisson_p(counts, mean):.2f}'
    rate = 0.3 / 0.7 / kind.dead_time_s
    dose = (rate - kind.dark_rate_cps) / kind.sensitivity_cps_per_usvh
    reading = measure(kind, dose, 1000.0, window_generator(1, 'rav1', 1))
    error = abs(reading.counts / 1000.0 * kind.dead_time_s / 0.3 - 1.0)
    yield 'dead time at a load of 0.3', '<= 1 %', f'{error:.2%}'


def _poisson_p(counts: Array, mean: float) -> float:
    """Return the probability of a larger chi-square, by Wilson and Hilferty."""
    low, high = int(mean - 3.0 * math.sqrt(mean)), int(mean + 3.0 * math.sqrt(mean))
    inner = np.array(
        [math.exp(k * math.log(mean) - mean - math.lgamma(k + 1)) for k in range(low, high + 1)]
    )
    expected = np.append(inner, 1.0 - inner.sum()) * len(counts)
    seen = [np.count_nonzero(counts == k) for k in range(low, high + 1)]
    observed = np.array([*seen, len(counts) - sum(seen)])
    chi2, dof = float(((observed - expected) ** 2 / expected).sum()), len(expected) - 1
    spread = 2.0 / (9.0 * dof)
    score = ((chi2 / dof) ** (1.0 / 3.0) - 1.0 + spread) / math.sqrt(spread)
    return 0.5 * math.erfc(score / math.sqrt(2.0))


def single(count: int) -> Iterator[Row]:
    """Target 3."""
    for low, high in ((3.0, 10.0), (10.0, 100.0)):
        ratios, inside, strengths, seconds, detected = [], 0, [], [], 0
        for trial in trials(3, count, 1, World(), low, high):
            if len(trial.found.sources) != 1:
                continue
            detected += 1
            source = trial.found.sources[0]
            miss = source.position_enu_m[:2] - trial.truth[0, :2]
            ratios.append(float(miss @ miss / np.trace(bound_m2(trial))))
            inside += bool(miss @ np.linalg.solve(source.covariance_m2[:2, :2], miss) < 5.991)
            strengths.append(
                (math.log(source.dose_rate_at_1m_usvh / trial.truth[0, 2]) / source.log_std) ** 2
            )
            seconds.append(trial.seconds)
        name = f'one source {low:g}-{high:g} GBq, {count} trials'
        yield f'{name}: found', '', f'{detected / count:.3f}'
        yield f'{name}: RMSE / bound', '<= 1.10', f'{math.sqrt(np.mean(ratios)):.3f}'
        yield f'{name}: in 95 % ellipse', '0.92-0.98', f'{inside / detected:.3f}'
        yield f'{name}: strength RMSE / bound', '<= 1.15', f'{math.sqrt(np.mean(strengths)):.3f}'
        yield f'{name}: seconds, median', '<= 0.3', f'{np.median(seconds):.2f}'


def several(count: int) -> Iterator[Row]:
    """Target 4."""
    for order in (1, 2, 3):
        yield from _order_rows(f'K = {order}', trials(4, count, order, World()), order)
    world = World(position_noise_m=3.0)
    yield from _noise_rows('position noise 3 m', trials(5, count, 1, world))


def _order_rows(name: str, results: Iterator[Trial], order: int) -> Iterator[Row]:
    results_list = list(results)
    right = [trial for trial in results_list if len(trial.found.sources) == order]
    errors = [error for trial in right for error in trial.errors_m()]
    name = f'{name}, {len(results_list)} trials'
    yield f'{name}: order right', '>= 0.95', f'{len(right) / len(results_list):.3f}'
    yield f'{name}: median error, m', '<= 1', f'{np.median(errors):.2f}'
    yield f'{name}: p95 error, m', '<= 6', f'{np.quantile(errors, 0.95):.2f}'
    times = [trial.seconds for trial in results_list]
    yield f'{name}: seconds, p95', '<= 2', f'{np.quantile(times, 0.95):.2f}'


def _noise_rows(name: str, results: Iterator[Trial]) -> Iterator[Row]:
    results_list = list(results)
    inside, spurious, squares, found = 0, 0, [], 0
    for trial in results_list:
        spurious += len(trial.found.sources) > 1
        if not trial.found.sources:
            continue
        found += 1
        source = min(
            trial.found.sources,
            key=lambda one: float(np.hypot(*(one.position_enu_m[:2] - trial.truth[0, :2]))),
        )
        miss = source.position_enu_m[:2] - trial.truth[0, :2]
        inside += bool(miss @ np.linalg.solve(source.covariance_m2[:2, :2], miss) < 5.991)
        squares.append(float(miss @ miss))
    total = len(results_list)
    yield f'{name}, {total} trials: in 95 % ellipse', '>= 0.90', f'{inside / max(found, 1):.3f}'
    yield f'{name}: runs with spurious sources', '<= 0.02', f'{spurious / total:.3f}'
    yield f'{name}: RMSE, m', '<= 2', f'{math.sqrt(np.mean(squares)):.2f}'


def mismatched(count: int) -> Iterator[Row]:
    """Target 5."""
    worlds = {
        'truth without attenuation': World(kernel=Kernel(is_lossy=False)),
        'truth shielded to a half': World(attenuation=0.5),
        'truth of iridium': World(kernel=replace(OPTIONS.kernel, nuclide='Ir-192')),
        'gain noise 10 %': World(gain_noise=0.1),
        'background uneven by 20 %': World(background_variation=0.2),
    }
    for name, world in worlds.items():
        yield from _noise_rows(name, trials(6, count, 1, world))
    for name, world in (
        ('no source, even background', World()),
        ('no source, background uneven by 20 %', World(background_variation=0.2)),
    ):
        found = [len(trial.found.sources) for trial in trials(7, count, 0, world)]
        clean = sum(order == 0 for order in found) / count
        yield f'{name}, {count} trials: none found', '>= 0.98', f'{clean:.3f}'


def adaptive(count: int) -> Iterator[Row]:
    """Target 6: readings until the ellipse is as small as after the lawn-mower's 441."""
    used: list[int] = []
    missed = 0
    axis = np.arange(0.0, EXTENT_M + 0.1, 50.0)
    east, north = (part.ravel() for part in np.meshgrid(axis, axis))
    coarse = np.stack([east, north, np.full(east.size, HEIGHT_M)], axis=1)
    for trial in trials(8, min(count, 30), 1, World(), 3.0, 30.0):
        generator = np.random.default_rng([9, len(used)])
        places, goal = coarse, log_volume(trial.found)
        counts = generator.poisson(SENSITIVITY * _rates(trial.truth, places)).astype(float)
        while len(places) < trial.survey.size:
            exposures = np.full(len(counts), SENSITIVITY)
            survey = Survey(positions_enu_m=places, counts=counts, exposures=exposures)
            found = localize(survey, OPTIONS)
            if found.sources and log_volume(found) <= goal:
                break
            grid = trial.survey.positions_enu_m
            chosen = next_waypoints(found, grid, SENSITIVITY, OPTIONS.kernel, 8)
            more = np.array([one.position_enu_m for one in chosen]) if chosen else grid[:8]
            new = generator.poisson(SENSITIVITY * _rates(trial.truth, more)).astype(float)
            places, counts = np.vstack([places, more]), np.append(counts, new)
        used.append(len(places))
        missed += len(places) >= trial.survey.size
    share = 1.0 - float(np.mean(used)) / 441.0
    yield f'adaptive: fewer readings, {len(used)} trials', '>= 0.30', f'{share:.2f}'
    yield 'adaptive: trials that never got there', '', f'{missed / len(used):.2f}'


def _rates(truth: Array, places: Array) -> Array:
    """Return the dose rate at each of `places`, uSv/h."""
    rates = np.full(len(places), BACKGROUND_USVH)
    for x, y, strength in truth:
        squares = ((places - [x, y, 0.0]) ** 2).sum(axis=1)
        rates = rates + strength * OPTIONS.kernel.values(squares)
    return rates


def speed(_: int) -> Iterator[Row]:
    """Target 7."""
    axis = np.asarray(np.linspace(0.0, 600.0, 600), np.float64)
    sources = [
        SourceEstimate(
            position_enu_m=np.array([place, 600.0 - place, 0.0]),
            dose_rate_at_1m_usvh=1000.0,
            joint_covariance=np.zeros((4, 4)),
            detection_llr=0.0,
        )
        for place in (50.0, 150.0, 300.0, 420.0, 580.0)
    ]
    times = []
    for _ in range(7):
        begin = time.process_time()
        grid_dose_rates_usvh(sources, BACKGROUND_USVH, OPTIONS.kernel, axis, axis)
        times.append(time.process_time() - begin)
    yield 'field of 600 x 600 points, 5 sources, ms', '<= 50', f'{1e3 * min(times):.0f}'


PARTS: dict[str, Callable[[int], Iterator[Row]]] = {
    'physics': physics,
    'counting': counting,
    'single': single,
    'several': several,
    'mismatched': mismatched,
    'adaptive': adaptive,
    'speed': speed,
}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description='Measure the localiser against its targets.')
    parser.add_argument('--trials', type=int, default=200, metavar='N', help='surveys a row')
    parser.add_argument('--only', nargs='+', choices=list(PARTS), default=list(PARTS))
    arguments = parser.parse_args()
    print(f'{"what":58} {"target":>10} {"measured":>10}')
    for part in arguments.only:
        for what, target, measured in PARTS[part](arguments.trials):
            print(f'{what:58} {target:>10} {measured:>10}', flush=True)


if __name__ == '__main__':
    main()
