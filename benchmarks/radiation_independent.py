# SPDX-License-Identifier: Apache-2.0
"""The shipped command on surveys of a simulator that shares nothing with the estimator.

    OMP_NUM_THREADS=1 python benchmarks/radiation_independent.py --count 36
    OMP_NUM_THREADS=1 python benchmarks/radiation_independent.py --kinds plate tank box --out FILE

Each survey is written as a CSV file and read by ``rocsafe localize FILE --ground --sensitivity
--json``, which has its defaults otherwise. Independent of the estimator are the law of the dose
rate (caesium in air, Berger's build-up replaced by a rational one), backgrounds, steel, the
places in degrees (geodesics of pyproj) and the bound.

A survey has 441 readings of 1 s on a grid of 100 x 230 m, each 0.3 m off it, 15 to 45 m high, and
fixes off by 1.5 m in each of three axes; 200, 550 or 1000 counts a second for 1 uSv/h. The
background is 0.06 to 0.12 uSv/h: even, waves of 80 to 300 m, a slope, or one to three hills and
hollows, by 5 to 20 %. There are 0 to 3 sources of 1 to 50 GBq, 0 to 1.2 m up, two heights apart or
more; the weakest gives 30 or more uncollided counts at its nearest reading. With ``--kinds`` there
is one source, over even background or waves, beside an upright plate (0.2 to 1.5 mean free paths
thick), in a tank (0.2 to 1.2, up to 2.5 times as much along it) or in the corner of a box (0.3 to
1.5). Survey i is of the kind i modulo their number; '' is without steel.

The table says for each background or steel and each number of sources how often the number is
right; in how many surveys without a source there was one; error over bound (root mean square,
median); in how many of the ellipses and intervals of the strength the truth lies; in how many
surveys the evidence was called enough, and in how many of these the number is right and all
ellipses hold; in which share the bound would allow half axes under 5 m; the median half axis and
the mean processor time. The bound is that of Cramer and Rao with an unknown background; it leaves
steel out. A second table tells how often the number is right by the probability stated.
"""

import os

# As `rocsafe localize` does.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

import argparse
import contextlib
import io
import itertools
import json
import math
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pyproj import Geod

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.command_line import localize_command

LATITUDE_DEG, LONGITUDE_DEG, GROUND_M = 47.3, 8.5, 412.0
GEODESICS = Geod(ellps='WGS84')
HALF_EAST_M, HALF_NORTH_M, LINES = 50.0, 115.0, 21
READINGS = LINES**2
PLACE_STD_M, FIX_STD_M = 0.3, 1.5
SENSITIVITIES_CPS = (200.0, 550.0, 1000.0)
# Of 662 keV: 0.00775 m2/kg by 1.215 kg/m3 of air; H*(10) at 1 m of 1 GBq.
ATTENUATION_PER_M = 0.00775 * 1.215
USVH_OF_1_GBQ = 92.5
LARGEST_ACTIVITY_GBQ = 50.0
FEWEST_COUNTS, LEAST_SEPARATION_HEIGHTS = 30.0, 2.0
# What the bound knows: the length of an uneven background, the standard deviations of its slope
# over HALF_NORTH_M and of a source's height.
LENGTH_M, SLOPE_STD, SOURCE_UP_STD_M = 35.0, 0.5, 1.0
QUANTILE_95, SMALL_AXIS_M = 5.991, 5.0
# Bins of stated probabilities.
CHANCES = (0.0, 0.9, 0.99, 0.999, math.inf)
SEED = 777

Generator = np.random.Generator


@dataclass(frozen=True, slots=True, kw_only=True)
class Background:
    """Kind, dose rate at each reading in uSv/h, and largest deviation over the level."""

    kind: str
    rates_usvh: FloatArray
    unevenness: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """A survey with its truth.

    Attributes
    ----------
    seed, kind
        Number of the survey, and its steel, or its background if there is none.
    height_m, sensitivity_cps
        Height of the flight above the ground, counts a second for 1 uSv/h.
    stated_m, counts
        East, north, up of the readings as the fixes state it, shape (n, 3), and counts, (n,).
    sources
        East, north, up in metres and uSv/h at 1 m of each source, shape (k, 4).
    bound_m2
        Bound of the covariance of east and north of each, shape (k, 2, 2).
    """

    seed: int
    kind: str
    height_m: float
    sensitivity_cps: float
    stated_m: FloatArray
    counts: FloatArray
    sources: FloatArray
    bound_m2: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What the command made of one survey.

    Attributes
    ----------
    seed, kind, height_m
        What it is of.
    order, found, probabilities
        True and stated number of sources, stated probability of each number.
    is_enough, verdict, doubts
        What is said of the evidence.
    cpu_s
        Processor time.
    bound_axes_m
        Longest half axis of the 95 % ellipse that the bound allows, for each source.
    errors, squares, axes_m, strengths
        For each source, if the number is right, of the nearest that was found: distance over the
        bound, squared distance by its covariance, longest half axis of its 95 % ellipse, and
        whether the strength lies in its interval.
    """

    seed: int
    kind: str
    height_m: float
    order: int
    found: int
    probabilities: list[float]
    is_enough: bool
    verdict: str
    doubts: list[str]
    cpu_s: float
    bound_axes_m: list[float]
    errors: list[float]
    squares: list[float]
    axes_m: list[float]
    strengths: list[bool]


def law(distances_m: FloatArray) -> FloatArray:
    """Return the dose rate at distances for 1 uSv/h at 1 m, scattered photons included."""
    paths = ATTENUATION_PER_M * distances_m
    build_up = 1.0 + 1.0 * paths + 0.285 * paths * paths / (1.0 + 0.02 * paths)
    return np.asarray(np.exp(-paths) * build_up / distances_m**2)


def law_slope(distances_m: FloatArray) -> FloatArray:
    """Return the derivative of ``law`` by the distance."""
    step_m = 1e-3
    return np.asarray((law(distances_m + step_m) - law(distances_m - step_m)) / (2.0 * step_m))


def drawn(seed: int, steel: str, alike: float = 0.0) -> Drawn:
    """Return the survey with number `seed`, with steel of a kind or, if this is '', without.

    The error of each fix is by the share `alike` that of the fix before, a second earlier. The
    order of the draws is part of the benchmark: a seed stays the same survey.
    """
    generator = np.random.default_rng([SEED, seed, len(steel)])
    height_m = float(generator.uniform(15.0, 45.0))
    sensitivity_cps = float(generator.choice(SENSITIVITIES_CPS))
    places = _flown(generator, height_m)
    order = 1 if steel else int(generator.integers(0, 4))
    # Drawn beside steel, too, and not used there: results name surveys by their seeds.
    kind = list(PATTERNS)[int(generator.integers(4))]
    background = _background(generator, list(PATTERNS)[seed % 2] if steel else kind, places)
    sources = _sources(generator, order, places, height_m, sensitivity_cps)
    rates = _rates(generator, background, sources, places, steel)
    counts = generator.poisson(rates * sensitivity_cps).astype(float)
    errors_m = generator.normal(0.0, FIX_STD_M, places.shape)
    for row in range(1, len(errors_m)):
        errors_m[row] = alike * errors_m[row - 1] + math.sqrt(1.0 - alike**2) * errors_m[row]
    return Drawn(
        seed=seed,
        kind=steel or kind,
        height_m=height_m,
        sensitivity_cps=sensitivity_cps,
        stated_m=places + errors_m,
        counts=counts,
        sources=sources,
        bound_m2=_bound(sources, places, background, sensitivity_cps),
    )


def _flown(generator: Generator, height_m: float) -> FloatArray:
    east, north = np.meshgrid(
        np.linspace(-HALF_EAST_M, HALF_EAST_M, LINES),
        np.linspace(-HALF_NORTH_M, HALF_NORTH_M, LINES),
    )
    places = np.column_stack([east.ravel(), north.ravel(), np.full(READINGS, height_m)])
    return np.asarray(places + generator.normal(0.0, PLACE_STD_M, places.shape))


def _background(generator: Generator, kind: str, places: FloatArray) -> Background:
    level_usvh = generator.uniform(0.06, 0.12)
    unevenness = float(generator.uniform(0.05, 0.2))
    pattern = PATTERNS[kind](generator, places)
    shares = unevenness * pattern / max(float(np.abs(pattern).max()), 1e-9)
    return Background(kind=kind, rates_usvh=level_usvh * (1.0 + shares), unevenness=unevenness)


def _even(_: Generator, places: FloatArray) -> FloatArray:
    return np.zeros(len(places))


def _waves(generator: Generator, places: FloatArray) -> FloatArray:
    pattern = np.zeros(len(places))
    for _ in range(8):
        length_m = generator.uniform(80.0, 300.0)
        along_m = _slope(generator, places)
        pattern += np.cos(2.0 * np.pi * along_m / length_m + generator.uniform(0.0, 6.28))
    return pattern


def _slope(generator: Generator, places: FloatArray) -> FloatArray:
    angle = generator.uniform(0.0, 2.0 * np.pi)
    return np.asarray(places[:, 0] * np.cos(angle) + places[:, 1] * np.sin(angle))


def _hills(generator: Generator, places: FloatArray) -> FloatArray:
    pattern = np.zeros(len(places))
    for _ in range(int(generator.integers(1, 4))):
        middle = places[generator.integers(len(places)), :2]
        squares = ((places[:, :2] - middle) ** 2).sum(axis=1)
        sign = generator.choice([-1, 1])
        pattern += sign * np.exp(-squares / 2.0 / generator.uniform(15.0, 50.0) ** 2)
    return pattern


PATTERNS: dict[str, Callable[[Generator, FloatArray], FloatArray]] = {
    'even': _even,
    'waves': _waves,
    'slope': _slope,
    'hills': _hills,
}


def _sources(
    generator: Generator, order: int, places: FloatArray, height_m: float, sensitivity_cps: float
) -> FloatArray:
    while True:
        east = generator.uniform(-45.0, 45.0, order)
        north = generator.uniform(-110.0, 110.0, order)
        up = generator.uniform(0.0, 1.2, order)
        activities_gbq = np.exp(generator.uniform(0.0, np.log(LARGEST_ACTIVITY_GBQ), order))
        sources = np.column_stack([east, north, up, USVH_OF_1_GBQ * activities_gbq])
        if _is_counted(sources, places, sensitivity_cps) and _is_apart(sources, height_m):
            return sources


def _is_counted(sources: FloatArray, places: FloatArray, sensitivity_cps: float) -> bool:
    for source in sources:
        nearest_m = float(np.linalg.norm(places - source[:3], axis=1).min())
        uncollided = math.exp(-ATTENUATION_PER_M * nearest_m) / nearest_m**2
        if sensitivity_cps * source[3] * uncollided < FEWEST_COUNTS:
            return False
    return True


def _is_apart(sources: FloatArray, height_m: float) -> bool:
    ways_m = [
        np.hypot(*(source[:2] - other[:2]))
        for index, source in enumerate(sources)
        for other in sources[:index]
    ]
    return all(way_m >= LEAST_SEPARATION_HEIGHTS * height_m for way_m in ways_m)


def _rates(
    generator: Generator,
    background: Background,
    sources: FloatArray,
    places: FloatArray,
    steel: str,
) -> FloatArray:
    total = background.rates_usvh
    for source in sources:
        rays = places - source[:3]
        rates = source[3] * law(np.linalg.norm(rays, axis=1))
        total = total + rates * (_left_by_steel(generator, rays, steel) if steel else 1.0)
    return total


def _left_by_steel(generator: Generator, rays: FloatArray, steel: str) -> FloatArray:
    """Return the share of each ray that passes, scattered photons included."""
    bearings = np.arctan2(rays[:, 1], rays[:, 0])
    elevations = np.arcsin(rays[:, 2] / np.linalg.norm(rays, axis=1))
    angles = bearings - generator.uniform(-np.pi, np.pi)
    paths = STEELS[steel](generator, angles, elevations)
    return np.asarray(np.exp(-paths) * (1.0 + paths))


def _plate(generator: Generator, angles: FloatArray, elevations: FloatArray) -> FloatArray:
    """Return the mean free paths in an upright plate across the direction 0."""
    top, half = (
        np.radians(generator.uniform(40.0, 75.0)),
        np.radians(generator.uniform(50.0, 85.0)),
    )
    across = np.cos(angles)
    is_below = np.tan(elevations) < np.tan(top) * across.clip(1e-6)
    slants = np.maximum(across * np.cos(elevations), 0.2)
    return np.where((across > np.cos(half)) & is_below, generator.uniform(0.2, 1.5) / slants, 0.0)


def _tank(generator: Generator, angles: FloatArray, elevations: FloatArray) -> FloatArray:
    """Return the mean free paths in a wall all around, thicker along the direction 0."""
    thickness, more = generator.uniform(0.2, 1.2), generator.uniform(0.3, 1.5)
    return np.asarray(thickness * (1.0 + more * np.abs(np.cos(angles)) * np.cos(elevations)))


def _box(generator: Generator, angles: FloatArray, elevations: FloatArray) -> FloatArray:
    """Return the mean free paths in two walls that meet, from the direction 0 on."""
    top = np.radians(generator.uniform(35.0, 70.0))
    thickness, wide = generator.uniform(0.3, 1.5), np.radians(generator.uniform(60.0, 140.0))
    is_hit = (np.mod(angles, 2.0 * np.pi) < wide) & (elevations < top)
    return np.where(is_hit, thickness, 0.0)


STEELS = {'plate': _plate, 'tank': _tank, 'box': _box}


def _bound(
    sources: FloatArray, places: FloatArray, background: Background, sensitivity_cps: float
) -> FloatArray:
    """Return the bound of each source, shape (k, 2, 2): level and slope are unknown, too."""
    order, counted = len(sources), background.rates_usvh * sensitivity_cps
    columns = [counted, *(counted * places[:, axis] / HALF_NORTH_M for axis in (0, 1))]
    expected, slopes = counted, np.zeros_like(places)
    for source in sources:
        rays = places - source[:3]
        distances_m = np.linalg.norm(rays, axis=1)
        own = sensitivity_cps * source[3] * law(distances_m)
        steepness = sensitivity_cps * source[3] * law_slope(distances_m) / distances_m
        own_slopes = steepness[:, None] * rays
        expected, slopes = expected + own, slopes + own_slopes
        columns += [*(-own_slopes.T), own]
    covariance = np.diag(expected + FIX_STD_M**2 * (slopes**2).sum(axis=1))
    if background.kind in ('waves', 'hills'):
        covariance += _covariance(places, background) * np.outer(counted, counted)
    matrix = np.stack(columns, axis=1)
    information = matrix.T @ np.linalg.solve(covariance, matrix)
    known = [0.0, SLOPE_STD**-2, SLOPE_STD**-2, *[0.0, 0.0, SOURCE_UP_STD_M**-2, 0.0] * order]
    inverse = np.linalg.inv(information + np.diag(known))
    blocks = [inverse[at : at + 2, at : at + 2] for at in range(3, 3 + 4 * order, 4)]
    return np.array(blocks).reshape(order, 2, 2)


def _covariance(places: FloatArray, background: Background) -> FloatArray:
    squares = ((places[:, None, :2] - places[None, :, :2]) ** 2).sum(axis=2)
    std = 0.5 * background.unevenness
    return np.asarray(std**2 * np.exp(-squares / 2.0 / LENGTH_M**2))


def outcome(one: Drawn) -> Outcome:
    """Return what the command makes of a survey."""
    document, cpu_s = _localized(one)
    found = document['sources']
    pairs = _pairs(one, found) if len(found) == len(one.sources) else []
    return Outcome(
        seed=one.seed,
        kind=one.kind,
        height_m=one.height_m,
        order=len(one.sources),
        found=len(found),
        probabilities=document['source_count_probability'],
        is_enough=document['is_enough'],
        verdict=document['verdict'],
        doubts=document['doubts'],
        cpu_s=cpu_s,
        bound_axes_m=[
            math.sqrt(QUANTILE_95 * float(np.linalg.eigvalsh(bound)[-1])) for bound in one.bound_m2
        ],
        errors=[_error(one, *pair) for pair in pairs],
        squares=[_square(one.sources[k], estimate) for k, estimate in pairs],
        axes_m=[estimate['ellipse_95_m'][0] for _, estimate in pairs],
        strengths=[_is_within(one.sources[k], estimate) for k, estimate in pairs],
    )


def _localized(one: Drawn) -> tuple[dict[str, Any], float]:
    """Return the document that the command prints, and its processor time in seconds."""
    printed = io.StringIO()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(printed):
        path = Path(folder) / 'readings.csv'
        path.write_text(_table_of_readings(one))
        known = ['--ground', str(GROUND_M), '--sensitivity', str(one.sensitivity_cps)]
        begin_s = time.process_time()
        code = localize_command.main([str(path), *known, '--json'])
        cpu_s = time.process_time() - begin_s
    if code:
        raise RuntimeError(f'survey {one.seed} ({one.kind}): the command returned {code}')
    return json.loads(printed.getvalue()), cpu_s


def _table_of_readings(one: Drawn) -> str:
    lines = ['time_ns,latitude_deg,longitude_deg,altitude_m,counts,live_time_s']
    for second, ((east_m, north_m, up_m), count) in enumerate(
        zip(one.stated_m, one.counts, strict=True)
    ):
        azimuth_deg = math.degrees(math.atan2(east_m, north_m))
        way_m = math.hypot(east_m, north_m)
        longitude, latitude, _ = GEODESICS.fwd(LONGITUDE_DEG, LATITUDE_DEG, azimuth_deg, way_m)
        place = f'{latitude:.9f},{longitude:.9f},{up_m + GROUND_M:.3f}'
        lines.append(f'{second}000000000,{place},{count:.0f},1.0')
    return '\n'.join(lines) + '\n'


def _place_m(estimate: dict[str, Any]) -> FloatArray:
    """Return east and north of a source of the document."""
    place = estimate['place']
    azimuth_deg, _, way_m = GEODESICS.inv(
        LONGITUDE_DEG, LATITUDE_DEG, place['longitude_deg'], place['latitude_deg']
    )
    azimuth = math.radians(azimuth_deg)
    return np.array([way_m * math.sin(azimuth), way_m * math.cos(azimuth)])


def _pairs(one: Drawn, found: list[dict[str, Any]]) -> list[tuple[int, dict[str, Any]]]:
    places = [_place_m(estimate) for estimate in found]
    return [
        (k, found[int(np.argmin([np.hypot(*(place - source[:2])) for place in places]))])
        for k, source in enumerate(one.sources)
    ]


def _error(one: Drawn, index: int, estimate: dict[str, Any]) -> float:
    miss_m = _place_m(estimate) - one.sources[index, :2]
    return float(np.hypot(*miss_m) / math.sqrt(np.trace(one.bound_m2[index])))


def _square(source: FloatArray, estimate: dict[str, Any]) -> float:
    miss_m = _place_m(estimate) - source[:2]
    covariance = np.array(estimate['position_covariance_m2'])[:2, :2]
    return float(miss_m @ np.linalg.solve(covariance, miss_m))


def _is_within(source: FloatArray, estimate: dict[str, Any]) -> bool:
    low, high = estimate['dose_rate_at_1m_95_usvh']
    return bool(low < source[3] < high)


HEAD = (
    f'{"of":6} {"n":>4} {"right":>6} {"false":>7} {"rms/bnd":>7} {"median":>6} {"ellipse":>8} '
    f'{"strength":>8} {"enough":>6} {"& right":>7} {"could":>6} {"axis m":>6} {"CPU s":>6}'
)


def summary(name: str, rows: Sequence[Outcome]) -> str:
    """Return one line of the table."""
    errors = [value for row in rows for value in row.errors]
    empty = [row for row in rows if row.order == 0]
    enough = [row for row in rows if row.is_enough]
    could = [all(axis_m < SMALL_AXIS_M for axis_m in row.bound_axes_m) for row in rows]
    false = f'{sum(row.found > 0 for row in empty)}/{len(empty)}'
    return (
        f'{name:6} {len(rows):4} {_mean([row.order == row.found for row in rows]):6.3f} '
        f'{false:>7} {math.sqrt(_mean([value**2 for value in errors])):7.2f} '
        f'{_median(errors):6.2f} '
        f'{_mean([value < QUANTILE_95 for row in rows for value in row.squares]):8.3f} '
        f'{_mean([value for row in rows for value in row.strengths]):8.3f} '
        f'{len(enough):6} {sum(_is_right(row) for row in enough):7} {_mean(could):6.2f} '
        f'{_median([value for row in rows for value in row.axes_m]):6.1f} '
        f'{_mean([row.cpu_s for row in rows]):6.2f}'
    )


def _is_right(row: Outcome) -> bool:
    return row.order == row.found and all(value < QUANTILE_95 for value in row.squares)


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if len(values) else math.nan


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if len(values) else math.nan


def table(rows: Sequence[Outcome]) -> str:
    """Return the table of kinds, of numbers of sources, and of all."""
    groups = {kind: [row for row in rows if row.kind == kind] for kind in (*PATTERNS, *STEELS)}
    groups |= {f'K = {order}': [row for row in rows if row.order == order] for order in range(4)}
    lines = [summary(name, own) for name, own in groups.items() if own]
    return '\n'.join([HEAD, *lines, summary('all', rows)])


def calibration(rows: Sequence[Outcome]) -> str:
    """Return how often the number is right among answers that state alike probabilities of it."""
    lines = [f'{"P stated":14} {"n":>4} {"mean P":>7} {"right":>6} {"ellipse":>8}']
    for low, high in itertools.pairwise(CHANCES):
        own = [row for row in rows if low <= max(row.probabilities) < high]
        squares = [value < QUANTILE_95 for row in own for value in row.squares]
        lines.append(
            f'{low:5.3f} to {min(high, 1.0):5.3f} {len(own):4} '
            f'{_mean([max(row.probabilities) for row in own]):7.4f} '
            f'{_mean([row.order == row.found for row in own]):6.3f} {_mean(squares):8.3f}'
        )
    return '\n'.join(lines)


def main() -> None:
    """Print the tables; write each outcome to a file of JSON lines."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--first', type=int, default=0, help='number of the first survey')
    parser.add_argument('--count', type=int, default=36, help='how many surveys')
    parser.add_argument('--kinds', nargs='+', choices=['', *STEELS], default=[''])
    parser.add_argument('--alike', type=float, default=0.0, help='likeness of errors of fixes')
    parser.add_argument('--out', type=Path, help='file of JSON lines, appended to')
    parser.add_argument('--table', type=Path, nargs='+', help='only the tables of such files')
    options = parser.parse_args()
    if options.table:
        lines = [line for path in options.table for line in path.read_text().splitlines()]
        _print([Outcome(**json.loads(line)) for line in lines])
        return
    rows = []
    for seed in range(options.first, options.first + options.count):
        row = outcome(drawn(seed, options.kinds[seed % len(options.kinds)], options.alike))
        rows.append(row)
        if options.out:
            with options.out.open('a') as stream:
                stream.write(json.dumps(asdict(row)) + '\n')
    _print(rows)


def _print(rows: Sequence[Outcome]) -> None:
    sys.stdout.write(f'{table(rows)}\n\n{calibration(rows)}\n')


if __name__ == '__main__':
    main()
