# SPDX-License-Identifier: Apache-2.0
"""The Poisson likelihood of counts given sources and background, and its maximum.

Expected counts m = x (b + sum of s_k g(d_k)), with the exposure x, the background b = exp(c0 + ch
(h0 - h) / 120 m + sum of c_j phi_j) at the height h and the kernel g. The tilt t of a
`LawDeviation` may change the law of the dose rate. Parameters: c0, ch, c_j, t, then for each
source east, north, height above the ground there and the logarithm of its strength. Fitted by
damped Fisher scoring.

Errors of position and gain make counts scatter beyond Poisson by a share rho of the excess that
sources add. They enter as weights w = 1 / (1 + rho^2 e^2 / n), with the excess e over the
background level. The weights come from the data, so that all models with one rho have the same
weights. Half the sum of log w in the likelihood makes different rho comparable.

Objects beside a source may take a part of its dose rate from unknown readings. Each reading is
shaded with a probability `shade`: its m is then x (b + t sum), where t is one of `SHADES`, all
equally likely. The place of a source then follows from the readings that are not shaded.
"""

from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.fit_setting import WIDE_SPACING_HEIGHTS, Setting
from rocsafe_radiation.localization.law_deviation import LawDeviation
from rocsafe_radiation.localization.reading_weights import SHADES, chances_of, log_sums, weights_of
from rocsafe_radiation.readings.survey import RadiationSurvey

SOURCE_PARAMETERS = 4
UP = 2
# Prior of the logarithm of the background level, uSv/h: all levels that occur.
LEVEL_MEAN, LEVEL_STD = float(np.log(0.1)), 3.0
SMALLEST_COUNTS = 1e-9
# Radiation of the ground falls by a factor of e in so many metres of height. Prior of its share of
# the background.
GROUND_DECAY_M = 120.0
HEIGHT_MEAN, HEIGHT_STD = 0.7, 0.5
# Number of parameters before the bumps: c0 and ch.
LEVEL_PARAMETERS = 2
# Sources stay within so many heights of the survey: farther ones raise all readings alike.
REACH_HEIGHTS = 3.0
LARGEST_LOG_STEP = 1.5
LARGEST_DAMPING, SMALLEST_DAMPING = 1e8, 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """A maximum: parameters, log likelihood with priors, and the information matrix there."""

    parameters: FloatArray
    log_likelihood: float
    information: FloatArray


class Likelihood:
    """The likelihood of one survey in one setting."""

    def __init__(self, survey: RadiationSurvey, setting: Setting, basis: FloatArray) -> None:
        self.survey = survey
        self.setting = setting
        heights = survey.heights_m
        below = (np.median(heights) - heights)[:, None] / GROUND_DECAY_M
        bumps = basis if setting.background_std > 0.0 else basis[:, :0]
        self._deviation = LawDeviation(
            height_m=survey.height_m(setting.source_up_m),
            tilt_std=setting.tilt_std,
            has_shield=setting.has_shield,
            edge_sharpness=setting.edge_sharpness,
        )
        stds = self._deviation.stds
        # The parameters of the law are the last before the sources; they add nothing to the
        # background.
        self.basis = np.hstack([below, bumps, np.zeros((survey.size, stds.size))])
        self.head_size = 1 + self.basis.shape[1]
        bumps_end = LEVEL_PARAMETERS + bumps.shape[1]
        self.bumps, self.law = slice(LEVEL_PARAMETERS, bumps_end), slice(bumps_end, self.head_size)
        self.nuisance_stds = np.append(np.full(bumps.shape[1], setting.background_std), stds)
        self.weights = weights_of(survey, setting.rho)
        counts = survey.counts
        # With this constant the log likelihood of a perfect fit is 0, so that no large numbers are
        # compared.
        perfect = np.where(counts > 0.0, counts * np.log(np.maximum(counts, 1.0)) - counts, 0.0)
        self._constant = float(0.5 * np.log(self.weights).sum() - self.weights @ perfect)
        self._shape = 1.0 if survey.background_shape is None else survey.background_shape
        self._step_limit_m = 20.0
        places = survey.positions_enu_m[:, :2]
        reach = REACH_HEIGHTS * survey.height_m(setting.source_up_m)
        self._low, self._high = places.min(axis=0) - reach, places.max(axis=0) + reach
        self._columns = np.ascontiguousarray(survey.positions_enu_m.T)
        shades = SHADES if setting.shade > 0.0 else ()
        self._shares = np.array((1.0, *shades))
        chances = [1.0 - setting.shade, *(setting.shade / len(SHADES) for _ in shades)]
        self._log_chances = np.log(np.array(chances))[:, None]

    @property
    def has_narrow_hills(self) -> bool:
        """Whether the background may vary over lengths as short as the response to a source."""
        setting = self.setting
        is_narrow = setting.background_spacing_heights < WIDE_SPACING_HEIGHTS
        return is_narrow and setting.background_std > 0.0

    def source_count(self, parameters: FloatArray) -> int:
        """Return the number of sources that `parameters` describe."""
        return (len(parameters) - self.head_size) // SOURCE_PARAMETERS

    def sources(self, parameters: FloatArray) -> FloatArray:
        """Return east, north, height and log strength of each source, shape (sources, 4)."""
        return parameters[self.head_size :].reshape(-1, SOURCE_PARAMETERS)

    def background_usvh(self, parameters: FloatArray) -> FloatArray:
        """Return the background at each reading, shape (n,)."""
        logs = parameters[0] + self.basis @ parameters[1 : self.head_size]
        return np.asarray(np.exp(np.clip(logs, -30.0, 30.0)) * self._shape)

    def expected(self, parameters: FloatArray) -> FloatArray:
        """Return the expected counts of each reading, shape (n,)."""
        rates = self.background_usvh(parameters)
        sources = self.sources(parameters)
        if len(sources):
            rates = rates + self.source_rates_usvh(parameters).sum(axis=0)
        return np.asarray(np.maximum(self.survey.exposures * rates, SMALLEST_COUNTS))

    def source_rates_usvh(self, parameters: FloatArray) -> FloatArray:
        """Return the dose rate of each source at each reading, shape (sources, n)."""
        sources = self.sources(parameters)
        offsets = self._offsets(sources)
        squares = np.einsum('kcn,kcn->kn', offsets, offsets)
        values = np.exp(sources[:, 3])[:, None] * self.setting.kernel.values(squares)
        if self.law.stop > self.law.start:
            values *= self._deviation.factors(parameters[self.law], offsets)
        return np.asarray(values)

    def objective(self, parameters: FloatArray) -> float:
        """Return the log likelihood with priors."""
        logs = self._log_shares(self._shaded(parameters))
        misses = parameters - self._prior_means(parameters)
        prior = 0.5 * float(self._prior_precisions(parameters) @ (misses * misses))
        return float(log_sums(logs).sum()) + self._constant - prior

    def _shaded(self, parameters: FloatArray) -> FloatArray:
        """Return the expected counts for each share of the dose rate, shape (shares, n)."""
        if len(self._shares) == 1:
            return self.expected(parameters)[None]
        exposures = self.survey.exposures
        background = self.background_usvh(parameters) * exposures
        added = self.source_rates_usvh(parameters).sum(axis=0) * exposures
        return np.asarray(np.maximum(background + self._shares[:, None] * added, SMALLEST_COUNTS))

    def _log_shares(self, expected: FloatArray) -> FloatArray:
        """Return the weighted log likelihood of each reading for each share, with its prior."""
        terms = self.weights * (self.survey.counts * np.log(expected) - expected)
        return np.asarray(terms + self._log_chances)

    def dispersion(self, parameters: FloatArray) -> float:
        """Return Pearson's chi^2 in standard deviations above that of Poisson counts."""
        return self.misfit(parameters)[0]

    def misfit(self, parameters: FloatArray) -> tuple[float, float]:
        """Return the dispersion, and Pearson's chi^2 divided by the degrees of freedom."""
        shaded = self._shaded(parameters)
        expected = (chances_of(self._log_shares(shaded)) * shaded).sum(axis=0)
        chi2 = float(self.weights @ ((self.survey.counts - expected) ** 2 / expected))
        degrees = max(1.0, self.survey.size - self._determined(parameters))
        # The variance of each term, 2 + 1/m, matters with few counts.
        spread = float(np.sqrt((2.0 + 1.0 / np.maximum(expected, 1e-3)).sum()))
        return (chi2 - degrees) / spread, chi2 / degrees

    def _determined(self, parameters: FloatArray) -> float:
        """Return the number of parameters that the readings determine rather than the priors."""
        information, _ = self.information_and_gradient(parameters)
        known = self._prior_precisions(parameters)
        return len(parameters) - float(known @ np.diag(np.linalg.inv(information)))

    def fit(self, start: FloatArray, iterations: int = 40) -> Fit:
        """Return the maximum near `start`."""
        parameters, value = start, self.objective(start)
        damping = 1e-2
        for _ in range(iterations):
            information, gradient = self.information_and_gradient(parameters)
            gained = 0.0
            while damping < LARGEST_DAMPING:
                proposal = self._inside(parameters + self._step(information, gradient, damping))
                better = self.objective(proposal)
                if better >= value:
                    gained, parameters, value = better - value, proposal, better
                    damping = max(damping / 10.0, SMALLEST_DAMPING)
                    break
                damping *= 5.0
            if gained < 1e-5:
                break
        information, _ = self.information_and_gradient(parameters)
        return Fit(parameters=parameters, log_likelihood=value, information=information)

    def information_and_gradient(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the expected information and the gradient of the objective."""
        slopes = self._slopes(parameters)
        misses = parameters - self._prior_means(parameters)
        precisions = self._prior_precisions(parameters)
        shaded = self._shaded(parameters)
        chances = chances_of(self._log_shares(shaded)) * self.weights
        residuals = chances * (self.survey.counts / shaded - 1.0)
        gradient, information = self._summed(slopes, residuals, chances / shaded)
        gradient -= precisions * misses
        information[np.diag_indices_from(information)] += precisions
        return information, gradient

    def _summed(
        self, slopes: FloatArray, residuals: FloatArray, precision: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return gradient and information; residuals and precision of each share, (shares, n)."""
        if len(self._shares) == 1:
            return slopes.T @ residuals[0], (slopes * precision[0][:, None]).T @ slopes
        # Only derivatives by source parameters scale with the share: sum over shares first.
        own = np.arange(slopes.shape[1]) >= self.law.start
        once, twice = self._shares @ precision, self._shares**2 @ precision
        natural, added = slopes * ~own, slopes * own
        mixed = (natural * once[:, None]).T @ added
        information = (natural * precision.sum(axis=0)[:, None]).T @ natural + mixed + mixed.T
        information += (added * twice[:, None]).T @ added
        gradient = natural.T @ residuals.sum(axis=0) + added.T @ (self._shares @ residuals)
        return gradient, information

    def _slopes(self, parameters: FloatArray) -> FloatArray:
        """Return the derivative of expected counts by each parameter, shape (n, parameters)."""
        exposures, setting = self.survey.exposures, self.setting
        slopes = np.empty((self.survey.size, len(parameters)))
        rates = self.background_usvh(parameters)
        slopes[:, 0] = rates
        slopes[:, 1 : self.head_size] = self.basis * rates[:, None]
        sources = self.sources(parameters)
        if len(sources):
            offsets = self._offsets(sources)
            squares = np.einsum('kcn,kcn->kn', offsets, offsets)
            values, by_square = setting.kernel.values_and_slopes(squares)
            strengths = np.exp(sources[:, 3])[:, None]
            parts = np.empty((len(sources), SOURCE_PARAMETERS, self.survey.size))
            parts[:, :3] = (-2.0 * strengths * by_square)[:, None, :] * offsets
            parts[:, 3] = strengths * values
            if self.law.stop > self.law.start:
                self._deviate(parameters[self.law], offsets, parts, slopes)
            self.survey.ground.follow(parts, sources)
            slopes[:, self.head_size :] = parts.reshape(-1, self.survey.size).T
        return np.asarray(slopes * exposures[:, None])

    def _deviate(
        self, numbers: FloatArray, offsets: FloatArray, parts: FloatArray, slopes: FloatArray
    ) -> None:
        """Correct derivatives by sources for a deviating law, and add those by its parameters."""
        parts *= self._deviation.factors(numbers, offsets)[:, None]
        parts[:, :3] += parts[:, 3:] * self._deviation.slopes(numbers, offsets)
        features = self._deviation.features(numbers, offsets)
        slopes[:, self.law] = np.einsum('kn,jkn->nj', parts[:, 3], features)

    def _offsets(self, sources: FloatArray) -> FloatArray:
        """Return the vector from each source to each reading, shape (sources, 3, n)."""
        return self._columns[None, :, :] - self.survey.ground.raised(sources[:, :3])[:, :, None]

    def _step(self, information: FloatArray, gradient: FloatArray, damping: float) -> FloatArray:
        matrix = information.copy()
        diagonal = np.diag_indices_from(matrix)
        matrix[diagonal] += damping * matrix[diagonal] + 1e-12
        step: FloatArray = np.asarray(np.linalg.solve(matrix, gradient), np.float64)
        head = step[: self.head_size]
        np.clip(head, -LARGEST_LOG_STEP, LARGEST_LOG_STEP, out=head)
        sources = step[self.head_size :].reshape(-1, SOURCE_PARAMETERS)
        limits = np.array([self._step_limit_m] * 3 + [LARGEST_LOG_STEP])
        np.clip(sources, -limits, limits, out=sources)
        return step

    def _inside(self, parameters: FloatArray) -> FloatArray:
        """Return `parameters` with all sources moved to within reach of the readings."""
        sources = parameters[self.head_size :].reshape(-1, SOURCE_PARAMETERS)
        np.clip(sources[:, :2], self._low, self._high, out=sources[:, :2])
        limits = self._deviation.limits
        np.clip(parameters[self.law], -limits, limits, out=parameters[self.law])
        return parameters

    def _prior_means(self, parameters: FloatArray) -> FloatArray:
        means = np.zeros_like(parameters)
        means[0], means[1] = LEVEL_MEAN, HEIGHT_MEAN
        means[self.head_size + UP :: SOURCE_PARAMETERS] = self.setting.source_up_m
        return means

    def _prior_precisions(self, parameters: FloatArray) -> FloatArray:
        precisions = np.zeros_like(parameters)
        precisions[0], precisions[1] = LEVEL_STD**-2, HEIGHT_STD**-2
        precisions[LEVEL_PARAMETERS : self.head_size] = self.nuisance_stds**-2.0
        # A fixed height has a standard deviation of a tenth of a millimetre.
        up_std = max(self.setting.source_up_std_m, 1e-4)
        precisions[self.head_size + UP :: SOURCE_PARAMETERS] = up_std**-2
        return precisions
