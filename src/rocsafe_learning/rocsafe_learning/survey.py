# SPDX-License-Identifier: Apache-2.0
"""A survey: one drone photographs an area until all of it is seen or its battery is empty."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import BoolArray
from rocsafe_geo.limits import require_between, require_positive
from rocsafe_geo.motion.leg import leg_duration_s
from rocsafe_geo.motion.performance import Performance
from rocsafe_learning.source_belief import Place
from rocsafe_learning.source_search import default_performance

CELLS = 32


@dataclass(frozen=True, slots=True, kw_only=True)
class SurveyOptions:
    """What is photographed, and what it is worth.

    Attributes
    ----------
    area_m
        Side of the square area, metres.
    footprint_m
        Ground that a photograph shows, east and north, metres.
    performance
        Limits of the flight.
    endurance_s
        Time of flight, the way home included, seconds.
    hover_s
        Time of a photograph, seconds.
    complete_share
        Share of the area at which the survey is complete.
    reward_per_share, reward_per_s
        Reward of the whole area seen, and of a second.
    """

    area_m: float = 100.0
    footprint_m: tuple[float, float] = (25.0, 19.0)
    performance: Performance = field(default_factory=default_performance)
    endurance_s: float = 300.0
    hover_s: float = 1.0
    complete_share: float = 0.99
    reward_per_share: float = 10.0
    reward_per_s: float = -0.02

    def __post_init__(self) -> None:
        require_between('area_m', self.area_m, 10.0, 10_000.0, 'm')
        require_positive('endurance_s', self.endurance_s, 's')
        require_between('complete_share', self.complete_share, 0.01, 1.0)
        for side in self.footprint_m:
            require_positive('footprint_m', side, 'm')


class Survey:
    """One survey after another.

    Parameters
    ----------
    options
        What is photographed.

    Attributes
    ----------
    seen : (32, 32)
        Which cells a photograph shows, by their middles; rows from the south.
    """

    def __init__(self, options: SurveyOptions) -> None:
        self.options = options
        self._centres_m = options.area_m / CELLS * (np.arange(CELLS) + 0.5)
        self.begin((0.0, 0.0))

    def begin(self, home_m: Place) -> None:
        """Begin at a home, with nothing seen."""
        self.home_m = self.place_m = home_m
        self.seen: BoolArray = np.zeros((CELLS, CELLS), bool)
        self.time_s = 0.0

    def advance(self, target_m: Place) -> float:
        """Fly to a place, take a photograph and return the reward.

        The drone does not fly where it would not get home from: it goes home instead.
        """
        target = self._within(target_m)
        needed = self._leg_s(self.place_m, target) + self.options.hover_s
        if self.time_s + needed + self._leg_s(target, self.home_m) > self.options.endurance_s:
            spent, self.place_m = self._leg_s(self.place_m, self.home_m), self.home_m
            self.time_s = self.options.endurance_s
            return self.options.reward_per_s * spent
        self.place_m = target
        self.time_s += needed
        before = self.seen.mean()
        self.seen |= self._shown()
        won = float(self.seen.mean() - before)
        return self.options.reward_per_share * won + self.options.reward_per_s * needed

    @property
    def is_complete(self) -> bool:
        """Whether enough of the area is seen."""
        return bool(self.seen.mean() >= self.options.complete_share)

    @property
    def is_over(self) -> bool:
        """Whether the drone had to go home."""
        return self.time_s >= self.options.endurance_s

    def seen_share(self) -> NDArray[np.float32]:
        """Return 1 for each cell that is seen, else 0, (32, 32)."""
        return self.seen.astype(np.float32)

    def _shown(self) -> BoolArray:
        """Return the cells that a photograph from here shows."""
        east, north = self.place_m
        width, height = self.options.footprint_m
        columns = np.abs(self._centres_m - east) <= width / 2.0
        rows = np.abs(self._centres_m - north) <= height / 2.0
        return rows[:, None] & columns

    def _within(self, target_m: Place) -> Place:
        side = self.options.area_m
        east, north = (min(max(value, 0.0), side) for value in target_m)
        return east, north

    def _leg_s(self, start_m: Place, end_m: Place) -> float:
        distance = math.dist(start_m, end_m)
        return float(leg_duration_s(distance, self.options.performance.level)) if distance else 0.0
