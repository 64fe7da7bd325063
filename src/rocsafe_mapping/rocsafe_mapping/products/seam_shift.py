# SPDX-License-Identifier: Apache-2.0
"""How far photographs disagree where the map changes from one to the other."""

import cv2
import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_mapping.alignment.adjustment.height_error import TieHeights
from rocsafe_mapping.drawing.coarse_view import NO_PHOTO
from rocsafe_mapping.drawing.grid import Window
from rocsafe_mapping.drawing.renderer import Renderer

PATCH_PX = 64
MOST_PATCHES = 150
# Flat patches and repetitive ones have no clear shift.
LEAST_CONTRAST = 6.0
LEAST_RESPONSE = 0.4
# Ground is where ties lie near, and none of their points is higher above the surface than this.
NEAR_M, LEAST_TIES, STANDING_M = 3.0, 2, 0.3


def seam_shifts_px(renderer: Renderer, most: int = MOST_PATCHES) -> tuple[FloatArray, FloatArray]:
    """Return shifts of photographs at places along all seams, map pixels (n,), and where (n, 2).

    About `most` places are asked, by phase correlation of patches of 64 pixels (Kuglin, Hines
    1975); patches without a clear answer do not count.
    """
    labels, window = renderer.owners, renderer.owner_window
    step = max(1, round(renderer.cell_m / renderer.grid.resolution_m))
    places = []
    for axis in (0, 1):
        one = labels[:-1] if axis == 0 else labels[:, :-1]
        other = labels[1:] if axis == 0 else labels[:, 1:]
        rows, columns = np.nonzero((one != other) & (one != NO_PHOTO) & (other != NO_PHOTO))
        places += list(zip(rows, columns, one[rows, columns], other[rows, columns], strict=True))
    chosen = places[:: max(1, len(places) // most)]
    hann = cv2.createHanningWindow((PATCH_PX, PATCH_PX), cv2.CV_32F)
    shifts: list[float] = []
    middles: list[tuple[float, float]] = []
    for row, column, first, second in chosen:
        at = Window(
            (window.row + int(row) + 1) * step - PATCH_PX // 2,
            (window.column + int(column) + 1) * step - PATCH_PX // 2,
            PATCH_PX,
            PATCH_PX,
        )
        patches = [renderer.gray_patch(renderer.names[number], at) for number in (first, second)]
        if min(patch.std() for patch in patches) < LEAST_CONTRAST:
            continue
        (x, y), response = cv2.phaseCorrelate(patches[0], patches[1], hann)
        if response > LEAST_RESPONSE:
            shifts.append(float(np.hypot(x, y)))
            middles.append((at.column + PATCH_PX / 2, at.row + PATCH_PX / 2))
    if not middles:
        return np.zeros(0), np.zeros((0, 2))
    at_px = np.array(middles)
    return np.array(shifts), renderer.grid.ground_of(at_px[:, 0], at_px[:, 1])


def on_ground(places_m: FloatArray, ties: TieHeights) -> BoolArray:
    """Return which places (n,) have no object about them, by the ties nearby.

    The ties of the adjustment decide, not the patches: a shifted patch alone is no sign of an
    object.
    """
    found = np.zeros(len(places_m), bool)
    tells = ties.stds_m < STANDING_M
    for number, place in enumerate(places_m):
        near = tells & (np.linalg.norm(ties.places_m - place, axis=1) < NEAR_M)
        found[number] = near.sum() >= LEAST_TIES and bool(
            np.all(np.abs(ties.standing_m[near]) < STANDING_M)
        )
    return found
