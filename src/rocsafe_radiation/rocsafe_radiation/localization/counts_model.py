# SPDX-License-Identifier: Apache-2.0
"""Expected counts of sources and background, their derivatives, and the priors of the parameters.

Expected counts m = x (b + sum of s_k g(d_k) f_k) + z, with the exposure x, dark counts z, the
kernel g and the background

    b = exp(c0 + ch (h0 - h) / 120 m + cx e + cy n + sum of c_j phi_j)

at the height h, east e and north n in half extents of the survey: a level, a trend and a random
field of few bumps phi_j, whose coefficients have a Gaussian prior. f_k is what a wall beside the
source leaves of it (`shade`), 1 in settings without walls. Parameters: c0, ch, cx, cy, c_j, then
for each source east, north, height above the ground there, the logarithm of its strength, and the
parameters of its shade.

Where the errors of fixes have something in common, parameters of these follow the background:
east, north and up of each leg, a difference between the clocks of places and readings, which moves
places along the flight, and the slope of the logarithm of each detector's gain with time.
"""

import math

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.shade import (
    SHADE_MEANS,
    SHADE_PARAMETERS,
    SHADE_STDS,
    left,
    left_and_slopes,
    paths,
)
from rocsafe_radiation.readings.survey import RadiationSurvey

SOURCE_PARAMETERS = 4
UP, STRENGTH = 2, 3
SMALLEST_COUNTS = 1e-9
# Radiation of the ground falls by a factor of e in so many metres of height.
GROUND_DECAY_M = 120.0
# Priors of the head: logarithm of the level in uSv/h, share of the ground in the background, slope
# of the logarithm over half of the extent. All levels occur.
HEAD_MEANS = np.array([math.log(0.1), 0.7, 0.0, 0.0])
TREND_STDS = np.array([3.0, 0.5, 0.3, 0.3])
HEAD_SIZE = len(HEAD_MEANS)
# Prior standard deviation of the difference of the clocks of fixes and readings, seconds.
CLOCK_STD_S = 1.0
# That of the logarithm of the gain of a detector at the end of a flight over that at its start.
GAIN_STD = 0.3
# Standard deviation of what is fixed.
FIXED_STD = 1e-4
# Prior of the logarithm of the strength, uSv/h at 1 m: 10 MBq to 1 TBq of Cs-137 within two
# standard deviations.
STRENGTH_MEAN, STRENGTH_STD = math.log(300.0), 3.0


class CountsModel:
    """What readings of one survey are expected to be, in one setting."""

    def __init__(self, survey: RadiationSurvey, setting: Setting, basis: FloatArray) -> None:
        self.survey = survey
        self.setting = setting
        heights = survey.heights_m
        below = (np.median(heights) - heights) / GROUND_DECAY_M
        places = survey.positions_enu_m[:, :2]
        half_m = max(0.5 * float(np.ptp(places, axis=0).max()), 1.0)
        trend = (places - places.mean(axis=0)) / half_m
        field = basis if setting.background_std > 0.0 else basis[:, :0]
        self.basis = np.column_stack([np.ones(survey.size), below, trend, field])
        self.background_size = self.head_size = self.basis.shape[1]
        self._flight = survey.flight if setting.drift_std_m > 0.0 else None
        if self._flight is not None:
            self._clock = self.head_size + 3 * (int(self._flight.legs.max()) + 1)
            self.head_size = self._clock + 2 + int(self._flight.vehicles.max())
            self._flown = self._flight.times_s / max(float(self._flight.times_s.max()), 1e-9)
        self.source_size = SOURCE_PARAMETERS
        if setting.has_shades:
            self.source_size += SHADE_PARAMETERS
        self._shape = 1.0 if survey.background_shape is None else survey.background_shape
        self._columns = np.ascontiguousarray(survey.positions_enu_m.T)

    def source_count(self, parameters: FloatArray) -> int:
        """Return the number of sources that `parameters` describe."""
        return (len(parameters) - self.head_size) // self.source_size

    def sources(self, parameters: FloatArray) -> FloatArray:
        """Return the parameters of each source, shape (sources, source_size)."""
        return parameters[self.head_size :].reshape(-1, self.source_size)

    def source_rows(self, count: int) -> IndexArray:
        """Return which of `count` parameters are those of each source, (sources, source_size)."""
        return np.arange(self.head_size, count, dtype=np.intp).reshape(-1, self.source_size)

    def background_usvh(self, parameters: FloatArray) -> FloatArray:
        """Return the background at each reading, shape (n,)."""
        logs = self.basis @ parameters[: self.background_size]
        return np.asarray(np.exp(np.clip(logs, -30.0, 30.0)) * self._shape)

    def expected(self, parameters: FloatArray) -> FloatArray:
        """Return the expected counts of each reading, shape (n,)."""
        rates = self.background_usvh(parameters)
        sources = self.sources(parameters)
        if len(sources):
            offsets = self.offsets(sources, parameters)
            squares = self._squares(offsets)
            values = self.setting.kernel.values(squares)
            if self.setting.has_shades:
                shades = sources[:, SOURCE_PARAMETERS:]
                values = values * left(paths(offsets, np.sqrt(squares), shades))
            rates = rates + np.exp(sources[:, STRENGTH]) @ values
        counts = self._exposures(parameters) * rates + self.survey.dark_counts
        return np.asarray(np.maximum(counts, SMALLEST_COUNTS))

    def clock_and_gains(
        self, parameters: FloatArray, covariance: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return what a fit tells of the clock, and the gain of each vehicle at the end of all.

        Returns
        -------
        values : shape (0,) or (1 + vehicles,)
            Seconds by which places are those before the readings, and logarithms of gains.
        stds : of the same shape
            Their standard deviations.
        """
        if self._flight is None:
            return np.empty(0), np.empty(0)
        own = slice(self._clock, self.head_size)
        return parameters[own], np.sqrt(np.diag(covariance)[own])

    def weights(self, parameters: FloatArray) -> FloatArray:
        """Return the share of the variance of each reading that is that of its counts, (n,)."""
        setting = self.setting
        sources = self.sources(parameters)
        if not len(sources) or (setting.position_std_m == 0.0 and setting.rho == 0.0):
            return np.ones(self.survey.size)
        exposures = self._exposures(parameters)
        parts = self._source_slopes(parameters) * exposures
        slopes = parts[:, :3].sum(axis=0)
        added = parts[:, STRENGTH].sum(axis=0)
        extra = setting.position_std_m**2 * (slopes * slopes).sum(axis=0)
        extra += (setting.rho * added) ** 2
        natural = exposures * self.background_usvh(parameters)
        expected = np.maximum(natural + added + self.survey.dark_counts, SMALLEST_COUNTS)
        return np.asarray(expected / (expected + extra))

    def slopes(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the derivative of expected counts by each parameter, and expected counts.

        Returns
        -------
        slopes : shape (n, parameters)
        expected : shape (n,)
        """
        exposures = self._exposures(parameters)
        rates = self.background_usvh(parameters)
        slopes = np.empty((self.survey.size, len(parameters)))
        slopes[:, : self.background_size] = self.basis * rates[:, None]
        slopes[:, self.background_size : self.head_size] = 0.0
        sources = self.sources(parameters)
        if len(sources):
            parts = self._source_slopes(parameters)
            rates = rates + parts[:, STRENGTH].sum(axis=0)
            if self._flight is not None:
                by_place = -parts[:, :3].sum(axis=0)
                rows = np.arange(self.survey.size)[:, None]
                for axis in range(3):
                    columns = self.background_size + 3 * self._flight.legs + axis
                    slopes[rows, columns] = by_place[axis, :, None]
                by_time = np.einsum('cn,nc->n', by_place, self._flight.velocities_mps)
                slopes[:, self._clock] = by_time
            self.survey.ground.follow(parts, sources)
            slopes[:, self.head_size :] = parts.reshape(-1, self.survey.size).T
        if self._flight is not None:
            columns = self._clock + 1 + self._flight.vehicles
            slopes[np.arange(self.survey.size), columns] = rates * self._flown
        expected = np.maximum(exposures * rates + self.survey.dark_counts, SMALLEST_COUNTS)
        return slopes * exposures[:, None], expected

    def offsets(self, sources: FloatArray, parameters: FloatArray | None = None) -> FloatArray:
        """Return the vector from each source to each reading, shape (sources, 3, n).

        With `parameters`, errors of the fixes that are common to a leg, and that of the clock, are
        taken off.
        """
        columns = self._columns
        if self._flight is not None and parameters is not None:
            drifts = parameters[self.background_size : self._clock].reshape(-1, 3)
            late_s = parameters[self._clock]
            columns = columns + drifts[self._flight.legs].sum(axis=1).T
            columns = columns + late_s * self._flight.velocities_mps.T
        return columns[None, :, :] - self.survey.ground.raised(sources[:, :3])[:, :, None]

    def priors(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return mean and precision of each parameter; a precision of 0: equally likely."""
        means, precisions = np.zeros((2, len(parameters)))
        means[:HEAD_SIZE] = HEAD_MEANS
        precisions[:HEAD_SIZE] = TREND_STDS**-2.0
        if self.background_size > HEAD_SIZE:
            precisions[HEAD_SIZE : self.background_size] = self.setting.background_std**-2
        if self._flight is not None:
            scales = self._flight.legs.shape[1]
            precisions[self.background_size : self._clock] = scales * self.setting.drift_std_m**-2
            precisions[self._clock] = CLOCK_STD_S**-2
            precisions[self._clock + 1 : self.head_size] = GAIN_STD**-2
        own_means, own = self.sources(means), self.sources(precisions)
        own_means[:, UP] = self.setting.source_up_m
        own[:, UP] = max(self.setting.source_up_std_m, FIXED_STD) ** -2.0
        own_means[:, STRENGTH], own[:, STRENGTH] = STRENGTH_MEAN, STRENGTH_STD**-2
        if self.source_size > SOURCE_PARAMETERS:
            own_means[:, SOURCE_PARAMETERS:] = SHADE_MEANS
            own[:, SOURCE_PARAMETERS:] = SHADE_STDS**-2.0
        return means, precisions

    def _exposures(self, parameters: FloatArray) -> FloatArray:
        """Return the exposures, shape (n,), with the gain that each detector has got by then."""
        if self._flight is None:
            return self.survey.exposures
        changes = parameters[self._clock + 1 : self.head_size][self._flight.vehicles]
        return np.asarray(self.survey.exposures * np.exp(changes * self._flown))

    def _source_slopes(self, parameters: FloatArray) -> FloatArray:
        """Return derivatives of the dose rate of each source by its parameters, (k, size, n).

        That by the logarithm of the strength is the dose rate itself.
        """
        sources = self.sources(parameters)
        offsets = self.offsets(sources, parameters)
        squares = self._squares(offsets)
        values, by_square = self.setting.kernel.values_and_slopes(squares)
        strengths = np.exp(sources[:, STRENGTH])[:, None]
        parts = np.empty((len(sources), self.source_size, self.survey.size))
        parts[:, :3] = (-2.0 * strengths * by_square)[:, None, :] * offsets
        parts[:, STRENGTH] = strengths * values
        if self.setting.has_shades:
            shades = sources[:, SOURCE_PARAMETERS:]
            kept, slopes = left_and_slopes(offsets, np.sqrt(squares), shades)
            parts[:, :SOURCE_PARAMETERS] *= kept[:, None]
            rates = parts[:, STRENGTH, None]
            parts[:, :3] += rates * slopes[:, :3]
            parts[:, SOURCE_PARAMETERS:] = rates * slopes[:, 3:]
        return parts

    @staticmethod
    def _squares(offsets: FloatArray) -> FloatArray:
        return np.asarray(np.einsum('kcn,kcn->kn', offsets, offsets))
