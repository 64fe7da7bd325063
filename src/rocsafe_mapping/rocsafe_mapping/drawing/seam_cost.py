# SPDX-License-Identifier: Apache-2.0
"""What a seam between two photographs would cost at each place: how far they disagree there."""

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_mapping.drawing.sheet import Shares

# Squared difference of blue, green and red that counts as one: 20 levels in each.
COLOUR_UNIT = 3 * 20.0**2
MOST_COLOUR = 8.0
# From here on a difference is not that of light and noise, and what lies between is no ground.
LEAST_COLOUR = 1.0
# Cost of a seam where photographs agree, for each pixel that it passes: while it is searched
# (it shall be short), and when things are kept whole afterwards (round them it may be longer).
SEARCH_LENGTH_COST, KEPT_LENGTH_COST = 1.0, 0.3
CLOSE, NEAR = np.ones((9, 9), np.uint8), np.ones((3, 3), np.uint8)
# Things that stand up lie elsewhere in each photograph: a shift costs its square.
LEAST_SHIFT_PX, MOST_SHIFT_PX = 1.0, 6.0
# Between its two places a thing would be missing or there twice.
WAY = (0.0, 0.25, 0.5, 0.75, 1.0)
# OpenCV's search of shifts fails in pictures of less than 32 pixels.
LEAST_SIDE_PX = 40
Colours = NDArray[np.uint8]
Marks = NDArray[np.uint8]


def seam_cost(first: Colours, second: Colours) -> Shares:
    """Return the cost (height, width), 0 for none, of a seam through each pixel of a place.

    Parameters
    ----------
    first, second: what two photographs show of it, shape (height, width, 3).
    """
    different = cv2.absdiff(first, second).astype(np.float32)
    square = np.einsum('ijk,ijk->ij', different, different) / np.float32(COLOUR_UNIT)
    colour: Shares = np.minimum(cv2.blur(square, (3, 3)), np.float32(MOST_COLOUR))
    differs = (colour > LEAST_COLOUR).astype(np.uint8)
    if not differs.any():
        return colour
    is_evident = cv2.dilate(cv2.morphologyEx(differs, cv2.MORPH_CLOSE, CLOSE), NEAR) > 0
    return colour + np.where(is_evident, _squared_shift(first, second), np.float32(0.0))


def _squared_shift(first: Colours, second: Colours) -> Shares:
    """Return how far what is seen at each pixel lies elsewhere in the second picture, squared.

    Found by dense inverse search (Kroeger et al. 2016); the whole way between the two places of a
    thing gets its shift.
    """
    height, width = first.shape[:2]
    search = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_FAST)
    flow = search.calc(_gray(first), _gray(second), None)[:height, :width]
    length = np.hypot(flow[..., 0], flow[..., 1])
    rows, columns = np.nonzero(length > LEAST_SHIFT_PX)
    across, down = flow[rows, columns].T
    square = np.minimum(length[rows, columns], np.float32(MOST_SHIFT_PX)) ** 2
    found = np.zeros((height, width), np.float32)
    for share in WAY:
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
