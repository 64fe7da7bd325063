# SPDX-License-Identifier: Apache-2.0
"""What readings say about the place and the strength of one source: Bayes' rule on a grid."""

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_count
from rocsafe_learning.sensing.sensor_model import SensorModel

Float32Array = NDArray[np.float32]
Place = tuple[float, float]
# Places of readings are rounded to this share of a cell, so that one table serves all of them.
PARTS = 4
# Strengths averaged over in a class of them.
_SUB_STRENGTHS = 3
_SMALLEST = np.float32(-80.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BeliefTables:
    """Readings expected at every offset that occurs, for each strength.

    Attributes
    ----------
    cells
        Cells along each side of the square area, K.
    area_m
        Length of the side, metres.
    strengths : (S,)
        Strengths told apart.
    means, weights, constants : (PARTS, PARTS, 2 K, 2 K, S)
        Mean of a reading, half its inverse variance and half the logarithm of its variance. The
        first two axes are the place of the reading within a cell, north and east; the next two
        by how many cells the source lies farther north and east, from -K.
    """

    cells: int
    area_m: float
    strengths: FloatArray
    means: Float32Array
    weights: Float32Array
    constants: Float32Array

    @classmethod
    def of(
        cls, sensor: SensorModel, area_m: float, cells: int = 32, strengths: int = 10
    ) -> 'BeliefTables':
        """Return the tables of a sensor over an area.

        Parameters
        ----------
        sensor
            What is read.
        area_m
            Length of the side of the square area, metres.
        cells
            Cells along each side.
        strengths
            Number of strengths, evenly over the range of the sensor.
        """
        require_count('cells', cells, 2, 256)
        require_count('strengths', strengths, 1, 100)
        edges = np.linspace(0.0, 1.0, strengths * _SUB_STRENGTHS, endpoint=False)
        middles: FloatArray = np.asarray(edges + 0.5 / len(edges), np.float64)
        levels = sensor.strengths(middles).reshape(strengths, _SUB_STRENGTHS)
        step = area_m / (cells * PARTS)
        pairs = [_averaged(sensor, row, step, cells) for row in levels]
        means, variances = (np.stack(part, axis=-1) for part in zip(*pairs, strict=True))
        return cls(
            cells=cells,
            area_m=area_m,
            strengths=np.median(levels, axis=1),
            means=means.astype(np.float32),
            weights=(0.5 / variances).astype(np.float32),
            constants=(0.5 * np.log(variances)).astype(np.float32),
        )

    @property
    def step_m(self) -> float:
        """Distance of the places where a reading can be, metres."""
        return self.area_m / (self.cells * PARTS)

    def rounded_m(self, place_m: Place) -> Place:
        """Return the nearest place at which the tables hold, east and north, metres."""
        return round(place_m[0] / self.step_m) * self.step_m, (
            round(place_m[1] / self.step_m) * self.step_m
        )

    def window(self, place_m: Place) -> tuple[int, int, slice, slice]:
        """Return where in the tables the cells lie as seen from a rounded place."""
        east, east_part = divmod(round(place_m[0] / self.step_m), PARTS)
        north, north_part = divmod(round(place_m[1] / self.step_m), PARTS)
        rows = slice(self.cells - north, 2 * self.cells - north)
        columns = slice(self.cells - east, 2 * self.cells - east)
        return north_part, east_part, rows, columns


def _averaged(
    sensor: SensorModel, levels: FloatArray, step_m: float, cells: int
) -> tuple[FloatArray, FloatArray]:
    """Return mean and variance of readings over all places within a cell and some strengths.

    What varies within a cell and a class of strength counts as noise; without it, a belief of
    few cells would be surer than it is right.
    """
    reach = (cells + 1) * PARTS
    axis = step_m * (np.arange(-reach, reach) + 0.5)
    offsets = np.stack(np.meshgrid(axis, axis), axis=-1)
    pairs = [sensor.expected(offsets, float(level)) for level in levels]
    first = np.mean([mean for mean, _ in pairs], axis=0)
    second = np.mean([mean**2 + variance for mean, variance in pairs], axis=0)
    mean, square = _mean_over_cells(first), _mean_over_cells(second)
    # From the middle of the source's cell to the reading, in steps; the first average is that
    # around -reach + PARTS / 2.
    steps = np.arange(PARTS)[:, None] - PARTS // 2 - PARTS * np.arange(-cells, cells)
    rows = steps + reach - PARTS // 2
    index = rows[:, None, :, None], rows[None, :, None, :]
    return mean[index], (square - mean**2)[index]


def _mean_over_cells(values: FloatArray) -> FloatArray:
    """Return the mean over each square of PARTS x PARTS places."""
    return np.asarray(sliding_window_view(values, (PARTS, PARTS)).mean(axis=(2, 3)))


class SourceBelief:
    """Probability of each cell and strength, given the readings so far.

    Parameters
    ----------
    tables
        Tables of the sensor.

    Attributes
    ----------
    cells : (K, K)
        Probability of each cell, rows from the south, columns from the west.
    entropy_nats
        Entropy of cell and strength together.
    """

    def __init__(self, tables: BeliefTables) -> None:
        shape = (tables.cells, tables.cells, len(tables.strengths))
        self.tables = tables
        self._logs = np.zeros(shape, np.float32)
        self._miss = np.empty(shape, np.float32)
        self._joint = np.full(shape, 1.0 / np.prod(shape), np.float32)
        self._centres_m = tables.area_m / tables.cells * (np.arange(tables.cells) + 0.5)
        self._ones = np.ones(shape[2], np.float32)
        self.cells: Float32Array = self._joint @ self._ones
        self.entropy_nats = float(np.log(np.prod(shape)))
        self._squares_m2 = self._centres_m * self._centres_m
        self._placed: tuple[Place, float] | None = None

    @property
    def joint(self) -> Float32Array:
        """Probability of each cell and strength, (K, K, S)."""
        return self._joint

    def add(self, place_m: Place, reading: float) -> float:
        """Take a reading at a rounded place; return by how much the entropy fell, nats."""
        tables, logs, miss = self.tables, self._logs, self._miss
        window = tables.window(place_m)
        np.subtract(tables.means[window], np.float32(reading), out=miss)
        miss *= miss
        miss *= tables.weights[window]
        miss += tables.constants[window]
        logs -= miss
        logs -= logs.max()
        # What is less likely than this by far is left at it: no product is infinite.
        np.maximum(logs, _SMALLEST, out=logs)
        np.exp(logs, out=self._joint)
        self.cells = self._joint @ self._ones
        total = float(self.cells.sum())
        share = np.float32(1.0 / total)
        self._joint *= share
        self.cells *= share
        self._placed = None
        before = self.entropy_nats
        self.entropy_nats = float(np.log(total) - np.vdot(self._joint, logs))
        return before - self.entropy_nats

    def mean_and_spread_m(self) -> tuple[Place, float]:
        """Return the mean place, and the root mean square distance from it, metres."""
        if self._placed is None:
            self._placed = self._mean_and_spread_m()
        return self._placed

    def _mean_and_spread_m(self) -> tuple[Place, float]:
        centres = self._centres_m
        east, north = self.cells.sum(axis=0), self.cells.sum(axis=1)
        middle = float(east @ centres), float(north @ centres)
        squares = (east + north) @ self._squares_m2
        return middle, float(max(squares - middle[0] ** 2 - middle[1] ** 2, 0.0)) ** 0.5

    def reading_spread(self, place_m: Place) -> tuple[float, float]:
        """Return the variance of what the belief expects at a place, and the noise's variance."""
        window = self.tables.window(place_m)
        means = self.tables.means[window]
        mean = float(np.vdot(self._joint, means))
        noise = float(np.vdot(self._joint, 0.5 / self.tables.weights[window]))
        return max(float(np.vdot(self._joint, means * means)) - mean * mean, 0.0), noise
