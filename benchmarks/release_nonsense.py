# SPDX-License-Identifier: Apache-2.0
"""Readings that are nonsense as readings of a plume: whether they are doubted.

    python benchmarks/release_nonsense.py [--split develop] [--first 0] [--count 4]
                                          [--kinds honest,permuted,...] [--out FILE]

Honest surveys of one release, about 120 readings each, are of two families: ``steady``, the trials
of release_families.py (filaments) with a lawn mower across the first one besides, and ``turning``,
a plume along the wind of each reading, which turns in the course of the survey. Of each, nonsense
is made:

    permuted   readings in another order
    swapped    east and north of the places exchanged
    mirrored   north counted southwards
    mixed      every second reading is of another release's survey: two agents
    other      all readings are of another release's survey: another site
    steps      constant levels with steps, and noise
    late       readings 5 to 29 places late
    hour       the wind of one hour before (``turning`` only)
    moving     no nonsense, but not of the model: the release moves by 80 m (``turning`` only)

Splits have seeds of their own; ``opened`` is for stated figures and looked at once. A row of JSON
for each survey is added to FILE; surveys that are there are not run again. In a wind that does not
turn, a mirror image of a plume is a plume in another wind, and nothing can tell.
"""

import argparse
import json
import math
import os
import time

os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from release_families import ANEMOMETER_M, RELEASE_M, ROUGHNESS_M, lawn_mower, trial
from release_search import AREA

from rocsafe_dispersion.estimation.fluctuating_plume import PlumeReadings, Shapes
from rocsafe_dispersion.estimation.gas_survey import GasSurvey, point_survey
from rocsafe_dispersion.estimation.locate import locate_releases
from rocsafe_dispersion.estimation.release_options import LocateOptions
from rocsafe_dispersion.mission_gas.stopping import ReleaseRule
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.wind.similarity import SurfaceLayer
from rocsafe_geo.wind.stability import CLASSES, layer_of_class

SEEDS = {'develop': 21, 'validate': 22, 'opened': 23}
HOUR_S, STEP_S, CONFIDENT_M = 3600.0, 10.0, 15.0
OTHER, MOVED_M = 500, 80.0
ONLY_TURNING = ('hour', 'moving')


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drawn:
    """An honest survey, the air told, and what nonsense is made of."""

    survey: GasSurvey
    layer: SurfaceLayer
    noise_g_m3: float
    an_hour_before_mps: FloatArray | None = None


def steady(split: str, number: int) -> Drawn:
    """Return a trial of release_families.py with one release, flown over twice."""
    drawn = trial(split, 4 * number + 1)
    flat = lawn_mower()[:, ::-1]
    more = np.column_stack([flat, np.full(len(flat), drawn.sensor_m)])
    survey = drawn.survey(np.concatenate([drawn.places(), more]))
    speed = float(np.hypot(*drawn.told_mps))
    layer = layer_of_class(drawn.told_stability, speed, ANEMOMETER_M, ROUGHNESS_M)
    return Drawn(survey=survey, layer=layer, noise_g_m3=drawn.noise_g_m3)


def turning(split: str, number: int, moved_m: float = 0.0) -> Drawn:
    """Return readings of a plume along the wind of each, told with errors of direction and air.

    The release moves in the course of the survey.
    """
    generator = np.random.default_rng([SEEDS[split], number])
    true = int(generator.integers(1, 5))
    told = (CLASSES[true], CLASSES[min(true + 1, 5)], 'D')[int(generator.integers(3))]
    speed, base = generator.uniform(2.0, 6.0), generator.uniform(0.0, 2.0 * math.pi)
    times: FloatArray = np.asarray(generator.uniform(8.0, 30.0) * np.arange(120.0), float)
    grid = np.arange(-HOUR_S, times[-1] + 1.0, STEP_S)
    wander = _wander(generator, len(grid), generator.uniform(300.0, 1200.0))
    std = math.radians(generator.uniform(10.0, 40.0))
    now, before = (
        _vectors(speed, base + std * np.interp(times - back_s, grid, wander))
        for back_s in (0.0, HOUR_S)
    )
    layer = layer_of_class(CLASSES[true], speed, ANEMOMETER_M, ROUGHNESS_M)
    second = lawn_mower()[:, ::-1]
    if number % 2 == 0:
        second = generator.uniform(-46.0, 46.0, second.shape)
    flat = np.concatenate([lawn_mower(), second])
    most = len(flat)
    times, now, before = times[:most], now[:most], before[:most]
    places = np.column_stack([flat, np.full(most, generator.uniform(2.0, 4.0))])
    release = generator.uniform(-40.0, 40.0, (1, 2))
    rate = math.exp(generator.uniform(math.log(0.3), math.log(8.0)))
    noise = math.exp(generator.uniform(math.log(3e-5), math.log(2e-4)))
    empty = point_survey(places, now, np.zeros(most), np.full(most, noise), times)
    reader = PlumeReadings(empty, RELEASE_M, similarity_travel(layer, RELEASE_M), speed)
    shapes = Shapes(
        turn_rad=np.zeros(1),
        spread_y=np.exp(0.3 * generator.standard_normal(1)),
        spread_z=np.exp(0.3 * generator.standard_normal(1)),
        meander=generator.uniform(0.0, 0.8, 1),
        relative=generator.uniform(0.2, 0.8, 1),
    )
    way = np.linspace(-0.5, 0.5, most)[:, None] * _vectors(moved_m, np.array([float(number)]))
    each_shape = shapes.at(np.zeros(most, int))
    mean, spread = (rate * np.diagonal(each) for each in reader.of(release + way, each_shape))
    form = 1.0 / np.clip((spread / np.maximum(mean, 1e-30)) ** 2, 0.05, 100.0)
    values = mean * generator.gamma(form) / form + noise * generator.standard_normal(most)
    values += generator.uniform(0.0, 5.0) * noise
    error = math.radians(5.0) * generator.standard_normal()
    factor = math.exp(0.1 * generator.standard_normal())
    told_mps = factor * _turned(now, error + math.radians(3.0) * generator.standard_normal(most))
    survey = point_survey(places, told_mps, values, np.full(most, noise), times)
    return Drawn(
        survey=survey,
        layer=layer_of_class(told, speed * factor, ANEMOMETER_M, ROUGHNESS_M),
        noise_g_m3=noise,
        an_hour_before_mps=factor * _turned(before, np.full(most, error)),
    )


FAMILIES: dict[str, Callable[[str, int], Drawn]] = {'turning': turning, 'steady': steady}


def _wander(generator: np.random.Generator, count: int, scale_s: float) -> FloatArray:
    rho = math.exp(-STEP_S / scale_s)
    found = np.zeros(count)
    found[0] = generator.standard_normal()
    for number in range(1, count):
        step = math.sqrt(1.0 - rho * rho) * generator.standard_normal()
        found[number] = rho * found[number - 1] + step
    return found


def _vectors(speed_mps: float, angles_rad: FloatArray) -> FloatArray:
    return speed_mps * np.column_stack([np.cos(angles_rad), np.sin(angles_rad)])


def _turned(vectors: FloatArray, angles_rad: FloatArray) -> FloatArray:
    found = (vectors[:, 0] + 1j * vectors[:, 1]) * np.exp(1j * angles_rad)
    return np.column_stack([found.real, found.imag])


def nonsense(kind: str, family: str, split: str, number: int) -> tuple[GasSurvey, SurfaceLayer]:
    """Return a survey of a kind, and the air told."""
    drawn = FAMILIES[family](split, number)
    if kind == 'moving':
        drawn = turning(split, number, MOVED_M)
    survey, count = drawn.survey, len(drawn.survey.values_g_m3)
    generator = np.random.default_rng([SEEDS[split], number, sum(map(ord, kind))])
    values, is_below = survey.values_g_m3.copy(), survey.is_below.copy()
    if kind in ('permuted', 'late'):
        order = (
            generator.permutation(count)
            if kind == 'permuted'
            else np.roll(np.arange(count), int(generator.integers(5, 30)))
        )
        values, is_below = values[order], is_below[order]
    elif kind in ('mixed', 'other'):
        other = FAMILIES[family](split, number + OTHER).survey
        own = np.arange(min(count, len(other.values_g_m3)))
        own = own[own % 2 == 1] if kind == 'mixed' else own
        values[own], is_below[own] = other.values_g_m3[own], other.is_below[own]
    elif kind == 'steps':
        steps = int(generator.integers(2, 7))
        cuts = np.sort(generator.integers(1, count, steps))
        levels = np.exp(generator.uniform(0.0, 5.0, steps + 1))
        levels = levels * (generator.random(steps + 1) < 0.6)
        shown = levels[np.searchsorted(cuts, np.arange(count), side='right')]
        values = drawn.noise_g_m3 * (shown + generator.standard_normal(count))
        is_below = np.zeros(count, bool)
    survey = replace(survey, values_g_m3=values, is_below=is_below)
    if kind == 'swapped':
        survey = replace(survey, places_m=survey.places_m[:, :, [1, 0, 2]])
    if kind == 'mirrored':
        survey = replace(survey, places_m=survey.places_m * (1.0, -1.0, 1.0))
    if kind == 'hour' and drawn.an_hour_before_mps is not None:
        survey = replace(survey, wind_towards_mps=drawn.an_hour_before_mps)
    return survey, drawn.layer


KINDS = (
    'honest', 'permuted', 'swapped', 'mirrored', 'mixed', 'other', 'steps', 'late', 'hour',
    'moving',
)  # fmt: skip


def outcome(kind: str, family: str, split: str, number: int) -> dict[str, Any]:
    """Return what is told of one survey as a row."""
    survey, layer = nonsense(kind, family, split, number)
    started = time.process_time()
    found = locate_releases(
        survey, AREA, layer, anemometer_m=ANEMOMETER_M, options=LocateOptions(most_releases=1)
    )
    return {
        'kind': kind, 'family': family, 'split': split, 'number': number,
        'region_m': [one.region_radius_m for one in found.releases],
        'gain_of_places': found.gain_of_places, 'wrong_wind': found.wrong_wind,
        'is_enough': ReleaseRule().verdict(found).is_enough,
        'cpu_s': time.process_time() - started,
    }  # fmt: skip


def print_rows(rows: list[dict[str, Any]]) -> None:
    """Print a table of kinds."""
    print('| kind | surveys | release told | places doubted | places or wind doubted '
          '| told within 15 m | of these doubted | enough |')  # fmt: skip
    print('|---|---|---|---|---|---|---|---|')
    for kind in KINDS:
        own = [row for row in rows if row['kind'] == kind]
        told = [row for row in own if row['region_m']]
        near = [row for row in told if row['region_m'][0] <= CONFIDENT_M]
        cells = (
            len(own), len(told), sum(row['gain_of_places'] <= 0.0 for row in told),
            sum(map(_is_doubted, told)), len(near), sum(map(_is_doubted, near)),
            sum(row['is_enough'] for row in own),
        )  # fmt: skip
        if own:
            print(f'| {kind} | {" | ".join(map(str, cells))} |')


def _is_doubted(row: dict[str, Any]) -> bool:
    return bool(row['gain_of_places'] <= 0.0 or row['wrong_wind'] > ReleaseRule().wrong_wind)


def main() -> int:
    """Run surveys that are not in the file, and print the table of all of this split."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument('--split', choices=SEEDS, default='develop')
    parser.add_argument('--first', type=int, default=0)
    parser.add_argument('--count', type=int, default=4)
    parser.add_argument('--kinds', default=','.join(KINDS))
    parser.add_argument('--out', type=Path, default=Path('release_nonsense.jsonl'))
    given = parser.parse_args()
    rows = []
    if given.out.exists():
        rows = [json.loads(line) for line in given.out.read_text().splitlines()]
    names = ('kind', 'family', 'split', 'number')
    done = {tuple(row[name] for name in names) for row in rows}
    for number in range(given.first, given.first + given.count):
        for kind in given.kinds.split(','):
            for family in FAMILIES:
                own = (kind, family, given.split, number)
                if own in done or (kind in ONLY_TURNING and family == 'steady'):
                    continue
                rows.append(outcome(*own))
                with given.out.open('a') as stream:
                    stream.write(json.dumps(rows[-1]) + '\n')
    print_rows([row for row in rows if row['split'] == given.split])
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
