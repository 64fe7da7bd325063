# SPDX-License-Identifier: Apache-2.0
"""The map made of all photographs placed so far."""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from rocsafe_geo.position import GeoPosition
from rocsafe_mapping.canvas import TILE_PX, Canvas, Rgba, Window
from rocsafe_mapping.errors import MappingError, PlacementError
from rocsafe_mapping.options import SMALLEST_MAX_PIXELS
from rocsafe_mapping.placement import (
    FloatArray,
    Placement,
    placement_of,
    position_of_utm,
    utm_epsg,
)
from rocsafe_mapping.rendering import render, window_of
from rocsafe_mapping.shot import ShotRecord

PREVIEW_SIDE_PX = 1024
# A preview is due when this many times its own pixels were laid since the last, or this share of
# all pixels laid: previews then cost less than the map, however fast photographs come.
PREVIEW_WORK = 8
PREVIEW_SHARE = 1 / 5
# Favours time over size: a preview is sent once and forgotten.
PNG_COMPRESSION = 1
# The map's edges lie on multiples of this many pixels, so that its reductions have no odd edge.
EDGE_STEP_PX = 32
ReadImage = Callable[[], bytes]
Notice = Callable[[str], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class MapExtent:
    """Where the map lies and how fine it is.

    Attributes
    ----------
    epsg: UTM zone of the grid.
    resolution_m: side of a pixel.
    window: pixels of the grid that the map holds.
    """

    epsg: int
    resolution_m: float
    window: Window

    @property
    def west_m(self) -> float:
        """Easting of the left edge."""
        return self.window.column * self.resolution_m

    @property
    def north_m(self) -> float:
        """Northing of the upper edge."""
        return -self.window.row * self.resolution_m

    @property
    def south_west(self) -> GeoPosition:
        """Lower left corner."""
        south_m = self.north_m - self.window.height * self.resolution_m
        return position_of_utm(self.epsg, self.west_m, south_m)

    @property
    def north_east(self) -> GeoPosition:
        """Upper right corner."""
        east_m = self.west_m + self.window.width * self.resolution_m
        return position_of_utm(self.epsg, east_m, self.north_m)


class Mosaic:
    """Places photographs on a map by position and attitude alone.

    The first photograph fixes the UTM zone; apart from that the map does not depend on the order
    of photographs.

    Parameters
    ----------
    ground_resolution_m: side of a pixel of the map, as long as it fits into `max_pixels`.
    max_pixels: limit of width times height; a larger map is made again with pixels twice as wide.
    notice: is told of that in one line.
    """

    def __init__(
        self,
        *,
        ground_resolution_m: float,
        max_pixels: int,
        notice: Notice = lambda _text: None,
    ) -> None:
        if max_pixels < SMALLEST_MAX_PIXELS:
            raise ValueError(f'max_pixels = {max_pixels} must be at least {SMALLEST_MAX_PIXELS}')
        self._resolution_m = ground_resolution_m
        self._max_pixels = max_pixels
        self._notice = notice
        self._canvas = Canvas()
        self._epsg: int | None = None
        self._placed: dict[str, tuple[ShotRecord, Placement, ReadImage]] = {}
        self._corners_m = np.empty((0, 2))
        self._laid_px = 0
        self._previewed_px = 0

    def __len__(self) -> int:
        return len(self._placed)

    def __contains__(self, shot_id: str) -> bool:
        return shot_id in self._placed

    @property
    def extent(self) -> MapExtent:
        """Where the map lies.

        Raises
        ------
        PlacementError: if no photograph is placed yet.
        """
        if self._epsg is None or not self._placed:
            raise PlacementError('no photograph is placed yet')
        return MapExtent(
            epsg=self._epsg,
            resolution_m=self._resolution_m,
            window=self._window(self._corners_m, self._resolution_m),
        )

    def place(self, record: ShotRecord, read_image: ReadImage) -> None:
        """Lay a photograph onto the map; one that lies there already changes nothing.

        `read_image` returns its JPEG file, now and whenever the map is made again.

        Raises
        ------
        PlacementError: if it cannot be placed; the map is as before.
        StoreError: if `read_image` cannot read it now.
        """
        if record.shot_id in self._placed:
            return
        epsg = self._epsg or utm_epsg(record)
        placement = placement_of(record, epsg)
        corners_m = np.vstack([self._corners_m, placement.corners_m])
        resolution_m = self._fitting_resolution_m(corners_m)
        rendering = render(record, placement, read_image(), resolution_m)
        self._epsg = epsg
        if resolution_m > self._resolution_m:
            self._make_again(resolution_m)
        self._canvas.lay(rendering.window, rendering.colours, rendering.scores)
        self._placed[record.shot_id] = (record, placement, read_image)
        self._corners_m = np.array([corners_m.min(axis=0), corners_m.max(axis=0)])
        self._laid_px += rendering.scores.size

    def read(self, window: Window) -> Rgba:
        """Return what a window of the grid shows, shape (height, width, 4), with coverage."""
        return self._canvas.read(window)

    @property
    def is_preview_due(self) -> bool:
        """Whether enough was laid onto the map since the last preview to make another."""
        new_px = self._laid_px - self._previewed_px
        if new_px == 0:
            return False
        window = self.extent.window
        preview_px = window.height * window.width / self._preview_reduction() ** 2
        return new_px >= min(PREVIEW_WORK * preview_px, PREVIEW_SHARE * self._laid_px)

    def preview_png(self) -> bytes:
        """Return a PNG picture of the whole map, north up, its longer side at most 1024 pixels.

        Raises
        ------
        PlacementError: if no photograph is placed yet.
        """
        self._previewed_px = self._laid_px
        rgba = self._canvas.read_small(self.extent.window, self._preview_reduction())
        bgra = cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGRA)
        _, png = cv2.imencode('.png', bgra, [cv2.IMWRITE_PNG_COMPRESSION, PNG_COMPRESSION])
        return bytes(png)

    def _preview_reduction(self) -> int:
        window = self.extent.window
        reduction = 1
        while max(window.height, window.width) > PREVIEW_SIDE_PX * reduction:
            reduction *= 2
        return min(reduction, TILE_PX)

    def _window(self, corners_m: FloatArray, resolution_m: float) -> Window:
        """Return the map's window that holds `corners_m`, its edges on multiples of a step."""
        step = window_of(corners_m, resolution_m * EDGE_STEP_PX)
        return Window(
            EDGE_STEP_PX * step.row,
            EDGE_STEP_PX * step.column,
            EDGE_STEP_PX * step.height,
            EDGE_STEP_PX * step.width,
        )

    def _fitting_resolution_m(self, corners_m: FloatArray) -> float:
        resolution_m = self._resolution_m
        while True:
            window = self._window(corners_m, resolution_m)
            if window.height * window.width <= self._max_pixels:
                return resolution_m
            resolution_m *= 2.0

    def _make_again(self, resolution_m: float) -> None:
        self._notice(
            f'the map would exceed {self._max_pixels} pixels: its pixels are now '
            f'{resolution_m:g} m wide, not {self._resolution_m:g} m'
        )
        self._resolution_m = resolution_m
        self._canvas = Canvas()
        for record, placement, read_image in tuple(self._placed.values()):
            try:
                rendering = render(record, placement, read_image(), resolution_m)
            except MappingError as error:
                self._notice(f'{record.shot_id} is lost from the map: {error}')
                del self._placed[record.shot_id]
                continue
            self._canvas.lay(rendering.window, rendering.colours, rendering.scores)
