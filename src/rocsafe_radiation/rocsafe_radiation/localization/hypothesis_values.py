# SPDX-License-Identifier: Apache-2.0
"""Fits of rising order with what speaks for each."""

from dataclasses import dataclass

import numpy as np

from rocsafe_radiation.localization.likelihood import Fit, Likelihood


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
