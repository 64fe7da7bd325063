# SPDX-License-Identifier: Apache-2.0
"""A ground that is computed from a seed, tile by tile, when a camera first looks there."""

import math
from collections import OrderedDict

import numpy as np

from rocsafe_scene.ground.picture import (
    GroundBounds,
    Patch,
    require_patch_size,
    south_up_homography,
)
from rocsafe_scene.scenery.canvas import Canvas, Image
from rocsafe_scene.scenery.noise import CM_PER_M, Window
from rocsafe_scene.scenery.scene import Scene
from rocsafe_scene.scenery.turf import detail, turf

TILE_PX = 512
# Painted beyond the tile, so that soft edges fit those of its neighbours.
PAD_M = 0.32
FINEST_OCTAVE = 0
COARSEST_OCTAVE = 9
DEFAULT_CACHE_BYTES = 160_000_000
_SHADOW_SOFTNESS_M = 0.18

TileKey = tuple[int, int, int]


class ProceduralGround:
    """World-unique turf with a painted scene on it, in tiles of texels of 2^k cm.

    Parameters
    ----------
    seed : of the turf.
    scene : painted on it.
    cache_bytes : tiles beyond this are forgotten, those longest unused first.
    """

    def __init__(self, seed: int, scene: Scene, cache_bytes: int = DEFAULT_CACHE_BYTES) -> None:
        self._seed = seed
        self._scene = scene
        self._cache_bytes = cache_bytes
        self._tiles: OrderedDict[TileKey, Image] = OrderedDict()
        self._held_bytes = 0

    @property
    def held_bytes(self) -> int:
        """Size of the tiles held at present."""
        return self._held_bytes

    def patch(self, bounds: GroundBounds, resolution_m: float) -> Patch:
        """Return a picture of all of `bounds` with texels of at most `resolution_m`.

        Raises
        ------
        GroundError: if it would be larger than any camera needs.
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

    def _tile(self, key: TileKey) -> Image:
        tile = self._tiles.get(key)
        if tile is None:
            tile = paint_tile(self._seed, self._scene, key)
            self._keep(key, tile)
        self._tiles.move_to_end(key)
        return tile

    def _keep(self, key: TileKey, tile: Image) -> None:
        self._tiles[key] = tile
        self._held_bytes += tile.nbytes
        while self._held_bytes > self._cache_bytes and len(self._tiles) > 1:
            _, forgotten = self._tiles.popitem(last=False)
            self._held_bytes -= forgotten.nbytes


def paint_tile(seed: int, scene: Scene, key: TileKey) -> Image:
    """Return the tile (octave, column, row): blue, green, red; row 0 in the south."""
    octave, column, row = key
    inner = Window(column * TILE_PX, row * TILE_PX, (column + 1) * TILE_PX, (row + 1) * TILE_PX)
    pad = max(4, round(PAD_M * CM_PER_M / 2.0**octave))
    window = inner.grown(pad)
    canvas = Canvas(window, octave, turf(seed, octave, window))
    canvas.paint(scene.ground)
    canvas.cast(scene.shadows, _SHADOW_SOFTNESS_M)
    canvas.paint(scene.bodies)
    return canvas.finished(detail(seed, octave, inner), pad)


def _octave(resolution_m: float) -> int:
    """Return the coarsest octave whose texels are not larger than `resolution_m`."""
    octave = math.floor(math.log2(resolution_m * CM_PER_M))
    return min(max(octave, FINEST_OCTAVE), COARSEST_OCTAVE)
