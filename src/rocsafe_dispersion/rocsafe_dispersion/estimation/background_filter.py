# SPDX-License-Identifier: Apache-2.0
"""Likelihood of readings beside a background that wanders, for many hypotheses at once.

The background of each instrument is a random walk that is followed through the readings in the
order of their times. It stays a normal distribution: after each reading its mean and variance are
those that the first two derivatives of the logarithm of the reading's probability give (assumed
density filter; Minka 2001). So it is averaged over, not fitted, and a zero that drifts does not
pass for gas.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.estimation.gas_survey import GasSurvey
from rocsafe_dispersion.estimation.reading_density import FREEDOM, cells, log_density
from rocsafe_geo.arrays import FloatArray, IndexArray

# Step of the derivatives, in noises: above the distance of the points of the table near 0.
_STEP = 0.5
# Gas of less than this, in noises, is none.
_LEAST_GAS = 0.02
# A block has as many readings as this share of those before it: they tell much less of the
# background than those before, so that it need not be followed within the block.
_BLOCK_SHARE, _LARGEST_BLOCK = 0.25, 8
# Largest share of the variance of the background that one reading takes away.
_MOST_TOLD = 0.999
_LOG_PEAK = math.log(0.375)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Block:
    """Readings of one instrument that follow each other: a kind, and the time since the last.

    The kind is 0 for values, 1 and 2 for upper and lower bounds; times are shares of the survey.
    """

    instrument: int
    kind: int
    numbers: IndexArray
    passed: float


class BackgroundFilter:
    """Follows the backgrounds of a survey."""

    def __init__(self, survey: GasSurvey) -> None:
        self._survey, self.readings = survey, len(survey.values_g_m3)
        instruments = range(int(survey.instruments.max()) + 1)
        self._start = np.array([_first_background(survey, one) for one in instruments])
        self._blocks = [block for one in instruments for block in _blocks(survey, one)]

    def log_likelihoods(
        self,
        means: FloatArray,
        spreads: FloatArray,
        noise: FloatArray,
        drift: FloatArray,
        each: FloatArray | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Return logarithms of the likelihood, (p,), and last backgrounds, (p, instruments).

        Parameters
        ----------
        means, spreads : (p, n)
            Mean and standard deviation of the gas, g/m^3.
        noise, drift : (p,)
            Factor of the detector's noise; how far the background wanders in the whole time,
            in noises.
        each : (p, n)
            Takes the logarithm of the likelihood of each reading, given those before.
        """
        background = np.tile(self._start[:, 0], (len(means), 1))
        variance = np.tile(self._start[:, 1] ** 2, (len(means), 1))
        total = np.zeros(len(means))
        for block in self._blocks:
            own, numbers = block.instrument, block.numbers
            std = noise[:, None] * self._survey.std_g_m3[numbers]
            variance[:, own] += block.passed * (drift * std[:, 0]) ** 2
            scale = np.sqrt(std**2 + variance[:, own, None])
            x = (self._survey.values_g_m3[numbers] - background[:, own, None]) / scale
            logs, slopes, curves = _terms(
                x, means[:, numbers] / scale, spreads[:, numbers] / scale, block.kind
            )
            own_logs = logs - (np.log(scale) if block.kind == 0 else 0.0)
            total += own_logs.sum(axis=1)
            if each is not None:
                each[:, numbers] = own_logs
            # What each reading adds to the precision and to the precision times the mean.
            before = variance[:, own]
            bent = np.clip(-curves / scale**2, 0.0, _MOST_TOLD / before[:, None])
            left = 1.0 - before[:, None] * bent
            variance[:, own] = 1.0 / (1.0 / before + (bent / left).sum(axis=1))
            background[:, own] -= variance[:, own] * (slopes / scale / left).sum(axis=1)
        return total, background


def _terms(
    x: FloatArray, means: FloatArray, spreads: FloatArray, kind: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return logarithms of the probability of readings and their two derivatives, all in noises.

    Readings without gas are those of the noise alone, which has a closed form.
    """
    base = FREEDOM + x**2
    logs = _LOG_PEAK - 2.5 * np.log(base / FREEDOM)
    slopes, curves = -5.0 * x / base, -5.0 * (FREEDOM - x**2) / base**2
    row, column = np.nonzero((means > _LEAST_GAS) | (kind > 0))
    gas, own = means[row, column], x[row, column]
    # A gas that is none has any intensity.
    squares = (spreads[row, column] / np.maximum(gas, _LEAST_GAS)) ** 2
    table = cells(gas, np.maximum(squares, 1e-3))
    low, middle, high = log_density(np.stack([own - _STEP, own, own + _STEP]), table, kind)
    logs[row, column] = middle
    slopes[row, column] = (high - low) / (2.0 * _STEP)
    curves[row, column] = (low - 2.0 * middle + high) / _STEP**2
    return logs, slopes, curves


def _blocks(survey: GasSurvey, instrument: int) -> Iterator[_Block]:
    """Yield the readings of an instrument in the order of their times."""
    own = np.flatnonzero(survey.instruments == instrument)
    own = own[np.argsort(survey.times_s[own], kind='stable')]
    kinds = survey.is_below[own] + 2 * survey.is_above[own]
    span = max(float(np.ptp(survey.times_s)), 1e-9)
    start = 0
    while start < len(own):
        size = min(max(int(_BLOCK_SHARE * start), 1), _LARGEST_BLOCK)
        changed = np.flatnonzero(kinds[start : start + size] != kinds[start])
        stop = start + (int(changed[0]) if len(changed) else min(size, len(own) - start))
        before = survey.times_s[own[max(start - 1, 0)]]
        yield _Block(
            instrument=instrument,
            kind=int(kinds[start]),
            numbers=own[start:stop],
            passed=float(survey.times_s[own[stop - 1]] - before) / span,
        )
        start = stop


def _first_background(survey: GasSurvey, instrument: int) -> tuple[float, float]:
    """Return mean and standard deviation of a background before the first reading, g/m^3."""
    own = survey.instruments == instrument
    if not own.any():
        return 0.0, 1.0
    values = survey.values_g_m3[own]
    low, quarter = np.quantile(values, (0.0, 0.25)).tolist()
    return quarter, max(quarter - low, 3.0 * float(np.median(survey.std_g_m3[own])))
