# SPDX-License-Identifier: Apache-2.0
"""The estimator on readings of detectors: climbs beside strong sources, and dark counts.

    OMP_NUM_THREADS=1 python benchmarks/radiation_detectors.py --families climb --count 60
    OMP_NUM_THREADS=1 python benchmarks/radiation_detectors.py --split validate --families dark

Surveys are drawn from seeds; each split has seeds of its own.

``climb``
    A scintillator without an energy window (190 or 550 counts a second for 1 uSv/h), which counts
    what air and soil scatter as the simulated ones do, over 0 to 2 sources of 10 GBq to 1 TBq of
    caesium, cobalt or iridium: climb at a corner, a level grid or one of two heights, descent.
    Fixes are off by 0.02, 0.5 or 1.5 m, which the estimator knows.
``dark``
    A tube of 2 to 60 counts a second for 1 uSv/h whose dark counts are 0 to 0.15 uSv/h, over none
    or one source; dose rates rounded to 0.01 or 0.001 uSv/h or not at all. 0.3 counts or more of
    background in a window.

The table: share of surveys with the right number of sources and without a doubt; share of sources
within their 95 % ellipse and strength interval, where the number is right; median of the stated
background over the true one, share of backgrounds within two standard deviations; mean processor
time.
"""

import os

# As `rocsafe localize` does.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.detection.detector import (
    NON_PARALYSABLE,
    SCINTILLATOR_RESPONSE,
    DetectorModel,
    measure,
)
from rocsafe_radiation.localization.localize import LocalizationOptions, localize
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.physics.scatter import counts_for_dose
from rocsafe_radiation.physics.transmission import air_transmission
from rocsafe_radiation.readings.survey import LocalReading, survey_of

FIRST_SEEDS = {'develop': 0, 'validate': 10_000, 'opened': 20_000}
SEED = 666
USVH_OF_1_GBQ = 92.5
NUCLIDES, SHARES = ('Cs-137', 'Co-60', 'Ir-192'), (0.7, 0.15, 0.15)
QUANTILE_95 = 5.991

Generator = np.random.Generator


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """Readings, what is known before, sources (k, 4) and the true mean background, uSv/h."""

    readings: list[LocalReading]
    options: LocalizationOptions
    sources: FloatArray
    background_usvh: float


@dataclass(slots=True)
class Tally:
    """What came of the surveys of a family."""

    right: list[bool] = field(default_factory=list)
    sure: list[bool] = field(default_factory=list)
    inside: list[bool] = field(default_factory=list)
    strong: list[bool] = field(default_factory=list)
    levels: list[float] = field(default_factory=list)
    near: list[bool] = field(default_factory=list)
    cpu_s: list[float] = field(default_factory=list)

    def add(self, one: Drawn) -> None:
        """Localise the sources of a survey and compare."""
        start_s = time.process_time()
        found = localize(survey_of(one.readings), one.options)
        self.cpu_s.append(time.process_time() - start_s)
        self.right.append(len(found.sources) == len(one.sources))
        self.sure.append(not found.doubts)
        miss = found.background_usvh - one.background_usvh
        self.levels.append(found.background_usvh / one.background_usvh)
        self.near.append(abs(miss) < 2.0 * found.background_std_usvh)
        for truth in one.sources if self.right[-1] else ():
            ways = [source.position_enu_m[:2] - truth[:2] for source in found.sources]
            nearest = int(np.argmin([way @ way for way in ways]))
            source, way = found.sources[nearest], ways[nearest]
            square = float(way @ np.linalg.solve(source.covariance_m2[:2, :2], way))
            low, high = source.interval_95_usvh()
            self.inside.append(square < QUANTILE_95)
            self.strong.append(low < truth[3] < high)

    def row(self, family: str) -> str:
        """Return the row of the table."""
        parts = (self.right, self.sure, self.inside, self.strong)
        shares = [float(np.mean(part)) if part else np.nan for part in parts]
        cells = [family, f'{len(self.right):6d}', *(f'{share:7.3f}' for share in shares)]
        cells += [f'{np.median(self.levels):7.3f}', f'{np.mean(self.near):7.3f}']
        return '  '.join([*cells, f'{np.mean(self.cpu_s):6.2f}'])


def climb(seed: int) -> Drawn:
    """Return the survey `seed` of a scintillator that climbs beside strong sources."""
    generator = np.random.default_rng([SEED, seed])
    height_m = float(generator.uniform(15.0, 60.0))
    sensitivity_cps = float(generator.choice([190.0, 550.0]))
    nuclide = str(generator.choice(NUCLIDES, p=SHARES))
    places = _level_grid(generator, height_m)
    sources = _sources(generator, seed % 3, places, height_m)
    if generator.uniform() < 0.3:
        places[::2, 2] *= generator.uniform(1.3, 2.0)
    ups = np.arange(0.5, height_m, generator.choice([0.5, 1.0, 2.0]))
    home = np.tile(-generator.uniform(0.0, 40.0, 2), (len(ups), 1))
    way = np.column_stack([home, ups])
    places = np.vstack([way, places, way[::-1]])
    background = generator.uniform(0.06, 0.12) * np.exp((height_m - places[:, 2]) / 120.0)
    rates = background.copy()
    for source in sources:
        away_m = np.linalg.norm(places - source[:3], axis=1)
        above_m = places[:, 2] - source[2]
        counted = counts_for_dose(nuclide, SCINTILLATOR_RESPONSE, above_m, away_m)
        rates += source[3] * air_transmission(nuclide, away_m) / away_m**2 * counted
    counts = generator.poisson(sensitivity_cps * rates)
    fix_std_m = float(generator.choice([0.02, 0.5, 1.5]))
    stated = places + generator.normal(0.0, fix_std_m, places.shape)
    readings = [
        LocalReading(
            position_enu_m=tuple(place),
            dose_rate_usvh=count / sensitivity_cps,
            counts=float(count),
            live_time_s=1.0,
        )
        for place, count in zip(stated.tolist(), counts.tolist(), strict=True)
    ]
    kernel = Kernel(nuclide=nuclide, response=SCINTILLATOR_RESPONSE)
    return Drawn(
        readings=readings,
        options=LocalizationOptions(kernel=kernel, position_std_m=fix_std_m),
        sources=sources,
        background_usvh=float(background.mean()),
    )


def dark(seed: int) -> Drawn:
    """Return the survey `seed` of a tube with dark counts."""
    generator = np.random.default_rng([SEED, seed, 1])
    sensitivity_cps = float(np.exp(generator.uniform(np.log(2.0), np.log(60.0))))
    background = float(generator.uniform(0.06, 0.2))
    window_s = float(generator.choice([1.0, 2.0, 5.0]))
    if sensitivity_cps * background * window_s < 0.3:
        window_s = 5.0
    kind = DetectorModel(
        name='tube',
        sensitivity_cps_per_usvh=sensitivity_cps,
        dead_time_s=1e-4,
        dead_time_model=NON_PARALYSABLE,
        dark_rate_cps=sensitivity_cps * float(generator.uniform(0.0, 0.15)),
    )
    height_m = float(generator.uniform(10.0, 30.0))
    places = _level_grid(generator, height_m)
    sources = _sources(generator, seed % 2, places, height_m)
    # One to four times what gives 60 counts and thrice the background below the flight.
    least = height_m**2 * (60.0 / (sensitivity_cps * window_s) + 2.0 * background)
    sources[:, 3] = least * generator.uniform(1.0, 4.0, len(sources))
    rates = np.full(len(places), background)
    for source in sources:
        rates += source[3] / ((places - source[:3]) ** 2).sum(axis=1)
    stated = places + generator.normal(0.0, 1.5, places.shape)
    digits = int(generator.choice([2, 3, 12]))
    readings = []
    for place, rate in zip(stated.tolist(), rates.tolist(), strict=True):
        one = measure(kind, rate, window_s, generator)
        readings.append(
            LocalReading(
                position_enu_m=tuple(place),
                dose_rate_usvh=round(one.dose_rate_usvh, digits),
                dose_rate_std_usvh=one.dose_rate_std_usvh,
                counts=float(one.counts),
                live_time_s=one.live_time_s,
            )
        )
    options = LocalizationOptions(kernel=Kernel(is_lossy=False))
    return Drawn(readings=readings, options=options, sources=sources, background_usvh=background)


def _level_grid(generator: Generator, height_m: float) -> FloatArray:
    """Return 13 x 13 to 20 x 20 places, 0.3 to 0.6 heights apart, shape (n, 3)."""
    axis = height_m * generator.uniform(0.3, 0.6) * np.arange(generator.integers(13, 21))
    east, north = (part.ravel() for part in np.meshgrid(axis, axis))
    ups = height_m * np.exp(generator.normal(0.0, 0.02, east.size))
    return np.column_stack([east, north, ups])


def _sources(generator: Generator, count: int, places: FloatArray, height_m: float) -> FloatArray:
    """Return sources two heights apart or more, of 10 GBq to 1 TBq, shape (count, 4)."""
    side_m = float(places[:, 0].max())
    while True:
        plane = side_m * generator.uniform(0.1, 0.9, (count, 2))
        ways = plane[:, None] - plane[None]
        distances = np.hypot(*ways.T)[np.triu_indices(count, 1)]
        if not (distances < 2.0 * height_m).any():
            break
    ups = np.abs(generator.normal(0.5, 0.5, count))
    strengths = USVH_OF_1_GBQ * 10.0 ** generator.uniform(1.0, 3.0, count)
    return np.column_stack([plane, ups, strengths])


FAMILIES: dict[str, Callable[[int], Drawn]] = {'climb': climb, 'dark': dark}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--split', choices=FIRST_SEEDS, default='develop')
    parser.add_argument('--families', choices=FAMILIES, nargs='+', default=list(FAMILIES))
    parser.add_argument('--count', type=int, default=40, help='surveys of each family')
    options = parser.parse_args()
    print('family       n    right     sure  ellipse strength  level     near   CPU s')
    for family in options.families:
        tally, first = Tally(), FIRST_SEEDS[options.split]
        for seed in range(first, first + options.count):
            tally.add(FAMILIES[family](seed))
        print(tally.row(f'{family:5s}'), flush=True)


if __name__ == '__main__':
    main()
