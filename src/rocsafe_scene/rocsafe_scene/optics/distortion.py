# SPDX-License-Identifier: Apache-2.0
"""The Brown-Conrady model of lens distortion, in the terms of OpenCV and sensor_msgs/CameraInfo.

Source: Brown, Decentering distortion of lenses (1966). x and y are normalised image coordinates,
in the plane at distance 1 in front of the camera.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.optics.effects import Effects

Plane = NDArray[np.float64]

# Limit of Newton steps, each of which doubles the digits, and the step that ends them.
_MOST_STEPS = 30
_LEAST_STEP = 1e-13
# Margin around the visible part of the image, px: interpolation reads one pixel more.
_MARGIN_PX = 2
# Further margin for a moving camera, as a share of the image size.
_MOTION_MARGIN = 0.12


@dataclass(frozen=True, slots=True)
class Distortion:
    """Coefficients of the model; maps normalised image coordinates."""

    k1: float
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    k3: float = 0.0

    def distorted(self, x: Plane, y: Plane) -> tuple[Plane, Plane]:
        """Return the distorted coordinates of undistorted points."""
        square = x * x + y * y
        radial = 1.0 + square * (self.k1 + square * (self.k2 + square * self.k3))
        both = 2.0 * x * y
        return (
            x * radial + self.p1 * both + self.p2 * (square + 2.0 * x * x),
            y * radial + self.p2 * both + self.p1 * (square + 2.0 * y * y),
        )

    def undistorted(self, x: Plane, y: Plane) -> tuple[Plane, Plane]:
        """Return the undistorted coordinates of distorted points, by Newton's method.

        Raises
        ------
        ValueError
            If there are none: the distortion folds the image over itself.
        """
        found_x, found_y = np.array(x, float), np.array(y, float)
        with np.errstate(all='ignore'):
            for _ in range(_MOST_STEPS):
                step_x, step_y = self._step(found_x, found_y, x, y)
                found_x, found_y = found_x - step_x, found_y - step_y
                if max(np.abs(step_x).max(), np.abs(step_y).max()) < _LEAST_STEP:
                    break
            is_folded = self._slopes(found_x, found_y)[3] <= 0.0
            off_x, off_y = self.distorted(found_x, found_y)
            error = max(np.abs(off_x - x).max(), np.abs(off_y - y).max())
        if is_folded.any() or not error < 1e-9:
            raise ValueError(
                f'distortion is {self.k1:g}, {self.k2:g}, {self.p1:g}, {self.p2:g}, {self.k3:g}: '
                'folds the picture over itself within its corners'
            )
        return found_x, found_y

    def _step(self, x: Plane, y: Plane, to_x: Plane, to_y: Plane) -> tuple[Plane, Plane]:
        at_x, at_y = self.distorted(x, y)
        xx, xy, yy, area = self._slopes(x, y)
        off_x, off_y = at_x - to_x, at_y - to_y
        return (yy * off_x - xy * off_y) / area, (xx * off_y - xy * off_x) / area

    def _slopes(self, x: Plane, y: Plane) -> tuple[Plane, Plane, Plane, Plane]:
        """Return dx/dx, dx/dy = dy/dx and dy/dy of the distortion, and their determinant."""
        square = x * x + y * y
        radial = 1.0 + square * (self.k1 + square * (self.k2 + square * self.k3))
        growth = 2.0 * (self.k1 + square * (2.0 * self.k2 + 3.0 * square * self.k3))
        xx = radial + growth * x * x + 2.0 * self.p1 * y + 6.0 * self.p2 * x
        yy = radial + growth * y * y + 2.0 * self.p2 * x + 6.0 * self.p1 * y
        xy = growth * x * y + 2.0 * (self.p1 * x + self.p2 * y)
        return xx, xy, yy, xx * yy - xy * xy


def pixel_rays(lens: PinholeCamera) -> tuple[Plane, Plane]:
    """Return the normalised coordinates x and y of all pixels of a pinhole, (height, width)."""
    matrix = lens.matrix
    u, v = np.meshgrid(np.arange(lens.image_width_px), np.arange(lens.image_height_px))
    return (u - matrix[0, 2]) / matrix[0, 0], (v - matrix[1, 2]) / matrix[1, 1]


def lens_to_draw(lens: PinholeCamera, effects: Effects) -> PinholeCamera:
    """Return a pinhole of the focal length of `lens` that sees everything a photograph shows.

    If the motion of the camera has an effect, there is a margin for what comes into view
    meanwhile.

    Raises
    ------
    ValueError
        If the distortion folds the border of the image.
    """
    if not effects.distortion and not effects.need_motion:
        return lens
    rays = [
        np.concatenate([plane[0], plane[-1], plane[:, 0], plane[:, -1]])
        for plane in pixel_rays(lens)
    ]
    if effects.distortion:
        rays = list(Distortion(*effects.distortion).undistorted(*rays))
    share = 1.0 + (_MOTION_MARGIN if effects.need_motion else 0.0)
    width, height = (
        2 * math.ceil(share * float(np.abs(plane).max()) * lens.focal_px + 0.5 + _MARGIN_PX)
        for plane in rays
    )
    return PinholeCamera(2.0 * math.atan(0.5 * width / lens.focal_px), width, height)
