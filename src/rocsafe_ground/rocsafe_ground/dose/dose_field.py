# SPDX-License-Identifier: Apache-2.0
"""The dose rate at each cell: mean, upper 95 %, and draws from what is known of the sources.

The cells of a dose map are wide where it reaches far: near a source the rate changes much within
one. The rate at a cell is therefore that of the sources by 1 / r^2, times the ratio of the map to
the same law, which varies slowly: it holds what air and shields absorb and scatter, and heights.
"""

from dataclasses import dataclass, replace

import numpy as np
from rasterio.enums import Resampling

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_geo.position import GeoPosition
from rocsafe_ground.dose.source_posterior import SourcePosterior
from rocsafe_ground.drivable.raster import Bands
from rocsafe_ground.drivable.route_grid import RouteGrid

# Nearer than this to a source a rate is that of this distance, metres.
LEAST_DISTANCE_M = 0.1
MEAN, UPPER = 0, 2
# A cell is near a source within this many standard deviations of its place plus this distance,
# metres. The cells of the map are too wide there: the upper 95 % comes from draws.
NEAR_STDS, NEAR_M = 3.0, 2.0
UPPER_QUANTILE, UPPER_DRAWS, UPPER_SEED = 0.95, 128, 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DoseField:
    """Dose rates on a grid.

    Attributes
    ----------
    mean_usvh, upper_usvh : (rows, columns)
        As estimated, and the upper 95 % of each cell; NaN where the map does not reach.
    grid
        The grid.
    posterior
        Sources; None: no draws.
    ratio : (rows, columns)
        Of the map to the law 1 / r^2.
    """

    mean_usvh: FloatArray
    upper_usvh: FloatArray
    grid: RouteGrid
    posterior: SourcePosterior | None
    ratio: FloatArray

    def drawn_rates(self, cells: IndexArray, count: int, seed: int) -> FloatArray:
        """Return rates at cells from `count` draws of the sources, (count, cells).

        Without sources each draw is the map as estimated.
        """
        row, column = np.divmod(np.asarray(cells, np.int64), self.grid.columns)
        if self.posterior is None:
            return np.tile(self.mean_usvh[row, column], (count, 1))
        generator = np.random.default_rng([seed, 0x6D])
        places = self.grid.place_of(cells)
        rates = np.tile(self.posterior.drawn_background(generator, count)[:, None], len(places))
        for source in self.posterior.sources:
            at = np.array(self.grid.enu_of(source.position))
            steps, strengths = source.drawn(generator, count)
            for k in range(count):
                rates[k] += strengths[k] * _by_distance(places - (at + steps[k]))
        return rates * self.ratio[row, column]


def dose_field(
    dose_map: Bands,
    posterior: SourcePosterior | None,
    grid: RouteGrid,
) -> DoseField:
    """Return the dose rates on `grid` from the bands mean, deviation and upper 95 % of a map."""
    used = replace(dose_map, values=dose_map.values[[MEAN, UPPER]])
    mean, upper = used.on(grid, Resampling.bilinear)
    upper = np.maximum(upper, mean)
    ratio: FloatArray = np.ones(grid.shape)
    if posterior is not None and posterior.sources:
        share = upper / np.maximum(mean, 1e-12)
        east, north = grid.places()
        places = np.column_stack([east.ravel(), north.ravel()])
        law = _rates(posterior, grid, places).reshape(grid.shape)
        ratio = _coarse_ratio(dose_map, posterior, grid)
        mean = np.where(np.isnan(mean), np.nan, law * ratio)
        upper = mean * share
    field = DoseField(
        mean_usvh=mean, upper_usvh=upper, grid=grid,
        posterior=posterior, ratio=ratio,
    )  # fmt: skip
    cells = _cells_near(posterior, grid)
    if len(cells):
        drawn = np.quantile(
            field.drawn_rates(cells, UPPER_DRAWS, UPPER_SEED), UPPER_QUANTILE, axis=0
        )
        row, column = np.divmod(cells, grid.columns)
        upper[row, column] = np.maximum(upper[row, column], drawn)
    return field


def _cells_near(posterior: SourcePosterior | None, grid: RouteGrid) -> IndexArray:
    """Return the cells in which a source may be, or which are next to such."""
    is_near = np.zeros(grid.shape, np.bool_)
    east, north = grid.places()
    for source in posterior.sources if posterior else ():
        at_east, at_north = grid.enu_of(source.position)
        std_m = float(np.sqrt(np.linalg.eigvalsh(source.covariance_m2[:2, :2])[-1]))
        reach = NEAR_STDS * std_m + NEAR_M
        is_near |= np.hypot(east - at_east, north - at_north) < reach
    return np.flatnonzero(is_near)


def _coarse_ratio(
    dose_map: Bands,
    posterior: SourcePosterior,
    grid: RouteGrid,
) -> FloatArray:
    """Return the ratio of the map to the law at the nodes of the map, between them bilinear."""
    _, rows, columns = dose_map.values.shape
    west, south, east, north = dose_map.bounds_in(grid.projection)
    east_m = west + (np.arange(columns) + 0.5) * (east - west) / columns
    north_m = north - (np.arange(rows) + 0.5) * (north - south) / rows
    places = np.column_stack([axis.ravel() for axis in np.meshgrid(east_m, north_m)])
    law = _rates(posterior, grid, places).reshape(rows, columns)
    ratio = Bands(
        values=(dose_map.values[MEAN] / np.maximum(law, 1e-12))[None],
        crs=dose_map.crs, transform=dose_map.transform, pixel_m=dose_map.pixel_m,
    )  # fmt: skip
    return ratio.on(grid, Resampling.bilinear)[0]


def _rates(posterior: SourcePosterior, grid: RouteGrid, places: FloatArray) -> FloatArray:
    """Return background and 1 / r^2, r horizontal, of all sources at places (n, 2), (n,)."""
    total: FloatArray = np.full(len(places), posterior.background_usvh)
    for source in posterior.sources:
        total += source.rate_usvh * _by_distance(places - np.array(grid.enu_of(source.position)))
    return total


def _by_distance(offsets_m: FloatArray) -> FloatArray:
    """Return 1 / r^2 of places from a source, east and north, (n, 2), (n,)."""
    squares = (offsets_m**2).sum(axis=1)
    return np.asarray(1.0 / np.maximum(squares, LEAST_DISTANCE_M**2))


def origin_of(dose_map: Bands) -> GeoPosition | None:
    """Return the origin of the frame of a dose map of ROCSAFE; None: it is another raster."""
    projection = dict(getattr(dose_map.crs, 'to_dict', dict)())
    if projection.get('proj') != 'tmerc' or 'lat_0' not in projection:
        return None
    return GeoPosition(float(projection['lat_0']), float(projection['lon_0']), 0.0)
