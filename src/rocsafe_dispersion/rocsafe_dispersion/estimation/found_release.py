# SPDX-License-Identifier: Apache-2.0
"""A release that was found: its place, its rate, and samples of what is possible."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.estimation.plume_kernel import PlumeShape
from rocsafe_geo.arrays import FloatArray

REGION_SHARE = 0.95
SAMPLES = 100


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReleaseSamples:
    """Equally probable releases.

    Attributes
    ----------
    places_m : (s, 2)
        East and north, metres.
    rates_g_s : (s,)
        Rates, g/s.
    shapes
        How the plume of each differs from the one that the air suggests.
    """

    places_m: FloatArray
    rates_g_s: FloatArray
    shapes: tuple[PlumeShape, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FoundRelease:
    """A release that was found.

    Attributes
    ----------
    place_m
        Most probable place, east and north, metres.
    mean_m, covariance_m2
        Mean and covariance of its place, (2,) and (2, 2).
    rate_g_s, rate_low_g_s, rate_high_g_s
        Rate: median, and the bounds of the middle 0.95, g/s.
    region_m : (r, 2)
        Cells that together hold the place with a probability of 0.95.
    cell_m
        Size of the cells.
    samples
        Releases drawn from the posterior.
    """

    place_m: tuple[float, float]
    mean_m: FloatArray
    covariance_m2: FloatArray
    rate_g_s: float
    rate_low_g_s: float
    rate_high_g_s: float
    region_m: FloatArray
    cell_m: float
    samples: ReleaseSamples

    def holds(self, east_m: float, north_m: float) -> bool:
        """Return whether a place is within the region of 0.95."""
        offset = np.abs(self.region_m - (east_m, north_m))
        return bool((offset <= self.cell_m / 2.0 + 1e-9).all(axis=1).any())

    @property
    def region_m2(self) -> float:
        """Area of the region of 0.95."""
        return len(self.region_m) * self.cell_m**2

    @property
    def region_radius_m(self) -> float:
        """Radius of a circle of that area, metres."""
        return math.sqrt(self.region_m2 / math.pi)


def found_release(
    weights: FloatArray,
    rates_g_s: FloatArray,
    places_m: FloatArray,
    shapes: Sequence[PlumeShape],
    cell_m: float,
) -> FoundRelease:
    """Return a release from weights and rates, (shapes, places, multiples)."""
    weights = weights / weights.sum()
    masses = weights.sum(axis=(0, 2))
    mean = masses @ places_m
    offset = places_m - mean
    order = np.argsort(-masses)
    count = int(np.searchsorted(np.cumsum(masses[order]), REGION_SHARE)) + 1
    low, middle, high = _quantiles(weights.ravel(), rates_g_s.ravel())
    east, north = places_m[order[0]].tolist()
    return FoundRelease(
        place_m=(east, north),
        mean_m=mean,
        covariance_m2=np.einsum('m,mi,mj->ij', masses, offset, offset),
        rate_g_s=middle,
        rate_low_g_s=low,
        rate_high_g_s=high,
        region_m=places_m[order[:count]],
        cell_m=cell_m,
        samples=drawn(weights, rates_g_s, places_m, shapes),
    )


def drawn(
    weights: FloatArray,
    rates_g_s: FloatArray,
    places_m: FloatArray,
    shapes: Sequence[PlumeShape],
    count: int = SAMPLES,
) -> ReleaseSamples:
    """Return releases drawn evenly by their weights, (shapes, places, rates): always the same."""
    total = np.cumsum(weights.ravel())
    wanted = (np.arange(count) + 0.5) / count * total[-1]
    chosen = np.minimum(np.searchsorted(total, wanted), total.size - 1)
    shape, place, _ = np.unravel_index(chosen, weights.shape)
    return ReleaseSamples(
        places_m=places_m[place],
        rates_g_s=rates_g_s.ravel()[chosen],
        shapes=tuple(shapes[index] for index in shape.tolist()),
    )


def _quantiles(weights: FloatArray, values: FloatArray) -> tuple[float, float, float]:
    """Return median of weighted values between the bounds of their middle 0.95."""
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    low, middle, high = (
        float(values[order[min(int(np.searchsorted(total, share)), len(total) - 1)]])
        for share in ((1.0 - REGION_SHARE) / 2.0, 0.5, (1.0 + REGION_SHARE) / 2.0)
    )
    return low, middle, high
