# SPDX-License-Identifier: Apache-2.0
"""Exposure at the points of a grid over time: means, toxic load, times of arrival."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_between, require_count, require_finite, require_positive


@dataclass(frozen=True, slots=True, kw_only=True)
class MapGrid:
    """Points of a level grid: rows northwards, columns eastwards.

    Attributes
    ----------
    west_m, south_m
        East and north of the first point, metres.
    cell_m
        Distance of points, metres.
    columns, rows
        Number of points.
    height_m
        Height of all points above the ground, metres: where people breathe.
    """

    west_m: float
    south_m: float
    cell_m: float
    columns: int
    rows: int
    height_m: float = 1.5

    def __post_init__(self) -> None:
        for name in ('west_m', 'south_m', 'height_m'):
            require_finite(name, getattr(self, name), 'm')
        require_positive('cell_m', self.cell_m, 'm')
        for name in ('columns', 'rows'):
            require_count(name, getattr(self, name), 2, 5000)

    def east_m(self) -> FloatArray:
        """Return east of the columns, metres."""
        return np.asarray(self.west_m + self.cell_m * np.arange(self.columns))

    def north_m(self) -> FloatArray:
        """Return north of the rows, metres."""
        return np.asarray(self.south_m + self.cell_m * np.arange(self.rows))

    def places_m(self) -> FloatArray:
        """Return all points, (rows * columns, 3), row by row, metres."""
        east, north = np.meshgrid(self.east_m(), self.north_m())
        height = np.full(east.size, self.height_m)
        return np.column_stack([east.ravel(), north.ravel(), height])


class Exposure:
    """Adds up concentrations at regular times.

    Parameters
    ----------
    step_s
        Time between two maps, seconds.
    minutes
        Averaging time, a whole multiple of `step_s`.
    load_exponent
        n of the toxic load C^n t, or None: it is not computed.
    arrival_g_m3
        Concentration that counts as arrival.
    """

    def __init__(
        self,
        step_s: float,
        minutes: float,
        load_exponent: float | None = None,
        arrival_g_m3: float = math.inf,
    ) -> None:
        self._step_s = require_positive('step_s', step_s, 's')
        self._count = round(minutes * 60.0 / step_s)
        if not math.isclose(self._count * step_s, minutes * 60.0) or self._count < 1:
            raise ValueError(
                f'minutes is {minutes:g}: must be a whole multiple of step_s, {step_s:g} s'
            )
        if load_exponent is not None:
            require_between('load_exponent', load_exponent, 0.5, 10.0)
        self._exponent, self._arrival = load_exponent, arrival_g_m3
        self._maps: deque[FloatArray] = deque()
        self._sum: FloatArray | None = None
        self._largest: FloatArray | None = None
        self._load: FloatArray | None = None
        self._arrived: FloatArray | None = None

    def add(self, time_s: float, concentrations_g_m3: FloatArray) -> None:
        """Take the map of the interval that ends at `time_s`; maps follow each other."""
        if self._sum is None or self._largest is None or self._arrived is None:
            shape = concentrations_g_m3.shape
            self._sum, self._largest = np.zeros(shape), np.zeros(shape)
            self._load, self._arrived = np.zeros(shape), np.full(shape, np.inf)
        self._maps.append(concentrations_g_m3)
        self._sum = self._sum + concentrations_g_m3
        if len(self._maps) > self._count:
            self._sum = self._sum - self._maps.popleft()
        # Before the averaging time is over, the rest of it counts as clean air.
        self._largest = np.maximum(self._largest, self._sum / self._count)
        if self._exponent is not None and self._load is not None:
            minutes = self._step_s / 60.0
            self._load = self._load + concentrations_g_m3**self._exponent * minutes
        here = (concentrations_g_m3 >= self._arrival) & np.isinf(self._arrived)
        self._arrived = np.where(here, time_s, self._arrived)

    def largest_mean_g_m3(self) -> FloatArray:
        """Return the largest mean over the averaging time so far, g/m^3."""
        return self._known(self._largest)

    def load(self) -> FloatArray:
        """Return the toxic load, (g/m^3)^n min.

        Raises
        ------
        ValueError
            If no exponent is known.
        """
        if self._exponent is None:
            raise ValueError('the toxic load needs a load_exponent, which must be published')
        return self._known(self._load)

    def arrival_s(self) -> FloatArray:
        """Return when the concentration came first, seconds; infinite: not yet."""
        return self._known(self._arrived)

    @staticmethod
    def _known(values: FloatArray | None) -> FloatArray:
        if values is None:
            raise ValueError('an exposure needs at least one map')
        return values
