# SPDX-License-Identifier: Apache-2.0
"""Photographs joined without a visible seam (multi-band blending, Burt and Adelson 1983)."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import BoolArray

LEVELS = 4
# Pixels farther from a seam are not mixed.
REACH_PX = 2**LEVELS * 2
GRAIN_PX = 2**LEVELS
Colour = NDArray[np.uint8]
Floats = NDArray[np.float32]
Mask = BoolArray
Place = tuple[slice, slice]


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A picture of a part of a window.

    Attributes
    ----------
    place
        Rows and columns of the window, all multiples of 16, see `reach`.
    picture
        Shape (height, width, 3) of the place.
    mask
        Which pixels of the whole window it shall own.
    """

    place: Place
    picture: Colour
    mask: Mask


def reach(mask: Mask) -> Place:
    """Return the rows and columns where a picture that owns `mask` has any share.

    The sides of the mask, which is not empty, are multiples of 16.
    """
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    return _grown(rows, mask.shape[0]), _grown(columns, mask.shape[1])


def _grown(indices: NDArray[np.int64], size: int) -> slice:
    low = max(int(indices[0]) - REACH_PX, 0) // GRAIN_PX * GRAIN_PX
    return slice(low, min(-(-(int(indices[-1]) + 1 + REACH_PX) // GRAIN_PX) * GRAIN_PX, size))


def blended(ground: Colour, ground_mask: Mask, parts: Sequence[Part]) -> Colour:
    """Return the pictures blended: each where its mask is, mixed across the borders of masks.

    Coarse structure is mixed over a wide margin, fine structure over a narrow one.

    Parameters
    ----------
    ground
        A picture of the whole window, shape (height, width, 3), multiples of 16.
    ground_mask
        What it owns; no pixel is in two masks.
    parts
        The other pictures.
    """
    # Each level of the blended pyramid is a weighted mean of the pictures: only the differences
    # from the first picture need a pyramid.
    smoothed = [_smoothed(part.mask[part.place].astype(np.float32)) for part in parts]
    totals = _smoothed(ground_mask.astype(np.float32))
    for part, masks in zip(parts, smoothed, strict=True):
        for level, mask in enumerate(masks):
            totals[level][_at(part.place, level)] += mask
    first = ground.astype(np.float32)
    bands = [np.zeros((*total.shape, 3), np.float32) for total in totals]
    for part, masks in zip(parts, smoothed, strict=True):
        different = _bands(cv2.subtract(part.picture.astype(np.float32), first[part.place]))
        for level, (band, mask) in enumerate(zip(different, masks, strict=True)):
            place = _at(part.place, level)
            share = mask / np.maximum(totals[level][place], np.float32(1e-6))
            bands[level][place] += cv2.multiply(band, cv2.merge([share, share, share]))
    whole = bands[-1]
    for band in reversed(bands[:-1]):
        whole = cv2.add(cv2.pyrUp(whole, dstsize=band.shape[1::-1]), band)
    result: Colour = np.clip(np.rint(cv2.add(first, whole)), 0, 255).astype(np.uint8)
    return result


def _at(place: Place, level: int) -> Place:
    """Return a place at a level of a pyramid."""
    rows, columns = place
    return (
        slice(rows.start >> level, rows.stop >> level),
        slice(columns.start >> level, columns.stop >> level),
    )


def _bands(picture: Floats) -> list[Floats]:
    """Return the Laplacian pyramid: finest first, what is left last."""
    bands: list[Floats] = []
    for _ in range(LEVELS):
        small = cv2.pyrDown(picture)
        bands.append(cv2.subtract(picture, cv2.pyrUp(small, dstsize=picture.shape[1::-1])))
        picture = small
    return [*bands, picture]


def _smoothed(mask: Floats) -> list[Floats]:
    masks = [mask]
    for _ in range(LEVELS):
        masks.append(cv2.pyrDown(masks[-1]))
    return masks
