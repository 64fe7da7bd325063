# SPDX-License-Identifier: Apache-2.0
"""Who is shown where: the index of a photograph at each pixel of the coarse grid."""

import numpy as np
from numpy.typing import NDArray

# The index where no photograph is shown.
NO_PHOTO = -1
Labels = NDArray[np.int32]
