# SPDX-License-Identifier: Apache-2.0
"""Policies of a search by one drone: what a learned one has to be better than."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import cycle

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_learning.source_belief import Place
from rocsafe_learning.source_search import SourceSearch

Policy = Callable[[SourceSearch], Place]
"""Returns the next place, east and north in metres, from what the drone knows."""
LANES = 8
FEATURES = ('gain', 'time', 'distance to the mean place', 'share of probability nearby')
NEAR_M = 12.0


def lawn_mower(area_m: float, lanes: int = LANES) -> Policy:
    """Return the policy that goes up and down evenly spaced lanes, whatever is read."""
    middles = (np.arange(lanes) + 0.5) * area_m / lanes
    places = []
    for number, north in enumerate(middles.tolist()):
        row = middles if number % 2 == 0 else middles[::-1]
        places += [(east, north) for east in row.tolist()]
    ways = cycle(places)
    return lambda _search: next(ways)


def at_random(area_m: float, generator: np.random.Generator) -> Policy:
    """Return the policy that goes anywhere."""

    def choose(_search: SourceSearch) -> Place:
        east, north = generator.uniform(0.0, area_m, 2).tolist()
        return east, north

    return choose


def information_gain(area_m: float, lanes: int = LANES) -> Policy:
    """Return the policy that goes where a reading tells most per second of flight."""
    places = _lattice(area_m, lanes)

    def choose(search: SourceSearch) -> Place:
        scores = [
            _gain_nats(search, place) / (search.leg_s(search.places_m[0], place) + 2.0)
            for place in places
        ]
        return places[int(np.argmax(scores))]

    return choose


@dataclass(frozen=True, slots=True, eq=False)
class LinearPolicy:
    """Goes to the place with the largest weighted sum of `FEATURES`.

    Attributes
    ----------
    weights : (4,)
        Weight of each feature.
    area_m
        Side of the area, metres.
    lanes
        Places along each side to choose from; the mean place of the belief is one more.
    """

    weights: FloatArray
    area_m: float = 100.0
    lanes: int = LANES

    def __call__(self, search: SourceSearch) -> Place:
        """Return the next place."""
        mean = search.belief.mean_and_spread_m()[0]
        places = [*_lattice(self.area_m, self.lanes), mean]
        scores = [float(self.weights @ self._features(search, place, mean)) for place in places]
        return places[int(np.argmax(scores))]

    def _features(self, search: SourceSearch, place: Place, mean: Place) -> FloatArray:
        return np.array(
            [
                _gain_nats(search, place),
                search.leg_s(search.places_m[0], place) / 10.0,
                math.dist(place, mean) / self.area_m,
                _share_near(search, place),
            ]
        )


def _lattice(area_m: float, lanes: int) -> list[Place]:
    middles = ((np.arange(lanes) + 0.5) * area_m / lanes).tolist()
    return [(east, north) for north in middles for east in middles]


def _gain_nats(search: SourceSearch, place_m: Place) -> float:
    """Return the information of a reading if all that is expected were normal, nats."""
    signal, noise = search.belief.reading_spread(search.rounded_m(place_m))
    return 0.5 * math.log1p(signal / noise)


def _share_near(search: SourceSearch, place_m: Place) -> float:
    """Return the probability of a source near a place."""
    cells = search.belief.tables.cells
    size = search.belief.tables.area_m / cells
    low_east, low_north = (max(int((value - NEAR_M) / size), 0) for value in place_m)
    high_east, high_north = (int((value + NEAR_M) / size) + 1 for value in place_m)
    return float(search.belief.cells[low_north:high_north, low_east:high_east].sum())
