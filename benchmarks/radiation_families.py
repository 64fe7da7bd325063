# SPDX-License-Identifier: Apache-2.0
"""Families of simulated surveys that no method was tuned to, and the bound of each.

Nothing of the estimator is used: the law of the dose rate is a fit of Berger's form of the
build-up, within 2 % of the tables of the package from 8 to 250 m, for iridium within 4 %.

A survey is drawn from ranges: nuclide, height 10 to 60 m, shape (grid, lines, ring, scattered
places), 200 to 600 readings, sensitivity, background with its slope, random field, hills and
spikes, errors of all three coordinates of the fixes, 0 to 3 sources of 1 to 50 GBq. Sources are
drawn again until the weakest one gives at least 30 uncollided counts at its nearest reading, and
all lie at least two heights apart. In the family ``steel``, a plate stands beside the source.

The bound is that of Cramer and Rao for Gaussian readings with the variance of counts and of the
errors of the fixes, a background with unknown level and slope and a random field of known
covariance, and the prior of the sources' heights.
"""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray

SPLITS = {
    'develop': 101,
    'validate': 202,
    'opened': 303,
    'develop-again': 1401,
    'validate-again': 2402,
    'opened-again': 93503,
}
FAMILIES = ('even', 'drift', 'slope', 'hills', 'spikes', 'steel')
POSITION_STD_M = 1.5
SOURCE_UP_M, SOURCE_UP_STD_M = 0.5, 1.0
FEWEST_COUNTS, LEAST_SEPARATION_HEIGHTS = 30.0, 2.0
# H*(10) at 1 m of 1 GBq in uSv/h; attenuation in air, 1/m; Berger's a and b:
# B = 1 + a x exp(b x) at x mean free paths.
NUCLIDES = {
    'Cs-137': (92.5, 0.00929, 0.991, 0.2437),
    'Co-60': (354.0, 0.00686, 0.850, 0.1668),
    'Ir-192': (139.0, 0.01245, 1.244, 0.3231),
}
IRON_PER_M = 58.0
SENSITIVITIES_CPS = (200.0, 550.0, 550.0, 1500.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Field:
    """Background: mean in uSv/h, slope of its logarithm, 1/m, and a random field."""

    level_usvh: float
    slope: tuple[float, float]
    std: float
    length_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """A survey with its truth.

    Attributes
    ----------
    family, nuclide
        What it is of.
    height_m
        Height of the flight above the ground.
    places_m, stated_m
        Places of the readings and what the fixes state, shape (n, 3).
    counts, exposures
        Shape (n,).
    sources
        East, north, up in metres and uSv/h at 1 m of each source, shape (k, 4).
    bound_m2
        Bound of the covariance of east, north, up and log strength of each, (k, 4, 4).
    """

    family: str
    nuclide: str
    height_m: float
    places_m: FloatArray
    stated_m: FloatArray
    counts: FloatArray
    exposures: FloatArray
    sources: FloatArray
    bound_m2: FloatArray


def law(nuclide: str, distances_m: FloatArray) -> FloatArray:
    """Return the dose rate at distances for 1 uSv/h at 1 m, scattered photons included."""
    _, per_m, a, b = NUCLIDES[nuclide]
    paths = per_m * distances_m
    return np.asarray(np.exp(-paths) * (1.0 + a * paths * np.exp(b * paths)) / distances_m**2)


def drawn(split: str, index: int, family: str, order: int) -> Drawn:
    """Return the survey with number `index` of a family with `order` sources."""
    seed = [SPLITS[split], FAMILIES.index(family), order, index]
    generator = np.random.default_rng(seed)
    while True:
        found = _tried(generator, family, order)
        if found is not None:
            return found


def _tried(generator: np.random.Generator, family: str, order: int) -> Drawn | None:
    height_m = float(np.exp(generator.uniform(math.log(10.0), math.log(60.0))))
    places = _flown(generator, height_m)
    nuclide = str(generator.choice(list(NUCLIDES), p=[0.7, 0.15, 0.15]))
    sensitivity = float(generator.choice(SENSITIVITIES_CPS))
    field = _field(generator, family, places, height_m)
    sources = _sources(generator, order, places, nuclide, height_m)
    if sources is None or not _is_counted(sources, places, nuclide, sensitivity):
        return None
    background = _background(generator, family, field, places, height_m)
    rates = background + _rates(generator, family, sources, places, nuclide)
    rates = rates * _spiked(generator, family, len(places))
    exposures = np.full(len(places), sensitivity)
    return Drawn(
        family=family,
        nuclide=nuclide,
        height_m=height_m,
        places_m=places,
        stated_m=places + generator.normal(0.0, POSITION_STD_M, places.shape),
        counts=generator.poisson(exposures * rates).astype(float),
        exposures=exposures,
        sources=sources,
        bound_m2=_bound(sources, places, nuclide, background * exposures, sensitivity, field),
    )


def _flown(generator: np.random.Generator, height_m: float) -> FloatArray:
    """Return the places of a grid, of lines, of rings or scattered ones."""
    count = int(generator.integers(200, 601))
    shape = generator.choice(['grid', 'lines', 'rings', 'scattered'])
    pitch = height_m * generator.uniform(0.3, 0.7)
    ratio = generator.uniform(1.0, 2.5)
    if shape == 'grid':
        rows = max(6, round(math.sqrt(count / ratio)))
        plane = _lattice(rows, round(count / rows), pitch, pitch)
    elif shape == 'lines':
        # Readings along a line lie nearer to each other than lines do.
        rows = max(5, round(math.sqrt(count / (3.0 * ratio))))
        plane = _lattice(rows, round(count / rows), 2.0 * pitch, 0.5 * pitch)
    elif shape == 'rings':
        turns = np.sqrt(np.arange(1.0, count + 1.0) / count)
        angles = np.arange(count) * math.pi * (3.0 - math.sqrt(5.0))
        reach = pitch * math.sqrt(count / math.pi)
        plane = reach * np.stack([turns * np.cos(angles), turns * np.sin(angles)], axis=1)
    else:
        size = pitch * math.sqrt(count / ratio)
        plane = generator.uniform(0.0, 1.0, (count, 2)) * [size * ratio, size]
    angle = generator.uniform(0.0, math.pi)
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    ups = height_m * np.exp(generator.normal(0.0, 0.02, len(plane)))
    return np.column_stack([(plane - plane.mean(axis=0)) @ turn, ups])


def _lattice(rows: int, columns: int, across_m: float, along_m: float) -> FloatArray:
    east, north = np.meshgrid(along_m * np.arange(columns), across_m * np.arange(rows))
    return np.stack([east.ravel(), north.ravel()], axis=1)


def _field(
    generator: np.random.Generator, family: str, places: FloatArray, height_m: float
) -> Field:
    half_m = 0.5 * float(np.ptp(places[:, :2], axis=0).max())
    steep = generator.uniform(0.1, 0.4) if family == 'slope' else 0.0
    angle = generator.uniform(0.0, 2.0 * math.pi)
    std = {'drift': generator.uniform(0.05, 0.2), 'hills': generator.uniform(0.05, 0.15)}
    length_m = height_m * generator.uniform(1.5, 6.0)
    return Field(
        level_usvh=float(generator.uniform(0.05, 0.15)),
        slope=(steep * math.cos(angle) / half_m, steep * math.sin(angle) / half_m),
        std=std.get(family, 0.0),
        length_m=length_m,
    )


def _background(
    generator: np.random.Generator,
    family: str,
    field: Field,
    places: FloatArray,
    height_m: float,
) -> FloatArray:
    logs = places[:, :2] @ np.array(field.slope) - (places[:, 2] - height_m) / 120.0
    if family == 'drift':
        covariance = _covariance(field, places) + 1e-9 * np.eye(len(places))
        logs = logs + np.linalg.cholesky(covariance) @ generator.normal(size=len(places))
    if family == 'hills':
        for _ in range(int(generator.integers(1, 4))):
            middle = places[generator.integers(len(places)), :2]
            squares = ((places[:, :2] - middle) ** 2).sum(axis=1)
            rise = 2.0 * field.std * generator.choice([-1.0, 1.0, 1.0])
            logs = logs + rise * np.exp(-squares / (2.0 * (0.6 * field.length_m) ** 2))
    return np.asarray(field.level_usvh * np.exp(logs))


def _covariance(field: Field, places: FloatArray) -> FloatArray:
    squares = ((places[:, None, :2] - places[None, :, :2]) ** 2).sum(axis=2)
    return np.asarray(field.std**2 * np.exp(-squares / (2.0 * field.length_m**2)))


def _sources(
    generator: np.random.Generator,
    order: int,
    places: FloatArray,
    nuclide: str,
    height_m: float,
) -> FloatArray | None:
    """Return `order` sources below the readings, None if they would be too near to each other."""
    rows: list[FloatArray] = []
    for _ in range(order):
        # About a place of a reading, so that the source is below the survey.
        near = places[generator.integers(len(places)), :2]
        plane = near + generator.uniform(-0.25, 0.25, 2) * height_m
        up = max(0.0, generator.normal(SOURCE_UP_M, 0.5))
        activity = math.exp(generator.uniform(0.0, math.log(50.0)))
        rows.append(np.array([*plane, up, activity * NUCLIDES[nuclide][0]]))
    found = np.array(rows).reshape(order, 4)
    for index in range(order):
        ways = found[:index, :2] - found[index, :2]
        if index and np.hypot(*ways.T).min() < LEAST_SEPARATION_HEIGHTS * height_m:
            return None
    return found


def _is_counted(sources: FloatArray, places: FloatArray, nuclide: str, sensitivity: float) -> bool:
    for source in sources:
        nearest_m = float(np.linalg.norm(places - source[:3], axis=1).min())
        uncollided = math.exp(-NUCLIDES[nuclide][1] * nearest_m) / nearest_m**2
        if sensitivity * source[3] * uncollided < FEWEST_COUNTS:
            return False
    return True


def _rates(
    generator: np.random.Generator,
    family: str,
    sources: FloatArray,
    places: FloatArray,
    nuclide: str,
) -> FloatArray:
    total = np.zeros(len(places))
    for source in sources:
        rays = places - source[:3]
        rates = source[3] * law(nuclide, np.linalg.norm(rays, axis=1))
        total += rates * (_past_plate(generator, rays) if family == 'steel' else 1.0)
    return total


def _past_plate(generator: np.random.Generator, rays: FloatArray) -> FloatArray:
    """Return what an upright iron plate beside the source leaves of each ray."""
    angle, away_m = generator.uniform(0.0, 2.0 * math.pi), generator.uniform(0.7, 2.0)
    thick_m, tall_m = generator.uniform(0.005, 0.03), generator.uniform(2.0, 4.0)
    half_m = generator.uniform(3.0, 10.0)
    across = rays[:, 0] * math.cos(angle) + rays[:, 1] * math.sin(angle)
    along = rays[:, 1] * math.cos(angle) - rays[:, 0] * math.sin(angle)
    reach = away_m / np.maximum(across, 1e-9)
    meets = (across > away_m) & (rays[:, 2] * reach < tall_m) & (np.abs(along * reach) < half_m)
    slant = np.linalg.norm(rays, axis=1) / np.maximum(across, 1e-9)
    paths = IRON_PER_M * thick_m * slant
    return np.where(meets, np.exp(-paths) * (1.0 + paths), 1.0)


def _spiked(generator: np.random.Generator, family: str, count: int) -> FloatArray:
    factors = np.ones(count)
    if family == 'spikes':
        hit = generator.choice(count, int(generator.integers(1, 4)), replace=False)
        factors[hit] = generator.uniform(2.0, 10.0, len(hit))
    return factors


def _bound(
    sources: FloatArray,
    places: FloatArray,
    nuclide: str,
    background: FloatArray,
    sensitivity: float,
    field: Field,
) -> FloatArray:
    """Return the bound of each source, shape (k, 4, 4)."""
    if not len(sources):
        return np.empty((0, 4, 4))
    half_m = 0.5 * float(np.ptp(places[:, :2], axis=0).max())
    columns = [background, *(background * places[:, axis] / half_m for axis in range(2))]
    slopes = np.zeros_like(places)
    expected = background.copy()
    for source in sources:
        own = _slopes(source, places, nuclide) * sensitivity
        slopes += own[:, :3]
        expected += own[:, 3]
        columns += [-own[:, 0], -own[:, 1], -own[:, 2], own[:, 3]]
    variances = expected + POSITION_STD_M**2 * (slopes**2).sum(axis=1)
    covariance = np.diag(variances)
    if field.std > 0.0:
        covariance += _covariance(field, places) * np.outer(background, background)
    matrix = np.stack(columns, axis=1)
    information = matrix.T @ np.linalg.solve(covariance, matrix)
    # The level is free, the slope is small.
    information[1, 1] += 4.0
    information[2, 2] += 4.0
    for index in range(len(sources)):
        information[5 + 4 * index, 5 + 4 * index] += SOURCE_UP_STD_M**-2
    bound = np.linalg.inv(information)
    return np.stack([bound[s : s + 4, s : s + 4] for s in range(3, 3 + 4 * len(sources), 4)])


def _slopes(source: FloatArray, places: FloatArray, nuclide: str) -> FloatArray:
    """Return the derivative of the dose rate by the place, and the dose rate, shape (n, 4)."""
    step, rays = 1e-3, places - source[:3]
    parts = []
    for axis in range(3):
        ahead = rays + step * np.eye(3)[axis]
        behind = rays - step * np.eye(3)[axis]
        far, near = np.linalg.norm(ahead, axis=1), np.linalg.norm(behind, axis=1)
        parts.append(source[3] * (law(nuclide, far) - law(nuclide, near)) / (2.0 * step))
    return np.stack([*parts, source[3] * law(nuclide, np.linalg.norm(rays, axis=1))], axis=1)
