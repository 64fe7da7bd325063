# SPDX-License-Identifier: Apache-2.0
"""Small rotations, and how one pose is turned from another."""

import math

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.model.photo import Pose


def tilt_and_yaw(pose: Pose, prior: Pose) -> tuple[FloatArray, float]:
    """Return how far `pose` is tilted (about east and north) and turned from `prior`, radians.

    The yaw is taken out before the tilt is measured: a wrong yaw does not change the tilt.
    """
    change = pose.rotation @ prior.rotation.T
    yaw = math.atan2(change[1, 0] - change[0, 1], change[0, 0] + change[1, 1])
    rest = change @ turned(np.array([0.0, 0.0, -yaw]))
    # For small tilts the rotation vector is half the antisymmetric part.
    tilt = 0.5 * np.array([rest[2, 1] - rest[1, 2], rest[0, 2] - rest[2, 0]])
    return tilt, yaw


def turned(vector: FloatArray) -> FloatArray:
    """Return the rotation (3, 3) by a rotation vector (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    if angle < 1e-9:
        return np.eye(3) + cross
    matrix: FloatArray = (
        np.eye(3)
        + math.sin(angle) / angle * cross
        + (1.0 - math.cos(angle)) / angle**2 * (cross @ cross)
    )
    return matrix
