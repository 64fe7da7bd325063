# SPDX-License-Identifier: Apache-2.0
"""Plane sweep: correlation of two photographs at each place, for each height that is tried.

A photograph on the map shows a point at the height z where the ray through it meets the ground.
For each height the second photograph is projected onto the first; they agree where the height is
right (Collins 1996). On level ground this is a shift and a change of scale: with cameras at c, c'
and heights h, h', the point that the first shows at x lies at x (1 - z / h) + c z / h, and the
second shows it h' / (h' - z) times as far from c'.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.drawing.grid import Window
from rocsafe_mapping.drawing.placed_photo import Shares
from rocsafe_mapping.drawing_options import ReliefOptions

NOT_SEEN = -1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepImage:
    """A photograph on the coarse grid.

    Attributes
    ----------
    window
        Where.
    gray
        Shape (height, width).
    is_seen
        Which of it the photograph shows, 1 or 0, shape (height, width).
    below
        The place (column, row) on the grid below the camera.
    height_m
        Of the camera above the ground.
    """

    window: Window
    gray: NDArray[np.uint8]
    is_seen: NDArray[np.uint8]
    below: FloatArray
    height_m: float


def likeness(
    first: SweepImage,
    box: Window,
    others: Sequence[SweepImage],
    heights_m: FloatArray,
    options: ReliefOptions,
) -> Shares:
    """Return how alike `first` and the others are, -1 to 1, at each height: (n, height, width).

    It is the mean, over those of the others that see the place, of the correlation of windows;
    -1 where none of them sees it.

    Parameters
    ----------
    box
        What of the grid is asked, within the window of `first`.
    heights_m
        Above the ground that are tried, shape (n,).
    """
    one = first.gray[box.within(first.window)].astype(np.float32)
    total = np.zeros((len(heights_m), *one.shape), np.float32)
    count = np.zeros(total.shape, np.uint8)
    for other in others:
        alike, is_seen = _compared(one, _laid(first, box, other, heights_m), options)
        alike *= is_seen
        total += alike
        count += is_seen
    np.divide(total, count, out=total, where=count > 1)
    total[count == 0] = NOT_SEEN
    return total


def _laid(
    first: SweepImage, box: Window, other: SweepImage, heights_m: FloatArray
) -> tuple[Shares, NDArray[np.uint8]]:
    """Return `other` projected onto `first` for each height (n, height, width), with masks."""
    shape = (len(heights_m), box.height, box.width)
    gray, is_seen = np.empty(shape, np.float32), np.empty(shape, np.uint8)
    size, picture = (box.width, box.height), other.gray.astype(np.float32)
    # Pixel (0, 0) of a picture has its middle half a pixel from its window's edge.
    corner = np.array([box.column, box.row]) + 0.5
    start = np.array([other.window.column, other.window.row]) + 0.5
    for number, height_m in enumerate(heights_m):
        sunk = height_m / first.height_m
        stretch = other.height_m / (other.height_m - height_m)
        x, y = (
            stretch * (corner * (1.0 - sunk) + first.below * sunk - other.below)
            + other.below - start
        )  # fmt: skip
        scale = stretch * (1.0 - sunk)
        matrix = np.array([[scale, 0.0, x], [0.0, scale, y]])
        cv2.warpAffine(
            picture, matrix, size, dst=gray[number],
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP, borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
        cv2.warpAffine(
            other.is_seen, matrix, size, dst=is_seen[number],
            flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP, borderMode=cv2.BORDER_CONSTANT,
        )  # fmt: skip
    return gray, is_seen


def _compared(
    one: Shares, laid: tuple[Shares, NDArray[np.uint8]], options: ReliefOptions
) -> tuple[Shares, NDArray[np.uint8]]:
    """Return the correlation of windows of `one` and each projected picture, and `is_seen`.

    All pictures are smoothed as one tall picture, for speed: within half a window of its upper and
    lower edge the correlation of each is not valid.
    """
    gray, is_seen = laid
    side_px, noise = options.compared_px, options.noise_variance
    mean, variance = _moments(one, side_px)
    tall = gray.reshape(-1, gray.shape[2])
    means, variances = (part.reshape(gray.shape) for part in _moments(tall, side_px))
    product = _smooth((gray * one).reshape(tall.shape), side_px).reshape(gray.shape)
    product -= means * mean
    product /= np.sqrt((variances + noise) * (variance + noise))
    return product, is_seen


def _moments(picture: Shares, side_px: int) -> tuple[Shares, Shares]:
    """Return mean and variance of the windows about each pixel."""
    mean = _smooth(picture, side_px)
    return mean, np.maximum(_smooth(picture * picture, side_px) - mean * mean, np.float32(0.0))


def _smooth(picture: Shares, side_px: int) -> Shares:
    side = (side_px, side_px)
    smoothed: Shares = cv2.boxFilter(picture, -1, side, borderType=cv2.BORDER_REPLICATE)
    return smoothed
