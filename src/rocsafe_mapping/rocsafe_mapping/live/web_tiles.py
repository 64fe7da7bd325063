# SPDX-License-Identifier: Apache-2.0
"""The map as tiles for web maps (XYZ), kept up to date on disk.

``<directory>/<zoom>/<x>/<y>.png``: Web Mercator, 256 pixels wide, y counted from the north. Each
file is replaced as a whole, so that a reader never sees half of one.
"""

import math
from collections import OrderedDict
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.drawing.coarse_view import NO_PHOTO
from rocsafe_mapping.drawing.grid import (
    FINEST_ZOOM,
    TILE_PX,
    WEB_MERCATOR_EPSG,
    WORLD_M,
    MapGrid,
    Window,
)
from rocsafe_mapping.drawing.placed_photo import LATTICE_PX, PlacedPhoto, drawn, scores
from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.mosaic.mapmaker import Mapmaker

COARSER_ZOOMS = 6
PNG_COMPRESSION = 2
OPAQUE = 255
# Halved tiles that are kept, 64 KiB each: the coarser tile above them is joined soon after.
MOST_HALVES = 256
Place = tuple[int, int, int]


class WebTiles:
    """Tiles of a growing map.

    Parameters
    ----------
    maker
        Of the map.
    directory
        Of the tiles.
    resolution_m
        Side of a pixel that the finest tiles must at least have; 0: the photographs'.
    """

    def __init__(self, maker: Mapmaker, directory: Path, resolution_m: float) -> None:
        self._maker = maker
        self._directory = directory
        self._resolution_m = resolution_m
        self._zoom = 0
        self._placed_photos: dict[str, PlacedPhoto] = {}
        self._at: dict[Place, set[str]] = {}
        # Dicts keep the order in which tiles went out of date; those to be drawn go by zoom.
        self._stale: dict[Place, None] = {}
        self._dirty: dict[int, dict[Place, None]] = {}
        self._halves: OrderedDict[Place, NDArray[np.uint8]] = OrderedDict()

    def move(self, placed: PlacedPhoto, before_m: FloatArray | None) -> None:
        """Note that a photograph lies here now; `before_m` are its corners as last drawn."""
        name = placed.photo.name
        if before_m is not None:
            for place in self._places(before_m):
                self._at[place].discard(name)
                self._stale[place] = None
        self._placed_photos[name] = placed
        for place in self._places(placed.corners_m):
            self._at.setdefault(place, set()).add(name)
            self._stale[place] = None

    @property
    def is_stale(self) -> bool:
        """Whether tiles are out of date that are not released."""
        return bool(self._stale)

    def release(self) -> None:
        """Let `draw_next` draw all tiles that are out of date now.

        A tile changes with each photograph on it; in rounds, it is drawn once for several changes.
        """
        for place in self._stale:
            self._mark(place)
        self._stale.clear()

    def draw_next(self) -> bool:
        """Draw one tile that was released; return whether there was one."""
        zooms = [zoom for zoom, places in self._dirty.items() if places]
        if not zooms:
            return False
        # Finest first: a coarser tile is drawn once, from finished finer tiles.
        place = next(iter(self._dirty[max(zooms)]))
        del self._dirty[max(zooms)][place]
        picture = self._drawn(place) if place[0] == self._zoom else self._joined(place)
        self._write(place, picture)
        self._keep_half(place, picture)
        if place[0] > max(self._zoom - COARSER_ZOOMS, 0):
            self._mark((place[0] - 1, place[1] // 2, place[2] // 2))
        return True

    def path_of(self, place: Place) -> Path:
        """Return the file of a tile (zoom, x, y)."""
        zoom, x, y = place
        return self._directory / str(zoom) / str(x) / f'{y}.png'

    def _mark(self, place: Place) -> None:
        self._dirty.setdefault(place[0], {})[place] = None

    def _grid(self) -> MapGrid:
        frame = self._maker.frame
        if frame is None:
            raise MappingError('no photograph is placed yet')
        if self._zoom == 0:
            latitude = math.radians(frame.frame.origin.latitude_deg)
            wanted_m = self._resolution_m or self._maker.finest_resolution_m
            zoom = math.log2(2.0 * WORLD_M * math.cos(latitude) / TILE_PX / wanted_m)
            self._zoom = min(max(round(zoom), 1), FINEST_ZOOM)
        resolution_m = 2.0 * WORLD_M / TILE_PX / 2**self._zoom
        return MapGrid(epsg=WEB_MERCATOR_EPSG, resolution_m=resolution_m, frame=frame)

    def _places(self, corners_m: FloatArray) -> list[Place]:
        window = self._grid().window_of(corners_m)
        half = 2 ** (self._zoom - 1)
        return [
            (self._zoom, tile.column // TILE_PX + half, tile.row // TILE_PX + half)
            for tile in window.tiles(TILE_PX)
        ]

    def _drawn(self, place: Place) -> NDArray[np.uint8]:
        """Return the tile's pixels: each from the photograph that shows it best."""
        half = 2 ** (self._zoom - 1)
        window = Window((place[2] - half) * TILE_PX, (place[1] - half) * TILE_PX, TILE_PX, TILE_PX)
        grid = self._grid()
        best = np.zeros((TILE_PX, TILE_PX), np.float32)
        owner = np.full((TILE_PX, TILE_PX), NO_PHOTO, np.int32)
        views = []
        edge_share = self._maker.options.drawing.views.edge_share
        for number, name in enumerate(sorted(self._at.get(place, ()))):
            placed = self._placed_photos[name]
            at = grid.window_of(placed.corners_m).cut(window).widened(LATTICE_PX)
            seen, part = placed.pixel_map(grid, at), at.within(window)
            found = scores(placed.photo.camera, seen, edge_share)
            owner[part][found > best[part]] = number
            np.maximum(best[part], found, out=best[part])
            views.append((name, seen, part))
        bgr = np.zeros((TILE_PX, TILE_PX, 3), np.uint8)
        for number in np.unique(owner[owner != NO_PHOTO]).tolist():
            name, seen, part = views[number]
            picture = drawn(self._maker.pixels.colour(name), seen, cv2.INTER_LINEAR)
            cv2.copyTo(picture, (owner[part] == number).view(np.uint8), bgr[part])
        alpha = np.where(owner != NO_PHOTO, OPAQUE, 0).astype(np.uint8)
        return np.dstack([bgr, alpha])

    def _joined(self, place: Place) -> NDArray[np.uint8]:
        """Return the four finer tiles, halved."""
        zoom, x, y = place
        whole = np.zeros((TILE_PX, TILE_PX, 4), np.uint8)
        half = TILE_PX // 2
        for down in (0, 1):
            for right in (0, 1):
                tile = self._half((zoom + 1, 2 * x + right, 2 * y + down))
                if tile is not None:
                    rows = slice(down * half, (down + 1) * half)
                    whole[rows, right * half : (right + 1) * half] = tile
        return whole

    def _half(self, place: Place) -> NDArray[np.uint8] | None:
        """Return a tile at half its size, None if there is none."""
        if place in self._halves:
            return self._halves[place]
        path = self.path_of(place)
        tile = cv2.imread(str(path), cv2.IMREAD_UNCHANGED) if path.exists() else None
        if tile is None or tile.shape != (TILE_PX, TILE_PX, 4):
            return None
        return _halved(tile)

    def _keep_half(self, place: Place, picture: NDArray[np.uint8]) -> None:
        self._halves.pop(place, None)
        self._halves[place] = _halved(picture)
        if len(self._halves) > MOST_HALVES:
            self._halves.popitem(last=False)

    def _write(self, place: Place, picture: NDArray[np.uint8]) -> None:
        path = self.path_of(place)
        _, png = cv2.imencode('.png', picture, [cv2.IMWRITE_PNG_COMPRESSION, PNG_COMPRESSION])
        part = path.with_suffix('.part')
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            part.write_bytes(bytes(png))
            part.replace(path)
        except OSError as error:
            raise MappingError(f'cannot write tile {path}: {error}') from error


def _halved(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    half = (TILE_PX // 2, TILE_PX // 2)
    small: NDArray[np.uint8] = cv2.resize(picture, half, interpolation=cv2.INTER_AREA)
    return small
