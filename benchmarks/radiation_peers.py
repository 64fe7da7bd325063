# SPDX-License-Identifier: Apache-2.0
"""Three usual ways to find sources, beside which the estimator is measured.

Each is told the true number of sources, the law of the dose rate and the height of the ground,
which the estimator has to find out or to allow for. Each returns the places, east and north.

* grid maximum likelihood: one source after the other at the place of a grid a quarter of a height
  wide that raises the Poisson likelihood most, all strengths and the background fitted anew
  (expectation maximisation), then each moved to its best place again;
* particle filter: 4000 particles of all sources, readings one after the other, resampled when
  their effective number falls below a half, moved by a shrinking jitter;
* Gaussian process: the logarithm of the dose rate regressed with a squared exponential of the
  likeliest of three lengths; its highest maxima.
"""

import math

import numpy as np
from radiation_families import SOURCE_UP_M, Drawn, law

from rocsafe_geo.arrays import FloatArray

PARTICLES, GRID_HEIGHTS, MOST_PLACES = 4000, 0.25, 4000
SEPARATION_HEIGHTS = 1.5


def grid_likelihood(one: Drawn) -> FloatArray:
    """Return the places of the sources by a search over a grid, shape (k, 2)."""
    grid = _grid(one)
    kernel = _kernel(one, grid)
    natural = one.exposures[None]
    chosen: list[int] = []
    for _ in range(len(one.sources)):
        chosen.append(_best(one, kernel, natural, chosen))
    for index in range(len(chosen)):
        others = chosen[:index] + chosen[index + 1 :]
        chosen[index] = _best(one, kernel, natural, others)
    return grid[chosen]


def _best(one: Drawn, kernel: FloatArray, natural: FloatArray, chosen: list[int]) -> int:
    """Return the place that, beside those chosen, gives the highest likelihood."""
    shapes = np.concatenate([natural, kernel[chosen]])
    strengths = _fitted(one.counts, shapes, np.full(len(shapes), one.counts.mean()))
    expected = strengths @ shapes
    scores = kernel @ (one.counts / expected - 1.0)
    variances = (kernel * kernel) @ (1.0 / expected)
    gains = np.where(scores > 0.0, scores**2 / variances, 0.0)
    best, value = 0, -math.inf
    for index in np.argsort(gains)[::-1][:40]:
        more = np.concatenate([shapes, kernel[index : index + 1]])
        start = np.append(strengths, max(scores[index] / variances[index], 1e-3))
        found = _fitted(one.counts, more, start) @ more
        logs = float(one.counts @ np.log(found) - found.sum())
        if logs > value:
            best, value = int(index), logs
    return best


def _fitted(counts: FloatArray, shapes: FloatArray, start: FloatArray) -> FloatArray:
    """Return the strengths of Poisson rates that are sums of shapes (k, n)."""
    strengths, totals = np.maximum(start, 1e-9), shapes.sum(axis=1)
    for _ in range(40):
        strengths = strengths * (shapes @ (counts / (strengths @ shapes))) / totals
    return np.asarray(strengths)


def particle_filter(one: Drawn) -> FloatArray:
    """Return the mean places of the particles, shape (k, 2)."""
    generator = np.random.default_rng(7)
    order = len(one.sources)
    low, high = one.stated_m[:, :2].min(axis=0), one.stated_m[:, :2].max(axis=0)
    level = float(np.quantile(one.counts / one.exposures, 0.3))
    places = generator.uniform(low, high, (PARTICLES, order, 2))
    logs = generator.uniform(math.log(50.0), math.log(5000.0), (PARTICLES, order))
    weights = np.zeros(PARTICLES)
    for step, index in enumerate(generator.permutation(len(one.counts))):
        way = one.stated_m[index] - np.concatenate(
            [places, np.full((PARTICLES, order, 1), SOURCE_UP_M)], axis=2
        )
        rates = level + (np.exp(logs) * law(one.nuclide, np.sqrt((way**2).sum(axis=2)))).sum(
            axis=1
        )
        expected = one.exposures[index] * rates
        # A tenth of the excess for errors of the fixes: else all particles but one die at once.
        variance = expected + (0.1 * (expected - one.exposures[index] * level)) ** 2
        weights -= 0.5 * (one.counts[index] - expected) ** 2 / variance + 0.5 * np.log(variance)
        weights -= weights.max()
        shares = np.exp(weights)
        shares /= shares.sum()
        if 1.0 / (shares @ shares) < PARTICLES / 2.0:
            picked = generator.choice(PARTICLES, PARTICLES, p=shares)
            jitter = one.height_m * max(0.02, 0.3 * (1.0 - step / len(one.counts)) ** 2)
            places = places[picked] + generator.normal(0.0, jitter, places.shape)
            logs = logs[picked] + generator.normal(0.0, 0.05, logs.shape)
            weights = np.zeros(PARTICLES)
            shares = np.full(PARTICLES, 1.0 / PARTICLES)
    # Sources have no order: each particle's are matched with those of the best one.
    best = places[int(np.argmax(shares))]
    squares = ((places[:, :, None] - best[None, None]) ** 2).sum(axis=3)
    matched = np.take_along_axis(places, squares.argmin(axis=1)[:, :, None], axis=1)
    return np.asarray(np.einsum('n,nkc->kc', shares, matched))


def process_peaks(one: Drawn) -> FloatArray:
    """Return the highest maxima of a Gaussian process, shape (k, 2)."""
    logs = np.log((one.counts + 0.5) / one.exposures)
    noise = 1.0 / (one.counts + 0.5) + 1e-3
    middle = float(np.median(logs))
    places = one.stated_m[:, :2]
    sill = max(float(logs.var()), 1e-3)
    fits = []
    for heights in (0.7, 1.2, 2.0):
        length = heights * one.height_m
        covariance = sill * np.exp(-_squares(places, places) / (2.0 * length**2))
        factor = np.linalg.cholesky(covariance + np.diag(noise))
        half = np.linalg.solve(factor, logs - middle)
        value = -0.5 * half @ half - np.log(np.diag(factor)).sum()
        fits.append((float(value), length, np.linalg.solve(factor.T, half)))
    _, length, weights = max(fits, key=lambda fit: fit[0])
    grid = _grid(one)
    means = sill * np.exp(-_squares(grid, places) / (2.0 * length**2)) @ weights
    found = []
    for _ in range(len(one.sources)):
        best = grid[int(np.argmax(means))]
        found.append(best)
        near = _squares(grid, best[None])[:, 0] < (SEPARATION_HEIGHTS * one.height_m) ** 2
        means = np.where(near, -math.inf, means)
    return np.array(found).reshape(-1, 2)


PEERS = {
    'grid': grid_likelihood,
    'particles': particle_filter,
    'process': process_peaks,
}


def _grid(one: Drawn) -> FloatArray:
    low, high = one.stated_m[:, :2].min(axis=0), one.stated_m[:, :2].max(axis=0)
    area = float(np.prod(high - low))
    pitch = max(GRID_HEIGHTS * one.height_m, math.sqrt(area / MOST_PLACES))
    axes = (np.arange(a, b + pitch, pitch) for a, b in zip(low, high, strict=True))
    return np.stack([part.ravel() for part in np.meshgrid(*axes)], axis=1)


def _kernel(one: Drawn, grid: FloatArray) -> FloatArray:
    squares = _squares(grid, one.stated_m[:, :2]) + (one.stated_m[:, 2] - SOURCE_UP_M) ** 2
    return one.exposures * law(one.nuclide, np.sqrt(squares))


def _squares(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.asarray(((first[:, None] - second[None]) ** 2).sum(axis=2))
