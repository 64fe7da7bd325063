# SPDX-License-Identifier: Apache-2.0
"""The interface of all simulated cameras."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray, ImageArray
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.scene.moving_sun import LightOrder


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Truth:
    """Depth and instance of each pixel of a photograph.

    Attributes
    ----------
    depth_m : (height, width)
        Distance along the optical axis, metres; infinite where the sky is.
    numbers : (height, width)
        Instance number, 0 for the sky.
    """

    depth_m: NDArray[np.float32]
    numbers: NDArray[np.uint32]


class Camera(Protocol):
    """Takes photographs of a simulated world."""

    @property
    def lens(self) -> PinholeCamera:
        """Intrinsics of the camera."""

    @property
    def truth(self) -> Truth | None:
        """Depth and instances of the last photograph; None if the camera has none."""

    @property
    def remark(self) -> str:
        """Note that every photograph must carry; may be empty."""

    def label_table(self) -> str:
        """Return names, classes and colours of the instances as JSON; empty without labels."""

    def set_light(self, order: LightOrder) -> None:
        """Change sun and air from the next image on; raises `ViewError` if it cannot be."""

    def through(self, lens: PinholeCamera) -> 'Camera':
        """Return a camera of the same world with another lens."""

    def close(self) -> None:
        """Release what it draws with."""

    def photograph(
        self,
        position_enu: Enu,
        rotation_enu_from_optical: FloatArray,
        time_ns: int = 0,
        *,
        is_quick: bool = False,
    ) -> ImageArray:
        """Return the image seen from a pose at a time: blue, green, red.

        With `is_quick` the image may be of lower quality, as for a stream, if that is faster.
        """
