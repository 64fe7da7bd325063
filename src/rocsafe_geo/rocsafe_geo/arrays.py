# SPDX-License-Identifier: Apache-2.0
"""Types of the arrays that all packages compute with."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IndexArray = NDArray[np.intp]
ImageArray = NDArray[np.uint8]
