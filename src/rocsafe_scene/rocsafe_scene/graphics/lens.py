# SPDX-License-Identifier: Apache-2.0
"""Pinhole cameras and their poses in Panda3D's terms."""

from typing import Any

import numpy as np
from panda3d import core

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.mesh.mesh import Floats

# Nothing nearer or farther than these is drawn, metres.
NEAR_M, FAR_M = 0.4, 9000.0


def pinhole_lens(camera: PinholeCamera) -> Any:
    """Return a lens with the exact intrinsics of `camera`.

    Film sizes are tangents. Integer pixel coordinates are pixel centres, so the image spans -0.5
    to size - 0.5.
    """
    matrix = camera.matrix
    width, height = camera.image_width_px, camera.image_height_px
    fx, fy = float(matrix[0, 0]), float(matrix[1, 1])
    cx, cy = float(matrix[0, 2]) + 0.5, float(matrix[1, 2]) + 0.5
    lens = core.PerspectiveLens()
    lens.setFocalLength(1.0)
    lens.setFilmSize(width / fx, height / fy)
    lens.setFilmOffset((0.5 * width - cx) / fx, -(0.5 * height - cy) / fy)
    lens.setNearFar(NEAR_M, FAR_M)
    return lens


def flat_lens(width_m: float, height_m: float, depth_m: float) -> Any:
    """Return a lens without perspective (parallel projection)."""
    lens = core.OrthographicLens()
    lens.setFilmSize(width_m, height_m)
    lens.setNearFar(0.0, depth_m)
    return lens


def node_matrix(position_enu: Floats, rotation_enu_from_optical: Floats) -> Any:
    """Return the matrix of a camera node (x right, y ahead, z up; row vectors)."""
    right, down, ahead = np.asarray(rotation_enu_from_optical, float).T
    rows = [*right, 0.0, *ahead, 0.0, *(-down), 0.0, *np.asarray(position_enu, float), 1.0]
    return core.LMatrix4f(*(float(value) for value in rows))


def looking(direction: Floats) -> Floats:
    """Return a rotation (3, 3), columns right, down, ahead, that looks in `direction`."""
    ahead = np.asarray(direction, float) / np.linalg.norm(direction)
    guide = np.array([0.0, 0.0, 1.0]) if abs(ahead[2]) < 0.99 else np.array([0.0, 1.0, 0.0])
    right = np.cross(ahead, guide)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(ahead, right), ahead])
