# SPDX-License-Identifier: Apache-2.0
"""Viewpoints of an area for a camera: the waypoint generator of the ROCSAFE paper.

A rectangle around the polygon is divided into tiles, one photograph each. The paper then drops
every tile whose centre fails a ray-casting test, which leaves slivers of the area unseen; here
every tile that touches the area is kept. A tile is no larger than a camera footprint, so the kept
ones see the whole area.
"""

import contextlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_planner.coverage.beside_exclusions import Views, with_views_beside
from rocsafe_planner.coverage.sight import Sight, sight
from rocsafe_planner.errors import TooManyViewpointsError
from rocsafe_planner.plan.survey_options import CoverageOptions, spacing_m
from rocsafe_planner.problem.airspace import Airspace

# A tile that reaches less far into the area sees no ground worth a photograph.
_TOUCH_M = 1e-6
_RIGHT = 0.5 * math.pi
_SEARCH_STEP_RAD = math.radians(5.0)
_SEARCHED_EDGES = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class CoverageSpec:
    """Measures of the grid.

    `footprint_m` and `spacing_m` are (across, along): across is the direction of the image's
    width, along that of its height, in which the vehicle's nose points.
    """

    footprint_m: tuple[float, float]
    spacing_m: tuple[float, float]
    grid: str
    max_viewpoints: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Coverage:
    """Viewpoints in the plane of a local frame, and the ground that their photographs show.

    Attributes
    ----------
    centres
        (east, north) below the cameras in metres, shape (n, 2): polygon after polygon, rows from
        the south, each from the west (as seen in the grid's own axes).
    yaw_rad
        Of the vehicle at each viewpoint, shape (n,): 0 = east, anticlockwise.
    footprints
        Corners (east, north) of the ground seen from each, shape (n, 4, 2), anticlockwise.
    polygon
        Number of the polygon that each viewpoint was made for, shape (n,).
    sight
        The part of the regions that all photographs show.
    """

    centres: FloatArray
    yaw_rad: FloatArray
    footprints: FloatArray
    polygon: IndexArray
    sight: Sight


def coverage_spec(camera: PinholeCamera, options: CoverageOptions) -> CoverageSpec:
    """Return the measures of the grid: each overlap holds with its own side of the image."""
    across, along = camera.footprint_m(options.height_agl_m)
    return CoverageSpec(
        footprint_m=(across, along),
        spacing_m=(
            spacing_m(across, options.overlap_fraction, options.spacing_rule),
            spacing_m(along, options.front_overlap, options.spacing_rule),
        ),
        grid=options.grid,
        max_viewpoints=options.max_viewpoints,
    )


def cover(
    polygons: Sequence[shapely.Polygon],
    spec: CoverageSpec,
    airspace: Airspace | None = None,
) -> Coverage:
    """Return the viewpoints that photograph `polygons` (east, north; metres).

    Each polygon has a grid of its own. Viewpoints in exclusions are left out; ground outside that
    only they see is photographed from places beside the exclusions, as far as it can be.

    Raises
    ------
    TooManyViewpointsError
        If more than ``spec.max_viewpoints`` are needed; they are counted, not made.
    NoWayError
        If no viewpoint is left.
    """
    tilings = [_tiling(polygon, spec) for polygon in polygons]
    _check_count(sum(len(centres) for centres, _ in tilings), spec)
    centres = np.vstack([centres for centres, _ in tilings])
    footprints = np.vstack([_footprints(*tiling, spec) for tiling in tilings])
    counts = [len(centres) for centres, _ in tilings]
    yaws = np.repeat([math.atan2(axes[1, 1], axes[0, 1]) for _, axes in tilings], counts)
    owners = np.repeat(np.arange(len(polygons)), counts)
    grid = Views(centres=centres, yaw_rad=yaws, footprints=footprints, polygon=owners)
    forbidden = None if airspace is None else airspace.zones
    if airspace is not None:
        grid = with_views_beside(grid, polygons, airspace)
        _check_count(len(grid.centres), spec)
    return Coverage(
        centres=grid.centres,
        yaw_rad=grid.yaw_rad,
        footprints=grid.footprints,
        polygon=grid.polygon,
        sight=sight(polygons, grid.footprints, forbidden),
    )


def _tiling(polygon: shapely.Polygon, spec: CoverageSpec) -> tuple[FloatArray, FloatArray]:
    """Return the viewpoints of one polygon, and the axes of its grid."""
    axes = GRIDS[spec.grid](polygon, spec)
    return _tile_centres(_turned(polygon, axes), spec) @ axes.T, axes


def _turned(polygon: shapely.Polygon, axes: FloatArray) -> shapely.Polygon:
    turned: shapely.Polygon = shapely.transform(polygon, lambda points: points @ axes)
    return turned


def _footprints(centres: FloatArray, axes: FloatArray, spec: CoverageSpec) -> FloatArray:
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    footprints: FloatArray = centres[:, None, :] + (0.5 * corners * spec.footprint_m) @ axes.T
    return footprints


def _axis_aligned(_polygon: shapely.Polygon, _spec: CoverageSpec) -> FloatArray:
    """Return the axes of the paper's rectangle: east, north."""
    return np.eye(2)


def _rotated(polygon: shapely.Polygon, _spec: CoverageSpec) -> FloatArray:
    """Return the axes of the smallest rectangle, the one nearest to east first; columns."""
    corners = shapely.get_coordinates(polygon.minimum_rotated_rectangle)
    side = corners[1] - corners[0]
    angle = math.atan2(side[1], side[0])
    return _axes(angle - round(angle / (math.pi / 2.0)) * (math.pi / 2.0))


def _best(polygon: shapely.Polygon, spec: CoverageSpec) -> FloatArray:
    """Return the axes that need fewest viewpoints: each 5 degrees, each edge, and `_rotated`."""
    ring = shapely.get_coordinates(polygon.exterior)
    sides = np.diff(ring, axis=0)
    longest = sides[np.argsort(-np.hypot(*sides.T), kind='stable')[:_SEARCHED_EDGES]]
    along = np.arctan2(longest[:, 1], longest[:, 0])
    angles = np.concatenate([np.arange(0.0, math.pi, _SEARCH_STEP_RAD), along, along + _RIGHT])
    counts: list[tuple[int, float]] = []
    rotated = _rotated(polygon, spec)
    angles = np.append(angles, math.atan2(rotated[1, 0], rotated[0, 0]))
    for angle in np.unique(np.round(angles % math.pi, 9)).tolist():
        with contextlib.suppress(TooManyViewpointsError):
            counts.append((len(_tile_centres(_turned(polygon, _axes(angle)), spec)), angle))
    # Where no angle is possible, the grid that is not rotated names the reason.
    return _axes(min(counts, default=(0, 0.0))[1])


def _axes(angle_rad: float) -> FloatArray:
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[cos, -sin], [sin, cos]])


GRIDS: dict[str, Callable[[shapely.Polygon, CoverageSpec], FloatArray]] = {
    'axis_aligned': _axis_aligned,
    'rotated': _rotated,
    'best': _best,
}
"""Axes of the circum-rectangle, as columns (across, along), by name."""


def _tile_centres(polygon: shapely.Polygon, spec: CoverageSpec) -> FloatArray:
    """Return the centres of the tiles that touch the polygon, in the grid's axes, (n, 2)."""
    (width, height), (west, south) = spec.spacing_m, polygon.bounds[:2]
    east, north = polygon.bounds[2:]
    columns = _tiles(east - west, width)
    rows = _tiles(north - south, height)
    # A connected area has a tile in every row and column.
    _check_count(max(columns, rows, _tiles(polygon.area, width * height)), spec)
    x0 = 0.5 * (west + east) - 0.5 * columns * width
    y0 = 0.5 * (south + north) - 0.5 * rows * height
    edges = y0 + height * np.arange(rows + 1)
    bands = shapely.intersection(
        polygon, shapely.box(west - 1.0, edges[:-1], east + 1.0, edges[1:])
    )
    row, column = _touched(bands, x0, width, columns)
    _check_count(len(row), spec)
    return np.column_stack([x0 + width * (column + 0.5), y0 + height * (row + 0.5)])


def _tiles(extent: float, tile: float) -> int:
    """Return how many tiles are needed; an extent of whole tiles is not rounded up."""
    return max(1, math.ceil(extent / tile - 1e-9))


def _touched(
    bands: NDArray[np.object_], x0: float, width: float, columns: int
) -> tuple[IndexArray, IndexArray]:
    """Return row and column of each tile that the area touches, row by row, each from the west.

    A connected part of a row's band touches exactly the columns that its x-interval meets.
    """
    parts, row = shapely.get_parts(bands, return_index=True)
    parts, inner = shapely.get_parts(parts, return_index=True)
    row = row[inner]
    solid = shapely.area(parts) > 0.0
    row, bounds = row[solid], shapely.bounds(parts[solid])
    first = np.floor((bounds[:, 0] + _TOUCH_M - x0) / width).astype(np.intp)
    last = np.ceil((bounds[:, 2] - _TOUCH_M - x0) / width).astype(np.intp)
    first = np.maximum(first, 0)
    last = np.minimum(np.maximum(last, first + 1), columns)
    count = np.maximum(last - first, 0)
    # All columns of all parts, in one sequence; parts of one row may share some.
    column = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    tile = np.repeat(row * columns + first, count) + column
    tiles = np.unique(tile)
    return tiles // columns, tiles % columns


def _check_count(needed: int, spec: CoverageSpec) -> None:
    if needed > spec.max_viewpoints:
        across, along = spec.spacing_m
        raise TooManyViewpointsError(
            f'the region needs at least {needed} viewpoints {across:.2f} m by {along:.2f} m '
            f'apart: max_viewpoints is {spec.max_viewpoints}'
        )
