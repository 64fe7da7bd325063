# SPDX-License-Identifier: Apache-2.0
"""The part of regions that photographs show; what lies in exclusions is counted apart."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from rocsafe_geo.arrays import FloatArray

# Smaller unseen parts are ignored: 3 cm by 3 cm.
_HAIR_M2 = 1e-3
# Corners of footprints are rounded to this before they are united.
_UNION_GRID_M = 1e-6
# Tolerance within which footprints lie in one row.
_RUN_M = 1e-7


@dataclass(frozen=True, slots=True, kw_only=True)
class Sight:
    """Areas of regions, square metres.

    Attributes
    ----------
    region_area_m2
        Of the regions.
    forbidden_area_m2
        Of their part in exclusions, which nobody has to photograph.
    covered_area_m2, largest_hole_m2
        Of the other part: what at least one footprint shows, and the largest hole in that.
    """

    region_area_m2: float
    forbidden_area_m2: float
    covered_area_m2: float
    largest_hole_m2: float


def sight(
    polygons: Sequence[shapely.Polygon],
    footprints: FloatArray,
    forbidden: shapely.Geometry | None = None,
) -> Sight:
    """Return the part of polygons that the footprints (n, 4, 2) show, less what is forbidden."""
    region = shapely.union_all(polygons)
    ground = accessible(region, forbidden)
    hole = unseen(ground, footprints)
    return Sight(
        region_area_m2=region.area,
        forbidden_area_m2=region.area - ground.area,
        covered_area_m2=ground.area - min(ground.area, hole.area),
        largest_hole_m2=float(shapely.area(shapely.get_parts(hole)).max(initial=0.0)),
    )


def accessible(region: shapely.Geometry, forbidden: shapely.Geometry | None) -> shapely.Geometry:
    """Return the part of a region outside exclusions."""
    return region if forbidden is None else shapely.difference(region, forbidden)


def unseen(region: shapely.Geometry, footprints: FloatArray) -> shapely.Geometry:
    """Return the part of the region in no footprint."""
    # Without the rounding, GEOS 3.13 may lose whole rectangles that nearly share an edge.
    seen = shapely.union_all(shapely.polygons(_runs(footprints)), grid_size=_UNION_GRID_M)
    parts = shapely.get_parts(shapely.difference(region, seen))
    # Rounding leaves thin slivers along common edges of footprints.
    return shapely.multipolygons(parts[shapely.area(parts) > _HAIR_M2])


def _runs(footprints: FloatArray) -> FloatArray:
    """Return footprints (n, 4, 2) with those joined that follow each other along their width.

    Two are joined where the second is the first, moved along its own base by less than its length:
    together they are one rectangle. Rows of a grid become few rectangles, which are quick to
    unite.
    """
    if len(footprints) < 2:
        return footprints
    moves = footprints[1:] - footprints[:-1]
    base = footprints[:-1, 1] - footprints[:-1, 0]
    length = np.hypot(base[:, 0], base[:, 1])
    along = (moves[:, 0] * base).sum(axis=1) / length
    across = (moves[:, 0, 0] * base[:, 1] - moves[:, 0, 1] * base[:, 0]) / length
    is_moved = np.abs(moves - moves[:, :1]).max(axis=(1, 2)) < _RUN_M
    joins = is_moved & (np.abs(across) < _RUN_M) & (along > 0.0) & (along <= length)
    first = np.flatnonzero(np.concatenate([[True], ~joins]))
    last = np.concatenate([first[1:], [len(footprints)]]) - 1
    return np.stack(
        [footprints[first, 0], footprints[last, 1], footprints[last, 2], footprints[first, 3]],
        axis=1,
    )
