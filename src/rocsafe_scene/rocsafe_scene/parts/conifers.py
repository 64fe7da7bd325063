# SPDX-License-Identifier: Apache-2.0
"""Conifers: needles on boughs in a cone, without a closed surface."""

import math
from dataclasses import replace

import numpy as np

from rocsafe_scene.mesh.mesh import Floats, Mesh
from rocsafe_scene.parts.crowns import Blob
from rocsafe_scene.parts.leaves import Species, filled, leaves


def cone(rng: np.random.Generator, height: float, radius: float, kind: Species) -> list[Blob]:
    """Return the boughs of a conifer of `height` and `radius`, layer by layer."""
    blobs = []
    # Layers are as high as their distance, so that the crown is closed up to its tip.
    least_up = 0.62 * (0.94 - kind.crown_from) * height / 8.0
    for layer in range(9):
        share = layer / 8.0
        girth = 0.75 * radius * (1.0 - share) + 0.12 * radius
        z = kind.crown_from * height + share * (0.94 - kind.crown_from) * height
        for k in range(max(1, round(6 * (1.0 - share)))):
            angle = rng.uniform(0.0, 2.0 * math.pi) + k
            reach = 0.62 * girth
            centre = np.array([reach * math.cos(angle), reach * math.sin(angle), z])
            radii = np.array([0.62 * girth, 0.62 * girth, max(0.45 * girth, least_up)])
            blobs.append(Blob(centre=centre, radii=radii))
    return blobs


def needles(
    rng: np.random.Generator, height: float, radius: float, kind: Species,
    boughs: tuple[list[Blob], float],
) -> Mesh:  # fmt: skip
    """Return the needles on boughs, at a density of leaves."""
    blobs, density = boughs
    # Fewer leaves are drawn larger, so that the crown stays closed.
    size = 1.0 / math.sqrt(density)
    areas = np.array([float(blob.radii[0] * blob.radii[2]) for blob in blobs])
    counts = np.maximum(4, density * 150.0 * areas * (0.34 / kind.leaf_m) ** 2).astype(int)
    grown = [filled(blob, n, rng) for blob, n in zip(blobs, counts.tolist(), strict=True)]
    centres = np.concatenate([places for places, _ in grown])
    outward = np.concatenate([directions for _, directions in grown])
    middle = np.array([0.0, 0.0, (0.5 + 0.5 * kind.crown_from) * height])
    away = centres - middle
    inside = np.linalg.norm(away / [radius, radius, 0.5 * height], axis=1, keepdims=True)
    outward = outward * np.clip(0.35 + 0.75 * inside, 0.3, 1.0)
    return _toned(leaves(centres, outward, kind, rng, size), counts, rng)


def _toned(crown: Mesh, counts: Floats, rng: np.random.Generator) -> Mesh:
    """Return `crown` with a brightness of its own for each blob, as branches differ."""
    tones = rng.uniform(0.72, 1.28, len(counts))[:, None] + rng.normal(0.0, 0.07, (len(counts), 3))
    leaf_tones = np.repeat(np.repeat(tones, counts, axis=0), 4, axis=0)
    colours = crown.colours.copy()
    colours[:, :3] = np.clip(colours[:, :3] * leaf_tones, 6, 250)
    return replace(crown, colours=colours)
