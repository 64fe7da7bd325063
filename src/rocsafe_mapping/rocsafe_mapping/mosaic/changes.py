# SPDX-License-Identifier: Apache-2.0
"""What changed between two flights over the same ground: where, and how much.

The photographs of both flights are aligned together, so that both maps lie in the same place to a
fraction of a pixel; then colours are compared, forgiving light that changed and edges that moved
by a pixel.
"""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from rocsafe_geo.arrays import BoolArray
from rocsafe_mapping.drawing.grid import MapGrid, Window
from rocsafe_mapping.drawing.renderer import Renderer
from rocsafe_mapping.photographs.shot import ShotRecord

BEFORE, AFTER = 'before_', 'after_'
OPAQUE = 255
# Differences of light wider than this are not changes: shadows of clouds.
LIGHT_M = 25.0
Rgba = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChangeOptions:
    """What counts as a change.

    Attributes
    ----------
    resolution_m
        Side of a pixel that is compared.
    least_area_m2
        Smaller changes are left out.
    least_levels
        Difference of colour, of 255, after the light was made alike.
    least_stds
        Difference over the usual difference of the two maps.
    """

    resolution_m: float = 0.2
    least_area_m2: float = 1.0
    least_levels: float = 25.0
    least_stds: float = 4.0

    def __post_init__(self) -> None:
        for name in ('resolution_m', 'least_area_m2', 'least_levels', 'least_stds'):
            if not getattr(self, name) > 0.0:
                raise ValueError(f'{name} = {getattr(self, name)} must be above 0')


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """A piece of ground that looks different.

    Attributes
    ----------
    outline
        In places (column, row) of the compared grid.
    area_m2
        Of it.
    levels
        Mean difference of colour, of 255.
    """

    outline: shapely.Polygon
    area_m2: float
    levels: float


def renamed(record: ShotRecord, prefix: str) -> ShotRecord:
    """Return `record` as that of one of two flights that are mapped together."""
    vehicle = prefix + record.vehicle
    return dataclasses.replace(record, vehicle=vehicle, shot_id=f'{vehicle}-{record.sequence:05d}')


def changes(before: Renderer, after: Renderer, options: ChangeOptions) -> list[Change]:
    """Return what changed, largest first; both maps are on one grid."""
    window = before.window.cut(after.window)
    if window.is_empty:
        return []
    first, second = _pixels(before, window), _pixels(after, window)
    is_seen = (first[..., 3] == OPAQUE) & (second[..., 3] == OPAQUE)
    difference = _difference(first, second, is_seen, options)
    usual = 1.4826 * float(np.median(difference[is_seen])) if np.any(is_seen) else 0.0
    limit = max(options.least_levels, options.least_stds * usual)
    changed = np.where(is_seen & (difference > limit), 255, 0).astype(np.uint8)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))
    changed = cv2.morphologyEx(changed, cv2.MORPH_OPEN, kernel)
    changed = cv2.morphologyEx(changed, cv2.MORPH_CLOSE, kernel, iterations=2)
    found = _pieces(changed, difference, window, before.grid, options)
    return sorted(found, key=lambda change: -change.area_m2)


def change_document(found: Sequence[Change], grid: MapGrid) -> dict[str, Any]:
    """Return the changes as GeoJSON (RFC 7946), with their area and strength."""
    features = []
    for number, change in enumerate(found):
        rings = []
        for ring in (change.outline.exterior, *change.outline.interiors):
            places = (grid.position_of(column, row) for column, row in ring.coords)
            rings.append([[round(p.longitude_deg, 9), round(p.latitude_deg, 9)] for p in places])
        features.append(
            {
                'type': 'Feature',
                'id': number,
                'geometry': {'type': 'Polygon', 'coordinates': rings},
                'properties': {
                    'area_m2': round(change.area_m2, 2),
                    'difference_levels': round(change.levels, 1),
                },
            }
        )
    return {'type': 'FeatureCollection', 'features': features}


def _pixels(renderer: Renderer, window: Window) -> Rgba:
    rgba = np.zeros((window.height, window.width, 4), np.uint8)
    for tile, part in renderer.tiles():
        shared = tile.cut(window)
        if not shared.is_empty:
            rgba[shared.within(window)] = part[shared.within(tile)]
    return rgba


def _difference(
    first: Rgba, second: Rgba, is_seen: BoolArray, options: ChangeOptions
) -> NDArray[np.float32]:
    """Return the difference of colour, light made alike, the best of shifts by one pixel."""
    side = int(LIGHT_M / options.resolution_m) | 1
    one, other = (_lit(picture, is_seen, side) for picture in (first, second))
    best = np.full(is_seen.shape, np.inf, np.float32)
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            shifted = np.roll(other, (down, right), (0, 1))
            np.minimum(best, np.abs(one - shifted).max(axis=2), out=best)
    best[~is_seen] = 0.0
    return cv2.GaussianBlur(best, (3, 3), 0.0)


def _lit(picture: Rgba, is_seen: BoolArray, side: int) -> NDArray[np.float32]:
    """Return the colours less their mean over a wide window of what both maps show."""
    colours = picture[..., :3].astype(np.float32)
    share = cv2.blur(is_seen.astype(np.float32), (side, side))
    mean = cv2.blur(colours * is_seen[..., np.newaxis], (side, side))
    level: NDArray[np.float32] = colours - mean / np.maximum(share, 1e-3)[..., np.newaxis]
    return level


def _pieces(
    changed: NDArray[np.uint8],
    difference: NDArray[np.float32],
    window: Window,
    grid: MapGrid,
    options: ChangeOptions,
) -> list[Change]:
    outlines, tree = cv2.findContours(changed, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    found = []
    for number, outline in enumerate(outlines):
        if tree[0][number][3] >= 0 or len(outline) < 3:
            continue
        mask = np.zeros_like(changed)
        cv2.drawContours(mask, outlines, number, 255, cv2.FILLED)
        mask &= changed
        area_m2 = float(np.count_nonzero(mask)) * grid.resolution_m**2
        if area_m2 < options.least_area_m2:
            continue
        corners = outline[:, 0] + np.array([window.column + 0.5, window.row + 0.5])
        # Half a pixel outwards: contours run through the centres of pixels.
        shape = shapely.Polygon(corners).buffer(0.5, join_style='mitre')
        # Rows count southwards: what runs clockwise there is anticlockwise on the ground.
        shape = shapely.geometry.polygon.orient(_largest(shape), -1.0)
        levels = float(difference[mask > 0].mean())
        found.append(Change(outline=shape, area_m2=area_m2, levels=levels))
    return found


def _largest(shape: shapely.Geometry) -> shapely.Polygon:
    parts = getattr(shape, 'geoms', [shape])
    return max(parts, key=lambda part: part.area)
