# SPDX-License-Identifier: Apache-2.0
"""A release that was found: place, region that holds it, rate, and samples of what is possible."""

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from scipy import ndimage

from rocsafe_dispersion.estimation.fluctuating_plume import Shapes
from rocsafe_dispersion.estimation.release_options import SearchArea
from rocsafe_geo.arrays import FloatArray

REGION_SHARE = 0.95
SAMPLES = 100
RATE_ERROR = math.sqrt(math.log(1.6))
"""Standard deviation of the logarithm of a plume model's own error: a good one scatters by about a
factor of two, a geometric variance of 1.6 (Chang & Hanna 2004, doi:10.1007/s00703-003-0070-7)."""
# The density of places is smoothed over neighbouring cells.
_SMOOTHING = np.array([0.25, 0.5, 0.25])
_MEDIAN_ROUNDS, _MEDIAN_LEAST_M = 50, 0.3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReleaseSamples:
    """Equally probable releases; those of several releases belong together one by one.

    Attributes
    ----------
    places_m : (s, 2)
        East and north, metres.
    rates_g_s : (s,)
        Rates, g/s.
    shapes
        How the plume of each differs from the one that the air suggests.
    spans_s : (2, s)
        When they start and end, in the time of the readings; infinite: before and after them.
        None: not known.
    velocities_mps : (s, 2)
        Where those that move go, m/s, 0 where they stand; None: all stand.
    """

    places_m: FloatArray
    rates_g_s: FloatArray
    shapes: Shapes
    spans_s: FloatArray | None = None
    velocities_mps: FloatArray | None = None

    def thinned(self, count: int = SAMPLES) -> 'ReleaseSamples':
        """Return `count` of them, evenly taken; some repeatedly if there are fewer."""
        index = (np.arange(count) * len(self.rates_g_s)) // count
        return ReleaseSamples(
            places_m=self.places_m[index],
            rates_g_s=self.rates_g_s[index],
            shapes=self.shapes.at(index),
            spans_s=None if self.spans_s is None else self.spans_s[:, index],
            velocities_mps=None if self.velocities_mps is None else self.velocities_mps[index],
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """When a release started or ended.

    Attributes
    ----------
    beyond
        Probability that it was not among the readings; None: their times are not known.
    time_s, bounds_s
        Where it rather was among them: median, and the bounds of the middle 0.95, in their time.
    """

    beyond: float | None = None
    time_s: float = math.nan
    bounds_s: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FoundRelease:
    """A release that was found.

    Attributes
    ----------
    place_m
        Place with the least expected distance to the true one (spatial median), metres; of one
        that moves, at the last reading.
    mean_m, covariance_m2
        Mean and covariance of its place, (2,) and (2, 2).
    rate_g_s, rate_low_g_s, rate_high_g_s
        Rate: median, and the bounds of the middle 0.95, g/s; with the error of the plume model,
        which many readings share.
    region_m : (r, 2)
        Cells that together hold the place with a probability of 0.95.
    cell_m
        Size of the cells.
    beyond
        Probability that it is beyond the ground that was searched.
    beyond_deg
        Direction from the middle of that ground to it, degrees clockwise from north.
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
    beyond: float
    beyond_deg: float
    samples: ReleaseSamples

    def holds(self, east_m: float, north_m: float) -> bool:
        """Return whether a place is within the region of 0.95."""
        offset = np.abs(self.region_m - (east_m, north_m))
        return bool((offset <= self.cell_m / 2.0 + 1e-9).all(axis=1).any())

    @property
    def moves(self) -> float:
        """Probability that it moves."""
        found = self.samples.velocities_mps
        return 0.0 if found is None else float((found != 0.0).any(axis=1).mean())

    @property
    def velocity_mps(self) -> tuple[float, float] | None:
        """Its velocity east and north, m/s: median of the samples that move; None: most stand."""
        found = self.samples.velocities_mps
        if found is None or self.moves <= 0.5:
            return None
        east, north = np.median(found[(found != 0.0).any(axis=1)], axis=0).tolist()
        return east, north

    @property
    def start(self) -> Moment:
        """When it started; beyond: before the readings."""
        return _moment(self.samples.spans_s, 0)

    @property
    def end(self) -> Moment:
        """When it ended; beyond: after the readings."""
        return _moment(self.samples.spans_s, 1)

    @property
    def region_m2(self) -> float:
        """Area of the region of 0.95."""
        return len(self.region_m) * self.cell_m**2

    @property
    def region_radius_m(self) -> float:
        """Radius of a circle of that area, metres."""
        return math.sqrt(self.region_m2 / math.pi)


def _moment(spans_s: FloatArray | None, which: int) -> Moment:
    if spans_s is None:
        return Moment()
    among = spans_s[which][np.isfinite(spans_s[which])]
    beyond = 1.0 - len(among) / spans_s.shape[1]
    if beyond >= 0.5:
        return Moment(beyond=beyond)
    tail = (1.0 - REGION_SHARE) / 2.0
    low, middle, high = np.quantile(among, (tail, 0.5, 1.0 - tail)).tolist()
    return Moment(beyond=beyond, time_s=middle, bounds_s=(low, high))


def found_release(samples: ReleaseSamples, area: SearchArea) -> FoundRelease:
    """Return a release from equally probable samples."""
    places = samples.places_m
    tail = (1.0 - REGION_SHARE) / 2.0
    bounds = np.log(np.quantile(samples.rates_g_s, (tail, 0.5, 1.0 - tail)))
    wider = np.hypot(bounds - bounds[1], NormalDist().inv_cdf(1.0 - tail) * RATE_ERROR)
    low, middle, high = np.exp(bounds[1] + wider * (-1.0, 0.0, 1.0)).tolist()
    east, north = _spatial_median(places).tolist()
    return FoundRelease(
        place_m=(east, north),
        mean_m=places.mean(axis=0),
        covariance_m2=np.asarray(np.cov(places.T), float),
        rate_g_s=middle,
        rate_low_g_s=low,
        rate_high_g_s=high,
        region_m=_region(places, area),
        cell_m=area.cell_m,
        beyond=1.0 - float(area.holds(places).mean()),
        beyond_deg=math.degrees(
            math.atan2(
                east - (area.west_m + area.east_m) / 2.0,
                north - (area.south_m + area.north_m) / 2.0,
            )
        )
        % 360.0,
        samples=samples.thinned(),
    )


def _spatial_median(places_m: FloatArray) -> FloatArray:
    """Return the place with the least mean distance (Weiszfeld 1937)."""
    found = np.median(places_m, axis=0)
    for _ in range(_MEDIAN_ROUNDS):
        distances = np.hypot(*(places_m - found).T)
        weights = 1.0 / np.maximum(distances, _MEDIAN_LEAST_M)
        found = weights @ places_m / weights.sum()
    return np.asarray(found)


def _region(places_m: FloatArray, area: SearchArea) -> FloatArray:
    """Return the middles of the fewest cells that hold 0.95 of the places, (r, 2).

    The grid is that of the area, continued as far as there are places.
    """
    first_m = np.array([area.west_m, area.south_m])
    index = np.floor((places_m - first_m) / area.cell_m).astype(int)
    low, high = index.min(axis=0) - 1, index.max(axis=0) + 1
    counts = np.zeros(high - low + 1)
    np.add.at(counts, tuple((index - low).T), 1.0)
    for axis in (0, 1):
        counts = ndimage.convolve1d(counts, _SMOOTHING, axis=axis, mode='constant')
    order = np.argsort(-counts.ravel(), kind='stable')
    total = np.cumsum(counts.ravel()[order])
    count = int(np.searchsorted(total, REGION_SHARE * total[-1])) + 1
    cells = np.stack(np.unravel_index(order[:count], counts.shape), axis=-1) + low
    return np.asarray(first_m + (cells + 0.5) * area.cell_m)
