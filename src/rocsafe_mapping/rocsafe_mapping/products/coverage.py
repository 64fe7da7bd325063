# SPDX-License-Identifier: Apache-2.0
"""How much of a region the map shows, and the largest hole in it."""

from typing import Any

import cv2
import numpy as np
import shapely

from rocsafe_geo.arrays import BoolArray
from rocsafe_mapping.drawing.coarse_view import NO_PHOTO
from rocsafe_mapping.drawing.renderer import Renderer


def coverage(renderer: Renderer, region: shapely.Polygon | None) -> dict[str, Any]:
    """Return the area shown and, of the region or else of the outline, the share and holes."""
    is_seen = renderer.owners != NO_PHOTO
    cell_m2 = renderer.cell_m**2
    wanted = _mask(renderer, region) if region is not None else _hull(is_seen)
    missing = wanted & ~is_seen
    count, _, statistics, _ = cv2.connectedComponentsWithStats(missing.astype(np.uint8))
    largest = max((int(statistics[n, cv2.CC_STAT_AREA]) for n in range(1, count)), default=0)
    # Parts of the region outside the map's grid are not seen.
    wanted_m2 = region.area if region is not None else float(wanted.sum()) * cell_m2
    return {
        'of': 'region' if region is not None else 'outline of the photographs',
        'shown_m2': round(float(is_seen.sum()) * cell_m2, 1),
        'share': round(
            min(float((wanted & is_seen).sum()) * cell_m2 / max(wanted_m2, 1e-9), 1.0), 4
        ),
        'largest_hole_m2': round(largest * cell_m2, 1),
    }


def _mask(renderer: Renderer, region: shapely.Polygon) -> BoolArray:
    """Return which coarse pixels lie in the region."""
    window = renderer.owner_window
    mask = np.zeros((window.height, window.width), np.uint8)
    for ring, value in [(region.exterior, 1), *((hole, 0) for hole in region.interiors)]:
        places = renderer.coarse.places_of(np.asarray(ring.coords)[:, :2])
        corners = np.rint(places - (window.column + 0.5, window.row + 0.5)).astype(np.int32)
        cv2.fillPoly(mask, [corners], value)
    return mask.astype(bool)


def _hull(is_seen: BoolArray) -> BoolArray:
    """Return what is seen with its holes filled."""
    mask = is_seen.astype(np.uint8)
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(mask, outlines, -1, 1, cv2.FILLED)
    return mask.astype(bool)
