# SPDX-License-Identifier: Apache-2.0
"""Motion of the image of a scene at rest while the camera moves."""

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
    """Velocity, m/s, and angular velocity, rad/s, of a camera in its optical axes, (3,) each."""

    velocity_mps: Plane
    turning_radps: Plane

    @property
    def is_none(self) -> bool:
        """Whether it stands still."""
        return not (self.velocity_mps.any() or self.turning_radps.any())


def motion_between(
    positions_enu: tuple[Enu, Enu], rotations: tuple[Plane, Plane], span_s: float
) -> CameraMotion:
    """Return the uniform motion from one pose to another.

    Parameters
    ----------
    positions_enu
        Positions before and after, metres.
    rotations
        Rotations (3, 3) from the optical frame to east, north, up, before and after.
    span_s
        Time between the poses, seconds.
    """
    before, after = rotations
    way = np.subtract(positions_enu[1], positions_enu[0]) / span_s
    turn = cv2.Rodrigues(before.T @ after)[0].ravel() / span_s
    # The image is taken half way.
    middle = before @ cv2.Rodrigues(0.5 * span_s * turn)[0]
    return CameraMotion(middle.T @ way, turn)


def pixel_rates(lens: PinholeCamera, depth_m: NDArray[np.float32], motion: CameraMotion) -> Rates:
    """Return the image velocity at each pixel, x right and y down, px/s, (height, width, 2).

    Equations of Longuet-Higgins and Prazdny (1980) for points at rest.

    Parameters
    ----------
    lens
        Intrinsics of the image.
    depth_m
        Distance along the optical axis, metres, (height, width); infinite where the sky is.
    motion
        Motion of the camera.
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
