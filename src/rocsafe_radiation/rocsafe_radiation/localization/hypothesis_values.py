# SPDX-License-Identifier: Apache-2.0
"""Fits of rising order with what speaks for each."""

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
    """The best fit of each order in one setting.

    Attributes
    ----------
    likelihood
        With its setting.
    fits
        Of 0, 1, 2 ... sources.
    scores
        Logarithm of the evidence of each, by BIC for sources and Laplace for the background, and
        of the prior odds.
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
        """The fit of that order."""
        return self.fits[self.order]

    @property
    def dispersion(self) -> float:
        """By how many standard deviations its misfit exceeds that of Poisson counts."""
        return self.likelihood.dispersion(self.best.parameters)

    def probabilities(self) -> tuple[float, ...]:
        """Return the probability of each order, sources being rare before."""
        logs = np.array(self.scores) - max(self.scores)
        return tuple((np.exp(logs) / np.exp(logs).sum()).tolist())

    def gain(self, order: int) -> float:
        """Return by how much one source more than `order` - 1 explains the readings better."""
        return self.fits[order].log_likelihood - self.fits[order - 1].log_likelihood
