# SPDX-License-Identifier: Apache-2.0
"""A small picture of the whole map, at any time."""

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.position import GeoPosition
from rocsafe_mapping.drawing.coarse_view import CoarseView, coarse_view
from rocsafe_mapping.drawing.grid import MapGrid, Window
from rocsafe_mapping.drawing.placed_photo import PlacedPhoto
from rocsafe_mapping.errors import PlacementError
from rocsafe_mapping.mosaic.mapmaker import Mapmaker

# Long side of a photograph, and of the whole picture.
PHOTOGRAPH_PX = 96
LONGEST_SIDE_PX = 1024
# Favours time over size: a preview is sent once and forgotten.
PNG_COMPRESSION = 1
OPAQUE = 255


class Preview:
    """Small views of all photographs at their places.

    Parameters
    ----------
    maker
        Of the map, which knows the frame and the pixels.
    """

    def __init__(self, maker: Mapmaker) -> None:
        self._maker = maker
        self._views: dict[str, CoarseView] = {}
        self._grid: MapGrid | None = None
        self.is_due = False

    def show(self, placed: PlacedPhoto) -> None:
        """Show a photograph at its place."""
        edge_share = self._maker.options.drawing.views.edge_share
        image = self._maker.pixels.colour(placed.photo.name)
        view = coarse_view(placed, image, self._fit(placed), edge_share)
        self._views[placed.photo.name] = view
        self.is_due = True

    @property
    def window(self) -> Window:
        """Pixels of the preview's own grid that photographs reach.

        Raises
        ------
        PlacementError
            If there is none.
        """
        if not self._views:
            raise PlacementError('no photograph is placed yet')
        windows = [view.window for view in self._views.values()]
        row, column = min(w.row for w in windows), min(w.column for w in windows)
        return Window(
            row,
            column,
            max(w.row + w.height for w in windows) - row,
            max(w.column + w.width for w in windows) - column,
        )

    def corners(self) -> tuple[GeoPosition, GeoPosition]:
        """Return the south-western and the north-eastern corner of `window`.

        Raises
        ------
        PlacementError
            If there is no photograph.
        """
        window = self.window
        assert self._grid is not None  # noqa: S101 - a window has a grid
        return (
            self._grid.position_of(window.column, window.row + window.height),
            self._grid.position_of(window.column + window.width, window.row),
        )

    def png(self) -> bytes:
        """Return the picture of `window` as PNG, its longer side at most 1024 pixels.

        Raises
        ------
        PlacementError
            If there is no photograph.
        """
        self.is_due = False
        bgra = self._composed(self.window)
        shrink = max(bgra.shape) / LONGEST_SIDE_PX
        if shrink > 1.0:
            size = (round(bgra.shape[1] / shrink), round(bgra.shape[0] / shrink))
            bgra = cv2.resize(bgra, size, interpolation=cv2.INTER_AREA)
        return bytes(cv2.imencode('.png', bgra, [cv2.IMWRITE_PNG_COMPRESSION, PNG_COMPRESSION])[1])

    def _composed(self, window: Window) -> NDArray[np.uint8]:
        best = np.zeros((window.height, window.width), np.float32)
        bgr = np.zeros((window.height, window.width, 3), np.uint8)
        for _, view in sorted(self._views.items()):
            part = view.window.within(window)
            is_best = view.scores > best[part]
            cv2.copyTo(view.colours, is_best.view(np.uint8), bgr[part])
            np.maximum(best[part], view.scores, out=best[part])
        alpha = np.where(best > 0.0, OPAQUE, 0).astype(np.uint8)
        return np.dstack([bgr, alpha])

    def _fit(self, placed: PlacedPhoto) -> MapGrid:
        """Return the preview's grid; the first photograph says how fine."""
        if self._grid is None:
            if self._maker.frame is None:
                raise PlacementError('no photograph is placed yet')
            side_m = float(np.ptp(placed.corners_m, axis=0).max())
            self._grid = MapGrid(
                epsg=self._maker.epsg,
                resolution_m=side_m / PHOTOGRAPH_PX,
                frame=self._maker.frame,
            )
        return self._grid
