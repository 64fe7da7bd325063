# SPDX-License-Identifier: Apache-2.0
"""A ground with round marks at known places, and photographs of it from geometry alone."""

import dataclasses
import hashlib
import math
from dataclasses import dataclass

import cv2
import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import (
    PinholeCamera,
    ground_homography,
    quaternion_of_rotation,
    rotation_enu_from_optical,
)
from rocsafe_mapping.photographs.shot import Intrinsics, ShotRecord

CAMERA = PinholeCamera(math.radians(60.0), 320, 240)
HEIGHT_M = 32.0
MARK_SIGMA_M = 0.35
MARK_LEVEL, GROUND_LEVEL = 150.0, 60.0


@dataclass(frozen=True)
class Ground:
    """Level ground about a mission's origin, with marks at (east, north) in metres."""

    frame: LocalFrame
    marks: tuple[tuple[float, float], ...]

    def brightness(self, easts: np.ndarray, norths: np.ndarray) -> np.ndarray:
        """Return the grey level of ground points."""
        level = np.full(easts.shape, GROUND_LEVEL)
        for east, north in self.marks:
            square = (easts - east) ** 2 + (norths - north) ** 2
            level += MARK_LEVEL * np.exp(-0.5 * square / MARK_SIGMA_M**2)
        return level

    def photograph(self, number, east, north, *, yaw=0.0, pitch=0.0, roll=0.0, camera=CAMERA):
        """Return the record and JPEG file of a photograph; angles in radians."""
        rotation = rotation_enu_from_optical(yaw, pitch, roll)
        position = np.array([east, north, HEIGHT_M])
        homography = ground_homography(camera, position, rotation)
        rows, columns = np.mgrid[: camera.image_height_px, : camera.image_width_px]
        pixels = np.stack([columns.ravel(), rows.ravel(), np.ones(rows.size)])
        points = np.linalg.solve(homography, pixels)
        levels = self.brightness(*(points[:2] / points[2])).reshape(rows.shape)
        grey = np.clip(np.rint(levels), 0, 255).astype(np.uint8)
        _, data = cv2.imencode('.jpg', grey, [cv2.IMWRITE_JPEG_QUALITY, 98])
        return self.record(number, position, rotation, bytes(data), camera), bytes(data)

    def distorted_photograph(self, lens, camera=CAMERA) -> bytes:
        """Return the JPEG file of a level photograph above the origin through a distorting lens.

        `lens` holds k1, k2, p1, p2, k3 of Brown's model; only k1 may differ from 0.
        """
        rows, columns = np.mgrid[: camera.image_height_px, : camera.image_width_px]
        x = (columns - camera.matrix[0, 2]) / camera.focal_px
        y = (rows - camera.matrix[1, 2]) / camera.focal_px
        distorted = np.hypot(x, y)
        radius = distorted.copy()
        # Solve r (1 + k1 r^2) = distorted for r by Newton's method.
        for _ in range(20):
            excess = radius * (1.0 + lens[0] * radius**2) - distorted
            radius -= excess / (1.0 + 3.0 * lens[0] * radius**2)
        scale = np.divide(radius, distorted, out=np.ones_like(radius), where=distorted > 0.0)
        # Yaw 0: the image top points east, its right side south.
        levels = self.brightness(-y * scale * HEIGHT_M, -x * scale * HEIGHT_M)
        grey = np.clip(np.rint(levels), 0, 255).astype(np.uint8)
        return bytes(cv2.imencode('.jpg', grey, [cv2.IMWRITE_JPEG_QUALITY, 98])[1])

    def record(self, number, position, rotation, jpeg, camera=CAMERA) -> ShotRecord:
        """Return the record of a photograph taken at `position`, ENU metres."""
        place = self.frame.position_of(position)
        return ShotRecord(
            shot_id=f'rav1-{number:05d}',
            vehicle='rav1',
            sequence=number,
            viewpoint_id=number,
            time_ns=number * 10**9,
            latitude_deg=place.latitude_deg,
            longitude_deg=place.longitude_deg,
            altitude_m=place.altitude_m,
            position_covariance_m2=(0.0,) * 9,
            height_agl_m=float(position[2]),
            orientation_xyzw=tuple(quaternion_of_rotation(rotation).tolist()),
            orientation_covariance_rad2=(0.0,) * 9,
            camera=Intrinsics.of_pinhole(camera),
            sha256=hashlib.sha256(jpeg).hexdigest(),
        )

    def geodetic(self, east, north) -> tuple[float, float]:
        """Return (latitude, longitude) in degrees of a ground point."""
        latitude, longitude, _ = self.frame.to_geodetic([east, north, 0.0])[0]
        return latitude, longitude


def plain_photograph(ground, number, east, north, grey=128, camera=CAMERA, **angles):
    """Return a photograph of one grey level."""
    pixels = np.full((camera.image_height_px, camera.image_width_px), grey, np.uint8)
    _, data = cv2.imencode('.jpg', pixels)
    turns = [angles.get(name, 0.0) for name in ('yaw', 'pitch', 'roll')]
    position = np.array([east, north, HEIGHT_M])
    rotation = rotation_enu_from_optical(*turns)
    record = ground.record(number, position, rotation, bytes(data), camera)
    return record, bytes(data)


def lens_changed(record: ShotRecord, **changes) -> ShotRecord:
    """Return `record` with another camera."""
    return dataclasses.replace(record, camera=dataclasses.replace(record.camera, **changes))
