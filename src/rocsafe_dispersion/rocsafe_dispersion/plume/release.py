# SPDX-License-Identifier: Apache-2.0
"""A release: what leaves where, how fast and how long."""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_finite, require_not_negative

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
