# SPDX-License-Identifier: Apache-2.0
"""Where one more source would explain the readings best."""

import math

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.likelihood import Likelihood
from rocsafe_radiation.readings.survey import RadiationSurvey

SMALLEST_STRENGTH_USVH = 1e-3


def candidate_grid(survey: RadiationSurvey, setting: Setting) -> FloatArray:
    """Return a grid of places over and around the readings, east and north, shape (m, 2)."""
    height, options = survey.height_m(setting.source_up_m), setting.search
    margin = options.margin_heights * height
    low = survey.positions_enu_m[:, :2].min(axis=0) - margin
    high = survey.positions_enu_m[:, :2].max(axis=0) + margin
    area = float(np.prod(high - low))
    pitch = max(options.pitch_heights * height, math.sqrt(area / options.most_places))
    axes = (np.arange(a, b + pitch, pitch) for a, b in zip(low, high, strict=True))
    east, north = np.meshgrid(*axes)
    return np.stack([east.ravel(), north.ravel()], axis=1)


def grid_kernel(survey: RadiationSurvey, setting: Setting, grid: FloatArray) -> FloatArray:
    """Return counts of each reading for 1 uSv/h at 1 m at each place of `grid`, shape (m, n)."""
    ups = survey.ground.ups_at(grid) + setting.source_up_m
    squares = np.subtract.outer(ups, survey.positions_enu_m[:, 2]) ** 2
    for axis in range(2):
        offsets = np.subtract.outer(grid[:, axis], survey.positions_enu_m[:, axis])
        squares += offsets * offsets
    return setting.kernel.values(squares) * survey.exposures


def score_candidates(
    likelihood: Likelihood, parameters: FloatArray, kernel: FloatArray, shares: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the gain in log likelihood of one more source at each place, and its strength.

    By the score test: the first step of Newton's method from strength 0, with all parameters free.
    Both have shape (m,). `shares` (n,) are further weights of the readings.
    """
    weights = shares * likelihood.weights(parameters)
    slopes, expected = likelihood.slopes(parameters)
    information, _ = likelihood.information_and_gradient(parameters, weights)
    precision = weights / expected
    scores = kernel @ (precision * (likelihood.survey.counts - expected))
    shared = kernel @ (slopes * precision[:, None])
    variances = (kernel * kernel) @ precision
    explained = np.einsum('mp,mp->m', shared, np.linalg.solve(information, shared.T).T)
    variances = np.maximum(variances - explained, 1e-3 * variances + 1e-30)
    strengths = np.maximum(scores / variances, SMALLEST_STRENGTH_USVH)
    return np.where(scores > 0.0, scores * scores / (2.0 * variances), 0.0), strengths


def best_separated(
    grid: FloatArray, gains: FloatArray, count: int, distance_m: float
) -> list[int]:
    """Return the indices of the best `count` places that lie `distance_m` apart."""
    left = gains.copy()
    chosen: list[int] = []
    for _ in range(count):
        best = int(np.argmax(left))
        if left[best] <= 0.0:
            break
        chosen.append(best)
        left[((grid - grid[best]) ** 2).sum(axis=1) < distance_m * distance_m] = 0.0
    return chosen
