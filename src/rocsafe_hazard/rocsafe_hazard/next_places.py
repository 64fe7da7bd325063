# SPDX-License-Identifier: Apache-2.0
"""When a search is enough, and the next places to measure: those whose readings tell most.

What is not known yet predicts different readings at each place. The information of a reading is
that of a Gaussian signal in Gaussian noise, 1/2 log(1 + variance of the predictions / variance of
the reading). Places are chosen one after the other; after each the predictions keep only the
spread that its reading would leave (square root filter, Potter 1964; Whitaker and Hamill 2002).
"""

import math
from dataclasses import dataclass

import numpy as np
import shapely

from rocsafe_geo.arrays import BoolArray, FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """Whether a search may end, and the reason in words."""

    is_enough: bool
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuringPlace:
    """A place to measure at: east, north and up, metres, and its information, nats."""

    place_m: tuple[float, float, float]
    gain: float


def next_places(
    candidates_m: FloatArray, factor: FloatArray, noise_variance: float, count: int
) -> list[MeasuringPlace]:
    """Return up to `count` of the candidates (n, 3), the one of most information first.

    Parameters
    ----------
    candidates_m
        Places that a vehicle can go to.
    factor : (d, n)
        Square root of the covariance of the predictions: its product with itself over `d`.
    noise_variance
        Variance of one reading.
    count
        How many, all of them different.
    """
    chosen = []
    is_taken = np.zeros(len(candidates_m), bool)
    for _ in range(min(count, len(candidates_m))):
        variances = np.where(is_taken, -1.0, (factor**2).sum(axis=0))
        best = int(variances.argmax())
        variance = float(variances[best])
        if variance <= 0.0:
            break
        east, north, up = candidates_m[best].tolist()
        gain = 0.5 * math.log1p(variance / noise_variance)
        chosen.append(MeasuringPlace(place_m=(east, north, up), gain=gain))
        is_taken[best] = True
        total = variance + noise_variance
        share = 1.0 / (1.0 + math.sqrt(noise_variance / total))
        own = factor[:, best]
        factor = factor - share * np.outer(own, (own @ factor) / total)
    return chosen


def are_within(places_m: FloatArray, area: shapely.Polygon | None) -> BoolArray:
    """Return which of places (n, 2 or more) lie within an area; None: all."""
    if area is None:
        return np.ones(len(places_m), dtype=bool)
    return np.asarray(shapely.contains_xy(area, places_m[:, 0], places_m[:, 1]), dtype=bool)
