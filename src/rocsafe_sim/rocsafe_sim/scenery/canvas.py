# SPDX-License-Identifier: Apache-2.0
"""A piece of ground being painted: anti-aliased marks over turf, and the grain over all."""

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_sim.scenery.marks import Layer, Mark
from rocsafe_sim.scenery.noise import CM_PER_M, Field, Window

Image = NDArray[np.uint8]

# Fixed-point bits of OpenCV's drawing coordinates.
_SHIFT = 6
# Marks smaller than this part of a texel are not worth painting.
_SMALLEST_TEXELS = 0.4
_SHADOW_COLOUR_BGR = np.array([66, 48, 40], np.float32)
_SHADOW_OPACITY = 0.62
# Relative swing of brightness at full grain.
_STRONGEST_GRAIN = 0.6


class Canvas:
    """Colours (blue, green, red) and grain of a window of texels; row 0 lies in the south."""

    def __init__(self, window: Window, octave: int, turf: Image) -> None:
        """Begin with `turf`, shape (rows, columns, 4), whose texels are 2^octave cm wide."""
        self._window = window
        self._texel_m = 2.0**octave / CM_PER_M
        self._layers = turf

    def paint(self, layer: Layer) -> None:
        """Paint the marks of `layer` in their order."""
        for mark in layer.within(*self._bounds()):
            if self._is_tiny(mark):
                continue
            if mark.paint.opacity >= 1.0:
                self._fill(self._layers, mark, (*mark.paint.colour[::-1], mark.paint.grain))
            else:
                self._glaze(mark)

    def cast(self, layer: Layer, softness_m: float) -> None:
        """Darken the union of the marks of `layer`, with soft edges."""
        mask = np.zeros(self._window.shape, np.uint8)
        found = False
        for mark in layer.within(*self._bounds()):
            self._fill(mask, mark, (255,))
            found = True
        if not found:
            return
        soft = self._softened(mask, softness_m).astype(np.float32) * (_SHADOW_OPACITY / 255.0)
        colours = self._layers[..., :3]
        colours[...] = colours + (_SHADOW_COLOUR_BGR - colours) * soft[..., None]

    def finished(self, detail: Field, pad: int) -> Image:
        """Return the picture without its `pad`: colours times (1 + grain times `detail`)."""
        blue, green, red, grain = cv2.split(self._layers[pad:-pad, pad:-pad])
        swing = cv2.multiply(grain, detail, scale=128.0 * _STRONGEST_GRAIN / 255.0,
                             dtype=cv2.CV_32F)
        factor = cv2.add(swing, 128.0, dtype=cv2.CV_8U)
        return cv2.merge(
            [cv2.multiply(part, factor, scale=1.0 / 128.0) for part in (blue, green, red)]
        )

    def _bounds(self) -> tuple[float, float, float, float]:
        w, t = self._window, self._texel_m
        return w.x0 * t, w.y0 * t, w.x1 * t, w.y1 * t

    def _is_tiny(self, mark: Mark) -> bool:
        west, south, east, north = mark.bounds
        return max(east - west, north - south) < _SMALLEST_TEXELS * self._texel_m

    def _fill(self, target: Image, mark: Mark, value: tuple[int, ...]) -> None:
        origin = np.array([self._window.x0, self._window.y0])
        texels = mark.points / self._texel_m - origin - 0.5
        fixed = np.round(texels * (1 << _SHIFT)).astype(np.int32)
        if mark.radius_m:
            radius = round(mark.radius_m / self._texel_m * (1 << _SHIFT))
            cv2.circle(target, fixed[0].tolist(), radius, value, -1, cv2.LINE_AA, _SHIFT)
        else:
            cv2.fillPoly(target, [fixed], value, cv2.LINE_AA, _SHIFT)

    def _glaze(self, mark: Mark) -> None:
        """Blend a translucent mark into the part of the canvas that it covers."""
        rows, columns = self._part(mark)
        mask = np.zeros(self._window.shape, np.uint8)
        self._fill(mask, mark, (255,))
        soft = self._softened(mask[rows, columns], mark.paint.softness_m)
        share = soft.astype(np.float32) * np.float32(mark.paint.opacity / 255.0)
        value = np.array([*mark.paint.colour[::-1], mark.paint.grain], np.float32)
        part = self._layers[rows, columns]
        part[...] = part + (value - part) * share[..., None]

    def _part(self, mark: Mark) -> tuple[slice, slice]:
        west, south, east, north = (np.array(mark.bounds) / self._texel_m).tolist()
        w = self._window
        rows = slice(max(0, int(south) - w.y0 - 2), max(0, int(north) - w.y0 + 3))
        return rows, slice(max(0, int(west) - w.x0 - 2), max(0, int(east) - w.x0 + 3))

    def _softened(self, mask: Image, softness_m: float) -> Image:
        sigma = 0.5 * softness_m / self._texel_m
        if sigma < 0.3:
            return mask
        size = 2 * round(2.0 * sigma) + 1
        return cv2.GaussianBlur(mask, (size, size), sigma)


