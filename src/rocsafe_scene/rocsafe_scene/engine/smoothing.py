# SPDX-License-Identifier: Apache-2.0
"""Anti-aliasing of edges by blending along each edge, after FXAA (Lottes, 2009)."""

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import BoolArray, ImageArray, IndexArray
from rocsafe_scene.engine.drawing_options import SMOOTHING

# Least contrast of an edge for each brightness of its brighter side.
_BOUNDS = np.rint(
    np.maximum(np.arange(256) * SMOOTHING.least_contrast_share, SMOOTHING.least_contrast)
).astype(np.uint8)
_BRIGHTNESS = np.array([0.114, 0.587, 0.299], np.float32)


def smoothed(image: ImageArray, numbers: NDArray[np.uint32], normals: ImageArray) -> ImageArray:
    """Return `image` (blue, green, red) with smooth edges of things.

    Parameters
    ----------
    image : (height, width, 3)
        Image as drawn.
    numbers
        Of instances, (height, width); where they change is an edge.
    normals
        Bytes, (height, width, 3); where they jump within a thing is an edge too.
    """
    bright = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    kernel = np.ones((3, 3), np.uint8)
    is_edge = _differs(numbers)
    is_edge |= _steps(cv2.extractChannel(normals, 2)) > SMOOTHING.least_turn
    chosen = np.flatnonzero(is_edge)
    # Pixels are picked one by one from here on: edges are a twentieth of an image.
    high = cv2.dilate(bright, kernel).ravel()[chosen]
    low = cv2.erode(bright, kernel).ravel()[chosen]
    is_strong = high - low > _BOUNDS[high]
    chosen, high, low = chosen[is_strong], high[is_strong], low[is_strong]
    if not len(chosen):
        return image
    rows, columns = np.divmod(chosen, image.shape[1])
    along = _along(bright, rows, columns)
    near, far = (
        _at(image, rows, columns, -share * along) + _at(image, rows, columns, share * along)
        for share in (1.0 / 6.0, 0.5)
    )
    wide = 0.25 * (near + far).astype(np.float32)
    shade = wide @ _BRIGHTNESS
    is_off = (shade < low) | (shade > high)
    found = np.where(is_off[:, None], 0.5 * near.astype(np.float32), wide)
    result = image.copy()
    result.reshape(-1, 3)[chosen] = np.rint(found).astype(np.uint8)
    return result


def _differs(values: NDArray[np.uint32]) -> BoolArray:
    """Return whether a value differs from that to the left or above."""
    found = np.zeros(values.shape, bool)
    np.not_equal(values[:, 1:], values[:, :-1], out=found[:, 1:])
    found[1:] |= values[1:] != values[:-1]
    return found


def _steps(values: ImageArray) -> ImageArray:
    """Return how far values differ among a pixel and those to the left and above."""
    kernel = np.ones((2, 2), np.uint8)
    return np.asarray(cv2.subtract(cv2.dilate(values, kernel), cv2.erode(values, kernel)))


def _along(bright: ImageArray, rows: IndexArray, columns: IndexArray) -> NDArray[np.float32]:
    """Return the direction in which each edge runs, x right and y down, pixels, (n, 2)."""
    framed = cv2.copyMakeBorder(bright, 1, 1, 1, 1, cv2.BORDER_REFLECT_101)
    width = framed.shape[1]
    flat, corner = framed.ravel(), rows * width + columns
    # The neighbours of each pixel, row by row; Sobel's operator of them.
    a, b, c, d, e, f, g, h = (
        flat[corner + shift].astype(np.int16)
        for shift in (0, 1, 2, width, width + 2, 2 * width, 2 * width + 1, 2 * width + 2)
    )
    across_x = (c - a + 2 * (e - d) + h - f).astype(np.float32)
    across_y = (f - a + 2 * (g - b) + h - c).astype(np.float32)
    along = np.stack([-across_y, across_x], axis=1)
    least = np.maximum(np.minimum(np.abs(across_x), np.abs(across_y)), 8.0)
    return np.clip(along / least[:, None], -SMOOTHING.reach_px, SMOOTHING.reach_px)


def _at(
    image: ImageArray, rows: IndexArray, columns: IndexArray, shift: NDArray[np.float32]
) -> NDArray[np.uint16]:
    """Return colours at places beside pixels, (n, 3)."""
    # OpenCV takes maps of fewer than 32768 rows.
    width = 4096
    count = len(rows)
    places = np.zeros((2, -(-count // width) * width), np.float32)
    places[0, :count] = columns + shift[:, 0]
    places[1, :count] = rows + shift[:, 1]
    x, y = places.reshape(2, -1, width)
    found = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(found.reshape(-1, 3)[:count], np.uint16)
