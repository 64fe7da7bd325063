# SPDX-License-Identifier: Apache-2.0
"""Maps of the ground's colours and classes, painted tile by tile."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import cv2
import numpy as np

from rocsafe_geo.arrays import ImageArray
from rocsafe_scene.ground.ground_kinds import GroundWork
from rocsafe_scene.ground.terrain import INNER_HALF_M, OUTER_HALF_M
from rocsafe_scene.mesh.classes import class_number
from rocsafe_scene.mesh.mesh import Floats
from rocsafe_scene.painting.canvas import Canvas, natural
from rocsafe_scene.painting.marks import Layer
from rocsafe_scene.painting.noise import CM_PER_M, Window
from rocsafe_scene.painting.turf import detail, turf

# Texels are 2^k cm wide: 4 cm where vehicles fly, 32 cm around; labels 16 cm and 64 cm.
INNER_OCTAVE, OUTER_OCTAVE = 2, 5
_LABEL_STEP = 2
_TILE_PX = 512
_PAD_PX = 8
_WORKERS = 2


@dataclass(frozen=True, slots=True, eq=False)
class GroundMap:
    """Colours and classes of the ground in square texels; row 0 lies in the south.

    Attributes
    ----------
    west_m, south_m
        South-west corner of the map, metres.
    texel_m
        Width of a texel of `colours`, metres.
    colours : (rows, columns, 3)
        Blue, green, red.
    classes : (rows / 4, columns / 4)
        Class numbers.
    """

    west_m: float
    south_m: float
    texel_m: float
    colours: ImageArray
    classes: ImageArray

    @property
    def size_m(self) -> tuple[float, float]:
        """Width and height, metres."""
        rows, columns = self.colours.shape[:2]
        return columns * self.texel_m, rows * self.texel_m

    def classes_at(self, places: Floats) -> ImageArray:
        """Return the class numbers at `places` (n, 2), clamped to the map."""
        texel = self.texel_m * 2**_LABEL_STEP
        rows, columns = self.classes.shape
        column = np.clip(((places[:, 0] - self.west_m) / texel).astype(int), 0, columns - 1)
        row = np.clip(((places[:, 1] - self.south_m) / texel).astype(int), 0, rows - 1)
        return np.asarray(self.classes[row, column])


def inner_map(works: Sequence[GroundWork], seed: int) -> GroundMap:
    """Return the map of the detailed ground."""
    return painted_map(works, seed, INNER_OCTAVE, INNER_HALF_M)


def outer_map(works: Sequence[GroundWork], seed: int) -> GroundMap:
    """Return the map of the ground around."""
    return painted_map(works, seed, OUTER_OCTAVE, OUTER_HALF_M)


def painted_map(
    works: Sequence[GroundWork], seed: int, octave: int, half_m: tuple[float, float]
) -> GroundMap:
    """Return a map about the origin. Half extents must be whole numbers of label texels."""
    texel = 2.0**octave / CM_PER_M
    columns, rows = (round(2.0 * half / texel) for half in half_m)
    layer = Layer(mark for work in works for mark in work.marks)
    colours = np.empty((rows, columns, 3), np.uint8)
    x0, y0 = round(-half_m[0] / texel), round(-half_m[1] / texel)

    def paint(corner: tuple[int, int]) -> None:
        row, column = corner
        high, wide = min(_TILE_PX, rows - row), min(_TILE_PX, columns - column)
        inner = Window(x0 + column, y0 + row, x0 + column + wide, y0 + row + high)
        colours[row : row + high, column : column + wide] = _tile(layer, seed, octave, inner)

    corners = [(r, c) for r in range(0, rows, _TILE_PX) for c in range(0, columns, _TILE_PX)]
    with ThreadPoolExecutor(_WORKERS) as pool:
        list(pool.map(paint, corners))
    classes = _classes(works, (rows, columns), texel, half_m)
    return GroundMap(-half_m[0], -half_m[1], texel, colours, classes)


def _tile(layer: Layer, seed: int, octave: int, inner: Window) -> ImageArray:
    window = inner.grown(_PAD_PX)
    canvas = Canvas(window, octave, turf(seed, octave, window))
    canvas.paint(layer)
    painted = canvas.finished(detail(seed, octave, inner), _PAD_PX)
    return natural(painted)


def _classes(
    works: Sequence[GroundWork], shape: tuple[int, int], texel: float, half_m: tuple[float, float]
) -> ImageArray:
    """Return the class numbers of label texels; later entries cover earlier ones."""
    step = 2**_LABEL_STEP
    found = np.full((shape[0] // step, shape[1] // step), class_number('grass'), np.uint8)
    for work in works:
        for stencil in work.stencils:
            number = class_number(stencil.label)
            for outline in stencil.outlines:
                pixels = (outline + np.array(half_m)) / (texel * step) - 0.5
                cv2.fillPoly(found, [np.round(pixels * 16).astype(np.int32)], number, shift=4)
    return found
