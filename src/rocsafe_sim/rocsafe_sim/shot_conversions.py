# SPDX-License-Identifier: Apache-2.0
"""Photographs and what is true of them -> image messages."""

from array import array
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import Image

from rocsafe_geo.shot import Shot
from rocsafe_ros.conversions import shot_header
from rocsafe_sim.camera import Truth, image_of


def raw_image_message(shot: Shot) -> Image:
    """Return the picture itself, 8 bits blue, green, red."""
    pixels = image_of(shot.jpeg)
    height, width, _ = pixels.shape
    message = Image(
        header=shot_header(shot), height=height, width=width, encoding='bgr8', step=3 * width
    )
    message.data = array('B', pixels.tobytes())
    return message


def depth_message(shot: Shot, truth: Truth) -> Image:
    """Return planar depth, metres, 32 bit floats; infinite where the sky is (REP 118)."""
    return _plane_message(shot, truth.depth_m.astype('<f4'), '32FC1')


def labels_message(shot: Shot, truth: Truth) -> Image:
    """Return instance numbers, 16 bits; those beyond 65535 show as 65535."""
    return _plane_message(shot, np.minimum(truth.numbers, 65_535).astype('<u2'), 'mono16')


def _plane_message(shot: Shot, plane: NDArray[Any], encoding: str) -> Image:
    height, width = plane.shape
    step = plane.itemsize * width
    message = Image(
        header=shot_header(shot), height=height, width=width, encoding=encoding, step=step
    )
    message.data = array('B', plane.tobytes())
    return message
