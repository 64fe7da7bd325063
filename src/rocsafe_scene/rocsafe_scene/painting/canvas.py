# SPDX-License-Identifier: Apache-2.0
"""A part of the ground while it is painted: anti-aliased marks over turf, with grain."""

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import ImageArray
from rocsafe_scene.painting.marks import Bounds, Dots, Layer, Points, Shape
from rocsafe_scene.painting.noise import CM_PER_M, Field, Window

# Fixed-point bits of OpenCV's drawing coordinates.
_SHIFT = 6
# Marks smaller than this share of a texel are left out.
_SMALLEST_TEXELS = 0.4
# Relative change of brightness at full grain.
_STRONGEST_GRAIN = 0.52
# Matrix from painted blue, green, red to the colours that the engine lights.
_NATURAL = np.array([[0.82, 0.16, 0.02], [0.03, 0.82, 0.13], [0.02, 0.26, 0.74]])


class Canvas:
    """Colours (blue, green, red) and grain of a window of texels; row 0 lies in the south."""

    def __init__(self, window: Window, octave: int, turf: ImageArray) -> None:
        """Begin with `turf`, shape (rows, columns, 4), whose texels are 2^octave cm wide."""
        self._window = window
        self._texel_m = 2.0**octave / CM_PER_M
        self._layers = turf

    def paint(self, layer: Layer) -> None:
        """Paint the marks of `layer` in their order."""
        for mark, bounds in layer.within(*self._bounds()):
            if self._is_tiny(bounds):
                continue
            if isinstance(mark, Dots):
                self._dot(self._layers, mark)
            elif mark.paint.opacity >= 1.0:
                value = (*mark.paint.colour[::-1], mark.paint.grain)
                self._fill(self._layers, mark, value)
            else:
                self._glaze(mark, bounds)

    def finished(self, detail: Field, pad: int) -> ImageArray:
        """Return the picture without its `pad`: colours times (1 + grain times `detail`)."""
        rows, columns = (pad + size for size in detail.shape)
        blue, green, red, grain = cv2.split(self._layers[pad:rows, pad:columns])
        swing = cv2.multiply(
            grain, detail, scale=128.0 * _STRONGEST_GRAIN / 255.0, dtype=cv2.CV_32F
        )
        factor = cv2.add(swing, 128.0, dtype=cv2.CV_8U)
        return cv2.merge(
            [cv2.multiply(part, factor, scale=1.0 / 128.0) for part in (blue, green, red)]
        )

    def _bounds(self) -> tuple[float, float, float, float]:
        w, t = self._window, self._texel_m
        return w.x0 * t, w.y0 * t, w.x1 * t, w.y1 * t

    def _is_tiny(self, bounds: Bounds) -> bool:
        west, south, east, north = bounds
        return max(east - west, north - south) < _SMALLEST_TEXELS * self._texel_m

    def _fill(
        self,
        target: ImageArray,
        shape: Shape,
        value: tuple[int, ...],
        corner: tuple[int, int] = (0, 0),
    ) -> None:
        """Fill `shape` in `target`, whose first texel is `corner` of the window."""
        fixed = [self._fixed(outline, corner) for outline in shape.outlines]
        cv2.fillPoly(target, fixed, value, cv2.LINE_AA, _SHIFT)

    def _dot(self, target: ImageArray, dots: Dots) -> None:
        """Draw those of `dots` that meet the window."""
        west, south, east, north = self._bounds()
        x, y = dots.centres.T
        r = dots.radii_m
        inside = (x + r >= west) & (x - r <= east) & (y + r >= south) & (y - r <= north)
        centres = self._fixed(dots.centres[inside], (0, 0)).tolist()
        radii = np.round(r[inside] / self._texel_m * (1 << _SHIFT)).astype(int).tolist()
        values = np.broadcast_to(dots.values, (len(r), dots.values.shape[1]))[inside]
        if values.shape[1] == 4:
            values = values[:, [2, 1, 0, 3]]
        for centre, radius, value in zip(centres, radii, values.tolist(), strict=True):
            cv2.circle(target, centre, radius, value, -1, cv2.LINE_AA, _SHIFT)

    def _fixed(self, points: Points, corner: tuple[int, int]) -> NDArray[np.int32]:
        origin = np.array([self._window.x0 + corner[0] + 0.5, self._window.y0 + corner[1] + 0.5])
        return np.round((points / self._texel_m - origin) * (1 << _SHIFT)).astype(np.int32)

    def _glaze(self, shape: Shape, bounds: Bounds) -> None:
        """Blend a translucent shape into the part of the canvas that it covers."""
        rows, columns = self._part(bounds)
        mask = np.zeros((rows.stop - rows.start, columns.stop - columns.start), np.uint8)
        corner = (columns.start, rows.start)
        if shape.is_faded:
            for step, outline in enumerate(shape.outlines, start=1):
                ring = Shape((outline,), shape.paint)
                self._fill(mask, ring, (255 * step // len(shape.outlines),), corner)
        else:
            self._fill(mask, shape, (255,), corner)
        paint = shape.paint
        self._blend(
            self._softened(mask, paint.softness_m),
            paint.opacity,
            (*paint.colour[::-1], paint.grain),
            (rows, columns),
            is_crisp=not (shape.is_faded or paint.softness_m),
        )

    def _blend(
        self,
        mask: ImageArray,
        opacity: float,
        value: tuple[int, ...],
        part: tuple[slice, slice] = (slice(None), slice(None)),
        *,
        is_crisp: bool = False,
    ) -> None:
        """Move a part of the canvas towards `value`; `mask` and `opacity` say how far.

        A crisp mask is used without its grey edge, which is several times as fast.
        """
        x, y, width, height = cv2.boundingRect(mask)
        if not width:
            return
        mask = np.ascontiguousarray(mask[y : y + height, x : x + width])
        y, x = y + (part[0].start or 0), x + (part[1].start or 0)
        part = (slice(y, y + height), slice(x, x + width))
        below = np.ascontiguousarray(self._layers[part])
        above = np.full(below.shape[:2], np.array(value, np.uint8).view(np.uint32)[0])
        above = above.view(np.uint8).reshape(below.shape)
        if is_crisp:
            _, crisp = cv2.threshold(mask, 127, 255, cv2.THRESH_BINARY)
            mixed = cv2.addWeighted(below, 1.0 - opacity, above, opacity, 0.0)
            self._layers[part] = cv2.copyTo(mixed, crisp, below)
        else:
            share = cv2.multiply(mask, opacity / 255.0, dtype=cv2.CV_32F)
            self._layers[part] = cv2.blendLinear(below, above, 1.0 - share, share)

    def _part(self, bounds: Bounds) -> tuple[slice, slice]:
        """Return rows and columns of the window that a mark within `bounds` may touch."""
        west, south, east, north = (int(edge / self._texel_m) for edge in bounds)
        w = self._window
        height, width = w.shape
        rows = slice(max(0, south - w.y0 - 2), min(height, north - w.y0 + 3))
        return rows, slice(max(0, west - w.x0 - 2), min(width, east - w.x0 + 3))

    def _softened(self, mask: ImageArray, softness_m: float) -> ImageArray:
        size = 2 * int(0.5 * softness_m / self._texel_m) + 1
        return cv2.blur(mask, (size, size)) if size > 1 else mask


def natural(painted: ImageArray) -> ImageArray:
    """Return painted colours less saturated and warmer, as the engine lights them."""
    return np.asarray(cv2.transform(painted, _NATURAL))
