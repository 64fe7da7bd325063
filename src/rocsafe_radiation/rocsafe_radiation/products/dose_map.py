# SPDX-License-Identifier: Apache-2.0
"""The dose rate one metre above the ground and its uncertainty, from the sources found."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.estimates import Localization, SourceEstimate
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.products.residual_kriging import residual
from rocsafe_radiation.readings.survey import RadiationSurvey

# Where responders measure: IAEA, EPR-First Responders.
HEIGHT_M = 1.0
SAMPLES = 40
ROWS_AT_A_TIME = 24
LARGEST_REACH_M = 500.0
MARGIN_M = 20.0
LARGEST_CELLS = 250_000
SMALLEST_CELL_M = 0.5
UPPER_QUANTILE = 0.95


@dataclass(frozen=True, slots=True, kw_only=True)
class DoseMap:
    """Dose rates on a grid, microsievert per hour, each of shape (rows, columns).

    Attributes
    ----------
    corner_m
        East and north of the south-western node.
    cell_m
        Distance of nodes.
    mean_usvh
        Dose rate of sources and background as estimated.
    std_usvh, upper_usvh
        Standard deviation and upper 95 % of the dose rate.
    """

    corner_m: tuple[float, float]
    cell_m: float
    mean_usvh: FloatArray
    std_usvh: FloatArray
    upper_usvh: FloatArray


def dose_map(
    found: Localization,
    survey: RadiationSurvey,
    kernel: Kernel,
    lowest_level_usvh: float,
    largest_cells: int = LARGEST_CELLS,
) -> DoseMap:
    """Return the map of the surveyed ground and of all ground that sources raise to a level.

    The map is that of sources and a constant background, times the kriged residual of the readings
    where this is more than noise. `kernel` is that of the readings. The uncertainty comes from 40
    draws of the places and strengths of the sources from their covariances, and of the residual.
    Cells are at least half a metre wide and not many more than `largest_cells`.
    """
    low, high = _bounds(found, survey, lowest_level_usvh)
    cell = max(SMALLEST_CELL_M, math.sqrt(float(np.prod(high - low)) / largest_cells))
    east = np.arange(low[0], high[0] + cell, cell, dtype=np.float64)
    north = np.arange(low[1], high[1] + cell, cell, dtype=np.float64)
    ups = _ups(survey, east, north)
    law = kernel.of_dose
    mean = grid_dose_rates_usvh(found.sources, found.background_usvh, law, east, north, ups)
    generator = np.random.default_rng([0, 0xD05E])
    draws = np.stack([_drawn(found, law, east, north, ups, generator) for _ in range(SAMPLES)])
    rest = residual(found, survey, kernel, east, north)
    if rest is not None:
        mean *= np.exp(rest.log_mean)
        # One number for each draw: the standard deviation of each cell is right, and cells vary
        # together.
        for draw, turn in zip(draws, generator.normal(size=SAMPLES), strict=True):
            draw *= np.exp(rest.log_mean + turn * rest.log_std)
    return DoseMap(
        corner_m=(float(east[0]), float(north[0])),
        cell_m=cell,
        mean_usvh=mean,
        std_usvh=draws.std(axis=0),
        upper_usvh=np.maximum(mean, np.quantile(draws, UPPER_QUANTILE, axis=0)),
    )


def _bounds(
    found: Localization, survey: RadiationSurvey, level_usvh: float
) -> tuple[FloatArray, FloatArray]:
    """Return the south-western and the north-eastern corner of the map."""
    places = survey.positions_enu_m[:, :2]
    low, high = places.min(axis=0) - MARGIN_M, places.max(axis=0) + MARGIN_M
    for source in found.sources:
        _, strongest = source.interval_95_usvh()
        reach = min(math.sqrt(strongest / level_usvh) * 1.1 + MARGIN_M, LARGEST_REACH_M)
        low = np.minimum(low, source.position_enu_m[:2] - reach)
        high = np.maximum(high, source.position_enu_m[:2] + reach)
    return low, high


def _ups(survey: RadiationSurvey, east: FloatArray, north: FloatArray) -> FloatArray | None:
    """Return the heights of the nodes, one metre above the ground; None if it is level."""
    if survey.ground.is_level:
        return None
    return survey.ground.ups_at(np.stack(np.meshgrid(east, north), axis=-1)) + HEIGHT_M


def _drawn(
    found: Localization,
    kernel: Kernel,
    east: FloatArray,
    north: FloatArray,
    ups: FloatArray | None,
    generator: np.random.Generator,
) -> FloatArray:
    background = max(0.0, generator.normal(found.background_usvh, found.background_std_usvh))
    sources = [_shifted(source, generator) for source in found.sources]
    return grid_dose_rates_usvh(sources, background, kernel, east, north, ups)


def _shifted(source: SourceEstimate, generator: np.random.Generator) -> SourceEstimate:
    values, vectors = np.linalg.eigh(source.joint_covariance)
    step = vectors @ (np.sqrt(np.maximum(values, 0.0)) * generator.normal(size=4))
    return SourceEstimate(
        position_enu_m=source.position_enu_m + step[:3],
        dose_rate_at_1m_usvh=source.dose_rate_at_1m_usvh * math.exp(min(step[3], 20.0)),
        joint_covariance=source.joint_covariance,
        detection_llr=source.detection_llr,
    )


def grid_dose_rates_usvh(
    sources: Sequence[SourceEstimate],
    background_usvh: float,
    kernel: Kernel,
    east: FloatArray,
    north: FloatArray,
    ups: FloatArray | None = None,
) -> FloatArray:
    """Return the dose rate at all nodes, shape (north, east).

    `ups` are their heights, of the same shape; None: all 1 m above level ground.
    """
    total: FloatArray = np.full((north.size, east.size), background_usvh)
    for source in sources:
        x, y, up = source.position_enu_m
        columns, rows = (east - x) ** 2, (north - y) ** 2
        if ups is None:
            columns += (HEIGHT_M - up) ** 2
        # Some rows at a time: their arrays stay in the cache of a core.
        for start in range(0, north.size, ROWS_AT_A_TIME):
            block = slice(start, start + ROWS_AT_A_TIME)
            squares = np.add.outer(rows[block], columns)
            if ups is not None:
                squares += (ups[block] - up) ** 2
            values = kernel.values(squares)
            values *= source.dose_rate_at_1m_usvh
            total[block] += values
    return total
