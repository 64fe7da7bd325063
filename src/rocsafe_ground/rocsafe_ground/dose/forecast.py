# SPDX-License-Identifier: Apache-2.0
"""The dose of a drive, and how sure it is, from draws of the sources."""

from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_ground.dose.dose_field import DoseField

# Limits between which 95 of 100 drives are.
BAND = (0.025, 0.975)


@dataclass(frozen=True, slots=True, kw_only=True)
class DoseForecast:
    """The dose of a drive over draws of the sources, microsievert.

    Attributes
    ----------
    mean_usv
        By the field as estimated.
    low_usv, high_usv
        95 of 100 draws are between.
    upper_usv
        Below it is the share of draws that was asked for.
    probability
        Share of draws within the budget.
    """

    mean_usv: float
    low_usv: float
    high_usv: float
    upper_usv: float
    probability: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Draws:
    """How a forecast is made: number and seed of the draws, share below the upper dose."""

    count: int
    seed: int
    confidence: float


def forecast_of(
    field: DoseField, cells: IndexArray, seconds: FloatArray, budget_usv: float, draws: Draws
) -> DoseForecast:
    """Return the forecast of a drive that is `seconds` in each of `cells`, (n,) both."""
    hours = np.bincount(cells, weights=seconds) / 3600.0
    visited = np.flatnonzero(hours)
    doses = field.drawn_rates(visited, draws.count, draws.seed) @ hours[visited]
    low, high = np.quantile(doses, BAND)
    # One of the draws, so that at least the share that was asked for is not above it.
    upper = np.quantile(doses, draws.confidence, method='higher')
    row, column = np.divmod(visited, field.grid.columns)
    return DoseForecast(
        mean_usv=float(field.mean_usvh[row, column] @ hours[visited]),
        low_usv=float(low),
        high_usv=float(high),
        upper_usv=float(upper),
        probability=float((doses <= budget_usv).mean()),
    )
