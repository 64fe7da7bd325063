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
Floats = NDArray[np.float32]


def blended(pictures: Sequence[Colour], masks: Sequence[NDArray[np.bool_]]) -> Colour:
    """Return the pictures, each where its mask is, mixed across the borders of the masks.

    Coarse structure is mixed over a wide margin, fine structure over a narrow one. The sides of
    the pictures are multiples of 16.

    Parameters
    ----------
    pictures: shape (height, width, 3) each.
    masks: shape (height, width) each; no pixel is in two.
    """
    if len(pictures) == 1:
        return pictures[0].copy()
    shares = _shares(masks)
    # Each level of the joined pyramid is linear in the pictures, with shares that add up to one:
    # only what the others differ from the first needs a pyramid of its own.
    first = pictures[0].astype(np.float32)
    bands: list[Floats] = []
    for picture, levels in zip(pictures[1:], shares[1:], strict=True):
        different = _bands(cv2.subtract(picture.astype(np.float32), first))
        for level, (band, share) in enumerate(zip(different, levels, strict=True)):
            part = cv2.multiply(band, cv2.merge([share, share, share]))
            if level == len(bands):
                bands.append(part)
            else:
                cv2.add(bands[level], part, dst=bands[level])
    whole = bands[-1]
    for band in reversed(bands[:-1]):
        whole = cv2.add(cv2.pyrUp(whole, dstsize=band.shape[1::-1]), band)
    result: Colour = np.clip(np.rint(cv2.add(first, whole)), 0, 255).astype(np.uint8)
    return result


def _bands(picture: Floats) -> list[Floats]:
    """Return the Laplacian pyramid: finest first, what is left last."""
    bands: list[Floats] = []
    for _ in range(LEVELS):
        small = cv2.pyrDown(picture)
        bands.append(cv2.subtract(picture, cv2.pyrUp(small, dstsize=picture.shape[1::-1])))
        picture = small
    return [*bands, picture]


def _shares(masks: Sequence[NDArray[np.bool_]]) -> list[list[Floats]]:
    """Return the share of each mask at each level; they add up to one where a mask is near."""
    smoothed = [_smoothed(mask.astype(np.float32)) for mask in masks]
    for levels in zip(*smoothed, strict=True):
        total = np.maximum(sum(levels), 1e-6)
        for level in levels:
            level /= total
    return smoothed


def _smoothed(mask: Floats) -> list[Floats]:
    masks = [mask]
    for _ in range(LEVELS):
        masks.append(cv2.pyrDown(masks[-1]))
    return masks
