# SPDX-License-Identifier: Apache-2.0
"""Owners: the index of the photograph that is shown at each pixel of the coarse grid."""

import numpy as np
from numpy.typing import NDArray

# The index where no photograph is shown.
NO_PHOTO = -1
Labels = NDArray[np.int32]
