# SPDX-License-Identifier: Apache-2.0
"""What one exposure gives."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rendering:
    """Pictures of the same moment, aligned to the pixel; row 0 at the top.

    Attributes
    ----------
    image : blue, green, red, (height, width, 3).
    depth_m : planar, along the view; infinite where the sky is, (height, width).
    numbers : instance, 0 for the sky, (height, width).
    classes : class number, (height, width).
    normals : of the surfaces in east, north, up, bytes 0 to 255 for -1 to 1, (height, width, 3).
    """

    image: NDArray[np.uint8]
    depth_m: NDArray[np.float32]
    numbers: NDArray[np.uint32]
    classes: NDArray[np.uint8]
    normals: NDArray[np.uint8]
