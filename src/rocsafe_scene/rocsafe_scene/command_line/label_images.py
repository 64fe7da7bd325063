# SPDX-License-Identifier: Apache-2.0
"""Images that show classes, instances, depth and normals."""

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import ImageArray
from rocsafe_scene.mesh.classes import CLASSES
from rocsafe_scene.mesh.mesh import Floats


def class_picture(classes: NDArray[np.uint8]) -> ImageArray:
    """Return class numbers in the colours of their classes; blue, green, red."""
    table = np.zeros((256, 3), np.uint8)
    for label in CLASSES.values():
        table[label.number] = label.colour[::-1]
    return np.asarray(table[classes])


def number_picture(numbers: NDArray[np.uint32]) -> ImageArray:
    """Return each instance in a colour of its own; the sky is black."""
    mixed = numbers.astype(np.uint64) * np.uint64(0x9E3779B1) & np.uint64(0xFFFFFF)
    parts = [(mixed >> np.uint64(shift)).astype(np.uint8) for shift in (0, 8, 16)]
    coloured = np.stack(parts, axis=-1) // 2 + 96
    return np.where(numbers[..., None] == 0, 0, coloured).astype(np.uint8)


def depth_picture(depth_m: Floats) -> ImageArray:
    """Return depth from near and bright to far and dark, by its logarithm."""
    near = float(np.min(depth_m))
    far = float(np.max(depth_m[np.isfinite(depth_m)], initial=near + 1.0))
    share = np.log(np.minimum(depth_m, far) / near) / max(1e-6, np.log(far / near))
    grey = np.clip(255.0 * (1.0 - share), 0.0, 255.0).astype(np.uint8)
    return np.asarray(cv2.applyColorMap(grey, cv2.COLORMAP_INFERNO))


def truth_sheet(classes: NDArray[np.uint8], numbers: NDArray[np.uint32], depth_m: Floats,
                normals: ImageArray) -> ImageArray:  # fmt: skip
    """Return one image with classes and instances above depth and normals."""
    above = np.hstack([class_picture(classes), number_picture(numbers)])
    below = np.hstack([depth_picture(depth_m), normals[..., ::-1]])
    return np.asarray(np.vstack([above, below]))
