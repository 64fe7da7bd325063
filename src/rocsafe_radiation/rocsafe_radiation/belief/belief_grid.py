# SPDX-License-Identifier: Apache-2.0
"""Search with yes-or-no sensors: a grid of probabilities, by Bayes' rule.

Several agents search the same grid. Each answer of a sensor is a sighting with a unique name.
Merged beliefs come from the union of sightings: none counts twice, in any order and for any number
of merges.
"""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class YesNoSensor:
    """A sensor that reports whether there is a source in the cell below.

    Attributes
    ----------
    false_positive
        Probability of yes where there is no source.
    false_negative
        Probability of no where there is a source.
    """

    false_positive: float
    false_negative: float

    def __post_init__(self) -> None:
        for name in ('false_positive', 'false_negative'):
            if not 0.0 < getattr(self, name) < 0.5:
                raise ValueError(f'{name} = {getattr(self, name)} must be between 0 and 0.5')

    def log_ratio(self, is_yes: bool) -> float:
        """Return the change of the log odds by an answer."""
        if is_yes:
            return math.log((1.0 - self.false_negative) / self.false_positive)
        return math.log(self.false_negative / (1.0 - self.false_positive))


@dataclass(frozen=True, slots=True)
class Sighting:
    """An answer of a sensor: agent, number, cell (row, column) and change of the log odds."""

    agent: str
    number: int
    cell: tuple[int, int]
    log_ratio: float


class BeliefGrid:
    """The probability of a source in each cell, as one agent knows it.

    Parameters
    ----------
    prior
        Prior probability of a source in each cell, shape (rows, columns).
    agent
        Name of the agent, unique.
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
        """All sightings of this agent and of those merged."""
        return tuple(self._seen.values())

    def probabilities(self) -> FloatArray:
        """Return the probability of a source in each cell, shape (rows, columns)."""
        return np.asarray(1.0 / (1.0 + np.exp(-np.clip(self._log_odds, -500.0, 500.0))))

    def observe(self, sensor: YesNoSensor, cell: tuple[int, int], is_yes: bool) -> Sighting:
        """Add an answer of this agent's own sensor."""
        rows, columns = self._log_odds.shape
        if not (0 <= cell[0] < rows and 0 <= cell[1] < columns):
            raise ValueError(f'cell = {cell} must lie within {rows} rows and {columns} columns')
        sighting = Sighting(self._agent, self._own, cell, sensor.log_ratio(is_yes))
        self._own += 1
        self._take(sighting)
        return sighting

    def merge(self, other: 'BeliefGrid') -> None:
        """Add the sightings of `other`, each once."""
        if other._log_odds.shape != self._log_odds.shape:
            raise ValueError('grids of different shape cannot be merged')
        for sighting in other.sightings:
            self._take(sighting)

    def _take(self, sighting: Sighting) -> None:
        key = (sighting.agent, sighting.number)
        if key not in self._seen:
            self._seen[key] = sighting
            self._log_odds[sighting.cell] += sighting.log_ratio
