# SPDX-License-Identifier: Apache-2.0
"""The likelihood of counts given sources and background, its maximum and its evidence.

Counts scatter about those expected (`counts_model`) beyond Poisson by errors of the fixes, in all
three coordinates, times the slope of m (errors in variables, Fuller 1987), and by a share rho of
what the sources add. This variance v enters as the weight w = m / (m + v) and as half of its
logarithm (quasi-likelihood, McCullagh and Nelder 1989). A small share of readings are spikes that
tell nothing: each reading is a mixture of both.

The evidence is Laplace's approximation of the integral over all parameters.
"""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.counts_model import STRENGTH, UP, CountsModel
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.readings.survey import RadiationSurvey

# Sources stay within so many heights of the survey: farther ones raise all readings alike.
REACH_HEIGHTS = 3.0
LARGEST_LOG_STEP, LARGEST_STEP_M = 1.5, 20.0
LARGEST_DAMPING, SMALLEST_DAMPING = 1e8, 1e-9
# The variance follows the parameters: so many times it is computed anew.
WEIGHT_ROUNDS = 3
# Counts of spikes are spread over so many factors of e.
SPIKE_SPREAD = 10.0
# A step that gains less log likelihood is the last one.
LEAST_GAIN = 1e-2


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """A maximum: parameters, log likelihood with priors, and the information matrix there."""

    parameters: FloatArray
    log_likelihood: float
    information: FloatArray

    @property
    def covariance(self) -> FloatArray:
        """The inverse of the information."""
        return np.asarray(np.linalg.inv(self.information), np.float64)


class Likelihood(CountsModel):
    """The likelihood of one survey in one setting."""

    def __init__(self, survey: RadiationSurvey, setting: Setting, basis: FloatArray) -> None:
        super().__init__(survey, setting, basis)
        counts = survey.counts
        # With this constant the log likelihood of a perfect fit is 0, so that no large numbers are
        # compared.
        self._perfect = np.where(counts > 0.0, counts * np.log(np.maximum(counts, 1.0)), 0.0)
        self._perfect -= counts
        share = setting.search.outlier_share
        self._spike_logs = np.log(
            share * np.sqrt(2.0 * math.pi / np.maximum(counts, 1.0)) / SPIKE_SPREAD
        )
        reach = REACH_HEIGHTS * survey.height_m(setting.source_up_m)
        places = survey.positions_enu_m[:, :2]
        self._low, self._high = places.min(axis=0) - reach, places.max(axis=0) + reach
        self._area_m2 = float(np.prod(self._high - self._low))

    def objective(self, parameters: FloatArray, weights: FloatArray | None = None) -> float:
        """Return the log likelihood with priors; `weights` are those of `parameters` if None."""
        weights = self.weights(parameters) if weights is None else weights
        logs = np.logaddexp(self._logs(self.expected(parameters), weights), self._spike_logs)
        return float(logs.sum()) - self._prior_cost(parameters)

    def _logs(self, expected: FloatArray, weights: FloatArray) -> FloatArray:
        misses = self.survey.counts * np.log(expected) - expected - self._perfect
        return np.asarray(weights * misses + 0.5 * np.log(weights))

    def _prior_cost(self, parameters: FloatArray) -> float:
        means, precisions = self.priors(parameters)
        misses = parameters - means
        return 0.5 * float(precisions @ (misses * misses))

    def regular_shares(self, expected: FloatArray, weights: FloatArray) -> FloatArray:
        """Return the probability of each reading that it is no spike, shape (n,)."""
        ratios = np.clip(self._spike_logs - self._logs(expected, weights), -50.0, 50.0)
        return np.asarray(1.0 / (1.0 + np.exp(ratios)))

    def misfit(self, parameters: FloatArray, are_spikes_left_out: bool) -> tuple[float, float]:
        """Return by how much Pearson's chi^2 is above its expectation.

        Returns
        -------
        dispersion : float
            In standard deviations.
        ratio : float
            Chi^2 divided by the degrees of freedom.
        """
        weights = self.weights(parameters)
        expected = self.expected(parameters)
        regular: FloatArray = np.ones(self.survey.size)
        if are_spikes_left_out:
            regular = self.regular_shares(expected, weights)
        chi2 = float((weights * regular) @ ((self.survey.counts - expected) ** 2 / expected))
        information, _ = self.information_and_gradient(parameters, weights)
        _, precisions = self.priors(parameters)
        determined = len(parameters) - precisions @ np.diag(np.linalg.inv(information))
        degrees = max(1.0, float(regular.sum() - determined))
        # The variance of each term, 2 + 1/m, matters with few counts.
        spread = float(np.sqrt((2.0 + 1.0 / np.maximum(expected, 1e-3)).sum()))
        return (chi2 - degrees) / spread, chi2 / degrees

    def fit(self, start: FloatArray, iterations: int = 40) -> Fit:
        """Return the maximum near `start`."""
        parameters = start
        for _ in range(WEIGHT_ROUNDS):
            weights = self.weights(parameters)
            before = self.objective(parameters)
            parameters = self._climbed(parameters, weights, iterations)
            value = self.objective(parameters)
            if abs(value - before) < LEAST_GAIN:
                break
        information, _ = self.information_and_gradient(parameters, self.weights(parameters))
        return Fit(parameters=parameters, log_likelihood=value, information=information)

    def hoped_for(self, start: FloatArray) -> Fit:
        """Return more than what a fit begun at `start` reaches, without fitting.

        It gains twice what Newton's step promises, which is exact where the logarithm of the
        likelihood is quadratic.
        """
        weights = self.weights(start)
        information, gradient = self.information_and_gradient(start, weights)
        gain = float(gradient @ np.linalg.solve(information, gradient))
        value = self.objective(start, weights) + gain
        return Fit(parameters=start, log_likelihood=value, information=information)

    def _climbed(self, parameters: FloatArray, weights: FloatArray, iterations: int) -> FloatArray:
        value, damping = self.objective(parameters, weights), 1e-2
        for _ in range(iterations):
            information, gradient = self.information_and_gradient(parameters, weights)
            gained = 0.0
            while damping < LARGEST_DAMPING:
                proposal = self._inside(parameters + self._step(information, gradient, damping))
                better = self.objective(proposal, weights)
                if better >= value:
                    gained, parameters, value = better - value, proposal, better
                    damping = max(damping / 10.0, SMALLEST_DAMPING)
                    break
                damping *= 5.0
            if gained < LEAST_GAIN:
                break
        return parameters

    def information_and_gradient(
        self, parameters: FloatArray, weights: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the expected information and the gradient of the objective."""
        slopes, expected = self.slopes(parameters)
        means, precisions = self.priors(parameters)
        shares = weights * self.regular_shares(expected, weights)
        gradient = slopes.T @ (shares * (self.survey.counts / expected - 1.0))
        gradient -= precisions * (parameters - means)
        information = (slopes * (shares / expected)[:, None]).T @ slopes
        information.flat[:: len(parameters) + 1] += precisions
        # A Gaussian as wide as the area of all places: readings may tell nothing of a place.
        places = self.source_rows(len(parameters))[:, :UP]
        information[places, places] += 2.0 * math.pi / self._area_m2
        return information, gradient

    def evidence(self, fit: Fit) -> float:
        """Return the logarithm of the integral of likelihood times prior about `fit`.

        Places are equally likely all over the survey and its margin. Sources have no order: each
        of their permutations is a maximum of its own.
        """
        count = self.source_count(fit.parameters)
        _, precisions = self.priors(fit.parameters)
        proper = precisions[precisions > 0.0]
        _, volume = np.linalg.slogdet(fit.information)
        places = count * math.log(2.0 * math.pi / self._area_m2) + math.lgamma(count + 1.0)
        return float(fit.log_likelihood + 0.5 * (np.log(proper).sum() - volume) + places)

    def _step(self, information: FloatArray, gradient: FloatArray, damping: float) -> FloatArray:
        matrix = information.copy()
        diagonal = matrix.diagonal()
        matrix.flat[:: len(matrix) + 1] += damping * diagonal + 1e-12
        step: FloatArray = np.asarray(np.linalg.solve(matrix, gradient), np.float64)
        head = step[: self.head_size]
        np.clip(head, -LARGEST_LOG_STEP, LARGEST_LOG_STEP, out=head)
        sources = self.sources(step)
        limits = np.full(self.source_size, LARGEST_LOG_STEP)
        limits[:STRENGTH] = LARGEST_STEP_M
        np.clip(sources, -limits, limits, out=sources)
        return step

    def _inside(self, parameters: FloatArray) -> FloatArray:
        """Return `parameters` with all sources moved to within reach of the readings."""
        sources = self.sources(parameters)
        np.clip(sources[:, :2], self._low, self._high, out=sources[:, :2])
        return parameters
