# SPDX-License-Identifier: Apache-2.0
"""Releases of other kinds found in simulated surveys: particles, and a release that moves.

    python benchmarks/release_kinds.py [--family particles] [--split develop] [--first 0]
                                       [--count 40] [--out FILE]

Air, eddies, patterns and what is told wrongly of the air are those of release_families.py, the
truth is filaments. Every fourth survey has no release, the others one. Families:

    particles   1e8 to 1e10 particles a second, that fall with 1 to 50 mm/s and decay by up to 0.01
                a second; both told wrongly by a factor (standard deviation of its logarithm 0.5).
                Counters of 1 l/min, 60 readings of 2 to 10 s, count one in 70 ml of air with a
                natural background that wanders.
    moves       gas of 1 to 8 g/s from a vehicle of 0.3 to 3 m/s on a straight line through the
                ground, 90 readings along two patterns one after the other.
    steady      the same as `moves`, but the vehicle stands.

Splits have seeds of their own: ``develop`` and ``validate`` may be looked at while a method is
changed, ``opened`` only once. One line of JSON for each survey is added to FILE; surveys that are
there are not run again.
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
from release_families import (
    ANEMOMETER_M,
    OLDEST_S,
    RELEASE_M,
    RELEASES_WITHIN_M,
    Trial,
    lawn_mower,
    trial,
)
from release_search import AREA, told_layer

from rocsafe_dispersion.detection.particle_counter import ParticleCounter
from rocsafe_dispersion.estimation.amount import PARTICLES, counted_per_m3
from rocsafe_dispersion.estimation.gas_survey import GasSurvey, point_survey
from rocsafe_dispersion.estimation.locate import LocatedReleases, locate_releases
from rocsafe_dispersion.estimation.release_options import LocateOptions
from rocsafe_dispersion.mission_gas.stopping import ReleaseRule
from rocsafe_dispersion.plume.filaments import FilamentCloud
from rocsafe_dispersion.plume.losses import NO_LOSSES, Losses
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_geo.arrays import FloatArray

SEEDS = {'develop': 31, 'validate': 32, 'opened': 33}
INSTANTS = 8
# Numbers of the trials of release_families.py with one release, far from those that it shows.
FIRST_TRIAL = 4001


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drawn:
    """A survey, what is told of the losses, and the release; None: there is none.

    `track_m` (n, 2) is where the release was at each reading; `seen` are the readings whose gas or
    particles are above five noises of the detector.
    """

    trial: Trial
    survey: GasSurvey
    told: Losses
    track_m: FloatArray | None
    rate: float
    seen: int


def particles(split: str, number: int) -> Drawn:
    """Return counts of particles that settle and decay."""
    generator = np.random.default_rng([SEEDS[split], number])
    drawn = trial(split, FIRST_TRIAL + 4 * number)
    settling, decay = math.exp(generator.uniform(-6.9, -3.0)), generator.uniform(0.0, 0.01)
    wrong = np.exp(0.5 * generator.standard_normal(2))
    rate = math.exp(generator.uniform(math.log(1e8), math.log(1e10)))
    place = generator.uniform(-RELEASES_WITHIN_M, RELEASES_WITHIN_M, 2)
    cloud = _cloud(drawn, Losses(settling_mps=settling, decay_per_s=decay), place, rate)
    places = drawn.places()
    times: FloatArray = np.asarray(OLDEST_S + drawn.between_s * np.arange(float(len(places))))
    counter, is_there = ParticleCounter(), number % 4 > 0
    litres = counter.flow_l_min / 60.0 * counter.efficiency * drawn.reading_s
    means = _means(cloud, places, times, drawn.reading_s) if is_there else np.zeros(len(places))
    rho = math.exp(-drawn.between_s / counter.background_s)
    wander = np.zeros(len(places))
    wander[0] = generator.standard_normal()
    for one in range(1, len(places)):
        step = math.sqrt(1.0 - rho * rho) * generator.standard_normal()
        wander[one] = rho * wander[one - 1] + step
    natural = np.exp(counter.background_scatter * wander)
    natural *= counter.background_per_l * counter.fluorescent_share
    counts = generator.poisson(litres * (natural + means / 1000.0)).astype(float)
    values, noise = counted_per_m3(counts, np.full(len(places), litres))
    survey = _survey(drawn, places, values, noise, times, generator)
    return Drawn(
        trial=drawn, survey=replace(survey, amount=PARTICLES), rate=rate,
        told=Losses(settling_mps=settling * wrong[0], decay_per_s=decay * wrong[1]),
        track_m=np.tile(place, (len(places), 1)) if is_there else None,
        seen=int((means > 5.0 * noise).sum()),
    )  # fmt: skip


def moves(split: str, number: int, *, stands: bool = False) -> Drawn:
    """Return readings of gas from a vehicle on a straight line, or that stands."""
    generator = np.random.default_rng([SEEDS[split], 10_000 + number])
    drawn = trial(split, FIRST_TRIAL + 4 * number)
    own = drawn.places()[:45]
    more = np.column_stack([lawn_mower(45)[:, ::-1], np.full(len(lawn_mower(45)), drawn.sensor_m)])
    places = np.concatenate([own, more])
    times: FloatArray = np.asarray(OLDEST_S + drawn.between_s * np.arange(float(len(places))))
    middle = generator.uniform(-0.5 * RELEASES_WITHIN_M, 0.5 * RELEASES_WITHIN_M, 2)
    angle, rate = generator.uniform(0.0, 2.0 * math.pi), math.exp(generator.uniform(0.0, 2.08))
    # It is on the ground searched all the time.
    length = generator.uniform(30.0, 80.0) * (not stands)
    half = length / 2.0 * np.array([math.cos(angle), math.sin(angle)])
    first, last = (np.clip(middle + way, -48.0, 48.0) for way in (-half, half))
    span = float(times[-1])
    track = () if stands else ((span, *last.tolist()),)
    cloud = _cloud(drawn, NO_LOSSES, first, rate, track)
    is_there = number % 4 > 0
    means = _means(cloud, places, times, drawn.reading_s) if is_there else np.zeros(len(places))
    noise = drawn.noise_g_m3
    values = drawn.background_g_m3 + means + noise * generator.standard_normal(len(places))
    survey = _survey(drawn, places, values, np.full(len(places), noise), times, generator)
    way = first + (0.0 if stands else 1.0) * (last - first) * (times / span)[:, None]
    return Drawn(
        trial=drawn, survey=survey, told=NO_LOSSES, track_m=way if is_there else None, rate=rate,
        seen=int((means > 5.0 * noise).sum()),
    )  # fmt: skip


def steady(split: str, number: int) -> Drawn:
    """Return readings of gas from a vehicle that stands."""
    return moves(split, number, stands=True)


FAMILIES: dict[str, Callable[[str, int], Drawn]] = {
    'particles': particles, 'moves': moves, 'steady': steady,
}  # fmt: skip


def _cloud(
    drawn: Trial,
    losses: Losses,
    place_m: FloatArray,
    rate: float,
    track: tuple[tuple[float, float, float], ...] = (),
) -> FilamentCloud:
    """Return filaments in the air of a trial."""
    east, north = place_m.tolist()
    return FilamentCloud(
        Release(place_m=(east, north), height_m=RELEASE_M, rate_g_s=rate, track=track),
        similarity_travel(drawn.wind.layer, RELEASE_M, losses=losses),
        drawn.wind,
        int(1e6 * abs(east)) % 2**31,
        drawn.eddies,
    )


def _means(
    cloud: FilamentCloud, places_m: FloatArray, times_s: FloatArray, reading_s: float
) -> FloatArray:
    offsets = (reading_s / INSTANTS * np.arange(INSTANTS)).tolist()
    return np.array([
        np.mean([cloud.at(time_s + one).concentrations_g_m3(place[None])[0] for one in offsets])
        for time_s, place in zip(times_s.tolist(), places_m, strict=True)
    ])  # fmt: skip


def _survey(
    drawn: Trial,
    places_m: FloatArray,
    values: FloatArray,
    std: FloatArray,
    times_s: FloatArray,
    generator: np.random.Generator,
) -> GasSurvey:
    turns = np.radians(3.0) * generator.standard_normal(len(places_m))
    told = complex(*drawn.told_mps) * np.exp(1j * turns)
    winds = np.column_stack([told.real, told.imag])
    return point_survey(places_m, winds, values, std, times_s)


def outcome(family: str, split: str, number: int) -> dict[str, Any]:
    """Return what is told of one survey as a row."""
    drawn = FAMILIES[family](split, number)
    started = time.process_time()
    found = locate_releases(
        drawn.survey, AREA, told_layer(drawn.trial), anemometer_m=ANEMOMETER_M,
        losses=drawn.told, options=LocateOptions(most_releases=1),
    )  # fmt: skip
    row = {
        'family': family, 'split': split, 'number': number,
        'is_there': drawn.track_m is not None, 'seen': drawn.seen, 'told': len(found.releases),
        'is_enough': ReleaseRule().verdict(found).is_enough,
        'cpu_s': time.process_time() - started,
    }  # fmt: skip
    return row | _errors(drawn, found)


def _errors(drawn: Drawn, found: LocatedReleases) -> dict[str, Any]:
    if drawn.track_m is None or not found.releases:
        return {}
    (release,) = found.releases
    last, middle = drawn.track_m[-1].tolist(), drawn.track_m.mean(axis=0).tolist()
    return {
        'error_m': math.dist(release.place_m, last),
        'middle_error_m': math.dist(release.place_m, middle),
        'is_held': release.holds(*last),
        'radius_m': release.region_radius_m,
        'rate_ratio': release.rate_g_s / drawn.rate,
        'is_rate_held': release.rate_low_g_s <= drawn.rate <= release.rate_high_g_s,
        'doubted': found.gain_of_places <= 0.0,
        'moves': getattr(release, 'moves', 0.0),
    }


def print_rows(family: str, rows: list[dict[str, Any]]) -> None:
    """Print what was found in the surveys of a family."""
    there = [row for row in rows if row['is_there']]
    clean = [row for row in rows if not row['is_there']]
    told = [row for row in there if row['told']]
    seen = [row for row in there if row['seen'] >= 2]
    print(f'{family}: {len(rows)} surveys, {len(told)} of {len(there)} found, '
          f'{sum(r["told"] for r in seen)} of {len(seen)} with two readings above five noises, '
          f'{sum(row["told"] for row in clean)} of {len(clean)} told without')  # fmt: skip
    if told:
        errors, radii = ([row[name] for row in told] for name in ('error_m', 'radius_m'))
        print(f'  error of the last place, median: {np.median(errors):.1f} m; '
              f'in the region of 95 %: {sum(r["is_held"] for r in told)} of {len(told)}; '
              f'region, median: {np.median(radii):.1f} m')  # fmt: skip
        print(f'  rate in its interval: {sum(r["is_rate_held"] for r in told)} of {len(told)}; '
              f'told / true, median: {np.median([row["rate_ratio"] for row in told]):.2f}; '
              f'enough: {sum(r["is_enough"] for r in told)}, of these not held: '
              f'{sum(r["is_enough"] and not r["is_held"] for r in told)}')  # fmt: skip
    if told and 'moves' in told[0]:
        print(f'  rather moves: {sum(r["moves"] > 0.5 for r in told)} of {len(told)}')
    print(f'  CPU-s, mean: {np.mean([row["cpu_s"] for row in rows]):.2f}')


def main() -> int:
    """Run surveys that are not in the file, and print those of the family and split."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument('--family', choices=FAMILIES, default='particles')
    parser.add_argument('--split', choices=SEEDS, default='develop')
    parser.add_argument('--first', type=int, default=0)
    parser.add_argument('--count', type=int, default=40)
    parser.add_argument('--out', type=Path, default=Path('release_kinds.jsonl'))
    given = parser.parse_args()
    rows = []
    if given.out.exists():
        rows = [json.loads(line) for line in given.out.read_text().splitlines()]
    own = [row for row in rows if (row['family'], row['split']) == (given.family, given.split)]
    done = {row['number'] for row in own}
    for number in range(given.first, given.first + given.count):
        if number not in done:
            own.append(outcome(given.family, given.split, number))
            with given.out.open('a') as stream:
                stream.write(json.dumps(own[-1]) + '\n')
    print_rows(given.family, own)
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
