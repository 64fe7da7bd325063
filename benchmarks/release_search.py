# SPDX-License-Identifier: Apache-2.0
"""Releases found in simulated searches: how often, how near, and whether regions hold them.

    python benchmarks/release_search.py [--split develop] [--count 80] [--first 0]
                                        [--designs drawn,search] [--turned DEG] [--out FILE]

A search has 60 readings: ``drawn`` at the places of the trial's pattern, ``search`` half of them
along a lawn mower, the rest at places that the readings so far suggest, ten at a time. One line of
JSON for each search is added to FILE; searches that are there are not run again. What is drawn,
splits and what is wrong for the estimator: release_families.py. ``--turned`` turns the wind that
is told besides.

Releases told are matched with true ones so that the sum of distances is the smallest.
"""

import argparse
import json
import math
import os
import time

os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from release_families import (
    ANEMOMETER_M,
    READINGS,
    READINGS_WITHIN_M,
    RELEASE_M,
    ROUGHNESS_M,
    SPLITS,
    Trial,
    lawn_mower,
    trial,
)
from scipy.optimize import linear_sum_assignment

from rocsafe_dispersion.estimation.gas_survey import BY_READING, GasSurvey
from rocsafe_dispersion.estimation.locate import LocatedReleases, locate_releases
from rocsafe_dispersion.estimation.measuring_places import MeanAir, measuring_places
from rocsafe_dispersion.estimation.release_options import SearchArea
from rocsafe_dispersion.mission_gas.stopping import ReleaseRule
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.wind.similarity import SurfaceLayer
from rocsafe_geo.wind.stability import layer_of_class

A_ROUND, ROUNDS = 10, 3
# Regions hold a release that is up to 10 m beyond the ground with releases.
AREA = SearchArea(
    west_m=-50.0, south_m=-50.0, east_m=50.0, north_m=50.0, cell_m=4.0, height_m=RELEASE_M
)
CANDIDATE_PITCH_M = 4.0


def told_layer(drawn: Trial) -> SurfaceLayer:
    """Return the air that the estimator is told of."""
    speed = float(np.hypot(*drawn.told_mps))
    return layer_of_class(drawn.told_stability, speed, ANEMOMETER_M, ROUGHNESS_M)


def located(drawn: Trial, survey: GasSurvey) -> tuple[LocatedReleases, float]:
    """Return what the estimator says of a survey, and its processor time, s."""
    started = time.process_time()
    found = locate_releases(survey, AREA, told_layer(drawn), anemometer_m=ANEMOMETER_M)
    return found, time.process_time() - started


def flown(drawn: Trial, design: str) -> tuple[GasSurvey, LocatedReleases, float]:
    """Return the survey of a design, what was found, and the time of the last estimate, s."""
    places = drawn.places()
    if design == 'search':
        flat = lawn_mower(READINGS - ROUNDS * A_ROUND)
        places = np.column_stack([flat, np.full(len(flat), drawn.sensor_m)])
    survey = drawn.survey(places)
    found, spent = located(drawn, survey)
    for _ in range(ROUNDS if design == 'search' else 0):
        survey = joined(survey, drawn.survey(suggested(drawn, found), len(survey.values_g_m3)))
        found, spent = located(drawn, survey)
    return survey, found, spent


def joined(first: GasSurvey, second: GasSurvey) -> GasSurvey:
    """Return the readings of both."""
    parts = {
        name: np.concatenate([getattr(first, name), getattr(second, name)]) for name in BY_READING
    }
    return replace(first, **parts)


def suggested(drawn: Trial, found: LocatedReleases) -> FloatArray:
    """Return the places of the next round, (A_ROUND, 3)."""
    layer = told_layer(drawn)
    east, north = drawn.told_mps.tolist()
    air = MeanAir(
        towards_mps=(east, north),
        travel=similarity_travel(layer, RELEASE_M),
        reference_mps=float(layer.speed_mps(ANEMOMETER_M)),
        release_height_m=RELEASE_M,
    )
    axis = np.arange(-READINGS_WITHIN_M, READINGS_WITHIN_M + 1.0, CANDIDATE_PITCH_M)
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    candidates = np.column_stack([grid, np.full(len(grid), drawn.sensor_m)])
    groups = [one.samples for one in found.releases] or [found.hidden.samples]
    chosen = measuring_places(groups, candidates, air, drawn.noise_g_m3, A_ROUND)
    return np.array([one.place_m for one in chosen])


def outcome(split: str, number: int, design: str, turned_deg: float = 0.0) -> dict[str, Any]:
    """Return one search as a row."""
    drawn = trial(split, number, turned_deg)
    survey, found, spent = flown(drawn, design)
    told = np.array([one.place_m for one in found.releases]).reshape(-1, 2)
    offsets = told[:, None] - drawn.places_m
    pairs = zip(*linear_sum_assignment(np.hypot(offsets[..., 0], offsets[..., 1])), strict=True)
    releases = []
    for one, true in pairs:
        near, place = found.releases[one], drawn.places_m[true].tolist()
        rate = float(drawn.rates_g_s[true])
        releases.append({
            'error_m': math.dist(near.place_m, place),
            'region_m': near.region_radius_m,
            'is_held': near.holds(*place),
            'rate_ratio': near.rate_g_s / rate,
            'is_rate_held': near.rate_low_g_s <= rate <= near.rate_high_g_s,
        })  # fmt: skip
    values = survey.values_g_m3 - np.median(survey.values_g_m3)
    return {
        'split': split, 'number': number, 'design': design, 'turned_deg': turned_deg,
        'true': len(drawn.rates_g_s), 'found': len(found.releases),
        'detector': drawn.detector, 'pattern': drawn.pattern,
        'hits': int((values > 6.0 * drawn.noise_g_m3).sum()), 'gains': list(found.gains),
        'probabilities': list(found.number_probabilities), 'releases': releases,
        'hidden': found.hidden.share, 'is_enough': ReleaseRule().verdict(found).is_enough,
        'wrong_wind': found.wrong_wind, 'cpu_s': spent,
    }  # fmt: skip


def print_rows(rows: list[dict[str, Any]]) -> None:
    """Print a table of designs and true numbers."""
    print('| design | releases | searches | told 0, 1, 2, 3 | right number (expected) | error, m '
          '| region held | region radius, m | rate held | enough | wind doubted '
          '| CPU-s, largest |')  # fmt: skip
    print('|---|---|---|---|---|---|---|---|---|---|---|---|')
    for design in dict.fromkeys(row['design'] for row in rows):
        for true in (0, 1, 2, 3, 'all'):
            own = [row for row in rows if row['design'] == design and true in (row['true'], 'all')]
            if own:
                print(f'| {design} | {true} | {_cells(own)} |')


def _cells(rows: list[dict[str, Any]]) -> str:
    near = [one for row in rows for one in row['releases']]

    def median(name: str) -> str:
        return f'{np.median([one[name] for one in near]):.1f}' if near else ''

    def held(name: str) -> str:
        return f'{sum(one[name] for one in near)} of {len(near)}'

    told = ', '.join(str(sum(row['found'] == number for row in rows)) for number in range(4))
    right = np.mean([row['found'] == row['true'] for row in rows])
    expected = np.mean([row['probabilities'][row['found']] for row in rows])
    cells = (
        len(rows), told, f'{right:.2f} ({expected:.2f})', median('error_m'), held('is_held'),
        median('region_m'), held('is_rate_held'), sum(row['is_enough'] for row in rows),
        sum(row['wrong_wind'] > ReleaseRule().wrong_wind for row in rows),
        f'{max(row["cpu_s"] for row in rows):.1f}',
    )  # fmt: skip
    return ' | '.join(str(cell) for cell in cells)


def main() -> int:
    """Run searches that are not in the file, and print the table of all of this split."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument('--split', choices=SPLITS, default='develop')
    parser.add_argument('--first', type=int, default=0)
    parser.add_argument('--count', type=int, default=8)
    parser.add_argument('--designs', default='drawn')
    parser.add_argument('--turned', type=float, default=0.0)
    parser.add_argument('--out', type=Path, default=Path('release_search.jsonl'))
    arguments = parser.parse_args()
    rows = []
    if arguments.out.exists():
        rows = [json.loads(line) for line in arguments.out.read_text().splitlines()]
    names = ('split', 'number', 'design', 'turned_deg')
    done = {tuple(row[name] for name in names) for row in rows}
    for number in range(arguments.first, arguments.first + arguments.count):
        for design in arguments.designs.split(','):
            if (arguments.split, number, design, arguments.turned) in done:
                continue
            rows.append(outcome(arguments.split, number, design, arguments.turned))
            with arguments.out.open('a') as stream:
                stream.write(json.dumps(rows[-1]) + '\n')
    wanted = arguments.split, arguments.turned
    print_rows([row for row in rows if (row['split'], row['turned_deg']) == wanted])
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
