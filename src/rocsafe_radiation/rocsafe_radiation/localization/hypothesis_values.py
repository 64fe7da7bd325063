# SPDX-License-Identifier: Apache-2.0
"""Fits with 0, 1, 2 ... sources and the evidence of each."""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_radiation.localization.likelihood import Fit, Likelihood

FREE_PARAMETERS = 3
"""Parameters of a source that the readings determine: east, north and strength."""


def source_penalty(likelihood: Likelihood) -> float:
    """Return the evidence that a source costs by its parameters (BIC, Schwarz 1978)."""
    return 0.5 * FREE_PARAMETERS * math.log(likelihood.survey.size)


def first_source_penalty(likelihood: Likelihood) -> float:
    """Return the evidence that the first source needs: its parameters and the prior odds."""
    return source_penalty(likelihood) - likelihood.setting.search.log_prior_odds_first


@dataclass(frozen=True, slots=True, kw_only=True)
class OrderSearch:
    """The best fit with each number of sources in one setting.

    Attributes
    ----------
    likelihood
        Likelihood of the survey in that setting.
    fits
        Best fit with 0, 1, 2 ... sources.
    scores
        Logarithm of the evidence of each, with prior odds: by BIC for sources, by Laplace's
        approximation for the background.
    """

    likelihood: Likelihood
    fits: tuple[Fit, ...]
    scores: tuple[float, ...]

    @property
    def order(self) -> int:
        """The number of sources with the best evidence."""
        return int(np.argmax(self.scores))

    @property
    def best(self) -> Fit:
        """The fit with that number of sources."""
        return self.fits[self.order]

    @property
    def dispersion(self) -> float:
        """Standard deviations by which its misfit exceeds that of Poisson counts."""
        return self.likelihood.dispersion(self.best.parameters)

    def probabilities(self) -> tuple[float, ...]:
        """Return the probability of each number of sources."""
        logs = np.array(self.scores) - max(self.scores)
        return tuple((np.exp(logs) / np.exp(logs).sum()).tolist())

    def gain(self, order: int) -> float:
        """Return the gain in log likelihood by the last of `order` sources."""
        return self.fits[order].log_likelihood - self.fits[order - 1].log_likelihood
