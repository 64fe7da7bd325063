# SPDX-License-Identifier: Apache-2.0
"""The estimator on flown tracks: ratemeters that smooth, clocks that differ, gains that fall.

    OMP_NUM_THREADS=1 python benchmarks/radiation_lag.py --count 24
    OMP_NUM_THREADS=1 python benchmarks/radiation_lag.py --split opened --families smooth5 both

A drone flies lines to and fro, 3 to 8 m/s, 15 to 45 m high, about 441 readings of a second, over 0
to 3 sources of 1 to 50 GBq two heights apart or more, in this order; the weakest gives 30 or more
uncollided counts at its nearest reading. Fixes are off by 1.5 m in each of three axes. Even
surveys tell counts, odd ones dose rates alone. The law of the dose rate is that of
``radiation_families``.

``plain``
    Nothing else.
``smooth2``, ``smooth5``, ``smooth10``
    Readings are running means that forget by a factor of e in so many seconds.
``box``
    Readings are means of the last 3 to 10 s.
``late``, ``early``
    The clock of the readings is 0.5 to 2 s behind that of the places, or ahead of it.
``both``
    A smoothing time of 1 to 10 s, and a clock off by up to 2 s either way.
``gain``
    The detector shows 20 to 40 % less at the end than at the start, where it was calibrated.
``tube``
    A Geiger tube of 1 to 6 counts a second for 1 uSv/h, over sources as many times stronger; half
    of these smooth.

The table: share of surveys with the right number of sources; share of sources within their 95 %
ellipse and strength interval where it is right; median of the strength over the true one; median
half axis; share of surveys that are enough, and how many of these are wrong: another number, or a
source outside its ellipse by half of it or more; surveys with a stated probability of the number
above 0.99 that is wrong; mean processor time.
"""

import os

# As `rocsafe localize` does.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

import argparse
import math
import time
from dataclasses import dataclass, field

import numpy as np
from radiation_families import FEWEST_COUNTS, NUCLIDES, law

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.decision.sequential_decision import sequential_evidence
from rocsafe_radiation.decision.stopping import StoppingRule
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.localize import LocalizationOptions, localize
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.readings.survey import LocalReading, survey_of

FIRST_SEEDS = {'develop': 0, 'validate': 10_000, 'opened': 20_000}
SEED = 4711
FIX_STD_M, READINGS = 1.5, 441
NUCLIDE = 'Cs-137'
QUANTILE_95 = 5.991
SMOOTHING_S = {'smooth2': 2.0, 'smooth5': 5.0, 'smooth10': 10.0}
FAMILIES = (
    'plain',
    'smooth2',
    'smooth5',
    'smooth10',
    'box',
    'late',
    'early',
    'both',
    'gain',
    'tube',
)

Generator = np.random.Generator


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """Readings, counts a second for 1 uSv/h (0: not told) and sources (k, 4)."""

    readings: list[LocalReading]
    sensitivity: float
    sources: FloatArray


def track(generator: Generator, height_m: float) -> tuple[FloatArray, FloatArray]:
    """Return places each tenth of a second along lines flown to and fro, and their times."""
    speed = generator.uniform(3.0, 8.0)
    spacing = height_m * generator.uniform(0.5, 1.2)
    length = speed * READINGS
    across = max(5, round(math.sqrt(length / spacing / generator.uniform(1.0, 2.5))))
    line = length / across - spacing
    corners = np.array(
        [[line * (((k + 1) // 2) % 2), spacing * (k // 2)] for k in range(2 * across)]
    )
    ways = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    times = np.arange(0.0, ways[-1] / speed, 0.1)
    plane = np.stack([np.interp(speed * times, ways, axis) for axis in corners.T], axis=1)
    ups = height_m + np.interp(times, times[::100], generator.normal(0, 0.3, len(times[::100])))
    return np.column_stack([plane, ups]), times


def drawn(family: str, seed: int) -> Drawn:
    """Return the survey `seed` of a family."""
    generator = np.random.default_rng([SEED, FAMILIES.index(family), seed])
    order = seed % 4
    height_m = float(generator.uniform(15.0, 45.0))
    places, times = track(generator, height_m)
    sensitivity = float(generator.choice([200.0, 550.0, 1000.0]))
    stronger = 1.0
    if family == 'tube':
        stronger = sensitivity / generator.uniform(1.0, 6.0)
        sensitivity /= stronger
    sources = drawn_sources(generator, order, places, height_m, sensitivity, stronger)
    angle = generator.uniform(0.0, 2.0 * math.pi)
    half_m = 0.5 * float(np.ptp(places[:, :2], axis=0).max())
    slope = generator.choice([0.0, 0.1]) / half_m
    turned = places[:, 0] * math.cos(angle) + places[:, 1] * math.sin(angle)
    background = generator.uniform(0.06, 0.12) * np.exp(slope * (turned - turned.mean()))
    rates = background * np.exp((height_m - places[:, 2]) / 120.0)
    for source in sources:
        rates = rates + source[3] * law(NUCLIDE, np.linalg.norm(places - source[:3], axis=1))
    if family == 'gain':
        fall = generator.uniform(0.2, 0.4)
        rates = rates * (1.0 - fall * times / times[-1])
    # Counts of each tenth of a second, then of each second.
    fine = generator.poisson(0.1 * sensitivity * rates).astype(float)
    whole = len(fine) // 10
    counts = fine[: 10 * whole].reshape(whole, 10).sum(axis=1)
    smoothing_s = SMOOTHING_S.get(family, 0.0)
    if family == 'both' or (family == 'tube' and seed % 8 >= 4):
        smoothing_s = float(generator.uniform(1.0, 10.0))
    if smoothing_s:
        counts = _running(counts, smoothing_s)
    if family == 'box':
        width = int(generator.integers(3, 11))
        sums = np.concatenate([np.zeros(width), np.cumsum(counts)])
        counts = (sums[width:] - sums[:-width]) / width
        counts[:width] = counts[width]
    delay_s = {
        'late': generator.uniform(0.5, 2.0),
        'early': -generator.uniform(0.5, 2.0),
        'both': generator.uniform(-2.0, 2.0),
    }.get(family, 0.0)
    # The stamp is the middle of the second; late: the place is that of a later moment.
    stamps = times[: 10 * whole : 10] + 0.5
    at = np.clip(stamps + delay_s, times[0], times[-1])
    stated = np.stack([np.interp(at, times, axis) for axis in places.T], axis=1)
    stated += generator.normal(0.0, FIX_STD_M, stated.shape)
    has_counts = seed % 2 == 0
    digits = int(generator.choice([3, 4]))
    readings = [
        LocalReading(
            position_enu_m=tuple(place),
            dose_rate_usvh=math.nan if has_counts else round(count / sensitivity, digits),
            counts=round(count, 2) if has_counts else 0.0,
            live_time_s=1.0 if has_counts else math.nan,
            time_s=stamp,
        )
        for place, count, stamp in zip(
            stated.tolist(), counts.tolist(), stamps.tolist(), strict=True
        )
    ]
    return Drawn(
        readings=readings, sensitivity=sensitivity if has_counts else 0.0, sources=sources
    )


def _running(counts: FloatArray, smoothing_s: float) -> FloatArray:
    kept = math.exp(-1.0 / smoothing_s)
    value, found = float(counts[:10].mean()), []
    for count in counts:
        value = kept * value + (1.0 - kept) * count
        found.append(value)
    return np.array(found)


def drawn_sources(
    generator: Generator,
    order: int,
    places: FloatArray,
    height_m: float,
    sensitivity: float,
    stronger: float,
) -> FloatArray:
    """Return sources (order, 4), two heights apart or more, that are counted."""
    low, high = places[:, :2].min(axis=0), places[:, :2].max(axis=0)
    usvh, per_m = NUCLIDES[NUCLIDE][:2]
    while True:
        plane = generator.uniform(low, high, (order, 2))
        ups = np.abs(generator.normal(0.5, 0.5, order))
        strengths = usvh * stronger * np.exp(generator.uniform(0.0, math.log(50.0), order))
        sources = np.column_stack([plane, ups, strengths])
        ways = np.hypot(*(plane[:, None] - plane[None]).T)[np.triu_indices(order, 1)]
        away = np.array([np.linalg.norm(places - one[:3], axis=1).min() for one in sources])
        counted = sensitivity * strengths * np.exp(-per_m * away) / np.maximum(away, 1.0) ** 2
        if not (ways < 2.0 * height_m).any() and not (counted < FEWEST_COUNTS).any():
            return sources


@dataclass(slots=True)
class Tally:
    """What came of the surveys of a family."""

    right: list[bool] = field(default_factory=list)
    inside: list[bool] = field(default_factory=list)
    strong: list[bool] = field(default_factory=list)
    ratios: list[float] = field(default_factory=list)
    axes_m: list[float] = field(default_factory=list)
    enough: list[bool] = field(default_factory=list)
    wrong: list[bool] = field(default_factory=list)
    sure: list[bool] = field(default_factory=list)
    cpu_s: list[float] = field(default_factory=list)

    def add(self, one: Drawn) -> None:
        """Localise the sources of a survey and compare."""
        survey = survey_of(one.readings, one.sensitivity)
        options, rule = LocalizationOptions(kernel=Kernel(nuclide=NUCLIDE)), StoppingRule()
        start_s = time.process_time()
        found = localize(survey, options)
        setting = Setting(kernel=options.kernel, source_up_m=options.source_up_m)
        evidence = sequential_evidence(survey, setting, rule.smallest_usvh)
        self.cpu_s.append(time.process_time() - start_s)
        is_right = len(found.sources) == len(one.sources)
        self.right.append(is_right)
        is_wrong = not is_right
        for truth in one.sources if is_right else ():
            ways = [source.position_enu_m[:2] - truth[:2] for source in found.sources]
            nearest = int(np.argmin([way @ way for way in ways]))
            source, way = found.sources[nearest], ways[nearest]
            square = float(way @ np.linalg.solve(source.covariance_m2[:2, :2], way))
            low, high = source.interval_95_usvh()
            self.inside.append(square < QUANTILE_95)
            self.strong.append(low < truth[3] < high)
            self.ratios.append(source.dose_rate_at_1m_usvh / truth[3])
            self.axes_m.append(source.ellipse_95()[0])
            is_wrong |= square > 1.5**2 * QUANTILE_95
        self.enough.append(rule.verdict(found, evidence).is_enough)
        self.wrong.append(is_wrong and self.enough[-1])
        self.sure.append(not is_right and max(found.order_probabilities) > 0.99)

    def row(self, family: str) -> str:
        """Return the row of the table."""
        shares = [
            float(np.mean(part)) if part else np.nan
            for part in (self.right, self.inside, self.strong)
        ]
        cells = [f'{family:9s} {len(self.right):4d}', *(f'{share:6.3f}' for share in shares)]
        cells += [f'{np.median(self.ratios):6.2f} {np.median(self.axes_m):6.2f}']
        cells += [f'{np.mean(self.enough):6.2f} {sum(self.wrong):5d} {sum(self.sure):5d}']
        return '  '.join([*cells, f'{np.mean(self.cpu_s):6.2f}'])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--split', choices=FIRST_SEEDS, default='develop')
    parser.add_argument('--families', choices=FAMILIES, nargs='+', default=list(FAMILIES))
    parser.add_argument('--count', type=int, default=16, help='surveys of each family')
    parser.add_argument('--first', type=int, default=0, help='number of the first in its split')
    options = parser.parse_args()
    print('family       n   right  ellipse strength ratio axis m enough wrong  sure   CPU s')
    for family in options.families:
        tally, first = Tally(), FIRST_SEEDS[options.split] + options.first
        for seed in range(first, first + options.count):
            tally.add(drawn(family, seed))
        print(tally.row(family), flush=True)


if __name__ == '__main__':
    main()
