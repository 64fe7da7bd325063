# SPDX-License-Identifier: Apache-2.0
"""Own vehicles kept apart: their least distance in the air, and starts late enough for it.

A vehicle on the ground waits for its take-off, one in the air waits where it is.

Distances between two tracks change no faster than both vehicles' top speeds together. From
samples half an interval apart that gives a lower bound in between, and the intervals that might
hold the minimum are halved until it is known to a centimetre.
"""

from collections.abc import Sequence

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_planner.flights.flight_track import FlightTrack

TOLERANCE_M = 0.01
"""Least distances are exact to this."""

_SAMPLE_S = 1.0
_DELAY_STEP_S = 2.0
# Nobody hovers longer to let others pass.
_LONGEST_HOVER_S = 300.0


def minimum_separation_m(tracks: Sequence[FlightTrack], delays_s: Sequence[float]) -> float:
    """Return the least distance of any two vehicles in the air, infinite if no two ever are."""
    least = np.inf
    for i, j in _pairs_by_distance(tracks):
        if _box_distance_m(tracks[i], tracks[j]) >= least:
            continue
        pair = _Pair((tracks[i], delays_s[i]), (tracks[j], delays_s[j]))
        least = min(least, pair.least_distance_m(least))
    return float(least)


def delays_apart(tracks: Sequence[FlightTrack], separation_m: float, turn: int = 0) -> list[float]:
    """Return how long each vehicle waits so that no two come nearer than `separation_m`.

    The one that flies longest goes first; each next one as soon as it stays apart from those
    before. On the ground there is always a way: to wait until they have landed. A vehicle in the
    air for which no wait is long enough does not wait, whoever it meets.
    """
    placed = Placed(separation_m)
    delays = [0.0] * len(tracks)
    for k in flying_order(tracks, turn):
        delays[k] = placed.add(tracks[k], placed.delay_s(tracks[k]))
    return delays


def flying_order(tracks: Sequence[FlightTrack], turn: int = 0) -> list[int]:
    """Return who is given its place first: who is in the air, then who flies longest.

    With `turn` so many of those in the air are given theirs after the others in the air.
    """
    order = sorted(
        range(len(tracks)), key=lambda k: (not tracks[k].is_aloft, -tracks[k].duration_s)
    )
    count = sum(track.is_aloft for track in tracks)
    aloft = order[:count]
    return [*aloft[turn:], *aloft[:turn], *order[count:]]


class Placed:
    """Tracks with their delays, which others are to keep away from."""

    def __init__(self, separation_m: float) -> None:
        self._separation = separation_m
        self._flights: list[tuple[FlightTrack, float]] = []

    def add(self, track: FlightTrack, delay_s: float) -> float:
        """Keep a place for a track, and return its delay: 0 s if no wait is long enough."""
        delay_s = delay_s if np.isfinite(delay_s) else 0.0
        self._flights.append((track, delay_s))
        return delay_s

    def delay_s(self, track: FlightTrack, limit_s: float = np.inf) -> float:
        """Return the least delay with which a track keeps away; infinite if above a limit.

        A vehicle in the air must keep away while it waits, too.
        """
        if track.is_aloft:
            limit_s = min(limit_s, track.longest_wait_s, _LONGEST_HOVER_S)
        near = [
            (other, delay)
            for other, delay in self._flights
            if _box_distance_m(track, other) < self._separation
        ]
        delay = 0.0
        while not self._is_apart(track, delay, near):
            delay += _DELAY_STEP_S
            if delay > limit_s:
                return np.inf
        return delay

    def _is_apart(
        self, track: FlightTrack, delay_s: float, near: list[tuple[FlightTrack, float]]
    ) -> bool:
        return all(
            _Pair((track, delay_s), (other, delay)).stays_apart(self._separation)
            for other, delay in near
        )


def _pairs_by_distance(tracks: Sequence[FlightTrack]) -> list[tuple[int, int]]:
    """Return all pairs, those whose boxes are near first: they bound the rest."""
    low = np.array([track.low for track in tracks])
    high = np.array([track.high for track in tracks])
    i, j = np.triu_indices(len(tracks), k=1)
    gaps = np.maximum(0.0, np.maximum(low[i] - high[j], low[j] - high[i]))
    nearest = np.argsort(np.hypot(gaps[:, 0], gaps[:, 1]), kind='stable')
    return list(zip(i[nearest].tolist(), j[nearest].tolist(), strict=True))


def _box_distance_m(a: FlightTrack, b: FlightTrack) -> float:
    gaps = np.maximum(0.0, np.maximum(a.low - b.high, b.low - a.high))
    return float(np.hypot(gaps[0], gaps[1]))


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
