# SPDX-License-Identifier: Apache-2.0
"""The map, drawn tile by tile: memory holds a tile, the small views and a cache of photographs."""

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_mapping.drawing.blending import REACH_PX, Mask, Part, blended, reach
from rocsafe_mapping.drawing.coarse_view import NO_PHOTO, CoarseView, coarse_grid, coarse_view
from rocsafe_mapping.drawing.gains import gains
from rocsafe_mapping.drawing.grid import TILE_PX, MapGrid, Window
from rocsafe_mapping.drawing.pixel_cache import PixelCache
from rocsafe_mapping.drawing.placed_photo import PlacedPhoto, drawn
from rocsafe_mapping.drawing.relief import Relief, relief
from rocsafe_mapping.drawing.seams import owners
from rocsafe_mapping.drawing.vignetting import FallOff, fall_offs
from rocsafe_mapping.drawing_options import DrawingOptions

Rgba = NDArray[np.uint8]


class Renderer:
    """Draws the map of aligned photographs.

    Parameters
    ----------
    placed_photos
        Aligned photographs by name.
    pictures
        Their pixels.
    grid
        Of the map.
    tied
        Photographs whose places are good enough to tell what stands on the ground; without them
        `relief` says that nothing does.
    """

    def __init__(
        self,
        placed_photos: Mapping[str, PlacedPhoto],
        pixels: PixelCache,
        grid: MapGrid,
        options: DrawingOptions,
        tied: Collection[str] = (),
    ) -> None:
        if not placed_photos:
            raise ValueError('placed_photos must hold at least one photograph')
        self.grid = grid
        self.names = sorted(placed_photos)
        self._placed_photos = dict(placed_photos)
        self._pixels = pixels
        # 1. Small views of all photographs from above, on a coarse grid.
        side_px = options.views.coarse_side_px
        self.coarse, self._step = coarse_grid(grid, placed_photos, side_px)
        views = self._coarse_views(options.views.edge_share)
        # 2. The lenses' fall-off, and gains that make their brightness and colour alike.
        lenses = {name: placed_photos[name].photo.lens for name in self.names}
        fall_offs_by_lens = fall_offs(views, lenses, options.gains, options.vignetting)
        self._fall_offs = {name: fall_offs_by_lens.get(lenses[name]) for name in self.names}
        views = {name: _flattened(view, self._fall_offs[name]) for name, view in views.items()}
        self.gains = gains(views, options.gains)
        for name in self.names:
            views[name] = _evened(views[name], self.gains[name])
        # 3. Who shows each place: borders where two agree. 4. Objects that they cut made whole.
        self._view_windows = {name: view.window for name, view in views.items()}
        self.owner_window = _about(self._view_windows.values())
        self.owners = owners(views, self.names, self.owner_window, options)
        # 5. Heights of what stands on the ground. 6. Tiles are drawn and blended when asked for.
        shown = self.owners, self.owner_window
        self.relief: Relief = relief(
            views, placed_photos, tied, shown, self.coarse, options.relief
        )

    @property
    def window(self) -> Window:
        """Pixels of the grid that show something."""
        rows, columns = np.nonzero(self.owners != NO_PHOTO)
        window = self.owner_window
        row, column = window.row + int(rows.min()), window.column + int(columns.min())
        height, width = int(np.ptp(rows)) + 1, int(np.ptp(columns)) + 1
        step = self._step
        return Window(row * step, column * step, height * step, width * step)

    @property
    def cell_m(self) -> float:
        """Side of a pixel of `owners`."""
        return self.coarse.resolution_m

    def shown_window(self, name: str) -> Window:
        """Return where a photograph may be shown, in coarse pixels within `owner_window`."""
        return self._view_windows[name].cut(self.owner_window)

    def tiles(self, side: int = TILE_PX) -> Iterator[tuple[Window, Rgba]]:
        """Return the map's tiles that show something, in rows."""
        for tile in self.window.tiles(side):
            rgba = self.tile(tile)
            if rgba is not None:
                yield tile, rgba

    def tile(self, tile: Window) -> Rgba | None:
        """Return red, green, blue and coverage of `tile`, None if nothing is shown there.

        Its sides are multiples of 16.
        """
        window = tile.grown(REACH_PX)
        numbers, index = self._owners_in(window)
        inner = (slice(REACH_PX, -REACH_PX), slice(REACH_PX, -REACH_PX))
        is_seen = index[inner] != NO_PHOTO
        if not np.any(is_seen):
            return None
        masks = {number: index == number for number in numbers}
        masks = {number: mask for number, mask in masks.items() if np.any(mask)}
        if len(masks) == 1:
            colours = self._drawn(self.names[next(iter(masks))], tile)
        else:
            colours = self._blended(window, masks)[inner]
        rgba: Rgba = cv2.cvtColor(np.ascontiguousarray(colours), cv2.COLOR_BGR2RGBA)
        if not np.all(is_seen):
            rgba[~is_seen] = 0
        return rgba

    def _blended(self, window: Window, masks: dict[int, Mask]) -> NDArray[np.uint8]:
        """Return photographs over `window`, each where its mask is: who owns most lies below."""
        most = max(masks, key=lambda number: int(masks[number].sum()))
        parts = []
        for number, mask in masks.items():
            if number == most:
                continue
            place = reach(mask)
            at = window.part(*place)
            picture = self._drawn(self.names[number], at)
            parts.append(Part(place=place, picture=picture, mask=mask))
        return blended(self._drawn(self.names[most], window), masks[most], parts)

    def owner_index(self, window: Window) -> NDArray[np.int32]:
        """Return the index in `names` of who is shown at each pixel of `window`, -1 for none."""
        return self._owners_in(window)[1]

    def gray_patch(self, name: str, window: Window) -> NDArray[np.float32]:
        """Return one photograph alone over `window`, in grey."""
        picture = cv2.cvtColor(self._drawn(name, window), cv2.COLOR_BGR2GRAY)
        return picture.astype(np.float32)

    def _drawn(self, name: str, window: Window) -> NDArray[np.uint8]:
        placed = self._placed_photos[name]
        seen = placed.pixel_map(self.grid, window)
        picture = drawn(self._pixels.colour(name), seen, cv2.INTER_LINEAR)
        fall_off = self._fall_offs[name]
        if fall_off is not None:
            picture = fall_off.undone(picture, seen.squares(placed.photo.camera))
        gain = self.gains[name]
        if max(abs(factor - 1.0) for factor in gain) < 1e-3:
            return picture
        return cv2.LUT(picture, _table(gain))

    def _owners_in(self, window: Window) -> tuple[list[int], NDArray[np.int32]]:
        """Return who is shown in `window`, and by which pixel, borders smoothed."""
        step = self._step
        row, column = window.row // step - 1, window.column // step - 1
        coarse = Window(
            row, column,
            (window.row + window.height) // step + 2 - row,
            (window.column + window.width) // step + 2 - column,
        )  # fmt: skip
        labels = np.full((coarse.height, coarse.width), NO_PHOTO, np.int32)
        shared = coarse.cut(self.owner_window)
        if not shared.is_empty:
            labels[shared.within(coarse)] = self.owners[shared.within(self.owner_window)]
        present = np.unique(labels).tolist()
        numbers = [number for number in present if number != NO_PHOTO]
        if len(present) == 1:
            full = np.full((window.height, window.width), present[0], np.int32)
            return numbers, full
        return numbers, self._smooth(labels, present, coarse, window)

    def _smooth(
        self, labels: NDArray[np.int32], present: list[int], coarse: Window, window: Window
    ) -> NDArray[np.int32]:
        """Return the label that is nearest at each pixel of `window`."""
        step = self._step
        offset = np.array([window.column, window.row]) / step + (0.5 / step - 0.5)
        offset -= [coarse.column, coarse.row]
        best = np.zeros((window.height, window.width), np.float32)
        index = np.full((window.height, window.width), NO_PHOTO, np.int32)
        for number in present:
            is_here = labels == number
            place, low = _spread_to(is_here, offset, step, window)
            size = (place[1].stop - place[1].start, place[0].stop - place[0].start)
            if min(size) <= 0:
                continue
            x, y = offset + low / step
            matrix = np.array([[1.0 / step, 0.0, x], [0.0, 1.0 / step, y]])
            share = cv2.warpAffine(
                is_here.astype(np.float32), matrix, size,
                flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP, borderMode=cv2.BORDER_REPLICATE,
            )  # fmt: skip
            is_more = share > best[place]
            index[place][is_more] = number
            np.maximum(best[place], share, out=best[place])
        return index

    def _coarse_views(self, edge_share: float) -> dict[str, CoarseView]:
        return {
            name: coarse_view(
                self._placed_photos[name], self._pixels.colour(name), self.coarse, edge_share
            )
            for name in self.names
        }


def _about(windows: Collection[Window]) -> Window:
    """Return the smallest window about all."""
    row, column = min(w.row for w in windows), min(w.column for w in windows)
    height = max(w.row + w.height for w in windows) - row
    width = max(w.column + w.width for w in windows) - column
    return Window(row, column, height, width)


def _spread_to(
    is_here: BoolArray, offset: FloatArray, step: int, window: Window
) -> tuple[tuple[slice, slice], FloatArray]:
    """Return where in `window` coarse pixels have any share, and its first column and row."""
    slices, lows = [], []
    for axis, size in ((0, window.width), (1, window.height)):
        coarse = np.flatnonzero(is_here.any(axis=axis))
        low = math.floor((coarse[0] - 1 - offset[axis]) * step)
        high = math.ceil((coarse[-1] + 1 - offset[axis]) * step) + 1
        slices.append(slice(min(max(low, 0), size), max(min(high, size), 0)))
        lows.append(float(slices[-1].start))
    return (slices[1], slices[0]), np.array(lows)


def _evened(view: CoarseView, gain: tuple[float, float, float]) -> CoarseView:
    return replace(view, colours=cv2.LUT(view.colours, _table(gain)))


def _flattened(view: CoarseView, fall_off: FallOff | None) -> CoarseView:
    if fall_off is None:
        return view
    return replace(view, colours=fall_off.undone(view.colours, view.squares))


def _table(gain: tuple[float, float, float]) -> NDArray[np.uint8]:
    """Return what becomes of each level of blue, green and red, shape (256, 1, 3)."""
    levels = np.arange(256.0)[:, np.newaxis, np.newaxis] * np.array(gain)
    table: NDArray[np.uint8] = np.clip(np.rint(levels), 0, 255).astype(np.uint8)
    return table
