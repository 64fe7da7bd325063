# SPDX-License-Identifier: Apache-2.0
"""The wind around the buildings and over the ground of a site."""

import numpy as np
from scipy import ndimage

from rocsafe_dispersion.buildings.mass_consistent import CorrectionOptions, corrected
from rocsafe_dispersion.buildings.voxels import ground_heights_m, middles_below, solid_cells
from rocsafe_dispersion.buildings.wakes import wake_factors
from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.limits import require_positive
from rocsafe_geo.solids.scene_solids import SceneSolids
from rocsafe_geo.wind.air_grid import AirGrid, FaceVelocities
from rocsafe_geo.wind.site_wind import SitePattern
from rocsafe_geo.wind.wind_field import ProfileWind


def building_wind(
    grid: AirGrid,
    solids: SceneSolids,
    mean: ProfileWind,
    options: CorrectionOptions | None = None,
) -> SitePattern:
    """Return how what stands on a site, and its ground, change a wind.

    Parameters
    ----------
    grid
        Cells in the frame of `solids`; the box should reach three heights above the buildings
        and five beyond them.
    solids
        Ground and things, as `rocsafe_geo.solids.solids_file.read_solids` returns them.
    mean
        Mean wind without buildings: wakes lie behind them as it goes, whatever the wind is later.
    options
        How exactly air is conserved.

    Raises
    ------
    ValueError
        If there is no wind, or the box does not reach above the ground.
    """
    ground = ground_heights_m(grid, solids)
    return wind_around(grid, solid_cells(grid, solids), ground, mean, options)


def wind_around(
    grid: AirGrid,
    solid: BoolArray,
    ground_m: FloatArray,
    mean: ProfileWind,
    options: CorrectionOptions | None = None,
) -> SitePattern:
    """Return the wind around solid cells, see `building_wind`."""
    require_positive('speed of the wind', mean.wind.speed_mps, 'm/s')
    if solid[:, :, -1].all():
        raise ValueError('the box of cells ends below the ground: raise its top')
    below = middles_below(grid, ground_m)
    above = grid.middles_m()[2] - ground_m[:, :, None]
    # Only what rises above the ground is a building; the highest solid cell tells its height.
    tops = np.where(solid & ~below, above + grid.layer_m / 2.0, 0.0)
    factors = wake_factors(grid, above, tops.max(axis=2), mean.wind)
    speed = mean.layer.speed_mps(np.maximum(above, 0.0))
    shares = factors * speed / float(mean.layer.speed_mps(mean.reference_height_m))
    east, north = (corrected(_faces(shares, axis), solid, grid, options) for axis in (0, 1))
    return SitePattern(
        grid=grid,
        ground_m=ground_m,
        # A step of the ground beside a cell is none: what is near the ground passes over it.
        floor_m=grid.bottom_m + grid.layer_m * ndimage.maximum_filter(below.sum(axis=2), 3),
        east=east,
        north=north,
        layer=mean.layer,
        height_m=mean.reference_height_m,
    )


def _faces(shares: FloatArray, axis: int) -> FaceVelocities:
    """Return the flow of 1 m/s along an axis at the faces of cells with `shares` of it."""
    parts = [
        np.zeros([size + (i == face) for i, size in enumerate(shares.shape)], np.float32)
        for face in range(3)
    ]
    parts[axis][:] = _between(shares, axis)
    return FaceVelocities(east=parts[0], north=parts[1], up=parts[2])


def _between(values: FloatArray, axis: int) -> FloatArray:
    """Return the means of neighbours along an axis, the outer ones as they are."""
    size = values.shape[axis]
    first = np.take(values, [0, *range(size)], axis)
    second = np.take(values, [*range(size), size - 1], axis)
    return np.asarray((first + second) / 2.0)
