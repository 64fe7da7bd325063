# SPDX-License-Identifier: Apache-2.0
"""Simple solids from which objects are assembled.

Corners run anticlockwise seen from outside, normals are smooth where the solid is round, and
surface coordinates are metres.
"""

import itertools
import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from rocsafe_scene.mesh.mesh import Floats, Mesh, joined, made, unit

# The corner indices of a box: bit 0 is +x, bit 1 +y, bit 2 +z.
_SIGNS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))[:, ::-1]
_FACES = tuple((axis, sign) for axis in range(3) for sign in (-1.0, 1.0))


def box(length: float, width: float, height: float, bevel: float = 0.02) -> Mesh:
    """Return a box with chamfered edges, centred on x = y = 0, that stands on z = 0.

    Each corner has one vertex a face; strips between the faces share them, so that light runs
    smoothly over the edges.
    """
    half = 0.5 * np.array([length, width, height])
    inset = min(bevel, 0.49 * float(half.min()) * 2.0)
    points, normals, places = [], [], []
    for axis, sign in _FACES:
        corners = _SIGNS * (half - inset)
        corners[:, axis] = _SIGNS[:, axis] * half[axis]
        chosen = corners[_SIGNS[:, axis] == sign]
        normal = np.zeros(3)
        normal[axis] = sign
        points.append(chosen)
        normals.append(np.tile(normal, (4, 1)))
        places.append(np.delete(chosen, axis, axis=1))
    stacked = np.concatenate(points)
    triangles = _box_triangles()
    stacked = stacked + np.array([0.0, 0.0, half[2]])
    return made(stacked, np.concatenate(normals), np.concatenate(places), triangles)


@lru_cache(maxsize=1)
def _box_triangles() -> Floats:
    """Return triangles of faces, edges and corners over 6 x 4 vertices, the same for all boxes."""
    points = [
        _SIGNS[_SIGNS[:, axis] == sign] * np.where(np.arange(3) == axis, 1.0, 0.9)
        for axis, sign in _FACES
    ]
    vertex = {}
    for face, (axis, sign) in enumerate(_FACES):
        for place, corner in enumerate(np.flatnonzero(_SIGNS[:, axis] == sign).tolist()):
            vertex[face, corner] = 4 * face + place
    found = []
    for face in range(6):
        a, b, c, d = (4 * face + number for number in range(4))
        found += [(a, b, c), (b, d, c)]
    for one, two in itertools.combinations(range(6), 2):
        if one // 2 == two // 2:
            continue
        shared = sorted({c for f, c in vertex if f == one} & {c for f, c in vertex if f == two})
        a, b = (vertex[one, corner] for corner in shared)
        c, d = (vertex[two, corner] for corner in shared)
        found += [(a, b, c), (b, d, c)]
    for corner in range(8):
        faces = [face for face in range(6) if (face, corner) in vertex]
        a, b, c = (vertex[face, corner] for face in faces)
        found.append((a, b, c))
    return _outward(np.concatenate(points), found)


def _outward(points: Floats, triangles: list[tuple[int, int, int]]) -> Floats:
    """Return `triangles` of a solid about the origin, all anticlockwise from outside."""
    corners = np.array(triangles)
    a, b, c = (points[corners[:, k]] for k in range(3))
    is_inward = np.einsum('ij,ij->i', np.cross(b - a, c - a), a + b + c) < 0.0
    corners[is_inward] = corners[is_inward][:, ::-1]
    return corners


def lathe(profile: ArrayLike, segments: int = 24) -> Mesh:
    """Return the solid of revolution of a profile about the x axis.

    Parameters
    ----------
    profile
        x and radius of its points, (k, 2), x rising; a point given twice makes a sharp edge.
    segments
        Number of segments around the axis.
    """
    line = np.asarray(profile, float)
    normals_2d = _profile_normals(line)
    turn = np.linspace(0.0, 2.0 * math.pi, segments + 1)
    circle = np.column_stack([np.zeros(segments + 1), np.cos(turn), np.sin(turn)])
    along = np.array([1.0, 0.0, 0.0])
    points = line[:, None, :1] * along + line[:, None, 1:] * circle
    normals = normals_2d[:, None, :1] * along + normals_2d[:, None, 1:] * circle
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    places = np.stack(np.broadcast_arrays(length[:, None], turn[None] * line[:, 1].max()), axis=-1)
    keep = np.linalg.norm(np.diff(line, axis=0), axis=1) > 0.0
    triangles = _grid_triangles(len(line), segments + 1, keep)[:, ::-1]
    return made(points.reshape(-1, 3), normals.reshape(-1, 3), places.reshape(-1, 2), triangles)


def _profile_normals(line: Floats) -> Floats:
    steps = np.diff(line, axis=0)
    across = unit(np.column_stack([-steps[:, 1], steps[:, 0]]))
    summed = np.zeros_like(line)
    summed[:-1] += across
    summed[1:] += across
    return unit(summed)


def _grid_triangles(rows: int, columns: int, keep: Floats | None = None) -> Floats:
    """Return triangles over a grid of vertices, only of the rows of cells in `keep`."""
    row, column = np.meshgrid(np.arange(rows - 1), np.arange(columns - 1), indexing='ij')
    if keep is not None:
        row, column = row[keep], column[keep]
    a = (row * columns + column).ravel()
    b, c, d = a + 1, a + columns, a + columns + 1
    return np.concatenate([np.column_stack([a, c, b]), np.column_stack([b, c, d])])


def cylinder(radius: float, length: float, segments: int = 20, bevel: float = 0.01) -> Mesh:
    """Return a closed cylinder along x, centred."""
    half, b = 0.5 * length, min(bevel, 0.4 * radius, 0.4 * length)
    profile = [
        (-half, 0.0), (-half, radius - b), (-half, radius - b), (-half + b, radius),
        (half - b, radius), (half, radius - b), (half, radius - b), (half, 0.0),
    ]  # fmt: skip
    return lathe(profile, segments)


def upright(radius: float, height: float, segments: int = 16, top: float | None = None) -> Mesh:
    """Return a cylinder or cone that stands on z = 0; `top` is its upper radius."""
    upper = radius if top is None else top
    profile = [
        (0.0, 0.0), (0.0, radius), (0.0, radius), (height, upper), (height, upper), (height, 0.0),
    ]  # fmt: skip
    return lathe(profile, segments).turned(pitch_deg=-90.0)


def tank(radius: float, length: float, dome: float, segments: int = 36, rings: int = 7) -> Mesh:
    """Return a tank along x with domed ends, centred; `length` includes the domes."""
    angle = np.linspace(0.0, 0.5 * math.pi, rings)
    end = np.column_stack([-np.cos(angle) * dome, np.sin(angle) * radius])
    end[:, 0] -= 0.5 * length - dome
    other = end[::-1] * np.array([-1.0, 1.0])
    return lathe(np.concatenate([end, other]), segments)


def ball(radius: float, segments: int = 16) -> Mesh:
    """Return a sphere about the origin."""
    return tank(radius, 2.0 * radius, radius, segments, max(3, segments // 3))


def prism(outline: ArrayLike, width: float) -> Mesh:
    """Return a prism: a convex `outline` (k, 2) in x and z, extruded along y.

    The outline runs anticlockwise with x to the right and z up; its edges stay sharp.
    """
    side = np.asarray(outline, float)
    count, half = len(side), 0.5 * width
    parts = []
    for y in (-half, half):
        points = np.column_stack([side[:, 0], np.full(count, y), side[:, 1]])
        fan = [(0, k, k + 1) for k in range(1, count - 1)]
        normal = np.tile([0.0, math.copysign(1.0, y), 0.0], (count, 1))
        corners = np.array(fan) if y < 0.0 else np.array(fan)[:, ::-1]
        parts.append(made(points, normal, side, corners))
    for k in range(count):
        parts.append(_side(side[k], side[(k + 1) % count], half))
    return joined(parts)


def _side(start: Floats, end: Floats, half: float) -> Mesh:
    step = end - start
    length = float(np.hypot(*step))
    normal = np.array([step[1], 0.0, -step[0]]) / max(length, 1e-9)
    points = [
        (start[0], -half, start[1]), (end[0], -half, end[1]),
        (end[0], half, end[1]), (start[0], half, start[1]),
    ]  # fmt: skip
    places = [(0.0, -half), (length, -half), (length, half), (0.0, half)]
    return made(points, np.tile(normal, (4, 1)), places, [(0, 2, 1), (0, 3, 2)])


def sheet(corners: ArrayLike) -> Mesh:
    """Return a flat convex polygon (k, 3), visible from where it runs anticlockwise."""
    points = np.asarray(corners, float)
    normal = unit(np.cross(points[1] - points[0], points[2] - points[0])[None])[0]
    across = unit((points[1] - points[0])[None])[0]
    places = np.column_stack([points @ across, points @ np.cross(normal, across)])
    fan = [(0, k, k + 1) for k in range(1, len(points) - 1)]
    return made(points, np.tile(normal, (len(points), 1)), places, fan)


def tube(path: ArrayLike, radii: ArrayLike, segments: int = 8) -> Mesh:
    """Return a round rod along `path` (k, 3), open at its ends."""
    line = np.asarray(path, float)
    thick = np.broadcast_to(np.asarray(radii, float), (len(line),))
    ahead = unit(np.gradient(line, axis=0))
    guide = np.where(np.abs(ahead[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    left = unit(np.cross(guide, ahead))
    up = np.cross(ahead, left)
    turn = np.linspace(0.0, 2.0 * math.pi, segments + 1)[None, :, None]
    normals = np.cos(turn) * left[:, None] + np.sin(turn) * up[:, None]
    points = line[:, None] + normals * thick[:, None, None]
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    places = np.stack(
        np.broadcast_arrays(run[:, None], turn[..., 0] * float(thick.max())), axis=-1
    )
    triangles = _grid_triangles(len(line), segments + 1)[:, ::-1]
    return made(points.reshape(-1, 3), normals.reshape(-1, 3), places.reshape(-1, 2), triangles)


def strip(line: ArrayLike, section: ArrayLike) -> Mesh:
    """Return a profile swept along a line: rails, kerbs, gutters.

    Parameters
    ----------
    line : (k, 3)
        Centre line, metres.
    section
        Open cross-section, metres left and up, (s, 2), from its left foot over the top to the
        right.
    """
    course = np.asarray(line, float)
    profile = np.asarray(section, float)
    ahead = unit(np.gradient(course, axis=0) * np.array([1.0, 1.0, 0.0]))
    left = np.column_stack([-ahead[:, 1], ahead[:, 0], np.zeros(len(course))])
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(course, axis=0), axis=1))])
    parts = []
    for start, end in itertools.pairwise(profile):
        edge = np.stack([start, end])
        points = course[:, None] + edge[None, :, :1] * left[:, None] + _up(edge)
        step = end - start
        normal = unit(left * step[1] - np.array([0.0, 0.0, 1.0]) * step[0])
        normals = np.repeat(normal[:, None], 2, axis=1)
        places = np.stack(np.broadcast_arrays(run[:, None], edge[None, :, 1]), axis=-1)
        mesh = made(
            points.reshape(-1, 3), normals.reshape(-1, 3), places.reshape(-1, 2),
            _grid_triangles(len(course), 2),
        )  # fmt: skip
        parts.append(_facing(mesh))
    return joined(parts)


def _up(edge: Floats) -> Floats:
    return np.asarray(edge[None, :, 1:] * np.array([0.0, 0.0, 1.0]))


def _facing(mesh: Mesh) -> Mesh:
    """Return `mesh` with triangles wound to match its normals."""
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    is_wrong = np.einsum('ij,ij->i', across, mesh.normals[mesh.triangles[:, 0]]) < 0.0
    triangles = mesh.triangles.copy()
    triangles[is_wrong] = triangles[is_wrong][:, ::-1]
    return replace(mesh, triangles=triangles)
