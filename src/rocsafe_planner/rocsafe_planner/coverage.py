# SPDX-License-Identifier: Apache-2.0
"""From an area and a camera to viewpoints: the waypoint generator of the ROCSAFE paper.

A rectangle around the polygon is divided into tiles, one photograph each. The paper then drops
every tile whose centre fails a ray-casting test, which leaves slivers of the area unseen; here
every tile that touches the area is kept. A tile is no larger than a camera footprint, so the kept
ones see the whole area.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from rocsafe_geo.limits import require_finite
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_planner.errors import TooManyViewpointsError

FloatArray = NDArray[np.float64]

# A tile that reaches less far into the area sees no ground worth a photograph.
_TOUCH_M = 1e-6
# Corners of footprints are rounded to this before they are united.
_UNION_GRID_M = 1e-6

SPACING_RULES: dict[str, Callable[[float], float]] = {
    'iou': lambda overlap: (1.0 - overlap) / (1.0 + overlap),
    'linear': lambda overlap: 1.0 - overlap,
}
"""Spacing as a fraction of the footprint, by name of the rule."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CoverageSpec:
    """What the grid depends on besides the area.

    `footprint_m` and `spacing_m` are (across, along): across is the direction of the image's
    width, along that of its height, in which the vehicle's nose points.
    """

    footprint_m: tuple[float, float]
    spacing_m: tuple[float, float]
    grid: str
    max_viewpoints: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Coverage:
    """Viewpoints in the plane of a local frame, and what their photographs see.

    Attributes
    ----------
    centres
        (east, north) below the cameras in metres, shape (n, 2): rows from the south, each from
        the west (as seen in the grid's own axes).
    yaw_rad
        Of the vehicle at every viewpoint: 0 = east, anticlockwise.
    footprints
        Corners (east, north) of the ground seen from each, shape (n, 4, 2), anticlockwise.
    region_area_m2, covered_area_m2
        Of the area, and of its part inside at least one footprint.
    """

    centres: FloatArray
    yaw_rad: float
    footprints: FloatArray
    region_area_m2: float
    covered_area_m2: float


def spacing_m(footprint_m: float, overlap_fraction: float, rule: str) -> float:
    """Return the distance between neighbouring viewpoints along one side of the footprint.

    ``'iou'`` is the paper's w = 2h((1-y)/(1+y))tan(theta), theta half the field of view: two
    neighbouring photographs share the fraction y of the ground that either sees. ``'linear'`` is
    the surveyors' w = F(1-y): they share the fraction y of one. With F = 2h tan(theta), y = 0.2
    means 33.3 % of the image side in the first and 20 % in the second.

    Raises
    ------
    ValueError
        If the rule is not known or the overlap is outside 0 to below 1.
    """
    if rule not in SPACING_RULES:
        raise ValueError(f'spacing_rule is {rule!r}: must be one of {", ".join(SPACING_RULES)}')
    overlap = require_finite('overlap_fraction', overlap_fraction)
    if not 0.0 <= overlap < 1.0:
        raise ValueError(f'overlap_fraction is {overlap:g}: must be from 0 to below 1')
    return footprint_m * SPACING_RULES[rule](overlap)


def coverage_spec(
    camera: PinholeCamera, height_m: float, overlap_fraction: float, rule: str,
    grid: str, max_viewpoints: int,
) -> CoverageSpec:
    """Return the grid's measures; the rule holds across and along, each with its own angle."""
    across, along = camera.footprint_m(height_m)
    return CoverageSpec(
        footprint_m=(across, along),
        spacing_m=(spacing_m(across, overlap_fraction, rule),
                   spacing_m(along, overlap_fraction, rule)),
        grid=grid,
        max_viewpoints=max_viewpoints,
    )


def cover(polygon: shapely.Polygon, spec: CoverageSpec) -> Coverage:
    """Return the viewpoints that photograph `polygon` (east, north; metres).

    Raises
    ------
    TooManyViewpointsError
        If more than ``spec.max_viewpoints`` are needed; found out without making them.
    """
    axes = GRIDS[spec.grid](polygon)
    turned = shapely.transform(polygon, lambda points: points @ axes)
    centres = _tile_centres(turned, spec)
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    footprints = centres[:, None, :] + 0.5 * corners * spec.footprint_m
    # Without the rounding, GEOS 3.13 may lose whole rectangles that nearly share an edge.
    seen = shapely.union_all(shapely.polygons(footprints), grid_size=_UNION_GRID_M)
    return Coverage(
        centres=centres @ axes.T,
        yaw_rad=math.atan2(axes[1, 1], axes[0, 1]),
        footprints=footprints @ axes.T,
        region_area_m2=polygon.area,
        covered_area_m2=min(polygon.area, turned.intersection(seen).area),
    )


def _axis_aligned(_polygon: shapely.Polygon) -> FloatArray:
    """Return the axes of the paper's rectangle: east, north."""
    return np.eye(2)


def _rotated(polygon: shapely.Polygon) -> FloatArray:
    """Return the axes of the smallest rectangle, the one nearest to east first; columns."""
    corners = shapely.get_coordinates(polygon.minimum_rotated_rectangle)
    side = corners[1] - corners[0]
    angle = math.atan2(side[1], side[0])
    angle -= round(angle / (math.pi / 2.0)) * (math.pi / 2.0)
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])


GRIDS: dict[str, Callable[[shapely.Polygon], FloatArray]] = {
    'axis_aligned': _axis_aligned,
    'rotated': _rotated,
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
    centres: list[FloatArray] = []
    for row, band in enumerate(bands):
        touched = _touched_columns(band, x0, width, columns)
        x = x0 + width * (touched + 0.5)
        centres.append(np.column_stack([x, np.full_like(x, y0 + height * (row + 0.5))]))
    _check_count(sum(len(row) for row in centres), spec)
    return np.vstack(centres)


def _tiles(extent: float, tile: float) -> int:
    """Return how many tiles are needed; an extent of whole tiles is not rounded up."""
    return max(1, math.ceil(extent / tile - 1e-9))


def _touched_columns(band: shapely.Geometry, x0: float, width: float, columns: int) -> FloatArray:
    """Return the numbers of the tiles of one row that the area touches, rising.

    A connected part of a row's band touches exactly the columns that its x-interval meets.
    """
    parts = shapely.get_parts(shapely.get_parts(band))
    touched = np.zeros(columns, dtype=bool)
    for x_min, _, x_max, _ in shapely.bounds(parts[shapely.area(parts) > 0.0]):
        first = math.floor((x_min + _TOUCH_M - x0) / width)
        last = math.ceil((x_max - _TOUCH_M - x0) / width)
        touched[max(first, 0):max(last, first + 1)] = True
    return np.flatnonzero(touched).astype(float)


def _check_count(needed: int, spec: CoverageSpec) -> None:
    if needed > spec.max_viewpoints:
        across, along = spec.spacing_m
        raise TooManyViewpointsError(
            f'the region needs at least {needed} viewpoints {across:.2f} m by {along:.2f} m '
            f'apart: max_viewpoints is {spec.max_viewpoints}'
        )
