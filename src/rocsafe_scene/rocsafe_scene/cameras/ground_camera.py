# SPDX-License-Identifier: Apache-2.0
"""A pinhole camera over flat ground."""

import struct
from dataclasses import dataclass, replace

import cv2
import numpy as np

from rocsafe_geo.arrays import FloatArray, ImageArray
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.pinhole import PinholeCamera, ground_corners, ground_homography
from rocsafe_scene.cameras.camera import Truth
from rocsafe_scene.errors import GroundError
from rocsafe_scene.ground.ground_patch import Ground, GroundBounds
from rocsafe_scene.scene.moving_sun import LightOrder

# Interpolation reads one texel beyond; one more for rounding.
_MARGIN_TEXELS = 2.0
_COMMENT = b'\xff\xfe'


@dataclass(frozen=True, slots=True)
class GroundCamera:
    """A pinhole camera `lens` over `ground`, which is the plane up = 0."""

    lens: PinholeCamera
    ground: Ground

    @property
    def truth(self) -> Truth | None:
        """None: flat ground has neither depth nor labels."""
        return None

    @property
    def remark(self) -> str:
        """Empty."""
        return ''

    def label_table(self) -> str:
        """Return an empty text: there are no labels."""
        return ''

    def set_light(self, order: LightOrder) -> None:  # noqa: ARG002 - there is none to change
        """Refuse: the ground is a photograph."""
        raise GroundError('the flat ground is a photograph: its light cannot be changed')

    def through(self, lens: PinholeCamera) -> 'GroundCamera':
        """Return a camera over the same ground with another lens."""
        return replace(self, lens=lens)

    def close(self) -> None:
        """Release nothing."""

    def photograph(
        self,
        position_enu: Enu,
        rotation_enu_from_optical: FloatArray,
        time_ns: int = 0,  # noqa: ARG002 - nothing moves in a picture
        *,
        is_quick: bool = False,  # noqa: ARG002 - it always is
    ) -> ImageArray:
        """Return the image seen from a pose: blue, green, red; shape (height, width, 3).

        The ground is sampled with texels no wider than the image's pixels below the camera, so
        that neither detail is lost nor fine texture aliased.

        Raises
        ------
        GroundError
            If the camera would see the horizon, or there is no ground image there.
        """
        try:
            corners = ground_corners(self.lens, position_enu, rotation_enu_from_optical)
        except ValueError as error:
            raise GroundError(f'camera at {position_enu}: {error}') from error
        resolution_m = position_enu[2] / self.lens.focal_px
        patch = self.ground.patch(_around(corners, resolution_m), resolution_m)
        homography = ground_homography(self.lens, position_enu, rotation_enu_from_optical)
        size = (self.lens.image_width_px, self.lens.image_height_px)
        return cv2.warpPerspective(
            patch.image,
            homography @ np.linalg.inv(patch.pixel_from_ground),
            size,
            flags=cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )


def _around(corners: FloatArray, resolution_m: float) -> GroundBounds:
    margin = _MARGIN_TEXELS * resolution_m
    west, south = (corners.min(axis=0) - margin).tolist()
    east, north = (corners.max(axis=0) + margin).tolist()
    return GroundBounds(west_m=west, south_m=south, east_m=east, north_m=north)


def jpeg_of(image: ImageArray, quality: int, remark: str = '') -> bytes:
    """Return `image` (blue, green, red) as a JPEG file of `quality` 1 to 100.

    A `remark` becomes a comment in the file, which the image store keeps.
    """
    is_done, data = cv2.imencode('.jpg', image, [cv2.IMWRITE_JPEG_QUALITY, quality])
    if not is_done:
        raise GroundError(f'no JPEG of an image of shape {image.shape}')
    jpeg: bytes = data.tobytes()
    if not remark:
        return jpeg
    text = remark.encode()
    return jpeg[:2] + _COMMENT + struct.pack('>H', len(text) + 2) + text + jpeg[2:]
