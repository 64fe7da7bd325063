# SPDX-License-Identifier: Apache-2.0
"""Small views of photographs from above, on one coarse grid: what the map is planned with.

The map itself is only ever in memory by the tile.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_mapping.drawing.grid import MapGrid, Window
from rocsafe_mapping.drawing.placed_photo import LATTICE_PX, PlacedPhoto, Shares, drawn, scores

# Owners: the index of the photograph that is shown at each pixel of the coarse grid, or none.
NO_PHOTO = -1
Labels = NDArray[np.int32]


@dataclass(frozen=True, slots=True, kw_only=True)
class CoarseView:
    """A photograph on the coarse grid.

    Attributes
    ----------
    window
        Where.
    colours
        Blue, green, red, shape (height, width, 3).
    scores
        How well it shows each pixel, 0 where it does not.
    squares
        Squared distances from the middle of the image, 1 in its corners.
    """

    window: Window
    colours: NDArray[np.uint8]
    scores: Shares
    squares: Shares


def coarse_grid(
    grid: MapGrid, placed_photos: Mapping[str, PlacedPhoto], side_px: int
) -> tuple[MapGrid, int]:
    """Return the coarse grid and how many pixels of the map one of its pixels is wide."""
    sides = [np.ptp(placed.corners_m, axis=0).max() for placed in placed_photos.values()]
    step = max(1, round(float(np.median(sides)) / side_px / grid.resolution_m))
    coarse = MapGrid(epsg=grid.epsg, resolution_m=grid.resolution_m * step, frame=grid.frame)
    return coarse, step


def coarse_view(
    placed: PlacedPhoto, image: NDArray[np.uint8], grid: MapGrid, edge_share: float
) -> CoarseView:
    """Return a photograph on the coarse grid."""
    window = grid.window_of(placed.corners_m)
    height, width = (-(-side // LATTICE_PX) * LATTICE_PX for side in (window.height, window.width))
    window = Window(window.row, window.column, height, width)
    seen = placed.pixel_map(grid, window)
    return CoarseView(
        window=window,
        colours=drawn(image, seen, cv2.INTER_LINEAR),
        scores=scores(placed.photo.camera, seen, edge_share),
        squares=seen.squares(placed.photo.camera),
    )


def overlapping(windows: Sequence[Window]) -> list[tuple[int, int]]:
    """Return the index pairs of windows that meet."""
    boxes = np.array([(w.row, w.column, w.row + w.height, w.column + w.width) for w in windows])
    pairs = []
    for a, box in enumerate(boxes):
        rest = boxes[a + 1 :]
        meets = np.all(rest[:, :2] < box[2:], axis=1) & np.all(box[:2] < rest[:, 2:], axis=1)
        pairs += [(a, a + 1 + int(b)) for b in np.flatnonzero(meets)]
    return pairs
