# SPDX-License-Identifier: Apache-2.0
"""Straight lines in place of the zigzag of a path over cells that cost no more of anything."""

import itertools
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray, IndexArray

# Samples per side of a cell: a line that touches a corner of a blocked cell by less goes by it.
SAMPLES = 4
# Of a cell: rounding of samples.
ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Surface:
    """What a line over cells costs: all arrays (rows, columns).

    `loads_per_s` is the toxic load that a second adds; None: it does not count. Along cells that
    are not free a line keeps within `aside_m` of the middles of those that are.
    """

    is_free: BoolArray
    slowness_spm: FloatArray
    rates_usvh: FloatArray
    cell_m: float
    aside_m: float
    loads_per_s: FloatArray | None = None

    def line_costs(self, a: int, b: int) -> tuple[float, float, float] | None:
        """Return time (s), dose (uSv) and toxic load of the straight line between two cells.

        None if it meets a cell that is not free.
        """
        places, length = self.line(a, b)
        rows, columns = np.rint(places).astype(np.int64).T
        # A sample near the edge of two cells is in both.
        edge = max(0.5 - self.aside_m / self.cell_m, ROUNDING)
        low, high = np.ceil(places - 0.5 - edge).T, np.floor(places + 0.5 + edge).T
        for r, c in itertools.product((low[0], high[0]), (low[1], high[1])):
            if not self.is_free[r.astype(np.int64), c.astype(np.int64)].all():
                return None
        weights = np.full(len(places), length / max(len(places) - 1, 1))
        weights[[0, -1]] *= 0.5
        times = weights * self.slowness_spm[rows, columns]
        dose = float((times * self.rates_usvh[rows, columns]).sum() / 3600.0)
        loads = self.loads_per_s
        load = 0.0 if loads is None else float((times * loads[rows, columns]).sum())
        return float(times.sum()), dose, load

    def line(self, a: int, b: int) -> tuple[FloatArray, float]:
        """Return samples (n, 2) of row and column from cell a to cell b, and its length, m."""
        columns = self.is_free.shape[1]
        begin = np.array(divmod(a, columns), np.float64)
        step = np.array(divmod(b, columns), np.float64) - begin
        count = int(np.ceil(np.abs(step).max() * SAMPLES)) + 1
        share = np.linspace(0.0, 1.0, count)[:, None]
        return begin + share * step, float(np.hypot(*step)) * self.cell_m


def straightened(
    path: IndexArray, costs: tuple[FloatArray, FloatArray, FloatArray], surface: Surface
) -> IndexArray:
    """Return the cells at which a path bends, ends included.

    Parameters
    ----------
    path : (n,)
        Cells.
    costs : (n - 1,) each
        Time, dose and toxic load of each step.
    surface
        What lines cost.

    Returns
    -------
    (m,)
        Cells between which straight lines take no more of any of these than the path.
    """
    sums = [np.concatenate([[0.0], np.cumsum(steps)]) for steps in costs]

    def is_better(i: int, j: int) -> bool:
        found = surface.line_costs(int(path[i]), int(path[j]))
        if found is None:
            return False
        return all(
            cost <= (total[j] - total[i]) * (1.0 + 1e-9)
            for cost, total in zip(found, sums, strict=True)
        )

    bends, here = [0], 0
    while here < len(path) - 1:
        reach = 1
        # Twice as far while it is better, then as far as the last doubling.
        while here + 2 * reach < len(path) and is_better(here, here + 2 * reach):
            reach *= 2
        step = reach // 2
        while step:
            if here + reach + step < len(path) and is_better(here, here + reach + step):
                reach += step
            step //= 2
        here += reach
        bends.append(here)
    return np.asarray(path[bends])
