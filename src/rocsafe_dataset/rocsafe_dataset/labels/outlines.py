# SPDX-License-Identifier: Apache-2.0
"""A mask as one polygon, in the text format of YOLO."""

import cv2
import numpy as np

from rocsafe_geo.arrays import BoolArray
from rocsafe_scene.mesh.mesh import Floats

# Parts smaller than this share of the largest part are left out.
_LEAST_SHARE = 0.02
# Tolerance of the simplified outline, pixels.
_TOLERANCE_PX = 0.4


def outline(mask: BoolArray) -> Floats:
    """Return one polygon around all parts of `mask`, pixels from its corner, (n, 2), n >= 3.

    Parts are joined by a line back and forth between their nearest corners; holes are lost.
    """
    # Four times as fine, so that the outline follows the borders of pixels.
    large = np.repeat(np.repeat(mask.astype(np.uint8), 4, axis=0), 4, axis=1)
    contours, _ = cv2.findContours(large, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    rings = sorted((ring[:, 0] for ring in contours), key=lambda r: -_area(r))
    largest = _area(rings[0])
    kept = [ring for ring in rings if _area(ring) >= _LEAST_SHARE * largest]
    fine = [cv2.approxPolyDP(ring, 4.0 * _TOLERANCE_PX, True)[:, 0] for ring in kept]
    joined = np.asarray(fine[0], float)
    for ring in fine[1:]:
        joined = _joined(joined, np.asarray(ring, float))
    return np.asarray((joined + 0.5) / 4.0)


def _area(ring: Floats) -> float:
    return float(cv2.contourArea(ring.astype(np.float32)))


def _joined(one: Floats, two: Floats) -> Floats:
    """Return one ring that follows `one`, crosses to `two`, follows it and returns."""
    distance = np.linalg.norm(one[:, None] - two[None], axis=2)
    here, there = np.unravel_index(int(np.argmin(distance)), distance.shape)
    around = np.concatenate([np.roll(two, -int(there), axis=0), two[there][None]])
    return np.concatenate([one[: here + 1], around, one[here:]])
