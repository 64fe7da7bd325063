# SPDX-License-Identifier: Apache-2.0
"""The return path of least dose, for a vehicle that turns back.

With estimates of the sources the dose of each way follows from them: the straight way, the way
that was flown, and shortest ways around the sources at several distances are compared. Without
estimates only the flown way is known: it is taken unless the straight way is shorter by more than
the dose rate fell along it. Exclusions are kept in any case, but by the flown way, which is free.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.detour import Place, Ring, WaysAround
from rocsafe_geo.limits import require_positive

S_PER_H = 3600.0
# Ways around the sources keep these distances, metres.
_BERTHS_M = (10.0, 20.0, 40.0, 80.0, 160.0)
_CORNERS = 12
_STEP_M = 2.0
# Below this distance, metres, an estimate of a source does not give the dose rate.
_LEAST_DISTANCE_M = 1.0
# The shorter path is taken if two doses differ by less than this share.
_EQUAL_SHARE = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimatedSource:
    """A source: its place (east, north, up), metres, and dose rate at 1 m, microsievert/h."""

    place_enu: tuple[float, float, float]
    at_1m_usvh: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Danger:
    """A vehicle that turns back, and what is known around it.

    Attributes
    ----------
    here_enu
        Where it is, metres.
    home
        Where it lands, (east, north), metres.
    speed_mps
        Speed over ground on the way.
    flown
        Places (east, north) that it has flown over since its take-off, in order, metres.
    flown_usvh
        Dose rate that it read at each of them, microsievert per hour.
    sources
        Estimated sources.
    exclusions
        Outlines of zones that are not flown over.
    clearance_m
        Distance to be kept from them, metres.
    """

    here_enu: tuple[float, float, float]
    home: Place
    speed_mps: float
    flown: tuple[Place, ...] = ()
    flown_usvh: tuple[float, ...] = ()
    sources: tuple[EstimatedSource, ...] = ()
    exclusions: tuple[Ring, ...] = ()
    clearance_m: float = 0.0

    def __post_init__(self) -> None:
        require_positive('speed_mps', self.speed_mps, 'm/s')
        if len(self.flown) != len(self.flown_usvh):
            raise ValueError(f'flown_usvh has {len(self.flown_usvh)} values: must be one a place')


@dataclass(frozen=True, slots=True, kw_only=True)
class Retreat:
    """A way home.

    Attributes
    ----------
    bends
        Places (east, north) on the way, without its ends, metres.
    dose_usv, straight_usv
        Expected dose on it, and on the straight way, microsievert.
    basis
        How the dose is known, in words.
    """

    bends: tuple[Place, ...]
    dose_usv: float
    straight_usv: float
    basis: str


def retreat(danger: Danger) -> Retreat:
    """Return the way home of least dose."""
    ways = list(_ways(danger))
    dose_of = _dose_by_sources if danger.sources else _dose_by_readings
    doses = [dose_of(danger, way) for way in ways]
    least = min(doses) * (1.0 + _EQUAL_SHARE)
    lengths = [
        _length_m(way) if dose <= least else math.inf
        for way, dose in zip(ways, doses, strict=True)
    ]
    best = lengths.index(min(lengths))
    basis = f'by the estimate of {len(danger.sources)} sources'
    return Retreat(
        bends=tuple(ways[best][1:-1]),
        dose_usv=doses[best],
        straight_usv=doses[0],
        basis=basis if danger.sources else 'by its readings, no source is found yet',
    )


def _ways(danger: Danger) -> Iterator[list[Place]]:
    """Yield the ways that are compared: straight, as flown, and around the sources."""
    here = danger.here_enu[:2]
    yield _around(danger, danger.exclusions)
    if danger.flown:
        yield [here, *reversed(danger.flown), danger.home]
    for berth_m in _BERTHS_M if danger.sources else ():
        rings = [_ring(source.place_enu[:2], berth_m) for source in danger.sources]
        yield _around(danger, (*danger.exclusions, *rings))


def _around(danger: Danger, zones: Sequence[Ring]) -> list[Place]:
    here = danger.here_enu[:2]
    if not zones:
        return [here, danger.home]
    return [here, *WaysAround(zones, danger.clearance_m, danger.home).bends(here), danger.home]


def _ring(centre: Place, radius_m: float) -> Ring:
    """Return a polygon around a circle."""
    outer_m = radius_m / math.cos(math.pi / _CORNERS)
    angles = [2.0 * math.pi * k / _CORNERS for k in range(_CORNERS)]
    return tuple(
        (centre[0] + outer_m * math.cos(a), centre[1] + outer_m * math.sin(a)) for a in angles
    )


def _dose_by_sources(danger: Danger, way: Sequence[Place]) -> float:
    """Return the dose of a way, by the inverse square law, microsievert."""
    places, step_s = _samples(danger, way)
    rates = np.zeros(len(places))
    for source in danger.sources:
        level = np.hypot(*(places - source.place_enu[:2]).T)
        distance = np.hypot(level, danger.here_enu[2] - source.place_enu[2])
        rates += source.at_1m_usvh / np.maximum(distance, _LEAST_DISTANCE_M) ** 2
    return float((rates * step_s).sum() / S_PER_H)


def _dose_by_readings(danger: Danger, way: Sequence[Place]) -> float:
    """Return the dose of a way if each place has the dose rate of the nearest reading.

    A place farther from all readings than the present one may have any: it counts as the highest
    of them.
    """
    places, step_s = _samples(danger, way)
    if not danger.flown:
        return float(step_s.sum() / S_PER_H)
    flown, rates = np.array(danger.flown), np.array(danger.flown_usvh)
    apart = np.hypot(*(places[:, None, :] - flown[None, :, :]).transpose(2, 0, 1))
    nearest = apart.argmin(axis=1)
    is_known = apart[np.arange(len(places)), nearest] <= _known_within_m(flown)
    assumed = np.where(is_known, rates[nearest], rates.max())
    return float((assumed * step_s).sum() / S_PER_H)


def _known_within_m(flown: FloatArray) -> float:
    """Return how far a reading is representative: to the next one, 10 m at least."""
    steps = np.hypot(*np.diff(flown, axis=0).T) if len(flown) > 1 else np.zeros(1)
    return max(10.0, float(np.median(steps)))


def _samples(danger: Danger, way: Sequence[Place]) -> tuple[FloatArray, FloatArray]:
    """Return places along a way, shape (n, 2), and the time spent around each, seconds."""
    places: list[FloatArray] = []
    steps: list[FloatArray] = []
    for a, b in pairwise(np.array(way, dtype=np.float64)):
        length_m = float(np.hypot(*(b - a)))
        count = max(1, math.ceil(length_m / _STEP_M))
        share = (np.arange(count) + 0.5) / count
        places.append(a + share[:, None] * (b - a))
        steps.append(np.full(count, length_m / count / danger.speed_mps))
    return np.vstack(places), np.concatenate(steps)


def _length_m(way: Sequence[Place]) -> float:
    return sum(math.dist(a, b) for a, b in pairwise(way))
