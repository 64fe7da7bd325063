# SPDX-License-Identifier: Apache-2.0
"""A search with sensors that only say yes or no: a grid of probabilities, by Bayes' rule.

Several agents search the same grid. What one sees is an observation with a name of its own; merged
beliefs are made from the union of observations, so none counts twice, in whatever order and
however often agents meet.
"""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class YesNoSensor:
    """A sensor that says whether there is something in the cell below.

    Attributes
    ----------
    false_positive
        Probability of yes where nothing is.
    false_negative
        Probability of no where something is.
    """

    false_positive: float
    false_negative: float

    def __post_init__(self) -> None:
        for name in ('false_positive', 'false_negative'):
            if not 0.0 < getattr(self, name) < 0.5:
                raise ValueError(f'{name} = {getattr(self, name)} must be between 0 and 0.5')

    def log_ratio(self, is_yes: bool) -> float:
        """Return by how much an answer raises the logarithm of the odds."""
        if is_yes:
            return math.log((1.0 - self.false_negative) / self.false_positive)
        return math.log(self.false_negative / (1.0 - self.false_positive))


@dataclass(frozen=True, slots=True)
class Sighting:
    """An answer of a sensor: who asked, its number, the cell (row, column) and the log ratio."""

    agent: str
    number: int
    cell: tuple[int, int]
    log_ratio: float


class BeliefGrid:
    """What one agent believes of each cell.

    Parameters
    ----------
    prior
        Probability of something in each cell before, shape (rows, columns).
    agent
        Name of the agent, different from all others.
    """

    def __init__(self, prior: FloatArray, agent: str) -> None:
        if not ((prior > 0.0) & (prior < 1.0)).all():
            raise ValueError('prior must lie between 0 and 1 in every cell')
        if not agent:
            raise ValueError('agent must have a name')
        self._agent = agent
        self._log_odds = np.log(prior / (1.0 - prior))
        self._seen: dict[tuple[str, int], Sighting] = {}
        self._own = 0

    @property
    def sightings(self) -> tuple[Sighting, ...]:
        """All that this agent has seen or been told."""
        return tuple(self._seen.values())

    def probabilities(self) -> FloatArray:
        """Return the probability of something in each cell, shape (rows, columns)."""
        return np.asarray(1.0 / (1.0 + np.exp(-np.clip(self._log_odds, -500.0, 500.0))))

    def observe(self, sensor: YesNoSensor, cell: tuple[int, int], is_yes: bool) -> Sighting:
        """Take an answer of this agent's own sensor."""
        rows, columns = self._log_odds.shape
        if not (0 <= cell[0] < rows and 0 <= cell[1] < columns):
            raise ValueError(f'cell = {cell} must lie within {rows} rows and {columns} columns')
        sighting = Sighting(self._agent, self._own, cell, sensor.log_ratio(is_yes))
        self._own += 1
        self._take(sighting)
        return sighting

    def merge(self, other: 'BeliefGrid') -> None:
        """Take what `other` has seen or been told, each sighting once."""
        if other._log_odds.shape != self._log_odds.shape:
            raise ValueError('grids of different shape cannot be merged')
        for sighting in other.sightings:
            self._take(sighting)

    def decided(self, probability: float) -> BoolArray:
        """Return which cells are decided either way with at least `probability`."""
        believed = self.probabilities()
        return np.asarray((believed >= probability) | (believed <= 1.0 - probability))

    def _take(self, sighting: Sighting) -> None:
        key = (sighting.agent, sighting.number)
        if key not in self._seen:
            self._seen[key] = sighting
            self._log_odds[sighting.cell] += sighting.log_ratio
