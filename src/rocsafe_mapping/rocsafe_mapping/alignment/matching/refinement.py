# SPDX-License-Identifier: Apache-2.0
"""Ties between two photographs made exact to a fraction of a pixel."""

import cv2
import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.matching.features import Gray
from rocsafe_mapping.alignment.matching.parallax import transformed
from rocsafe_mapping.alignment_options import RefinementOptions


def refined(
    first: Gray,
    second: Gray,
    homography: FloatArray,
    first_px: FloatArray,
    second_px: FloatArray,
    options: RefinementOptions,
) -> tuple[FloatArray, FloatArray]:
    """Return the ties (n, 2) moved to where the pictures agree best (Lucas, Kanade 1981).

    The second picture is brought into the view of the first by `homography`, first to second, so
    that the pictures differ by small shifts only. Where that fails the ties stay as they are.
    """
    margin = 2 * options.window_px
    low = np.maximum(first_px.min(axis=0).astype(int) - margin, 0)
    high = np.minimum(first_px.max(axis=0).astype(int) + margin, first.shape[::-1])
    to_crop = np.eye(3)
    to_crop[:2, 2] = -low
    size = tuple(int(side) for side in high - low)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    inverse = homography @ np.linalg.inv(to_crop)
    warped = cv2.warpPerspective(second, inverse, size, flags=flags)
    piece = np.ascontiguousarray(first[low[1] : high[1], low[0] : high[0]])
    start = (first_px - low).astype(np.float32)
    # Points off the plane are searched where their descriptor was matched.
    guess = transformed(np.linalg.inv(inverse), second_px).astype(np.float32)
    is_flat = np.linalg.norm(guess - start, axis=1) < options.largest_move_px
    guess[is_flat] = start[is_flat]
    moved, status, error = cv2.calcOpticalFlowPyrLK(
        piece,
        warped,
        start,
        guess.copy(),
        winSize=(options.window_px, options.window_px),
        maxLevel=1,
        criteria=(
            cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS,
            options.iterations,
            options.least_step_px,
        ),
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    move = np.linalg.norm(moved - guess, axis=1)
    is_good = (
        (status.ravel() == 1)
        & (move < options.largest_move_px)
        & (error.ravel() < options.largest_error)
    )
    if is_good.mean() < options.least_share:
        return first_px, second_px
    there = np.column_stack([moved[is_good].astype(float), np.ones(is_good.sum())]) @ inverse.T
    return first_px[is_good], there[:, :2] / there[:, 2:]
