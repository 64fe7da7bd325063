# SPDX-License-Identifier: Apache-2.0
"""How probable each observation is with each agent, from cited tables.

A cell that no source fills is unknown. In its place stands the mean of the known cells of the
observation, so that a report of it neither favours nor rejects that agent among the others.
"""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any

import numpy as np

from rocsafe_dispersion.agents.agent_table import agents
from rocsafe_geo.arrays import FloatArray

NO_AGENT, SOMETHING_ELSE = 'no agent', 'something else'
# In the table of signs a source says only which agents cause a sign. These probabilities are
# choices: a sign that is listed for an agent, and one that is listed for other agents only.
SIGN_LISTED, SIGN_NOT_LISTED = 0.8, 0.05


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Signatures:
    """Probabilities of observations.

    Attributes
    ----------
    hypotheses
        Names of agents, then `NO_AGENT` and `SOMETHING_ELSE`.
    observations
        What can be reported as seen or not seen.
    probabilities : (hypotheses, observations)
        Probability that the observation is true; unknown cells are filled.
    is_known : (hypotheses, observations)
        Whether a source gives it.
    """

    hypotheses: tuple[str, ...]
    observations: tuple[str, ...]
    probabilities: FloatArray
    is_known: np.ndarray[Any, np.dtype[np.bool_]]

    def column(self, observation: str) -> int:
        """Return the column of an observation.

        Raises
        ------
        ValueError
            If there is none of that name.
        """
        if observation not in self.observations:
            known = ', '.join(self.observations)
            raise ValueError(f'observation {observation!r} is not known; known: {known}')
        return self.observations.index(observation)

    def of(self, names: Iterable[str]) -> 'Signatures':
        """Return the table of some of the hypotheses, in the order of `names`."""
        rows = [self.hypotheses.index(name) for name in names]
        return Signatures(
            hypotheses=tuple(self.hypotheses[row] for row in rows),
            observations=self.observations,
            probabilities=self.probabilities[rows],
            is_known=self.is_known[rows],
        )


@lru_cache(maxsize=1)
def signatures() -> Signatures:
    """Return the table of all agents."""
    seed, signs = _document('seed_signatures.json'), _document('sign_table.json')
    names = (*agents(), NO_AGENT, SOMETHING_ELSE)
    table = np.full((len(names), len(seed['observations']) + len(signs['observations'])), np.nan)
    width = len(seed['observations'])
    for name, row in seed['agents'].items():
        table[names.index(name), :width] = row
    named = sorted({agent for found in signs['observations'].values() for agent in found})
    for column, found in enumerate(signs['observations'].values(), width):
        for agent in named:
            table[names.index(agent), column] = SIGN_LISTED if agent in found else SIGN_NOT_LISTED
    absent = [*seed['no_agent'], *([seed['no_agent'][0]] * len(signs['observations']))]
    table[names.index(NO_AGENT)] = absent
    is_known = ~np.isnan(table)
    means = np.nanmean(np.delete(table, names.index(NO_AGENT), axis=0), axis=0)
    return Signatures(
        hypotheses=names,
        observations=(*seed['observations'], *signs['observations']),
        probabilities=np.where(is_known, table, means),
        is_known=is_known,
    )


@lru_cache(maxsize=1)
def placards() -> dict[str, int]:
    """Return the UN numbers of agents that have one of their own."""
    numbers: dict[str, int] = _document('un_numbers.json')['numbers']
    return numbers


def _document(name: str) -> dict[str, Any]:
    text = files('rocsafe_dispersion.identification').joinpath(name).read_text(encoding='utf-8')
    document: dict[str, Any] = json.loads(text)
    return document
