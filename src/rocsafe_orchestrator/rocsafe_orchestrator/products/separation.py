# SPDX-License-Identifier: Apache-2.0
"""Least distance between two vehicles in the air, from the recording."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.position import ecef_m
from rocsafe_orchestrator.products.run_record import FlightLog, IntArray, Track, VehicleSample

Span = tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Nearest:
    """The least distance of any two vehicles in the air, who they were, and when."""

    distance_m: float
    vehicles: tuple[str, str]
    time_ns: int


def airborne_spans_ns(samples: Sequence[VehicleSample]) -> tuple[Span, ...]:
    """Return the spans in which a vehicle was in the air: from such a state to the next other one.

    A vehicle that was never seen to land counts as flying until its last message.
    """
    spans = []
    for is_airborne, group in itertools.groupby(
        range(len(samples)), key=lambda number: samples[number].is_airborne
    ):
        if is_airborne:
            numbers = list(group)
            end = min(numbers[-1] + 1, len(samples) - 1)
            spans.append((samples[numbers[0]].time_ns, samples[end].time_ns))
    return tuple(spans)


def nearest_in_the_air(log: FlightLog) -> Nearest | None:
    """Return the least distance of any two vehicles in the air; None if no two ever were.

    Between two recorded positions each vehicle is taken to fly straight.
    """
    flown = {
        name: _Flown(track, airborne_spans_ns(log.samples.get(name, ())))
        for name, track in log.tracks.items()
    }
    return min(_pairs(flown), key=lambda found: found.distance_m, default=None)


def _pairs(flown: Mapping[str, '_Flown']) -> Iterator[Nearest]:
    for (name_a, a), (name_b, b) in itertools.combinations(flown.items(), 2):
        for span in _common(a.spans, b.spans):
            times = a.times_between(b, span)
            distance_m, time_ns = _least(a.places(times) - b.places(times), times)
            yield Nearest(distance_m=distance_m, vehicles=(name_a, name_b), time_ns=time_ns)


class _Flown:
    """A vehicle's track in the air."""

    def __init__(self, track: Track, spans: Sequence[Span]) -> None:
        self._times = track.time_ns
        self._places = ecef_m(track.latitude_deg, track.longitude_deg, track.altitude_m)
        first, last = int(track.time_ns[0]), int(track.time_ns[-1])
        self.spans = tuple((max(begin, first), min(end, last)) for begin, end in spans)

    def times_between(self, other: '_Flown', span: Span) -> IntArray:
        """Return all times within a span at which either was recorded, and its ends."""
        times = np.unique(np.concatenate([self._times, other._times, np.array(span)]))
        within: IntArray = times[(times >= span[0]) & (times <= span[1])]
        return within

    def places(self, times: IntArray) -> FloatArray:
        """Return where it was, shape (n, 3), metres."""
        zero = int(self._times[0])
        at, known = times - zero, self._times - zero
        return np.column_stack([np.interp(at, known, self._places[:, axis]) for axis in range(3)])


def _common(a: Sequence[Span], b: Sequence[Span]) -> Iterator[Span]:
    for (begin_a, end_a), (begin_b, end_b) in itertools.product(a, b):
        begin, end = max(begin_a, begin_b), min(end_a, end_b)
        if begin < end:
            yield begin, end


def _least(apart: FloatArray, times: IntArray) -> tuple[float, int]:
    """Return the least length of a vector (n, 3), linear between times, and its time."""
    change = np.diff(apart, axis=0)
    square = (change**2).sum(axis=1)
    towards = -(apart[:-1] * change).sum(axis=1)
    share = np.clip(np.divide(towards, square, out=np.zeros_like(square), where=square > 0), 0, 1)
    nearest = np.sqrt(((apart[:-1] + share[:, None] * change) ** 2).sum(axis=1))
    number = int(nearest.argmin())
    span_ns = int(times[number + 1]) - int(times[number])
    return float(nearest[number]), int(times[number]) + round(float(share[number]) * span_ns)
