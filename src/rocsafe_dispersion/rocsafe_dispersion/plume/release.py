# SPDX-License-Identifier: Apache-2.0
"""A release: what leaves where, how fast and how long."""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_finite, require_not_negative, require_positive

# East and north, metres.
Place = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Release:
    """A release at one place, over a disc or along a track.

    Attributes
    ----------
    place_m
        East and north of the origin at its start, metres.
    height_m
        Height above the ground, metres.
    rate_g_s
        What leaves in a second, g/s; 0 for a burst.
    burst_g
        What leaves at once at the start, g.
    start_s, duration_s
        When, seconds after the start of the mission, and how long; infinite: without end.
    radius_m
        Radius of the disc that it leaves, or of the cloud of a burst, metres.
    track
        Further places of a moving release: seconds after its start, east and north in metres.
    """

    place_m: Place
    height_m: float = 0.0
    rate_g_s: float = 0.0
    burst_g: float = 0.0
    start_s: float = 0.0
    duration_s: float = math.inf
    radius_m: float = 0.0
    track: tuple[tuple[float, float, float], ...] = ()

    def __post_init__(self) -> None:
        for name in ('height_m', 'rate_g_s', 'burst_g', 'radius_m'):
            require_not_negative(name, getattr(self, name))
        require_finite('start_s', self.start_s, 's')
        for value in (*self.place_m, *(value for stop in self.track for value in stop)):
            require_finite('place of a release', value)
        if not self.duration_s > 0.0:
            raise ValueError(f'duration_s is {self.duration_s:g}: must be above 0')
        if (self.rate_g_s > 0.0) == (self.burst_g > 0.0):
            raise ValueError('a release needs exactly one of rate_g_s and burst_g above 0')
        if np.any(np.diff([0.0, *(stop[0] for stop in self.track)]) <= 0.0):
            raise ValueError('times of the track of a release must ascend from 0')

    @property
    def sigma_m(self) -> float:
        """Standard deviation of an even disc along one axis, metres."""
        return self.radius_m / 2.0

    def places_m(self, times_s: FloatArray) -> FloatArray:
        """Return east and north at times since the start of the mission, (n, 2)."""
        stops = np.array([(0.0, *self.place_m), *self.track])
        since = np.asarray(times_s) - self.start_s
        return np.column_stack([np.interp(since, stops[:, 0], stops[:, i]) for i in (1, 2)])

    def released_g(self, times_s: FloatArray) -> FloatArray:
        """Return what has left before each time, (n,), g."""
        since = np.asarray(times_s, float) - self.start_s
        if self.burst_g:
            return np.where(since > 0.0, self.burst_g, 0.0)
        return np.asarray(self.rate_g_s * np.clip(since, 0.0, self.duration_s))


def area_release(release: Release, corners_m: FloatArray, count: int = 16) -> list[Release]:
    """Return releases at places spread evenly over a polygon, which add up to `release`.

    Parameters
    ----------
    release
        Its rate or burst is that of the whole area.
    corners_m : (n, 2)
        Corners of the polygon, metres.
    count
        Number of places.

    Raises
    ------
    ValueError
        If the polygon has no area.
    """
    places = _spread(np.asarray(corners_m, float), require_positive('count', count))
    if not len(places):
        raise ValueError('the area of a release must be a polygon with an area')
    share = 1.0 / len(places)
    cell = math.sqrt(_area_m2(np.asarray(corners_m, float)) * share)
    return [
        Release(
            place_m=(east, north),
            height_m=release.height_m,
            rate_g_s=release.rate_g_s * share,
            burst_g=release.burst_g * share,
            start_s=release.start_s,
            duration_s=release.duration_s,
            # The disc of the same area as its part of the polygon.
            radius_m=cell / math.sqrt(math.pi),
        )
        for east, north in places.tolist()
    ]


def _area_m2(corners: FloatArray) -> float:
    x, y = corners.T
    return float(abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2.0)


def _spread(corners: FloatArray, count: float) -> FloatArray:
    """Return about `count` points of a square lattice within a polygon, (n, 2)."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    area = _area_m2(corners)
    if area <= 0.0:
        return np.zeros((0, 2))
    step = math.sqrt(area / count)
    axes = [
        first + (np.arange(math.ceil((last - first) / step)) + 0.5) * step
        for first, last in zip(low, high, strict=True)
    ]
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    inside = np.zeros(len(points), bool)
    for first, second in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        # Even-odd rule: count the edges to the east of each point.
        crosses = (first[1] > points[:, 1]) != (second[1] > points[:, 1])
        rise = second[1] - first[1] or 1.0
        at = first[0] + (points[:, 1] - first[1]) / rise * (second[0] - first[0])
        inside ^= crosses & (points[:, 0] < at)
    found = points[inside]
    return found if len(found) else corners.mean(axis=0, keepdims=True)
