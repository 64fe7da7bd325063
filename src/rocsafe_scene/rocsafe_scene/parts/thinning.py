# SPDX-License-Identifier: Apache-2.0
"""Simpler plants for large distances: fewer, larger leaves, or none on crowns of trees."""

import math

import numpy as np

from rocsafe_scene.mesh.coarse import clustered
from rocsafe_scene.mesh.mesh import Floats, Mesh, joined
from rocsafe_scene.mesh.surfaces import Surface
from rocsafe_scene.parts.plants import BLADES, POINTS_OF_BLADE

# Classes of objects that `coarser` can thin.
LEAFY = frozenset({'tree', 'hedge', 'shrub'})
# One of so many leaves is drawn; other triangles keep one corner in each cube of this size,
# metres.
_STEPS = ((4, 0.45), (16, 0.8), (64, 1.2))
# Leaves larger than this factor would look like spikes on a crown.
_MOST_ON_SKIN = 4


def coarser(mesh: Mesh) -> list[Mesh]:
    """Return a plant and thinned versions for larger distances: fewer, larger leaves."""
    return [mesh, *(_thinned(mesh, step, cell_m) for step, cell_m in _STEPS)]


def sparser(tufts: Mesh) -> Mesh:
    """Return long grass with half its tufts."""
    tuft = BLADES * POINTS_OF_BLADE
    keep = np.arange(len(tufts.points)) // tuft % 2 == 0
    return _part(tufts, keep)


def _thinned(mesh: Mesh, step: int, cell_m: float) -> Mesh:
    """Return a plant with one of `step` leaves, each a triangle as large as those it replaces."""
    rest = mesh.colours[:, 3] != Surface.LEAF
    if step > _MOST_ON_SKIN and np.any(mesh.colours[:, 3] == Surface.CROWN):
        return clustered(_part(mesh, rest), cell_m)
    leaf = np.flatnonzero(mesh.colours[:, 3] == Surface.LEAF).reshape(-1, 4)[::step]
    stem, right, tip, left = np.moveaxis(mesh.points[leaf], 1, 0)
    back = stem - 0.5 * (left + right)
    points = np.stack([right + back, tip, left + back], axis=1)
    middle = points.mean(axis=1, keepdims=True)
    # A little less than the sum of their areas, as leaves overlap.
    grown = middle + (points - middle) * (0.88 * math.sqrt(step))
    triangles = np.arange(3 * len(leaf)).reshape(-1, 3)
    crown = _selected(mesh, leaf[:, 1:].ravel(), triangles, grown.reshape(-1, 3))
    return joined([crown, clustered(_part(mesh, rest), cell_m)]) if rest.any() else crown


def _selected(mesh: Mesh, chosen: Floats, triangles: Floats, points: Floats) -> Mesh:
    return Mesh(
        points=points,
        normals=mesh.normals[chosen],
        places=mesh.places[chosen],
        colours=mesh.colours[chosen],
        triangles=triangles.astype(np.int32),
    )


def _part(mesh: Mesh, keep: Floats) -> Mesh:
    """Return the triangles of `mesh` whose corners are all in `keep`."""
    chosen = np.flatnonzero(keep)
    new = np.cumsum(keep) - 1
    triangles = new[mesh.triangles[keep[mesh.triangles].all(axis=1)]]
    return _selected(mesh, chosen, triangles, mesh.points[chosen])
