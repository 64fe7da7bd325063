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
    image : (height, width, 3)
        Blue, green, red.
    depth_m : (height, width)
        Planar, along the view; infinite where the sky is.
    numbers : (height, width)
        Instance, 0 for the sky.
    classes : (height, width)
        Class number.
    normals : (height, width, 3)
        Of the surfaces in east, north, up, bytes 0 to 255 for -1 to 1.
    """

    image: NDArray[np.uint8]
    depth_m: NDArray[np.float32]
    numbers: NDArray[np.uint32]
    classes: NDArray[np.uint8]
    normals: NDArray[np.uint8]
