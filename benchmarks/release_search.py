# SPDX-License-Identifier: Apache-2.0
"""Releases found in simulated searches: how often, how near, and whether regions hold them.

    python benchmarks/release_search.py [--split develop] [--count 8] [--first 0]
                                        [--designs mower,crosswind,search] [--out FILE]

A search has 60 readings: ``mower`` along parallel lines, ``crosswind`` along four lines across the
wind, ``search`` half of them along a lawn mower, the rest at places that the readings so far
suggest, ten at a time. One line of JSON for each search is added to FILE; searches that are there
are not run again. Families, splits and what is wrong for the estimator: release_families.py.
"""

import argparse
import json
import math
import os
import time

os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

from pathlib import Path
from typing import Any

import numpy as np
from release_families import (
    ANEMOMETER_M,
    FAMILIES,
    NOISE_G_M3,
    READINGS_WITHIN_M,
    RELEASE_M,
    ROUGHNESS_M,
    SENSOR_M,
    SPLITS,
    Trial,
    crosswind,
    lawn_mower,
    trial,
)

from rocsafe_dispersion.estimation.gas_survey import GasSurvey, point_survey
from rocsafe_dispersion.estimation.locate import LocatedReleases, locate_releases
from rocsafe_dispersion.estimation.measuring_places import MeanAir, measuring_places
from rocsafe_dispersion.estimation.release_options import SearchArea
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.wind.stability import layer_of_class

READINGS, A_ROUND, ROUNDS = 60, 10, 3
# Regions hold a release that is up to 10 m beyond the ground with releases.
AREA = SearchArea(
    west_m=-50.0, south_m=-50.0, east_m=50.0, north_m=50.0, cell_m=4.0, height_m=RELEASE_M
)
CANDIDATE_PITCH_M = 4.0


def located(drawn: Trial, places: FloatArray, values: FloatArray, winds: FloatArray) -> Any:
    """Return survey and what the estimator says of it."""
    speed = float(np.hypot(*drawn.told_mps))
    layer = layer_of_class(drawn.told_stability, speed, ANEMOMETER_M, ROUGHNESS_M)
    survey = point_survey(places, winds, values, np.full(len(values), NOISE_G_M3))
    return survey, locate_releases(survey, AREA, layer, anemometer_m=ANEMOMETER_M)


def flown(drawn: Trial, design: str) -> tuple[GasSurvey, LocatedReleases]:
    """Return the survey of a design and what was found."""
    if design == 'crosswind':
        places = crosswind(READINGS, drawn.told_mps)
    else:
        places = lawn_mower(READINGS if design == 'mower' else READINGS - ROUNDS * A_ROUND)
    values, winds = drawn.readings(places, 0)
    survey, found = located(drawn, places, values, winds)
    for _ in range(ROUNDS if design == 'search' else 0):
        more = suggested(drawn, found)
        new_values, new_winds = drawn.readings(more, len(values))
        places = np.concatenate([places, more])
        values, winds = np.concatenate([values, new_values]), np.concatenate([winds, new_winds])
        survey, found = located(drawn, places, values, winds)
    return survey, found


def suggested(drawn: Trial, found: LocatedReleases) -> FloatArray:
    """Return the places of the next round, (A_ROUND, 3)."""
    speed = float(np.hypot(*drawn.told_mps))
    layer = layer_of_class(drawn.told_stability, speed, ANEMOMETER_M, ROUGHNESS_M)
    east, north = drawn.told_mps.tolist()
    air = MeanAir(
        towards_mps=(east, north),
        travel=similarity_travel(layer, RELEASE_M),
        reference_mps=float(layer.speed_mps(ANEMOMETER_M)),
        release_height_m=RELEASE_M,
    )
    axis = np.arange(-READINGS_WITHIN_M, READINGS_WITHIN_M + 1.0, CANDIDATE_PITCH_M)
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    candidates = np.column_stack([grid, np.full(len(grid), SENSOR_M)])
    groups = [one.samples for one in found.releases] or [found.hidden.samples]
    chosen = measuring_places(groups, candidates, air, NOISE_G_M3, A_ROUND)
    return np.array([one.place_m for one in chosen])


def outcome(split: str, family: str, number: int, design: str) -> dict[str, Any]:
    """Return one search as a row."""
    started = time.process_time()
    drawn = trial(split, family, number)
    survey, found = flown(drawn, design)
    releases = []
    for place, rate in zip(drawn.places_m.tolist(), drawn.rates_g_s.tolist(), strict=True):
        if not found.releases:
            continue
        near = min(found.releases, key=lambda one: math.dist(one.place_m, place))
        releases.append({
            'error_m': math.dist(near.place_m, place),
            'region_m': near.region_radius_m,
            'is_held': near.holds(*place),
            'rate_ratio': near.rate_g_s / rate,
            'is_rate_held': near.rate_low_g_s <= rate <= near.rate_high_g_s,
        })  # fmt: skip
    values = survey.values_g_m3 - np.median(survey.values_g_m3)
    return {
        'split': split, 'family': family, 'number': number, 'design': design,
        'stability': drawn.true_stability, 'readings': len(survey.values_g_m3),
        'hits': int((values > 6.0 * NOISE_G_M3).sum()), 'true': len(drawn.rates_g_s),
        'found': len(found.releases), 'gains': list(found.gains), 'releases': releases,
        'hidden': found.hidden.share,
        'cpu_s': time.process_time() - started,
    }  # fmt: skip


def print_rows(rows: list[dict[str, Any]]) -> None:
    """Print a table of families and designs."""
    print('| design | family | searches | found | right number | error, m | region held '
          '| rate | rate held | region radius, m |')  # fmt: skip
    print('|---|---|---|---|---|---|---|---|---|---|')
    for design in dict.fromkeys(row['design'] for row in rows):
        for family in (*FAMILIES, 'all with one'):
            own = [
                row for row in rows
                if row['design'] == design
                and (row['family'] == family or (family == 'all with one' and row['true'] == 1))
            ]  # fmt: skip
            if own:
                print(f'| {design} | {family} | {_cells(own)} |')


def _cells(rows: list[dict[str, Any]]) -> str:
    near = [one for row in rows for one in row['releases']]

    def median(name: str) -> str:
        return f'{np.median([one[name] for one in near]):.2f}' if near else ''

    def mean(name: str) -> str:
        return f'{sum(one[name] for one in near)} of {len(near)}'

    cells = (
        len(rows), sum(row['found'] > 0 for row in rows),
        sum(row['found'] == row['true'] for row in rows), median('error_m'), mean('is_held'),
        median('rate_ratio'), mean('is_rate_held'), median('region_m'),
    )  # fmt: skip
    return ' | '.join(str(cell) for cell in cells)


def main() -> int:
    """Run searches that are not in the file, and print the table of all of this split."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument('--split', choices=SPLITS, default='develop')
    parser.add_argument('--first', type=int, default=0)
    parser.add_argument('--count', type=int, default=8)
    parser.add_argument('--designs', default='mower,search')
    parser.add_argument('--families', default=','.join(FAMILIES))
    parser.add_argument('--out', type=Path, default=Path('release_search.jsonl'))
    arguments = parser.parse_args()
    rows = []
    if arguments.out.exists():
        rows = [json.loads(line) for line in arguments.out.read_text().splitlines()]
    done = {(row['split'], row['family'], row['number'], row['design']) for row in rows}
    for number in range(arguments.first, arguments.first + arguments.count):
        for family in arguments.families.split(','):
            for design in arguments.designs.split(','):
                if (arguments.split, family, number, design) in done:
                    continue
                rows.append(outcome(arguments.split, family, number, design))
                with arguments.out.open('a') as stream:
                    stream.write(json.dumps(rows[-1]) + '\n')
    print_rows([row for row in rows if row['split'] == arguments.split])
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
