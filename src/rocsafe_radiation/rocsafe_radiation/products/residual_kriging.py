# SPDX-License-Identifier: Apache-2.0
"""Kriged residual of readings about sources and a constant background, in the logarithm.

The logarithms of counts over expected counts are a random field with exponential covariance plus
the noise of the counts (simple kriging, or a Gaussian process). Its variance is that of the
readings beyond their counts, its length the most likely of a few. Where the readings agree with
the estimate, there is no residual.
"""

from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.estimates import Localization
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.readings.survey import RadiationSurvey

MOST_READINGS = 600
MOST_NODES_A_SIDE = 60
LENGTH_HEIGHTS = (1.0, 2.0, 4.0, 8.0)
# Misfits beyond this many standard deviations of chi^2 are more than noise.
LEAST_MISFIT = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Residual:
    """Difference of the logarithm of the dose rate from the estimate, and its deviation.

    Attributes
    ----------
    log_mean, log_std
        At the nodes of a grid, shape (north, east).
    """

    log_mean: FloatArray
    log_std: FloatArray


def residual(
    found: Localization,
    survey: RadiationSurvey,
    kernel: Kernel,
    east: FloatArray,
    north: FloatArray,
) -> Residual | None:
    """Return the residual at all nodes, None where readings agree with the estimate."""
    sources = np.array([source.position_enu_m for source in found.sources]).reshape(-1, 3)
    above = sources[:, 2] - survey.ground.ups_at(sources[:, :2])
    source_up_m = float(np.median(above)) if len(above) else 0.0
    height = survey.height_m(source_up_m)
    thin = survey.merged(0.25 * height, MOST_READINGS)
    counted = kernel.at_heights(thin.heights_m - source_up_m)
    expected = thin.exposures * _rates_usvh(found, thin, counted) + thin.dark_counts
    values = np.log((thin.counts + 0.5) / (expected + 0.5))
    excess = np.maximum(expected - thin.exposures * found.background_usvh - thin.dark_counts, 0.0)
    noise = 1.0 / (expected + 0.5) + (found.rho * excess / (expected + 0.5)) ** 2
    misfit = float((values**2 / noise).sum() - thin.size) / np.sqrt(2.0 * thin.size)
    sill = float(((values**2 - noise) / noise).sum() / (1.0 / noise).sum())
    if misfit <= LEAST_MISFIT or sill <= 0.0:
        return None
    places = thin.positions_enu_m[:, :2]
    fits = [_Kriging(places, values, noise, sill, height * share) for share in LENGTH_HEIGHTS]
    best = max(fits, key=lambda fit: fit.log_likelihood)
    return best.on_grid(east, north)


class _Kriging:
    """A random field of known covariance, conditioned on noisy values."""

    def __init__(
        self,
        places: FloatArray,
        values: FloatArray,
        noise: FloatArray,
        sill: float,
        length_m: float,
    ) -> None:
        self._places, self._sill, self._length_m = places, sill, length_m
        covariance = self._covariance(places)
        covariance[np.diag_indices_from(covariance)] += noise
        self._factor = np.linalg.cholesky(covariance)
        half = np.linalg.solve(self._factor, values)
        self._weights = np.linalg.solve(self._factor.T, half)
        logs = np.log(np.diag(self._factor)).sum()
        self.log_likelihood = float(-0.5 * half @ half - logs)

    def on_grid(self, east: FloatArray, north: FloatArray) -> Residual:
        """Return mean and standard deviation, computed on a coarse grid and interpolated."""
        coarse_east, coarse_north = _coarse(east), _coarse(north)
        nodes = np.stack([part.ravel() for part in np.meshgrid(coarse_east, coarse_north)], axis=1)
        across = self._covariance(nodes)
        mean = across @ self._weights
        known = np.linalg.solve(self._factor, across.T)
        variance = np.maximum(self._sill - (known * known).sum(axis=0), 0.0)
        shape = (coarse_north.size, coarse_east.size)
        log_mean, log_std = (
            _interpolated(part.reshape(shape), (coarse_east, coarse_north), (east, north))
            for part in (mean, np.sqrt(variance))
        )
        return Residual(log_mean=log_mean, log_std=log_std)

    def _covariance(self, places: FloatArray) -> FloatArray:
        squares = np.zeros((len(places), len(self._places)))
        for axis in range(2):
            squares += np.subtract.outer(places[:, axis], self._places[:, axis]) ** 2
        return np.asarray(self._sill * np.exp(-np.sqrt(squares) / self._length_m))


def _rates_usvh(found: Localization, survey: RadiationSurvey, kernel: Kernel) -> FloatArray:
    rates: FloatArray = np.full(survey.size, found.background_usvh)
    for source in found.sources:
        squares = ((survey.positions_enu_m - source.position_enu_m) ** 2).sum(axis=1)
        rates += source.dose_rate_at_1m_usvh * kernel.values(squares)
    return rates


def _coarse(axis: FloatArray) -> FloatArray:
    """Return at most `MOST_NODES_A_SIDE` places from end to end of `axis`."""
    count = min(axis.size, MOST_NODES_A_SIDE)
    return np.asarray(np.linspace(axis[0], axis[-1], count), np.float64)


def _interpolated(
    values: FloatArray, coarse: tuple[FloatArray, FloatArray], fine: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """Return `values` (north, east) at the fine nodes, bilinear."""
    rows = np.stack([np.interp(fine[0], coarse[0], row) for row in values])
    columns = [np.interp(fine[1], coarse[1], column) for column in rows.T]
    return np.asarray(np.stack(columns, axis=1))
