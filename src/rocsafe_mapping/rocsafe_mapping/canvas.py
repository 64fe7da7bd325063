# SPDX-License-Identifier: Apache-2.0
"""A map of pixels that grows as photographs are laid onto it.

Of all photographs that show a pixel the canvas keeps the two that show it best. The best one is
seen; where the second is nearly as good, which is along seams, the two are mixed. What the canvas
shows so depends on the photographs alone, not on the order in which they came.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

TILE_PX = 256
# Difference of scores over which a seam is mixed. The score of the ground falls by 0.02 a metre
# halfway between two nadir photographs from 32 m, 25 m apart: seams are about 1 m wide.
SEAM_SCORE = 0.02
OPAQUE = 255
WHOLE = (slice(None), slice(None))
Colours = NDArray[np.uint32]
Scores = NDArray[np.float32]
Rgba = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Window:
    """Rows and columns of the map's grid; rows count southwards, columns eastwards."""

    row: int
    column: int
    height: int
    width: int

    def cut(self, other: 'Window') -> 'Window':
        """Return what this window and `other`, which meet, have in common."""
        row, column = max(self.row, other.row), max(self.column, other.column)
        return Window(
            row,
            column,
            min(self.row + self.height, other.row + other.height) - row,
            min(self.column + self.width, other.column + other.width) - column,
        )

    def within(self, other: 'Window') -> tuple[slice, slice]:
        """Return the slices of an array over `other` that hold this window."""
        row, column = self.row - other.row, self.column - other.column
        return slice(row, row + self.height), slice(column, column + self.width)

    def tiles(self) -> Iterator['Window']:
        """Return the tiles of the grid that this window meets."""
        for row in range(self.row // TILE_PX, -(-(self.row + self.height) // TILE_PX)):
            for column in range(self.column // TILE_PX, -(-(self.column + self.width) // TILE_PX)):
                yield Window(row * TILE_PX, column * TILE_PX, TILE_PX, TILE_PX)


@dataclass(slots=True)
class _Tile:
    """The two best colours of each pixel with their scores; a score of 0 means none."""

    best: Colours = field(default_factory=lambda: np.zeros((TILE_PX, TILE_PX), np.uint32))
    second: Colours = field(default_factory=lambda: np.zeros((TILE_PX, TILE_PX), np.uint32))
    best_score: Scores = field(default_factory=lambda: np.zeros((TILE_PX, TILE_PX), np.float32))
    second_score: Scores = field(default_factory=lambda: np.zeros((TILE_PX, TILE_PX), np.float32))
    thumbnail: Rgba | None = None

    def lay(self, part: tuple[slice, slice], colours: Colours, scores: Scores) -> None:
        """Lay a piece of a photograph onto `part` of the tile."""
        best, second = self.best[part], self.second[part]
        best_score, second_score = self.best_score[part], self.second_score[part]
        wins = scores > best_score
        is_second = (scores > second_score) & ~wins
        np.copyto(second, best, where=wins)
        np.copyto(second_score, best_score, where=wins)
        np.copyto(best, colours, where=wins)
        np.copyto(best_score, scores, where=wins)
        np.copyto(second, colours, where=is_second)
        np.copyto(second_score, scores, where=is_second)
        self.thumbnail = None

    def seen(self, part: tuple[slice, slice] = WHOLE) -> Rgba:
        """Return what `part` shows: red, green, blue, and 0 or 255 for its coverage."""
        best, score = self.best[part].copy(), self.best_score[part]
        rgba = best.view(np.uint8).reshape(*best.shape, 4)
        lead = score - self.second_score[part]
        seam = (self.second_score[part] > 0.0) & (lead < SEAM_SCORE)
        share = (0.5 - 0.5 * lead[seam] / SEAM_SCORE)[:, np.newaxis]
        first = rgba[seam].astype(np.float32)
        other = self.second[part][seam].view(np.uint8).reshape(-1, 4)
        rgba[seam] = np.rint(first + share * (other - first))
        rgba[..., 3] = np.where(score > 0.0, OPAQUE, 0)
        return rgba

    def seen_small(self, reduction: int) -> Rgba:
        """Return what the tile shows, each side divided by `reduction`, a power of two."""
        side = TILE_PX // reduction
        if self.thumbnail is None or self.thumbnail.shape[0] != side:
            self.thumbnail = _shrunk(self.seen(), side)
        return self.thumbnail


class Canvas:
    """The map's pixels, in tiles that exist only where a photograph lies."""

    def __init__(self) -> None:
        self._tiles: dict[tuple[int, int], _Tile] = {}

    def lay(self, window: Window, colours: Colours, scores: Scores) -> None:
        """Lay a photograph onto the map.

        Parameters
        ----------
        window: where it lies.
        colours: red, green, blue and a fourth byte packed into one number, shape of `window`.
        scores: how well each pixel is shown, 0 where it is not; at most 1, shape of `window`.
        """
        for place in window.tiles():
            shared = place.cut(window)
            part = shared.within(window)
            if np.any(scores[part]):
                tile = self._tiles.setdefault((place.row, place.column), _Tile())
                tile.lay(shared.within(place), colours[part], scores[part])

    def read(self, window: Window) -> Rgba:
        """Return what `window` shows, shape (height, width, 4), see `_Tile.seen`."""
        rgba = np.zeros((window.height, window.width, 4), np.uint8)
        for place in window.tiles():
            tile = self._tiles.get((place.row, place.column))
            if tile is not None:
                shared = place.cut(window)
                rgba[shared.within(window)] = tile.seen(shared.within(place))
        return rgba

    def read_small(self, window: Window, reduction: int) -> Rgba:
        """Return what `window` shows, each side divided by `reduction`.

        `reduction` is a power of two, at most the side of a tile; the edges of `window` are moved
        outwards to its multiples.
        """
        row, column = window.row // reduction, window.column // reduction
        small = Window(
            row,
            column,
            -(-(window.row + window.height) // reduction) - row,
            -(-(window.column + window.width) // reduction) - column,
        )
        side = TILE_PX // reduction
        rgba = np.zeros((small.height, small.width, 4), np.uint8)
        for place in window.tiles():
            tile = self._tiles.get((place.row, place.column))
            if tile is not None:
                place = Window(place.row // reduction, place.column // reduction, side, side)
                shared = place.cut(small)
                part = shared.within(place)
                rgba[shared.within(small)] = tile.seen_small(reduction)[part]
        return rgba


def _shrunk(rgba: Rgba, side: int) -> Rgba:
    """Return the average of the covered pixels, shape (side, side, 4)."""
    reduced: Rgba = cv2.resize(rgba, (side, side), interpolation=cv2.INTER_AREA)
    if reduced[..., 3].min() == OPAQUE:
        return reduced
    small = reduced.astype(np.float32)
    # Uncovered pixels are black: the average is too dark by the share that is covered.
    cover = small[..., 3:] / OPAQUE
    colours = np.divide(small[..., :3], cover, out=np.zeros_like(small[..., :3]), where=cover > 0)
    is_seen = cover >= 0.5
    rgb = np.where(is_seen, np.minimum(colours, OPAQUE), 0)
    shrunk: Rgba = np.dstack([rgb, np.where(is_seen, OPAQUE, 0)]).astype(np.uint8)
    return shrunk
