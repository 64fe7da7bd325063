# SPDX-License-Identifier: Apache-2.0
"""A pinhole camera looking down at level ground.

Pixels: integer coordinates are pixel centres (OpenCV), so the image spans -0.5 to size - 0.5.
Optical frame: x to the right of the image, y down the image, z along the view (REP 103).
Body frame: x forward, y left, z up; roll, pitch, yaw about x, y, z in the order yaw, pitch, roll
(REP 103), so that positive pitch lowers the nose.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_count, require_finite, require_positive

MAX_IMAGE_SIDE_PX = 65_535

# A nadir camera whose image top points forward: columns are the optical axes in the body frame.
_BODY_FROM_OPTICAL = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


@dataclass(frozen=True, slots=True)
class PinholeCamera:
    """A camera with square pixels, no distortion, and its principal point in the image centre.

    `horizontal_fov_rad` is the full angle across the image width, between 0 and pi.
    """

    horizontal_fov_rad: float
    image_width_px: int
    image_height_px: int

    def __post_init__(self) -> None:
        fov = require_finite('horizontal_fov_rad', self.horizontal_fov_rad)
        if not 0.0 < fov < math.pi:
            raise ValueError(
                f'horizontal_fov_rad is {fov:g} ({math.degrees(fov):g} deg): '
                'must be above 0 and below pi (180 deg)'
            )
        for name in ('image_width_px', 'image_height_px'):
            count = require_count(name, getattr(self, name), 1, MAX_IMAGE_SIDE_PX)
            object.__setattr__(self, name, count)

    @property
    def focal_px(self) -> float:
        """Focal length in pixels."""
        return 0.5 * self.image_width_px / math.tan(0.5 * self.horizontal_fov_rad)

    @property
    def matrix(self) -> FloatArray:
        """Intrinsic matrix (3, 3): optical coordinates -> homogeneous pixels."""
        centre_x = 0.5 * (self.image_width_px - 1)
        centre_y = 0.5 * (self.image_height_px - 1)
        f = self.focal_px
        return np.array([[f, 0.0, centre_x], [0.0, f, centre_y], [0.0, 0.0, 1.0]])

    def footprint_m(self, height_m: float) -> tuple[float, float]:
        """Return (width, height) of the ground seen from `height_m` straight above it."""
        metres_per_px = require_positive('height_m', height_m, 'm') / self.focal_px
        return self.image_width_px * metres_per_px, self.image_height_px * metres_per_px


def rotation_enu_from_optical(
    yaw_rad: float, pitch_rad: float = 0.0, roll_rad: float = 0.0
) -> FloatArray:
    """Return the rotation (3, 3) from the optical frame of a nadir camera to ENU.

    The image top points to where the vehicle's nose points (yaw 0 = east, anticlockwise).
    """
    body = rotation_enu_from_body(yaw_rad, pitch_rad, roll_rad)
    rotation: FloatArray = body @ _BODY_FROM_OPTICAL
    return rotation


def rotation_enu_from_body(yaw_rad: float, pitch_rad: float, roll_rad: float) -> FloatArray:
    """Return Rz(yaw) Ry(pitch) Rx(roll), shape (3, 3)."""
    cy, sy = math.cos(yaw_rad), math.sin(yaw_rad)
    cp, sp = math.cos(pitch_rad), math.sin(pitch_rad)
    cr, sr = math.cos(roll_rad), math.sin(roll_rad)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rotation_body_from_optical(
    pitch_rad: float = -0.5 * math.pi, yaw_rad: float = 0.0
) -> FloatArray:
    """Return the rotation (3, 3) from the optical frame of a camera on a vehicle to its body.

    Parameters
    ----------
    pitch_rad
        Angle of the view above the horizon of a level vehicle: -pi/2 is straight down.
    yaw_rad
        Angle of the view from the nose, anticlockwise. With a view straight down it turns the
        image.
    """
    cy, sy = math.cos(yaw_rad), math.sin(yaw_rad)
    # Straight down the sum is exactly 0, so that the rotation is exactly that of a nadir camera.
    raised = pitch_rad + 0.5 * math.pi
    cr, sr = math.cos(raised), math.sin(raised)
    about_up = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    about_right = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    rotation: FloatArray = about_up @ _BODY_FROM_OPTICAL @ about_right
    return rotation


def ground_homography(
    camera: PinholeCamera,
    position_enu: ArrayLike,
    rotation_enu_from_optical: ArrayLike,
    ground_up_m: float = 0.0,
) -> FloatArray:
    """Return the homography (3, 3) that maps ground (east, north, 1) to (u, v, 1) pixels.

    Its third output before division is the depth in metres: positive in front of the camera.

    Parameters
    ----------
    camera
        The camera.
    position_enu
        Place of the camera's centre, metres, shape (3,).
    rotation_enu_from_optical
        Rotation from the optical frame to ENU, shape (3, 3).
    ground_up_m
        Height of the level ground in the same frame, metres.

    Raises
    ------
    ValueError
        If the camera is not above the ground.
    """
    centre = np.asarray(position_enu, float)
    require_positive('camera height above ground', float(centre[2]) - ground_up_m, 'm')
    rotation = np.asarray(rotation_enu_from_optical, float)
    ground = np.zeros((3, 3))
    ground[0, 0] = ground[1, 1] = 1.0
    ground[:, 2] = np.array([0.0, 0.0, ground_up_m]) - centre
    homography: FloatArray = camera.matrix @ rotation.T @ ground
    return homography


def ground_corners(
    camera: PinholeCamera,
    position_enu: ArrayLike,
    rotation_enu_from_optical: ArrayLike,
    ground_up_m: float = 0.0,
) -> FloatArray:
    """Return (east, north) of the image's outer corners on level ground, metres, shape (4, 2).

    Order: top left, top right, bottom right, bottom left of the image. Arguments as in
    `ground_homography`.

    Raises
    ------
    ValueError
        If the camera is not above the ground, or a corner looks at or above the horizon.
    """
    centre = np.asarray(position_enu, float)
    height = require_positive('camera height above ground', centre[2] - ground_up_m, 'm')
    right, bottom = camera.image_width_px - 0.5, camera.image_height_px - 0.5
    pixels = np.array(
        [[-0.5, -0.5, 1.0], [right, -0.5, 1.0], [right, bottom, 1.0], [-0.5, bottom, 1.0]]
    )
    rotation = np.asarray(rotation_enu_from_optical, float)
    rays = np.linalg.solve(camera.matrix, pixels.T).T @ rotation.T
    if not np.all(rays[:, 2] < 0.0):
        raise ValueError(
            'an image corner looks at or above the horizon: the camera is tilted '
            'too far for its field of view'
        )
    corners: FloatArray = centre[:2] - rays[:, :2] / rays[:, 2:] * height
    return corners


def rotation_of_quaternion(quaternion_xyzw: ArrayLike) -> FloatArray:
    """Return the rotation matrix (3, 3) of a quaternion (x, y, z, w), normalised first.

    Raises
    ------
    ValueError
        If its length is zero or not finite.
    """
    q = np.asarray(quaternion_xyzw, float)
    length = require_positive('quaternion length', float(np.linalg.norm(q)))
    x, y, z, w = q / length
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_of_rotation(rotation: ArrayLike) -> FloatArray:
    """Return the unit quaternion (x, y, z, w), w >= 0, of a rotation matrix; shape (4,).

    It is the eigenvector of the largest eigenvalue of Bar-Itzhack's matrix K (2000), which is
    well conditioned at every angle.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = np.asarray(rotation, float)
    k = np.array(
        [
            [xx - yy - zz, yx + xy, zx + xz, zy - yz],
            [yx + xy, yy - xx - zz, zy + yz, xz - zx],
            [zx + xz, zy + yz, zz - xx - yy, yx - xy],
            [zy - yz, xz - zx, yx - xy, xx + yy + zz],
        ]
    )
    quaternion: FloatArray = np.linalg.eigh(k)[1][:, -1]
    return -quaternion if quaternion[3] < 0.0 else quaternion
