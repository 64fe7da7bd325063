# SPDX-License-Identifier: Apache-2.0
"""The result of drawing a scene once."""

from dataclasses import dataclass
from enum import Enum, auto

import numpy as np
from numpy.typing import NDArray


class Purpose(Enum):
    """What a camera is for; a renderer may leave out the rest."""

    ALL = auto()
    IMAGE = auto()
    TRUTH = auto()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rendering:
    """Image, depth and labels of one pose, aligned to the pixel; row 0 at the top.

    What is not the purpose of a camera may be empty: images have no depth and classes, the truth
    has no image.

    Attributes
    ----------
    image : (height, width, 3)
        Blue, green, red.
    depth_m : (height, width)
        Distance along the optical axis, metres; infinite where the sky is.
    numbers : (height, width)
        Instance numbers, 0 for the sky.
    classes : (height, width)
        Class numbers.
    normals : (height, width, 3)
        Surface normals in east, north, up; bytes 0 to 255 stand for -1 to 1.
    """

    image: NDArray[np.uint8]
    depth_m: NDArray[np.float32]
    numbers: NDArray[np.uint32]
    classes: NDArray[np.uint8]
    normals: NDArray[np.uint8]
