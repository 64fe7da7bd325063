# SPDX-License-Identifier: Apache-2.0
"""Choice among values by what each has brought so far (Ropke and Pisinger, 2006)."""

import numpy as np

from rocsafe_planner.solver.search.tuning import CycleTuning


class AdaptiveChoices:
    """Values of parameters with weights that follow their success.

    Parameters
    ----------
    values
        Values of each parameter.
    tuning
        Scores, and how fast weights follow them.
    choices
        Random numbers.
    """

    def __init__(
        self,
        values: dict[str, tuple[float, ...]],
        tuning: CycleTuning,
        choices: np.random.Generator,
    ) -> None:
        self._values, self._tuning, self._choices = values, tuning, choices
        self._weights = {name: np.ones(len(given)) for name, given in values.items()}

    def draw(self) -> dict[str, int]:
        """Return the number of a value of each parameter, by weight."""
        return {
            name: int(np.searchsorted(np.cumsum(w) / w.sum(), self._choices.random(), 'right'))
            for name, w in self._weights.items()
        }

    def value(self, name: str, drawn: dict[str, int]) -> float:
        """Return the value of a parameter that was drawn."""
        return self._values[name][drawn[name]]

    def reward(self, drawn: dict[str, int], score: float) -> None:
        """Let the weights of drawn values follow the score of their cycle."""
        memory = self._tuning.memory
        for name, number in drawn.items():
            weights = self._weights[name]
            weights[number] = memory * weights[number] + (1.0 - memory) * score
