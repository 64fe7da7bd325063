# SPDX-License-Identifier: Apache-2.0
"""A scene laid level: its ground is the plane of most of its points, below all cameras."""

from dataclasses import replace

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.model.photo import PLACEHOLDER_HEIGHT_M
from rocsafe_mapping.alignment.structure.bundle import Scene
from rocsafe_mapping.alignment_options import StructureOptions


def levelled(scene: Scene, options: StructureOptions) -> Scene | None:
    """Return the scene with its ground at up = 0, and the median camera 100 above it.

    None if no plane lies below all cameras.
    """
    plane = _ground(scene, options)
    if plane is None:
        return None
    up, offset = plane
    east = np.cross([0.0, 1.0, 0.0] if abs(up[1]) < 0.9 else [1.0, 0.0, 0.0], up)
    east /= np.linalg.norm(east)
    turn = np.array([east, np.cross(up, east), up])
    lift = np.array([0.0, 0.0, offset])
    centres = scene.centres @ turn.T - lift
    scale = PLACEHOLDER_HEIGHT_M / float(np.median(centres[:, 2]))
    return replace(
        scene,
        centres=scale * centres,
        rotations=turn @ scene.rotations,
        points=scale * (scene.points @ turn.T - lift),
    )


def _ground(scene: Scene, options: StructureOptions) -> tuple[FloatArray, float] | None:
    """Return the unit normal of the ground, upwards, and its distance from the origin."""
    rng = np.random.default_rng(0)
    points, best, most = scene.points, None, 0
    for _ in range(options.plane_trials):
        chosen = points[rng.choice(len(points), 3, replace=False)]
        normal = np.cross(chosen[1] - chosen[0], chosen[2] - chosen[0])
        size = float(np.linalg.norm(normal))
        if size < 1e-12:
            continue
        normal = normal / size
        heights = scene.centres @ normal - chosen[0] @ normal
        if np.median(heights) < 0.0:
            normal, heights = -normal, -heights
        if heights.min() <= 0.0:
            continue
        off = np.abs(points @ normal - chosen[0] @ normal)
        near = off < options.plane_share * float(np.median(heights))
        if near.sum() > most:
            most, best = int(near.sum()), near
    if best is None:
        return None
    middle = points[best].mean(axis=0)
    normal = np.linalg.svd(points[best] - middle, full_matrices=False)[2][2]
    if np.median(scene.centres @ normal) < middle @ normal:
        normal = -normal
    return normal, float(middle @ normal)
