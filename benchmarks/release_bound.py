# SPDX-License-Identifier: Apache-2.0
"""Error of the place of a release against the Cramer-Rao bound, where the truth is the model.

    python benchmarks/release_bound.py [--count 40] [--seed 1]

Readings of one release (1 to 8 g/s) at 60 places along four lines across the wind are drawn from
the estimator's own model, air and eddies from its prior: gamma of mean and intensity, noise of
Student's t. The bound is that of place, rate, air and eddies together; for air and eddies it has
the information of the prior, too (van Trees 1968). Beside it stands the bound with all but place
and rate known. Trials with a release found count.
"""

import argparse
import math

import numpy as np

from rocsafe_dispersion.estimation.background_filter import BackgroundFilter
from rocsafe_dispersion.estimation.fluctuating_plume import PlumeReadings
from rocsafe_dispersion.estimation.gas_survey import point_survey
from rocsafe_dispersion.estimation.locate import locate_releases
from rocsafe_dispersion.estimation.reading_density import FREEDOM, cells, log_density
from rocsafe_dispersion.estimation.release_options import LocateOptions, SearchArea
from rocsafe_dispersion.estimation.release_sampler import SHARED, Bounds, ReleaseSampler
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.wind.stability import layer_of_class

NOISE_G_M3, SPEED_MPS, SENSOR_M = 5e-5, 3.0, 3.0
AREA = SearchArea(west_m=-50.0, south_m=-50.0, east_m=50.0, north_m=50.0)
LAYER = layer_of_class('D', SPEED_MPS, 10.0, 0.03)
# Steps of the derivatives: east, north, metres, the logarithm of the rate, and what is standard
# normal before readings: turn, two sizes, meander, intensity.
STEPS = np.array([0.5, 0.5, 0.1, *[0.05] * 5])
# Readings in noises over which the information is added up.
GRID = np.sinh(np.linspace(-4.0, 14.0, 1500))


def readings_of(sampler: ReleaseSampler, reader: PlumeReadings, truth: FloatArray) -> FloatArray:
    """Return mean and standard deviation of the gas of each reading, (2, n), g/m^3."""
    shared = np.zeros((1, SHARED))
    shared[0, :5] = truth[3:]
    return np.array(reader.of(truth[None, :2], sampler.shapes_of(shared)))[:, 0] * math.exp(
        truth[2]
    )


def bounds_m(
    sampler: ReleaseSampler, reader: PlumeReadings, truth: FloatArray
) -> tuple[float, float]:
    """Return the bounds of the distance of the place, with all unknown and with place and rate."""

    def densities(values: FloatArray) -> FloatArray:
        mean, spread = readings_of(sampler, reader, values) / NOISE_G_M3
        squares = np.clip((spread / np.maximum(mean, 1e-30)) ** 2, 0.1, 100.0)
        own = cells(mean, squares)
        return np.exp(log_density(np.repeat(GRID[:, None], len(squares), axis=1), own, 0))

    middle = densities(truth)
    widths = np.gradient(GRID)[:, None]
    slopes = [
        (densities(truth + step) - densities(truth - step)) / (2.0 * step.sum())
        for step in np.diag(STEPS)
    ]
    rows = [
        [float((widths * a * b / np.maximum(middle, 1e-12)).sum()) for a in slopes] for b in slopes
    ]
    information = np.array(rows)
    prior = np.diag([0.0] * 3 + [1.0] * 5)
    all_unknown = np.linalg.inv(information + prior)
    two = (np.trace(all_unknown[:2, :2]), np.trace(np.linalg.inv(information[:3, :3])[:2, :2]))
    return math.sqrt(two[0]), math.sqrt(two[1])


def main() -> None:
    """Draw, locate, print the ratio."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument('--count', type=int, default=40)
    parser.add_argument('--seed', type=int, default=1)
    given = parser.parse_args()
    generator = np.random.default_rng(given.seed)
    side = np.linspace(-46.0, 46.0, 15)
    places = np.array([(east, north, SENSOR_M) for east in (-30, -10, 12, 36) for north in side])
    winds = np.tile([SPEED_MPS, 0.0], (len(places), 1))
    std = np.full(len(places), NOISE_G_M3)
    travel, options = similarity_travel(LAYER, 0.5), LocateOptions(most_releases=1)
    empty = point_survey(places, winds, np.zeros(len(places)), std)
    reader = PlumeReadings(empty, AREA.height_m, travel, float(LAYER.speed_mps(10.0)))
    edges = Bounds(edges_m=(-50.0, -50.0, 50.0, 50.0), rates_g_s=(0.1, 100.0))
    sampler = ReleaseSampler(reader, BackgroundFilter(empty), edges, options, generator)
    rows = []
    for _ in range(given.count):
        place, air = generator.uniform(-40.0, 20.0, 2), generator.standard_normal(5)
        truth = np.array([*place, generator.uniform(0.0, math.log(8.0)), *air])
        mean, spread = readings_of(sampler, reader, truth)
        form = 1.0 / np.clip((spread / np.maximum(mean, 1e-30)) ** 2, 0.1, 100.0)
        values = mean * generator.gamma(form) / form
        values += NOISE_G_M3 * generator.standard_t(FREEDOM, len(places))
        survey = point_survey(places, winds, values, std)
        found = locate_releases(survey, AREA, LAYER, options=options).releases
        if found:
            error = math.dist(found[0].place_m, place.tolist())
            rows.append(
                (error, *bounds_m(sampler, reader, truth), found[0].holds(*place.tolist()))
            )
    table = np.array(rows)
    error, all_unknown, two = np.sqrt((table[:, :3] ** 2).mean(axis=0)).tolist()
    medians = ', '.join(f'{one:.2f}' for one in np.median(table[:, :3], axis=0))
    held = int(table[:, 3].sum())
    print(f'{len(rows)} of {given.count} found, {held} in their regions')
    print(f'root mean squares: error {error:.2f} m, bound {all_unknown:.2f} m, with all but place')
    print(f'and rate known {two:.2f} m; ratio {error / all_unknown:.2f}; medians {medians} m')


if __name__ == '__main__':
    main()
