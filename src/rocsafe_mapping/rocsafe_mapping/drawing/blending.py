# SPDX-License-Identifier: Apache-2.0
"""Photographs joined without a visible seam (multi-band blending, Burt and Adelson 1983)."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

LEVELS = 4
# Beyond so many pixels from a seam nothing is mixed.
REACH_PX = 2**LEVELS * 2
Colour = NDArray[np.uint8]


def blended(pictures: Sequence[Colour], masks: Sequence[NDArray[np.bool_]]) -> Colour:
    """Return the pictures, each where its mask is, mixed across the borders of the masks.

    Coarse structure is mixed over a wide margin, fine structure over a narrow one. The sides of
    the pictures are multiples of 16.

    Parameters
    ----------
    pictures: shape (height, width, 3) each.
    masks: shape (height, width) each; no pixel is in two.
    """
    total: list[NDArray[np.float32]] = []
    weights: list[NDArray[np.float32]] = []
    for picture, mask in zip(pictures, masks, strict=True):
        bands = _bands(picture.astype(np.float32))
        shares = _smoothed(mask.astype(np.float32))
        for level, (band, share) in enumerate(zip(bands, shares, strict=True)):
            part = band * share[..., np.newaxis]
            if level == len(total):
                total.append(part)
                weights.append(share)
            else:
                total[level] += part
                weights[level] = weights[level] + share
    joined = [
        part / np.maximum(weight, 1e-6)[..., np.newaxis]
        for part, weight in zip(total, weights, strict=True)
    ]
    whole = joined[-1]
    for band in reversed(joined[:-1]):
        whole = cv2.pyrUp(whole, dstsize=band.shape[1::-1]) + band
    result: Colour = np.clip(np.rint(whole), 0, 255).astype(np.uint8)
    return result


def _bands(picture: NDArray[np.float32]) -> list[NDArray[np.float32]]:
    """Return the Laplacian pyramid: finest first, what is left last."""
    bands = []
    for _ in range(LEVELS):
        small = cv2.pyrDown(picture)
        bands.append(picture - cv2.pyrUp(small, dstsize=picture.shape[1::-1]))
        picture = small
    return [*bands, picture]


def _smoothed(mask: NDArray[np.float32]) -> list[NDArray[np.float32]]:
    masks = [mask]
    for _ in range(LEVELS):
        masks.append(cv2.pyrDown(masks[-1]))
    return masks
