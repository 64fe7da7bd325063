# SPDX-License-Identifier: Apache-2.0
"""Simpler meshes for large distances, by clustering of vertices.

Source: Rossignac and Borrel, Multi-resolution 3D approximations for rendering complex scenes
(1993).
"""

import numpy as np

from rocsafe_scene.mesh.mesh import Floats, Mesh, unit


def clustered(mesh: Mesh, cell_m: float) -> Mesh:
    """Return `mesh` with one corner in each cube of `cell_m`, at the mean of those in the cube.

    Colours, normals and places of a corner are those of the corners of the same surface that
    faced the same way, so that edges stay edges; no gap opens.
    """
    cell = _ranks(np.floor(mesh.points / cell_m).astype(np.int64))
    side = np.argmax(np.abs(mesh.normals), axis=1)
    side = 2 * side + (np.take_along_axis(mesh.normals, side[:, None], 1)[:, 0] > 0.0)
    corner = _ranks(np.column_stack([cell, side, mesh.colours[:, 3]]))
    first = np.zeros(corner.max() + 1, np.intp)
    first[corner] = np.arange(len(corner))
    colours = _means(mesh.colours.astype(float), corner)
    colours[:, 3] = mesh.colours[first, 3]
    triangles = mesh.triangles[_is_open(cell[mesh.triangles])]
    return Mesh(
        points=_means(mesh.points, cell)[cell[first]].astype(mesh.points.dtype),
        normals=unit(_means(mesh.normals, corner)).astype(mesh.normals.dtype),
        places=mesh.places[first],
        colours=np.rint(colours).astype(np.uint8),
        triangles=_single(corner[triangles]).astype(np.int32),
    )


def _ranks(keys: Floats) -> Floats:
    """Return the number of each row (n, k) of whole numbers among the different rows."""
    return np.unique(_joint(keys), return_inverse=True)[1].reshape(-1)


def _joint(keys: Floats) -> Floats:
    """Return one number for each row (n, k) of whole numbers, different for different rows."""
    low = keys.min(axis=0)
    found = np.zeros(len(keys), np.int64)
    for column, span in zip((keys - low).T, (keys.max(axis=0) - low + 1).tolist(), strict=True):
        found = found * int(span) + column
    return found


def _means(values: Floats, group: Floats) -> Floats:
    """Return the mean of `values` (n, k) of each group."""
    counts = np.bincount(group)
    sums = [np.bincount(group, values[:, k]) for k in range(values.shape[1])]
    return np.asarray(np.stack(sums, axis=1) / counts[:, None])


def _is_open(triangles: Floats) -> Floats:
    """Return whether the three corners (n, 3) of each triangle differ."""
    a, b, c = triangles.T
    return np.asarray((a != b) & (b != c) & (c != a))


def _single(triangles: Floats) -> Floats:
    """Return triangles (n, 3) without duplicates."""
    if not len(triangles):
        return triangles
    turn = np.argmin(triangles, axis=1)
    rolled = np.take_along_axis(triangles, (turn[:, None] + np.arange(3)) % 3, axis=1)
    return triangles[np.sort(np.unique(_joint(rolled), return_index=True)[1])]
