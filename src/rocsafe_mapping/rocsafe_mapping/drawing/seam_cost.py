# SPDX-License-Identifier: Apache-2.0
"""Cost of a seam between two photographs at each place: how much they disagree there."""

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_mapping.drawing.placed_photo import Shares
from rocsafe_mapping.drawing_options import SeamOptions

# OpenCV's search of shifts fails in pictures of less than 32 pixels.
LEAST_SIDE_PX = 40
Colours = NDArray[np.uint8]
Marks = NDArray[np.uint8]


def seam_cost(first: Colours, second: Colours, options: SeamOptions) -> Shares:
    """Return the cost (height, width), 0 for none, of a seam through each pixel of a place.

    Parameters
    ----------
    first, second
        What two photographs show of it, shape (height, width, 3).
    """
    different = cv2.absdiff(first, second).astype(np.float32)
    square = np.einsum('ijk,ijk->ij', different, different) / np.float32(options.colour_unit)
    colour: Shares = np.minimum(cv2.blur(square, (3, 3)), np.float32(options.most_colour))
    differs = (colour > options.least_colour).astype(np.uint8)
    if not differs.any():
        return colour
    closing, margin = (np.ones((n, n), np.uint8) for n in (options.closing_px, options.margin_px))
    is_evident = cv2.dilate(cv2.morphologyEx(differs, cv2.MORPH_CLOSE, closing), margin) > 0
    return colour + np.where(is_evident, _squared_shift(first, second, options), np.float32(0.0))


def _squared_shift(first: Colours, second: Colours, options: SeamOptions) -> Shares:
    """Return the squared shift of what each pixel shows in the second picture.

    Found by dense inverse search (Kroeger et al. 2016). All pixels between the two places of an
    object get its shift.
    """
    height, width = first.shape[:2]
    search = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_FAST)
    flow = search.calc(_gray(first), _gray(second), None)[:height, :width]
    length = np.hypot(flow[..., 0], flow[..., 1])
    rows, columns = np.nonzero(length > options.least_shift_px)
    across, down = flow[rows, columns].T
    square = np.minimum(length[rows, columns], np.float32(options.most_shift_px)) ** 2
    found = np.zeros((height, width), np.float32)
    for share in options.shift_places:
        x = np.clip(np.rint(columns + share * across).astype(int), 0, width - 1)
        y = np.clip(np.rint(rows + share * down).astype(int), 0, height - 1)
        np.maximum.at(found, (y, x), square)
    return found


def _gray(colours: Colours) -> Colours:
    """Return a picture in grey, made large enough to be searched."""
    gray = cv2.cvtColor(np.ascontiguousarray(colours), cv2.COLOR_BGR2GRAY)
    below, beside = (max(LEAST_SIDE_PX - side, 0) for side in gray.shape)
    grown: Colours = cv2.copyMakeBorder(gray, 0, below, 0, beside, cv2.BORDER_REPLICATE)
    return grown
