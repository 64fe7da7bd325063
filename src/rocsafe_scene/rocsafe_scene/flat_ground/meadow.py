# SPDX-License-Identifier: Apache-2.0
"""Meadow without limits, painted tile by tile when a camera first sees a tile."""

import math
from collections import OrderedDict

import cv2
import numpy as np

from rocsafe_geo.arrays import ImageArray
from rocsafe_scene.ground.ground_patch import (
    GroundBounds,
    Patch,
    require_patch_size,
    south_up_homography,
)
from rocsafe_scene.painting.canvas import Canvas, natural
from rocsafe_scene.painting.noise import CM_PER_M, Window
from rocsafe_scene.painting.turf import detail, turf
from rocsafe_scene.scene.sunlight import DEFAULT_TIME, Lighting, lighting, sun_direction

TILE_PX = 512
FINEST_OCTAVE, COARSEST_OCTAVE = 0, 9
CACHE_BYTES = 160_000_000
# Latitude and longitude, degrees, at which the sun stands above the meadow at `DEFAULT_TIME`.
_PLACE_DEG = (53.28, -9.06)

TileKey = tuple[int, int, int]


class Meadow:
    """Grass that nowhere repeats itself, in tiles of texels of 2^k cm.

    Parameters
    ----------
    seed
        Of the grass.
    cache_bytes
        Limit of the tiles that are kept; those that were not used for longest are dropped.
    """

    def __init__(self, seed: int, cache_bytes: int = CACHE_BYTES) -> None:
        self._seed = seed
        self._cache_bytes = cache_bytes
        self._tiles: OrderedDict[TileKey, ImageArray] = OrderedDict()
        self._held_bytes = 0
        latitude, longitude = _PLACE_DEG
        direction = sun_direction(DEFAULT_TIME, latitude, longitude)
        self._tones = tone_table(lighting(direction, 'clear'))

    @property
    def held_bytes(self) -> int:
        """Size of the tiles held at present, bytes."""
        return self._held_bytes

    def patch(self, bounds: GroundBounds, resolution_m: float) -> Patch:
        """Return a picture of all of `bounds` with texels of at most `resolution_m`.

        Raises
        ------
        GroundError
            If it would be larger than any camera needs.
        """
        octave = _octave(resolution_m)
        texel_m = 2.0**octave / CM_PER_M
        span_m = TILE_PX * texel_m
        x0, x1 = math.floor(bounds.west_m / span_m), math.floor(bounds.east_m / span_m) + 1
        y0, y1 = math.floor(bounds.south_m / span_m), math.floor(bounds.north_m / span_m) + 1
        require_patch_size((x1 - x0) * TILE_PX, (y1 - y0) * TILE_PX)
        rows = [
            np.hstack([self._tile((octave, x, y)) for x in range(x0, x1)]) for y in range(y0, y1)
        ]
        homography = south_up_homography(x0 * span_m, y0 * span_m, texel_m)
        return Patch(np.vstack(rows), homography)

    def _tile(self, key: TileKey) -> ImageArray:
        tile = self._tiles.get(key)
        if tile is None:
            tile = cv2.LUT(paint_tile(self._seed, key), self._tones)
            self._keep(key, tile)
        self._tiles.move_to_end(key)
        return tile

    def _keep(self, key: TileKey, tile: ImageArray) -> None:
        self._tiles[key] = tile
        self._held_bytes += tile.nbytes
        while self._held_bytes > self._cache_bytes and len(self._tiles) > 1:
            _, dropped = self._tiles.popitem(last=False)
            self._held_bytes -= dropped.nbytes


def paint_tile(seed: int, key: TileKey) -> ImageArray:
    """Return the tile (octave, column, row) before it is lit: blue, green, red; row 0 south."""
    octave, column, row = key
    window = Window(column * TILE_PX, row * TILE_PX, (column + 1) * TILE_PX, (row + 1) * TILE_PX)
    canvas = Canvas(window, octave, turf(seed, octave, window))
    return natural(canvas.finished(detail(seed, octave, window), 0))


def tone_table(light: Lighting) -> ImageArray:
    """Return what level ground of each painted brightness looks like in the engine.

    These are the formulas of ``engine/light.glsl`` for an open place without haze.

    Returns
    -------
    (1, 256, 3)
        A look-up table for blue, green, red.
    """
    sky = 1.15 * (0.45 * np.array(light.horizon) + 0.55 * np.array(light.zenith))
    arriving = np.array(light.sun) * light.sun_direction[2] + sky
    painted = np.linspace(0.0, 1.0, 256)[:, None]
    seen = 0.5 * light.exposure * painted**2 * arriving
    seen = seen * (2.51 * seen + 0.03) / (seen * (2.43 * seen + 0.59) + 0.14)
    tones = np.rint(255.0 * np.sqrt(np.clip(seen, 0.0, 1.0)))
    return np.ascontiguousarray(tones[None, :, ::-1].astype(np.uint8))


def _octave(resolution_m: float) -> int:
    """Return the coarsest octave whose texels are not larger than `resolution_m`."""
    octave = math.floor(math.log2(resolution_m * CM_PER_M))
    return min(max(octave, FINEST_OCTAVE), COARSEST_OCTAVE)
