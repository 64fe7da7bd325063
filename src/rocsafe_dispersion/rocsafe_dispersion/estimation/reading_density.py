# SPDX-License-Identifier: Apache-2.0
"""Probability of a reading of gas that comes and goes, with the noise of its detector.

The concentration in a plume follows a gamma distribution of given mean and intensity (standard
deviation over mean; Cassiani and others 2020, Boundary-Layer Meteorol. 177). Where the
intensity is above 1 it is mostly near zero and sometimes far above the mean, so that a reading
within the plume that shows nothing needs no rule of its own. The noise of the detector is
Student's t: its tails are heavier than those of a normal distribution.

The convolution of both has no closed form: its logarithm is a table of three numbers (reading and
mean in units of the noise, intensity).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import special

from rocsafe_geo.arrays import FloatArray, IndexArray

FREEDOM = 4.0
# Grid: asinh of the reading and logarithm of the mean, both in noises, logarithm of the squared
# intensity. Means and intensities beyond count as at its edge.
_FIRST_X, _STEP_X, _COUNT_X = -5.0, 0.1, 200
_FIRST_M, _STEP_M, _COUNT_M = np.log(0.01), 0.35, 49
_FIRST_I, _STEP_I, _COUNT_I = np.log(0.1), 0.25, 29
# Bins of the gamma distribution for each step of the mean, and how far they go below and above.
_FINER, _BELOW, _ABOVE = 4, 14.0, 4.0
_LEAST = 1e-30


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Where readings are in the table by mean and intensity.

    `rows` are those of the mean below, of the nearest intensity; `shares` of the mean above.
    """

    rows: IndexArray
    shares: FloatArray


@lru_cache(maxsize=1)
def _tables() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return logarithms of density, of the probability below and above, each (mean, x)."""
    step = _STEP_M / _FINER
    first = _FIRST_M - _BELOW
    count = int((_BELOW + _ABOVE) / step) + _FINER * _COUNT_M
    middles = np.exp(first + step * np.arange(count))
    # A bin is as wide as the distance of its neighbours: the sum over bins is smooth.
    widths = np.sqrt(1.0 + (step * middles) ** 2)
    x = np.sinh(_FIRST_X + _STEP_X * np.arange(_COUNT_X))
    offsets = (x[:, None] - middles) / widths
    density = 0.375 * (1.0 + offsets**2 / FREEDOM) ** -2.5 / widths
    below = special.stdtr(FREEDOM, offsets)
    shares = _bin_shares(step, int((_BELOW + _ABOVE) / step), count)
    parts = (density, below, 1.0 - below)
    found = [np.log(np.maximum(shares @ part.T, _LEAST)).astype(np.float32) for part in parts]
    return found[0], found[1], found[2]


def _bin_shares(step: float, width: int, count: int) -> FloatArray:
    """Return the share of each bin of the gamma distributions, (means x intensities, bins)."""
    shapes = 1.0 / np.exp(_FIRST_I + _STEP_I * np.arange(_COUNT_I))
    edges = np.exp(-_BELOW + step * (np.arange(width + 1) - 0.5))
    shares = np.zeros((_COUNT_M, _COUNT_I, count))
    for number, shape in enumerate(shapes.tolist()):
        own = np.diff(special.gammainc(shape, shape * edges))
        own[0] += special.gammainc(shape, shape * edges[0])
        own = own / own.sum()
        for mean in range(_COUNT_M):
            shares[mean, number, _FINER * mean : _FINER * mean + width] = own
    return shares.reshape(_COUNT_M * _COUNT_I, count)


def cells(means: FloatArray, squares: FloatArray) -> Cells:
    """Return where means (in noises) and squared intensities are in the table, any shape."""
    mean, share = _whole((np.log(np.maximum(means, 1e-3)) - _FIRST_M) / _STEP_M, _COUNT_M)
    nearest = np.clip(np.rint((np.log(squares) - _FIRST_I) / _STEP_I), 0, _COUNT_I - 1)
    return Cells(rows=mean * _COUNT_I + nearest.astype(np.intp), shares=share)


def log_density(x: FloatArray, own: Cells, kind: int) -> FloatArray:
    """Return the logarithms of the density of readings, in noises.

    Parameters
    ----------
    x : (..., n)
        Readings above the background, in noises.
    own
        Cells of (n,).
    kind
        0: density; 1: probability of less than `x`; 2: of more.
    """
    table = _tables()[kind].reshape(-1)
    column, part = _whole((np.arcsinh(x) - _FIRST_X) / _STEP_X, _COUNT_X)
    at = own.rows * _COUNT_X + column
    above = at + _COUNT_I * _COUNT_X
    low = table[at] + part * (table[at + 1] - table[at])
    high = table[above] + part * (table[above + 1] - table[above])
    return np.asarray(low + own.shares * (high - low))


def _whole(place: FloatArray, count: int) -> tuple[IndexArray, FloatArray]:
    """Return the number of the grid point before each place, and the share of the one after."""
    inside = np.clip(place, 0.0, count - 1.001)
    whole = inside.astype(np.intp)
    return whole, inside - whole
