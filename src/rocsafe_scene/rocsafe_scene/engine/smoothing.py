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
    high, low = cv2.dilate(bright, kernel), cv2.erode(bright, kernel)
    is_edge = _differs(numbers)
    is_edge |= _steps(cv2.extractChannel(normals, 2)) > SMOOTHING.least_turn
    is_edge &= cv2.subtract(high, low) > cv2.LUT(high, _BOUNDS)
    chosen = np.flatnonzero(is_edge)
    if not len(chosen):
        return image
    rows, columns = np.divmod(chosen, image.shape[1])
    along = _along(bright, rows, columns)
    close = 0.5 * (
        _at(image, rows, columns, along / -6.0) + _at(image, rows, columns, along / 6.0)
    )
    ends = 0.5 * (_at(image, rows, columns, -0.5 * along) + _at(image, rows, columns, 0.5 * along))
    wide = 0.5 * (close + ends)
    shade = wide @ _BRIGHTNESS
    is_off = (shade < low.ravel()[chosen]) | (shade > high.ravel()[chosen])
    result = image.copy()
    found = np.where(is_off[:, None], close, wide)
    result.reshape(-1, 3)[chosen] = np.rint(found).astype(np.uint8)
    return result


def _differs(values: NDArray[np.uint32]) -> BoolArray:
    """Return whether a value differs from that to the left or above."""
    found = np.zeros(values.shape, bool)
    found[:, 1:] = values[:, 1:] != values[:, :-1]
    found[1:] |= values[1:] != values[:-1]
    return found


def _steps(values: ImageArray) -> ImageArray:
    """Return how far values differ among a pixel and those to the left and above."""
    kernel = np.ones((2, 2), np.uint8)
    return np.asarray(cv2.subtract(cv2.dilate(values, kernel), cv2.erode(values, kernel)))


def _along(bright: ImageArray, rows: IndexArray, columns: IndexArray) -> NDArray[np.float32]:
    """Return the direction in which each edge runs, x right and y down, pixels, (n, 2)."""
    across_x = cv2.Sobel(bright, cv2.CV_16S, 1, 0)[rows, columns].astype(np.float32)
    across_y = cv2.Sobel(bright, cv2.CV_16S, 0, 1)[rows, columns].astype(np.float32)
    along = np.stack([-across_y, across_x], axis=1)
    least = np.maximum(np.minimum(np.abs(across_x), np.abs(across_y)), 8.0)
    return np.clip(along / least[:, None], -SMOOTHING.reach_px, SMOOTHING.reach_px)


def _at(
    image: ImageArray, rows: IndexArray, columns: IndexArray, shift: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Return colours at places beside pixels, (n, 3)."""
    x = (columns + shift[:, 0]).astype(np.float32)
    y = (rows + shift[:, 1]).astype(np.float32)
    # OpenCV takes maps of fewer than 32768 rows.
    width = 4096
    fill = -len(x) % width
    grid_x = np.pad(x, (0, fill)).reshape(-1, width)
    grid_y = np.pad(y, (0, fill)).reshape(-1, width)
    found = cv2.remap(image, grid_x, grid_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(found.reshape(-1, 3)[: len(x)], np.float32)
