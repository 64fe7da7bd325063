# SPDX-License-Identifier: Apache-2.0
"""What every camera of the simulation offers."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.painting.canvas import Image


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Truth:
    """What is true of each pixel of a photograph.

    Attributes
    ----------
    depth_m : planar, along the view; infinite where the sky is, (height, width).
    numbers : of the instance seen, 0 for the sky, (height, width).
    """

    depth_m: NDArray[np.float32]
    numbers: NDArray[np.uint32]


class Camera(Protocol):
    """Takes photographs of a simulated world."""

    @property
    def lens(self) -> PinholeCamera:
        """Intrinsics."""

    @property
    def truth(self) -> Truth | None:
        """What is true of the last photograph; None if the camera does not know."""

    @property
    def remark(self) -> str:
        """What must be said in every photograph; empty if nothing."""

    def label_table(self) -> str:
        """Return names, classes and colours of the instances as JSON; empty without labels."""

    def photograph(
        self,
        position_enu: Enu,
        rotation_enu_from_optical: FloatArray,
        time_ns: int = 0,
        *,
        is_quick: bool = False,
    ) -> Image:
        """Return the picture seen from a pose at a time: blue, green, red.

        `is_quick`: in the quality of a stream, if that is sooner done.
        """
