# SPDX-License-Identifier: Apache-2.0
"""A textured ground and photographs of it with exact poses, for tests of the alignment."""

import hashlib
import math
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import (
    PinholeCamera,
    ground_homography,
    quaternion_of_rotation,
    rotation_enu_from_optical,
)
from rocsafe_geo.position import GeoPosition
from rocsafe_mapping.photographs.shot import Intrinsics, ShotRecord

CAMERA = PinholeCamera(math.radians(60.0), 400, 300)
HEIGHT_M = 32.0
GROUND_SIDE_M, GROUND_PX_PER_M = 160.0, 8.0
FRAME = LocalFrame(GeoPosition(53.28, -9.06, 60.0))


@dataclass(frozen=True)
class Photographed:
    """A photograph with its truth."""

    record: ShotRecord
    jpeg: bytes
    centre: np.ndarray
    rotation: np.ndarray


@lru_cache(maxsize=4)
def textured_ground(seed: int) -> np.ndarray:
    """Return a ground picture, west to east and north to south about the origin."""
    rng = np.random.default_rng(seed)
    side = int(GROUND_SIDE_M * GROUND_PX_PER_M)
    ground = np.zeros((side, side, 3), np.float32)
    for cells in (8, 40, 160, 480):
        rough = rng.normal(0.0, 1.0, (cells, cells, 3)).astype(np.float32)
        ground += cv2.resize(rough, (side, side), interpolation=cv2.INTER_CUBIC)
    ground += rng.normal(0.0, 0.5, ground.shape)
    return np.clip(120.0 + 30.0 * ground, 0, 255).astype(np.uint8)


def photograph(ground, number, east, north, *, rng, yaw=0.0, vehicle='rav1', **noise):
    """Return a photograph from about (east, north) with a noisy record.

    `noise`: fix_m, tilt_rad, told_yaw (what the record says), gain.
    """
    tilt_rad = noise.get('tilt_rad', 0.02)
    pitch, roll = rng.normal(0.0, tilt_rad, 2)
    rotation = rotation_enu_from_optical(yaw, pitch, roll)
    centre = np.array([east, north, HEIGHT_M])
    picture = seen(ground, centre, rotation)
    picture = np.clip(picture * noise.get('gain', 1.0), 0, 255).astype(np.uint8)
    jpeg = bytes(cv2.imencode('.jpg', picture, [cv2.IMWRITE_JPEG_QUALITY, 92])[1])
    fix_m = noise.get('fix_m', 1.0)
    told = centre + np.array([*rng.normal(0.0, fix_m, 2), rng.normal(0.0, 0.2)])
    told += noise.get('fix_off', np.zeros(3))
    level = rotation_enu_from_optical(noise.get('told_yaw', yaw))
    return Photographed(
        record=record_of(number, told, level, fix_m, tilt_rad, jpeg, vehicle),
        jpeg=jpeg,
        centre=centre,
        rotation=rotation,
    )


def seen(ground, centre, rotation) -> np.ndarray:
    """Return what the camera sees of `ground`."""
    homography = ground_homography(CAMERA, centre, rotation)
    to_ground = np.array(
        [
            [1.0 / GROUND_PX_PER_M, 0.0, -GROUND_SIDE_M / 2],
            [0.0, -1.0 / GROUND_PX_PER_M, GROUND_SIDE_M / 2],
            [0.0, 0.0, 1.0],
        ]
    )
    size = (CAMERA.image_width_px, CAMERA.image_height_px)
    return cv2.warpPerspective(ground, homography @ to_ground, size, flags=cv2.INTER_AREA)


def record_of(number, told, rotation, fix_m, tilt_rad, jpeg, vehicle) -> ShotRecord:
    """Return a record as a vehicle would send it."""
    place = FRAME.position_of(told)
    variance = max(fix_m, 0.02) ** 2
    turn = max(tilt_rad, 1e-3) ** 2
    return ShotRecord(
        shot_id=f'{vehicle}-{number:05d}',
        vehicle=vehicle,
        sequence=number,
        viewpoint_id=number,
        time_ns=number * 10**9,
        latitude_deg=place.latitude_deg,
        longitude_deg=place.longitude_deg,
        altitude_m=place.altitude_m,
        position_covariance_m2=(variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, 0.04),
        height_agl_m=float(told[2]),
        orientation_xyzw=tuple(quaternion_of_rotation(rotation).tolist()),
        orientation_covariance_rad2=(turn, 0.0, 0.0, 0.0, turn, 0.0, 0.0, 0.0, turn),
        camera=Intrinsics.of_pinhole(CAMERA),
        sha256=hashlib.sha256(jpeg).hexdigest(),
    )


def flight(seed=1, *, rows=2, columns=3, spacing_m=(22.0, 17.0), **noise):
    """Return photographs of a grid of viewpoints, flown to and fro."""
    rng = np.random.default_rng(seed)
    ground = textured_ground(seed)
    shots = []
    for row in range(rows):
        for step in range(columns):
            column = step if row % 2 == 0 else columns - 1 - step
            east = (column - (columns - 1) / 2) * spacing_m[1]
            north = ((rows - 1) / 2 - row) * spacing_m[0]
            shots.append(photograph(ground, len(shots), east, north, rng=rng, **noise))
    return shots
