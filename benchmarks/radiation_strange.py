# SPDX-License-Identifier: Apache-2.0
"""Surveys over what is no point source at rest: time of the estimator, and what it tells of them.

    OMP_NUM_THREADS=1 python benchmarks/radiation_strange.py [--kinds contaminated] [--count 12]
                      [--split develop] [--first 0] [--out FILE]

Tracks, law of the dose rate, errors of the fixes and backgrounds are those of ``radiation_lag``:
441 readings of a second, which tell counts, over 0 to 2 sources of 1 to 50 GBq.

``contaminated``
    One or two vehicles, each with a part of the lines at the same time. At a moment, from 0.15 to
    0.85 of the flight, one gets a dose rate of 0.02 to 1 uSv/h more, and keeps it.
``clean``
    The same without it.
``passes``
    As ``contaminated``, but it is there for 5 to 20 s only, as beside a train that passes.
``switched``
    At such a moment all sources are covered, or, in every second survey, uncovered.
``moving``
    All sources move by 0.5 to 3 heights on straight lines in the course of the survey.
``patch``
    One source is spread over a disc with a radius of 0.3 to 1.5 heights.
``radon``
    The background rises by a factor of 1.5 to 4 and falls again in half an hour of rain.
``steps``
    The detector shows 15 to 40 % less from a moment on.

One line of JSON for each survey is added to FILE; surveys that are there are not run again. The
table: surveys, those with the right number of sources and those without a source that are told
one, sources within their 95 % ellipse where the number is right, surveys that are enough and those
of them that are wrong (as in ``radiation_lag``), and processor time. Where sources move or are
spread, no place is the right one: those of their middles count.
"""

import os

# As `rocsafe localize` does.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

import argparse
import json
import math
import time
from pathlib import Path
from typing import Any

import numpy as np
from radiation_families import law
from radiation_lag import FIX_STD_M, NUCLIDE, QUANTILE_95, drawn_sources, track

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.decision.sequential_decision import sequential_evidence
from rocsafe_radiation.decision.stopping import StoppingRule
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.localize import LocalizationOptions, localize
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.readings.survey import LocalReading, survey_of

FIRST_SEEDS = {'develop': 0, 'validate': 10_000, 'opened': 20_000}
SEED, POINTS = 4712, 40
KINDS = (
    'contaminated', 'clean', 'passes', 'switched', 'moving', 'patch', 'radon', 'steps',
)  # fmt: skip

Generator = np.random.Generator


def drawn(kind: str, seed: int) -> tuple[list[LocalReading], float, FloatArray]:
    """Return readings, counts a second for 1 uSv/h and sources (k, 4) of a survey."""
    # Clean surveys are those that are contaminated, without it.
    family = 'contaminated' if kind == 'clean' else kind
    generator = np.random.default_rng([SEED, KINDS.index(family), seed])
    order = seed % 3 if family in ('contaminated', 'passes', 'radon', 'steps') else 1 + seed % 2
    height_m = float(generator.uniform(15.0, 45.0))
    places, times = track(generator, height_m)
    # The tenths of a second that fill whole seconds; each vehicle has a half of them, or all.
    vehicles = int(generator.integers(1, 3))
    each = len(times) // (10 * vehicles)
    places, times = places[: 10 * each * vehicles], np.tile(times[: 10 * each], vehicles)
    owner = np.repeat(np.arange(vehicles), 10 * each)
    flown = times / times.max()
    sensitivity = float(generator.choice([200.0, 550.0, 1000.0]))
    sources = drawn_sources(generator, order, places, height_m, sensitivity, 1.0)
    angle, moment = generator.uniform(0.0, 2.0 * math.pi), generator.uniform(0.15, 0.85)
    half_m = 0.5 * float(np.ptp(places[:, :2], axis=0).max())
    turned = places[:, 0] * math.cos(angle) + places[:, 1] * math.sin(angle)
    slope = generator.choice([0.0, 0.1]) / half_m
    background = generator.uniform(0.06, 0.12) * np.exp(slope * (turned - turned.mean()))
    background *= np.exp((height_m - places[:, 2]) / 120.0)
    added = math.exp(generator.uniform(math.log(0.02), 0.0)) * (owner == 0)
    if kind == 'contaminated':
        background += added * (flown > moment)
    if kind == 'passes':
        lasts = generator.uniform(5.0, 20.0) / times.max()
        background += added * (np.abs(flown - moment) < 0.5 * lasts)
    if kind == 'radon':
        lasts = 1800.0 / times.max()
        risen = np.exp(-0.5 * ((flown - moment) / (0.25 * lasts)) ** 2)
        background *= 1.0 + generator.uniform(0.5, 3.0) * risen
    rates = background + _of_sources(generator, kind, sources, places, flown, moment, height_m)
    if kind == 'steps':
        rates = rates * np.where(flown > moment, generator.uniform(0.6, 0.85), 1.0)
    counts = generator.poisson(sensitivity * rates.reshape(-1, 10).mean(axis=1))
    stated = places[5::10] + generator.normal(0.0, FIX_STD_M, (len(counts), 3))
    readings = [
        LocalReading(
            position_enu_m=tuple(place), dose_rate_usvh=math.nan, counts=count, live_time_s=1.0,
            vehicle=f'rav{one + 1}', time_s=stamp,
        )
        for place, count, one, stamp in zip(
            stated.tolist(), counts.astype(float).tolist(), owner[5::10].tolist(),
            times[5::10].tolist(), strict=True,
        )
    ]  # fmt: skip
    return readings, sensitivity, sources


def _of_sources(
    generator: Generator,
    kind: str,
    sources: FloatArray,
    places: FloatArray,
    flown: FloatArray,
    moment: float,
    height_m: float,
) -> FloatArray:
    """Return the dose rates of sources, (n,)."""
    rates: FloatArray = np.zeros(len(places))
    for source in sources:
        angle = generator.uniform(0.0, 2.0 * math.pi)
        way = height_m * np.array([math.cos(angle), math.sin(angle), 0.0])
        offsets = places - source[:3]
        if kind == 'moving':
            offsets = offsets - np.outer(flown - 0.5, generator.uniform(0.5, 3.0) * way)
        if kind == 'patch':
            radius_m = height_m * generator.uniform(0.3, 1.5)
            for far, turn in generator.uniform(0.0, 1.0, (POINTS, 2)).tolist():
                around = np.array([math.cos(6.2832 * turn), math.sin(6.2832 * turn), 0.0])
                apart = offsets - radius_m * math.sqrt(far) * around
                rates += source[3] / POINTS * law(NUCLIDE, np.linalg.norm(apart, axis=1))
            continue
        rates += source[3] * law(NUCLIDE, np.linalg.norm(offsets, axis=1))
    if kind == 'switched':
        rates *= (flown < moment) == (generator.random() < 0.5)
    return rates


def outcome(kind: str, split: str, number: int) -> dict[str, Any]:
    """Return what is told of a survey as a row."""
    readings, sensitivity, sources = drawn(kind, FIRST_SEEDS[split] + number)
    started = time.process_time()
    survey = survey_of(readings, sensitivity)
    options, rule = LocalizationOptions(kernel=Kernel(nuclide=NUCLIDE)), StoppingRule()
    found = localize(survey, options)
    spent = time.process_time() - started
    setting = Setting(kernel=options.kernel, source_up_m=options.source_up_m)
    evidence = sequential_evidence(survey, setting, rule.smallest_usvh)
    verdict = rule.verdict(found, evidence)
    squares = []
    for truth in sources:
        ways = [source.position_enu_m[:2] - truth[:2] for source in found.sources]
        if len(ways) == len(sources):
            nearest = int(np.argmin([way @ way for way in ways]))
            covariance = found.sources[nearest].covariance_m2[:2, :2]
            squares.append(float(ways[nearest] @ np.linalg.solve(covariance, ways[nearest])))
    return {
        'kind': kind, 'split': split, 'number': number, 'true': len(sources),
        'told': len(found.sources), 'probabilities': list(found.order_probabilities),
        'places': [one.position_enu_m.tolist() for one in found.sources],
        'strengths': [one.dose_rate_at_1m_usvh for one in found.sources],
        'axes_m': [one.ellipse_95()[0] for one in found.sources],
        'squares': squares, 'is_enough': verdict.is_enough, 'verdict': verdict.reason,
        'doubts': list(found.doubts), 'cpu_s': spent,
    }  # fmt: skip


def row(kind: str, rows: list[dict[str, Any]]) -> str:
    """Return the row of the table."""
    squares = [square for one in rows for square in one['squares']]
    right = [one['true'] == one['told'] for one in rows]
    wrong = [
        one['true'] != one['told'] or max(one['squares'], default=0.0) > 1.5**2 * QUANTILE_95
        for one in rows
    ]
    empty = [one['told'] > 0 for one in rows if not one['true']]
    times = [one['cpu_s'] for one in rows]
    enough = [one['is_enough'] for one in rows]
    return (
        f'{kind:13s}{len(rows):4d}  {sum(right):3d}  {sum(empty):3d} of {len(empty):2d}'
        f'  {sum(square < QUANTILE_95 for square in squares):3d} of {len(squares):3d}'
        f'  {sum(enough):3d}  {sum(np.array(enough) & np.array(wrong)):3d}'
        f'  {np.mean(times):6.2f}  {max(times):6.2f}'
    )


def main() -> None:
    """Run surveys that are not in the file, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--split', choices=FIRST_SEEDS, default='develop')
    parser.add_argument('--kinds', choices=KINDS, nargs='+', default=list(KINDS))
    parser.add_argument('--count', type=int, default=12, help='surveys of each kind')
    parser.add_argument('--first', type=int, default=0, help='number of the first in its split')
    parser.add_argument('--out', type=Path, default=Path('radiation_strange.jsonl'))
    given = parser.parse_args()
    rows = []
    if given.out.exists():
        rows = [json.loads(line) for line in given.out.read_text().splitlines()]
    print('kind            n  right  false      inside  enough wrong  CPU s, mean, largest')
    for kind in given.kinds:
        own = [one for one in rows if (one['kind'], one['split']) == (kind, given.split)]
        done = {one['number'] for one in own}
        for number in range(given.first, given.first + given.count):
            if number not in done:
                own.append(outcome(kind, given.split, number))
                with given.out.open('a') as stream:
                    stream.write(json.dumps(own[-1]) + '\n')
        print(row(kind, own), flush=True)


if __name__ == '__main__':
    main()
