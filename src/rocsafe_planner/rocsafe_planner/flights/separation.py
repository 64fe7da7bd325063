# SPDX-License-Identifier: Apache-2.0
"""Distances of own vehicles in the air, and the starts of two that keep them apart.

A vehicle on the ground waits for its take-off, one in the air waits where it is.

Distances between two tracks change no faster than both vehicles' top speeds together. From
samples half an interval apart that gives a lower bound in between, and the intervals that might
hold the minimum are halved until it is known to a centimetre.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray, IndexArray
from rocsafe_planner.flights.flight_track import FlightTrack

TOLERANCE_M = 0.01
"""Least distances are exact to this."""

_SAMPLE_S = 1.0


def minimum_separation_m(tracks: Sequence[FlightTrack], delays_s: Sequence[float]) -> float:
    """Return the least distance of any two vehicles in the air, infinite if no two ever are."""
    least = np.inf
    for apart_m, i, j in box_distances(tracks):
        if apart_m >= least:
            break
        pair = _Pair((tracks[i], delays_s[i]), (tracks[j], delays_s[j]))
        least = min(least, pair.least_distance_m(least))
    return float(least)


class Conflicts:
    """Which starts of two tracks keep a distance between them, whole seconds apart.

    Samples exclude most pairs quickly; the remaining pairs are checked exactly on demand.
    """

    def __init__(self, separation_m: float) -> None:
        self._separation = separation_m
        self._lags: dict[tuple[FlightTrack, FlightTrack], tuple[int, BoolArray]] = {}
        self._exact: dict[tuple[FlightTrack, int, FlightTrack, int], bool] = {}

    def open_starts(
        self, track: FlightTrack, starts: IndexArray, others: Sequence[tuple[FlightTrack, int]]
    ) -> Iterator[int]:
        """Yield those starts, in seconds, with which a track keeps away from others begun."""
        is_open = np.ones(len(starts), dtype=bool)
        for other, begun in others:
            first, blocked = self._blocked(other, track)
            is_open &= ~blocked[np.clip(starts - begun - first, 0, len(blocked) - 1)]
        for start in starts[is_open].tolist():
            if all(self._is_apart(other, begun, track, start) for other, begun in others):
                yield start

    def _is_apart(self, one: FlightTrack, begun: int, other: FlightTrack, start: int) -> bool:
        # Waiting in the air counts, so that then not only the time between the starts matters.
        since = begun if one.is_aloft or other.is_aloft else 0
        key = (one, since, other, start - begun + since)
        if key not in self._exact:
            pair = _Pair((one, float(key[1])), (other, float(key[3])))
            self._exact[key] = pair.stays_apart(self._separation)
        return self._exact[key]

    def _blocked(self, one: FlightTrack, other: FlightTrack) -> tuple[int, BoolArray]:
        """Return the first of consecutive seconds from a start to the other's, and which are not.

        The first and the last stand for all before and after.
        """
        if (one, other) not in self._lags:
            self._lags[one, other] = self._found(one, other)
        return self._lags[one, other]

    def _found(self, one: FlightTrack, other: FlightTrack) -> tuple[int, BoolArray]:
        # Loaded here: it takes a while that vehicles which never meet can do without.
        from scipy.spatial import KDTree

        first = -int(other.duration_s) - 2
        blocked = np.zeros(int(one.duration_s) + 3 - first, dtype=bool)
        (times, places), (other_times, other_places) = one.samples, other.samples
        tree, other_tree = KDTree(places), KDTree(other_places)
        near = tree.sparse_distance_matrix(other_tree, self._separation, output_type='ndarray')
        blocked[times[near['i']] - other_times[near['j']] - first] = True
        if one.is_aloft and len(near_j := self._passing(one, other)):
            blocked[: max(0, 1 - int(near_j[0]) - first)] = True
        if other.is_aloft and len(near_i := self._passing(other, one)):
            blocked[int(near_i[0]) - first :] = True
        return first, blocked

    def _passing(self, waiting: FlightTrack, other: FlightTrack) -> IndexArray:
        """Return the seconds of a track at which it is near to where another waits in the air."""
        times, places = other.samples
        gaps = np.sqrt(((places - waiting.samples[1][0]) ** 2).sum(axis=1))
        return times[gaps < self._separation]


def box_distances(tracks: Sequence[FlightTrack]) -> list[tuple[float, int, int]]:
    """Return the horizontal distances of the boxes of all pairs, the near ones first."""
    low = np.array([track.low for track in tracks]).reshape(-1, 3)
    high = np.array([track.high for track in tracks]).reshape(-1, 3)
    i, j = np.triu_indices(len(tracks), k=1)
    gaps = np.maximum(0.0, np.maximum(low[i] - high[j], low[j] - high[i]))
    apart = np.hypot(gaps[:, 0], gaps[:, 1])
    nearest = np.argsort(apart, kind='stable')
    return list(
        zip(apart[nearest].tolist(), i[nearest].tolist(), j[nearest].tolist(), strict=True)
    )


class _Pair:
    """Two tracks, each with its delay."""

    def __init__(
        self, first: tuple[FlightTrack, float], second: tuple[FlightTrack, float]
    ) -> None:
        (self._a, delay_a), (self._b, delay_b) = first, second
        self._lag = delay_b - delay_a
        self._windows = self._a.windows_after(delay_a), self._b.windows_after(delay_b)
        self._speed = self._a.top_speed_mps + self._b.top_speed_mps

    def least_distance_m(self, known: float) -> float:
        """Return the least distance, or any value not below `known` if it is not less."""
        return min((self._least(times, known) for times in self._samples()), default=np.inf)

    def stays_apart(self, separation_m: float) -> bool:
        """Return whether the least distance is at least `separation_m`."""
        for times in self._samples():
            if self._distances(times).min() < separation_m:
                return False
        return self.least_distance_m(separation_m) >= separation_m

    def _samples(self) -> list[FloatArray]:
        """Return times of the first track's clock, for each while in which both are in the air."""
        samples = []
        for begin_a, end_a in self._windows[0]:
            for begin_b, end_b in self._windows[1] + self._lag:
                begin, end = max(begin_a, begin_b), min(end_a, end_b)
                if begin < end:
                    samples.append(np.linspace(begin, end, 2 + int((end - begin) / _SAMPLE_S)))
        return samples

    def _distances(self, times: FloatArray) -> FloatArray:
        apart = self._a.places(times) - self._b.places(times - self._lag)
        distances: FloatArray = np.sqrt((apart**2).sum(axis=1))
        return distances

    def _least(self, times: FloatArray, known: float) -> float:
        distances = self._distances(times)
        least = float(distances.min())
        begin, end = times[:-1], times[1:]
        at_begin, at_end = distances[:-1], distances[1:]
        while True:
            bound = 0.5 * (at_begin + at_end - self._speed * (end - begin))
            open_ = bound < min(least, known) - TOLERANCE_M
            if not open_.any():
                return least
            begin, end, at_begin, at_end = (
                values[open_] for values in (begin, end, at_begin, at_end)
            )
            middle = 0.5 * (begin + end)
            between = self._distances(middle)
            least = min(least, float(between.min()))
            begin, end = np.concatenate([begin, middle]), np.concatenate([middle, end])
            at_begin, at_end = (
                np.concatenate([at_begin, between]),
                np.concatenate([between, at_end]),
            )
