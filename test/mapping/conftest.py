# SPDX-License-Identifier: Apache-2.0
"""Photographs for the tests of mapping."""

import dataclasses
import hashlib
import math
from collections.abc import Callable

import cv2
import numpy as np
import pytest

from rocsafe_geo.pinhole import quaternion_of_rotation, rotation_enu_from_optical
from rocsafe_mapping.photographs.shot import Intrinsics, ShotRecord

WIDTH_PX, HEIGHT_PX = 64, 48
Shot = tuple[ShotRecord, bytes]


def jpeg_of(pixels: np.ndarray) -> bytes:
    """Return BGR `pixels` as a JPEG file."""
    encoded, data = cv2.imencode('.jpg', pixels, [cv2.IMWRITE_JPEG_QUALITY, 95])
    assert encoded
    return bytes(data)


def plain_shot(number: int = 0, image: bytes | None = None, **changes: object) -> Shot:
    """Return a photograph taken 32 m above Galway; `changes` to its record are made last."""
    if image is None:
        pixels = np.random.default_rng(number).integers(0, 256, (HEIGHT_PX, WIDTH_PX, 3))
        image = jpeg_of(pixels.astype(np.uint8))
    camera = Intrinsics(
        width_px=WIDTH_PX, height_px=HEIGHT_PX, fx_px=55.0, fy_px=55.0, cx_px=31.5, cy_px=23.5
    )
    record = ShotRecord(
        shot_id=f'rav1-{number:05d}',
        vehicle='rav1',
        sequence=number,
        viewpoint_id=number + 7,
        time_ns=1_700_000_000_123_456_789 + number * 10**9,
        latitude_deg=53.2838,
        longitude_deg=-9.0633,
        altitude_m=92.5,
        position_covariance_m2=(2.25, 0.0, 0.0, 0.0, 2.25, 0.0, 0.0, 0.0, 4.0),
        height_agl_m=32.5,
        orientation_xyzw=tuple(
            quaternion_of_rotation(rotation_enu_from_optical(math.radians(30.0))).tolist()
        ),
        orientation_covariance_rad2=(0.0,) * 9,
        camera=camera,
        sha256=hashlib.sha256(image).hexdigest(),
    )
    return dataclasses.replace(record, **changes), image


@pytest.fixture(scope='session')
def shot() -> Callable[..., Shot]:
    """Return the maker of photographs, see `plain_shot`."""
    return plain_shot
