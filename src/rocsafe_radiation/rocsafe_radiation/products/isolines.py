# SPDX-License-Identifier: Apache-2.0
"""Areas of a grid above a level, by marching triangles."""

import numpy as np
import shapely
from shapely.geometry import MultiPolygon, Polygon

from rocsafe_geo.arrays import FloatArray, IndexArray

Index = tuple[IndexArray, IndexArray]
# Corners of the two triangles of a cell as (row, column), and the pairs that make their edges.
TRIANGLES = (((0, 0), (0, 1), (1, 1)), ((0, 0), (1, 1), (1, 0)))
EDGES = ((0, 1), (1, 2), (2, 0))


def areas_above(
    values: FloatArray, level: float, corner: tuple[float, float], cell_m: float
) -> MultiPolygon:
    """Return where `values` exceed `level`, with holes; rings lie on the interpolated isoline.

    Parameters
    ----------
    values
        At the nodes of a grid, shape (rows, columns), rows northwards, columns eastwards.
    level
        Value of the isoline.
    corner
        East and north of ``values[0, 0]``.
    cell_m
        Distance of nodes.
    """
    # Values outside of the grid count as very low, so that each area is closed at the border.
    floor = level - 1e9 * max(1.0, abs(level), float(values.max()))
    padded = np.pad(values, 1, constant_values=floor)
    # Nodes exactly at the level count as just above it: no isoline runs through a node.
    padded = np.where(padded == level, np.nextafter(level, np.inf), padded)
    cells = _cells_cut(padded, level)
    segments = np.concatenate([_segments(padded, level, cells, shape) for shape in TRIANGLES])
    if not len(segments):
        return MultiPolygon()
    segments = np.array(corner) + (segments - 1.0) * cell_m
    faces = shapely.get_parts(shapely.polygonize(list(shapely.linestrings(segments))))
    high = [face for face in faces if _value_in(values, face, corner, cell_m) > level]
    merged = shapely.union_all(high)
    if isinstance(merged, Polygon):
        return MultiPolygon([merged])
    return merged if isinstance(merged, MultiPolygon) else MultiPolygon()


def _cells_cut(values: FloatArray, level: float) -> Index:
    """Return row and column of the cells with corners on both sides of `level`."""
    high = values > level
    corners = (high[:-1, :-1], high[:-1, 1:], high[1:, :-1], high[1:, 1:])
    count = np.sum(corners, axis=0)
    row, column = np.nonzero((count > 0) & (count < len(corners)))
    return row, column


def _segments(
    values: FloatArray, level: float, cells: Index, corners: tuple[tuple[int, int], ...]
) -> FloatArray:
    """Return the isoline in one triangle of each cell, (column, row), shape (n, 2, 2)."""
    row, column = cells
    nodes = [(row + down, column + right) for down, right in corners]
    heights = [values[node] - level for node in nodes]
    crossed = [heights[a] * heights[b] < 0.0 for a, b in EDGES]
    cut = crossed[0] | crossed[1] | crossed[2]
    points = np.stack([_crossing(nodes[a], nodes[b], values, level) for a, b in EDGES], axis=1)
    is_end = np.stack(crossed, axis=1)[cut]
    return np.asarray(points[cut][is_end].reshape(-1, 2, 2))


def _crossing(first: Index, second: Index, values: FloatArray, level: float) -> FloatArray:
    """Return where each edge crosses `level`, (column, row).

    The ends are taken in a fixed order: both triangles of an edge get the very same point.
    """
    swap = (first[0] > second[0]) | ((first[0] == second[0]) & (first[1] > second[1]))
    ends = [
        (np.where(swap, b, a), np.where(swap, a, b)) for a, b in zip(first, second, strict=True)
    ]
    (row0, row1), (column0, column1) = ends
    low, high = values[row0, column0], values[row1, column1]
    span = np.where(high == low, 1.0, high - low)
    share = np.clip((level - low) / span, 0.0, 1.0)
    return np.stack([column0 + share * (column1 - column0), row0 + share * (row1 - row0)], axis=1)


def _value_in(
    values: FloatArray, face: Polygon, corner: tuple[float, float], cell_m: float
) -> float:
    """Return the value, by the plane of its triangle, at a point within `face`."""
    point = face.representative_point()
    column = min(max((point.x - corner[0]) / cell_m, 0.0), values.shape[1] - 1.0)
    row = min(max((point.y - corner[1]) / cell_m, 0.0), values.shape[0] - 1.0)
    j, i = min(int(column), values.shape[1] - 2), min(int(row), values.shape[0] - 2)
    x, y = column - j, row - i
    base, far = values[i, j], values[i + 1, j + 1]
    if x >= y:
        return float(base + x * (values[i, j + 1] - base) + y * (far - values[i, j + 1]))
    return float(base + y * (values[i + 1, j] - base) + x * (far - values[i + 1, j]))
