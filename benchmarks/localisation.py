# SPDX-License-Identifier: Apache-2.0
"""How well sources are found: a table of targets and measured values.

    python benchmarks/localisation.py [--trials N] [--only NAME ...]

The surveys are simulated: 300 x 300 m, readings each 15 m at 32 m, one second each with 550 cps
per uSv/h, background 0.1 uSv/h, Cs-137. Truth and estimator share the tables of
attenuation, but where the table says otherwise. One core is used.
"""

import os

# Threads of the linear algebra would only wait for each other on matrices this small.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from radiation_surveys import (
    BACKGROUND_USVH,
    CAESIUM_USVH_PER_GBQ,
    EXTENT_M,
    HEIGHT_M,
    OPTIONS,
    PITCH_M,
    SENSITIVITY,
    Row,
    Trial,
    World,
    bound_m2,
    drawn,
    errors_at_bound_m,
    flown,
    print_table,
    trials,
)

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.decision.sequential_decision import sequential_evidence
from rocsafe_radiation.decision.stopping import ABSENT, CONTINUE, PRESENT, StoppingRule
from rocsafe_radiation.decision.waypoint_choice import log_volume, next_waypoints
from rocsafe_radiation.detection.detector import DETECTORS, measure, window_generator
from rocsafe_radiation.localization.estimates import SourceEstimate
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.localize import localize
from rocsafe_radiation.physics.field import dose_rate_usvps
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.physics.nuclide import nuclide
from rocsafe_radiation.physics.photons import material
from rocsafe_radiation.physics.shielding import Box
from rocsafe_radiation.physics.transmission import air_transmission
from rocsafe_radiation.products.dose_map import grid_dose_rates_usvh
from rocsafe_radiation.readings.survey import RadiationSurvey

# Roentgen cm^2/(h mCi) of one microgray m^2/(h GBq).
EXPOSURE = 0.037 * 1e4 / 8760.0
LINES_A_LOOK = 3
# The smallest source that matters, and one three times as strong.
SMALLEST_GBQ = 1.0


def physics(_: int) -> Iterator[Row]:
    """Target 1."""
    distances: FloatArray = np.asarray(np.geomspace(0.1, 1e4, 1000), np.float64)
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


def _poisson_p(counts: FloatArray, mean: float) -> float:
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
            ratios.append(float(miss @ miss / np.trace(bound_m2(trial)[0])))
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
    least = np.quantile(errors_at_bound_m(results_list), (0.5, 0.95))
    yield f'{name}: the same at the Cramer-Rao bound', '', f'{least[0]:.2f}; {least[1]:.2f}'
    times = [trial.seconds for trial in results_list]
    yield f'{name}: seconds, p95', '<= 2', f'{np.quantile(times, 0.95):.2f}'


def _noise_rows(name: str, results: Iterator[Trial], *, is_stated: bool = False) -> Iterator[Row]:
    """Yield coverage, spurious sources and error; without targets where these are only stated."""
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
    targets = ('', '', '') if is_stated else ('>= 0.90', '<= 0.02', '<= 2')
    yield f'{name}, {total} trials: in 95 % ellipse', targets[0], f'{inside / max(found, 1):.3f}'
    yield f'{name}: runs with spurious sources', targets[1], f'{spurious / total:.3f}'
    rmse, median = math.sqrt(np.mean(squares)), math.sqrt(np.median(squares))
    yield f'{name}: RMSE, m', targets[2], f'{rmse:.2f}'
    if is_stated:
        yield f'{name}: median error, m; found', '', f'{median:.2f}; {found / total:.3f}'


# A tank car beside the source: 15 x 3 x 3 m with walls of 10 mm of iron.
TANK_CAR = Box(material='iron', centre_enu_m=(0.0, 0.0, 2.5), size_m=(15.0, 3.0, 3.0), wall_m=0.01)
# The same full of water: what stands behind it sees nothing of the source.
FULL_CAR = Box(material='water', centre_enu_m=(0.0, 0.0, 2.5), size_m=(15.0, 3.0, 3.0))
MISMATCHES = {
    'truth without attenuation': World(kernel=Kernel(is_lossy=False)),
    'truth of iridium': World(kernel=replace(OPTIONS.kernel, nuclide='Ir-192')),
    'truth shielded to a half': World(attenuation=0.5),
    'truth beside an empty tank car': World(car=TANK_CAR),
    'truth beside a full tank car': World(car=FULL_CAR),
    'gain noise 10 %': World(gain_noise=0.1),
    'dead time 20 us instead of 5': World(dead_time_s=20e-6),
    'background uneven by 20 %': World(background_variation=0.2),
}
SOURCE_FREE = {
    'even background': World(),
    'gain noise 10 %': World(gain_noise=0.1),
    'dead time 20 us instead of 5': World(dead_time_s=20e-6),
    'background uneven by 20 %': World(background_variation=0.2),
    'background uneven by 40 %': World(background_variation=0.4),
    'uneven by 20 % over 60 to 200 m': World(
        background_variation=0.2, background_lengths_m=(60.0, 200.0)
    ),
    'uneven by 20 %, gain noise 10 %': World(background_variation=0.2, gain_noise=0.1),
}


def mismatched(count: int) -> Iterator[Row]:
    """Target 5: how much worse it gets where the truth differs; no source where none is."""
    for name, world in MISMATCHES.items():
        yield from _noise_rows(name, trials(6, count, 1, world), is_stated=True)


def source_free(count: int) -> Iterator[Row]:
    """Target 5 without a source."""
    for name, world in SOURCE_FREE.items():
        found = [len(trial.found.sources) for trial in trials(7, count, 0, world)]
        clean = sum(order == 0 for order in found) / count
        yield f'no source, {name}, {count} trials: none found', '>= 0.98', f'{clean:.3f}'


def stopping(count: int) -> Iterator[Row]:
    """Yield how often the test decides wrongly, looked at after each three lines of a survey."""
    rule = StoppingRule(smallest_usvh=SMALLEST_GBQ * CAESIUM_USVH_PER_GBQ)
    for name, gbq, wrong in (
        ('no source', 0.0, PRESENT),
        ('a source of 1 GBq', SMALLEST_GBQ, ABSENT),
        ('a source of 3 GBq', 3.0 * SMALLEST_GBQ, ABSENT),
    ):
        ends, looks = [], []
        for index in range(count):
            generator = np.random.default_rng([11, int(10 * gbq), index])
            truth = drawn(generator, int(gbq > 0.0), max(gbq, 1.0), max(gbq, 1.0) * 1.0001)
            verdict, line = _searched(flown(generator, World(), truth), rule)
            ends.append(verdict)
            looks.append(line)
        errors = ends.count(wrong) / count
        yield f'sequential test, {name}, {count} trials: wrong', '<= 0.01', f'{errors:.3f}'
        decided = 1.0 - ends.count(CONTINUE) / count
        yield f'sequential test, {name}: decided', '', f'{decided:.2f}'
        share = float(np.mean(looks)) / (300.0 / PITCH_M + 1.0)
        yield f'sequential test, {name}: share of the survey used', '', f'{share:.2f}'


def _searched(survey: RadiationSurvey, rule: StoppingRule) -> tuple[str, int]:
    """Return how a survey, read line by line, is decided, and after how many lines.

    The ground is known from the start: what is not read yet has readings of next to no exposure.
    """
    setting = Setting(kernel=OPTIONS.kernel, source_up_m=OPTIONS.source_up_m)
    lines = np.round(survey.positions_enu_m[:, 1] / PITCH_M).astype(int)
    last = int(lines.max())
    for line in range(LINES_A_LOOK - 1, last + 1, LINES_A_LOOK):
        seen = lines <= line
        part = RadiationSurvey(
            positions_enu_m=survey.positions_enu_m,
            counts=np.where(seen, survey.counts, 0.0),
            exposures=np.where(seen, survey.exposures, 1e-6),
        )
        decision = rule.decision(sequential_evidence(part, setting, rule.smallest_usvh))
        if decision != CONTINUE:
            return decision, line + 1
    return CONTINUE, last + 1


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
            survey = RadiationSurvey(positions_enu_m=places, counts=counts, exposures=exposures)
            found = localize(survey, OPTIONS)
            if found.sources and log_volume(found) <= goal:
                break
            grid = trial.survey.positions_enu_m
            chosen = next_waypoints(found, grid, SENSITIVITY, OPTIONS.kernel, 8)
            more = np.array([one.place_m for one in chosen]) if chosen else grid[:8]
            new = generator.poisson(SENSITIVITY * _rates(trial.truth, more)).astype(float)
            places, counts = np.vstack([places, more]), np.append(counts, new)
        used.append(len(places))
        missed += len(places) >= trial.survey.size
    share = 1.0 - float(np.mean(used)) / 441.0
    yield f'adaptive: fewer readings, {len(used)} trials', '>= 0.30', f'{share:.2f}'
    yield 'adaptive: trials that never got there', '', f'{missed / len(used):.2f}'


def _rates(truth: FloatArray, places: FloatArray) -> FloatArray:
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
    'source_free': source_free,
    'stopping': stopping,
    'adaptive': adaptive,
    'speed': speed,
}


if __name__ == '__main__':
    print_table('Measure the localiser against its targets.', PARTS)
