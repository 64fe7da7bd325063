# SPDX-License-Identifier: Apache-2.0
"""How the picture of a still world moves while the camera does."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.motion.state import Enu
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.optics.distortion import Plane, pixel_rays

Rates = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class CameraMotion:
    """Of a camera, in its own optical axes: m/s and rad/s, (3,) each."""

    velocity_mps: Plane
    turning_radps: Plane

    @property
    def is_none(self) -> bool:
        """Whether it stands still."""
        return not (self.velocity_mps.any() or self.turning_radps.any())


def motion_between(
    positions_enu: tuple[Enu, Enu], rotations: tuple[Plane, Plane], span_s: float
) -> CameraMotion:
    """Return the even motion that leads from one pose to another.

    Parameters
    ----------
    positions_enu
        Metres, before and after.
    rotations
        From the optical frame to east, north, up, (3, 3), before and after.
    span_s
        Time between them.
    """
    before, after = rotations
    way = np.subtract(positions_enu[1], positions_enu[0]) / span_s
    turn = cv2.Rodrigues(before.T @ after)[0].ravel() / span_s
    # half way, where the picture is taken
    middle = before @ cv2.Rodrigues(0.5 * span_s * turn)[0]
    return CameraMotion(middle.T @ way, turn)


def pixel_rates(lens: PinholeCamera, depth_m: NDArray[np.float32], motion: CameraMotion) -> Rates:
    """Return how fast what each pixel shows moves, x right and y down, px/s, (height, width, 2).

    The equations of Longuet-Higgins and Prazdny (1980), for a point at rest.

    Parameters
    ----------
    lens
        Of the picture.
    depth_m
        Planar, (height, width); infinite where the sky is.
    motion
        Of the camera.
    """
    x, y = (plane.astype(np.float32) for plane in pixel_rays(lens))
    vx, vy, vz = motion.velocity_mps.tolist()
    wx, wy, wz = motion.turning_radps.tolist()
    nearness = 1.0 / depth_m
    rates = np.empty((*depth_m.shape, 2), np.float32)
    rates[..., 0] = (x * vz - vx) * nearness + x * y * wx - (1.0 + x * x) * wy + y * wz
    rates[..., 1] = (y * vz - vy) * nearness + (1.0 + y * y) * wx - x * y * wy - x * wz
    rates *= lens.focal_px
    return rates


def plane_depth_m(lens: PinholeCamera, height_m: float, rotation: Plane) -> NDArray[np.float32]:
    """Return the planar depth of level ground `height_m` below a camera, (height, width)."""
    x, y = pixel_rays(lens)
    down = -(rotation[2, 0] * x + rotation[2, 1] * y + rotation[2, 2])
    with np.errstate(divide='ignore'):
        return np.where(down > 0.0, height_m / down, np.inf).astype(np.float32)
