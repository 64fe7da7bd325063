# SPDX-License-Identifier: Apache-2.0
"""Options of the search for releases."""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.limits import require_between, require_count, require_positive


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchArea:
    """Ground on which releases are searched; that one is beyond it is possible, too.

    Attributes
    ----------
    west_m, south_m, east_m, north_m
        Edges, metres.
    cell_m
        Size of the cells of regions, metres.
    height_m
        Height of a release above the ground, metres.
    """

    west_m: float
    south_m: float
    east_m: float
    north_m: float
    cell_m: float = 4.0
    height_m: float = 0.5

    def __post_init__(self) -> None:
        require_positive('width of the area', self.east_m - self.west_m, 'm')
        require_positive('height of the area', self.north_m - self.south_m, 'm')
        require_positive('cell_m', self.cell_m, 'm')
        require_between('height_m', self.height_m, 0.0, 30.0, 'm')
        sides = self.east_m - self.west_m, self.north_m - self.south_m
        cells = math.prod(max(side / self.cell_m, 1.0) for side in sides)
        require_between('number of cells of the area', cells, 4.0, 40_000.0)

    def holds(self, places_m: FloatArray) -> BoolArray:
        """Return which of places (..., 2) are on this ground."""
        low, high = (self.west_m, self.south_m), (self.east_m, self.north_m)
        return np.asarray(((places_m >= low) & (places_m <= high)).all(axis=-1))

    def cells_m(self) -> FloatArray:
        """Return the middles of all cells, row by row from the south, (m, 2); at least one."""
        cell = self.cell_m
        east, north = (
            np.arange(low + cell / 2.0, max(high, low + cell), cell)
            for low, high in ((self.west_m, self.east_m), (self.south_m, self.north_m))
        )
        return np.stack(np.meshgrid(east, north), axis=-1).reshape(-1, 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class LocateOptions:
    """How releases are found.

    Attributes
    ----------
    turn_std_deg
        Standard deviation of the error of the wind direction before readings, degrees.
    wrong_wind
        Probability before readings that the direction of the wind that is told is wrong, and the
        true one anything: signs or conventions mixed up, an anemometer turned on its mast.
    limited
        Probability before readings that releases start or end among them, where their times are
        known.
    moves
        Probability before readings that a release moves on a straight line, where their times are
        known; it is asked of one release alone.
    spread_std
        Standard deviation of the logarithm of the factors of the crosswind and of the vertical
        size of the plume before readings.
    most_releases
        Largest number of releases, at most 3.
    least_gain
        Logarithm of the odds that any release needs, where all numbers were equally probable
        before: 4.6 stands for 99 to 1.
    least_gain_more
        That one release more needs beside others: 0.7 stands for 2 to 1. Less (0.5) tells the
        number as often rightly and more releases that do not exist; more (1.0) fewer of both.
    smallest_g_s, smallest_per_s
        Rate of the weakest release that matters, g/s, of particles 1/s: what is said of releases
        that were not found is said of this rate.
    particles, sweeps
        Number of hypotheses for 100 points of readings (fewer for larger surveys, up to three
        times as many for smaller ones), and how often each is moved at each power of the
        likelihood.
    """

    turn_std_deg: float = 6.0
    wrong_wind: float = 0.02
    limited: float = 0.1
    moves: float = 0.05
    spread_std: float = 0.7
    most_releases: int = 3
    least_gain: float = 4.6
    least_gain_more: float = 0.7
    smallest_g_s: float = 0.5
    smallest_per_s: float = 1e8
    particles: int = 600
    sweeps: int = 2

    def __post_init__(self) -> None:
        require_positive('turn_std_deg', self.turn_std_deg, 'degrees')
        require_between('wrong_wind', self.wrong_wind, 1e-6, 0.4)
        require_between('limited', self.limited, 1e-6, 0.4)
        require_between('moves', self.moves, 1e-6, 0.4)
        require_positive('spread_std', self.spread_std)
        require_between('smallest_g_s', self.smallest_g_s, 1e-9, 1e9, 'g/s')
        require_between('smallest_per_s', self.smallest_per_s, 1.0, 1e15, '1/s')
        require_count('most_releases', self.most_releases, 0, 3)
        require_count('particles', self.particles, 100, 100_000)
        require_count('sweeps', self.sweeps, 1, 100)
