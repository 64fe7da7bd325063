# SPDX-License-Identifier: Apache-2.0
"""The surface of tree crowns as seen from the height of a vehicle.

From 32 m a pixel is 6 cm wide and leaves merge: a crown looks like a dense, lumpy surface. Here it
is one closed surface around blended lobes, with dents of noise. Photographs from two places see
the same texture on it, so that they can be matched; of single leaves they would see different
ones.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np

from rocsafe_scene.mesh.mesh import Colour, Floats, Mesh, unit
from rocsafe_scene.mesh.surfaces import Surface


@dataclass(frozen=True, slots=True, kw_only=True)
class CrownOptions:
    """Shape and shade of all crowns, set by the look of the pictures.

    Attributes
    ----------
    side_m
        Side of a triangle of the surface, metres.
    fewest_parts, most_parts
        Limits of the number of parts into which an edge of the icosahedron is divided.
    steps
        Steps of the search for the surface along a ray.
    softness
        Sharpness of the blend of lobes: the exponent of Blinn (1982).
    flat_from, flattened
        A crown flattens above this share of half its height, to this share of the slope at its
        top.
    dents
        Wavelength and depth of each layer of dents, metres.
    waves
        Number of waves in a layer of dents.
    shaded, shaded_side
        Brightness of the top and of the sides, as a share of that of a leaf: leaves shadow each
        other.
    on_top
        Density of leaves on top of a crown, as a share of that on its sides.
    """

    side_m: float = 0.23
    fewest_parts: int = 5
    most_parts: int = 26
    steps: int = 26
    softness: float = 5.0
    flat_from: float = 0.2
    flattened: float = 0.4
    dents: tuple[tuple[float, float], ...] = ((1.6, 0.12), (0.8, 0.07), (0.45, 0.035))
    waves: int = 14
    shaded: float = 0.72
    shaded_side: float = 0.64
    on_top: float = 0.15


CROWN = CrownOptions()


@dataclass(frozen=True, slots=True, kw_only=True)
class Blob:
    """A lobe of a crown.

    Attributes
    ----------
    centre : (3,)
        Centre, metres.
    radii : (3,)
        Half axes, metres.
    """

    centre: Floats
    radii: Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class Crown:
    """The lobes and colours of a crown.

    Attributes
    ----------
    lobes
        Lobes within the surface.
    middle : (3,)
        A place inside, from which the whole surface is visible.
    size : (3,)
        Half extents in x, y and z, metres.
    leaf
        Red, green, blue of a leaf in full light.
    variety
        How much lobes differ in brightness, 0 to 1.
    """

    lobes: list[Blob]
    middle: Floats
    size: Floats
    leaf: Colour
    variety: float


def skin(crown: Crown, rng: np.random.Generator, density: float = 1.0) -> Mesh:
    """Return the closed surface of a crown; `density` scales the number of its triangles.

    Its texture coordinates are (east, north) unrolled from the top, so that textures are stretched
    little.
    """
    side = CROWN.side_m / math.sqrt(density)
    frequency = round(1.05 * float(crown.size.mean()) / side)
    sphere, triangles = _sphere(min(max(frequency, CROWN.fewest_parts), CROWN.most_parts))
    direction = unit(sphere * crown.size)
    reach = _reach(crown, direction)
    points = crown.middle + reach[:, None] * direction
    # Smooth on top, which vehicles see, and ragged on the sides.
    dents = _dents(points, rng) * (0.1 + 1.4 * np.clip(1.0 - sphere[:, 2], 0.0, 1.0))
    points = points + dents[:, None] * direction
    tint = _colours(crown, points, dents, rng)
    points = _flattened(crown, points)
    # Stereographic projection: conformal, finer on the sides.
    unrolled = 2.0 / np.maximum(1.0 + sphere[:, 2:], 0.4)
    normals = smooth_normals(points, triangles)
    colours = np.full((len(points), 4), Surface.CROWN, np.uint8)
    colours[:, :3] = np.clip(_shaded(normals) * tint, 6.0, 250.0)
    return Mesh(
        points=points,
        normals=normals,
        places=points[:, :2] * unrolled,
        colours=colours,
        triangles=triangles,
    )


def _flattened(crown: Crown, points: Floats) -> Floats:
    """Return the points (n, 3) of a crown with a flattened dome: crowns of a wood end level.

    The top is kept.
    """
    above = np.maximum((points[:, 2] - crown.middle[2]) / crown.size[2] - CROWN.flat_from, 0.0)
    most = 1.0 - CROWN.flat_from
    raised = points.copy()
    raised[:, 2] += crown.size[2] * (1.0 - CROWN.flattened) * (most**2 - above**2) / (2.0 * most)
    return raised


def smooth_normals(points: Floats, triangles: Floats) -> Floats:
    """Return unit normals (n, 3), averaged over the triangles around each point by area."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    corners = triangles.T.ravel()
    summed = [np.bincount(corners, np.tile(across[:, k], 3), len(points)) for k in range(3)]
    return unit(np.stack(summed, axis=1))


def scattered(
    mesh: Mesh, density: float, rng: np.random.Generator
) -> tuple[Floats, Floats, Floats]:
    """Return places on a surface with normals and colours, denser on the sides than on top.

    `density` is the number on a square metre of a side.
    """
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    normal = unit(mesh.normals[mesh.triangles].mean(axis=1))
    weight = 0.5 * area * (1.0 - (1.0 - CROWN.on_top) * _upness(normal))
    count = int(density * weight.sum())
    chosen = np.searchsorted(np.cumsum(weight) / weight.sum(), rng.uniform(0.0, 1.0, count))
    chosen = np.minimum(chosen, len(weight) - 1)
    u, v = rng.uniform(0.0, 1.0, (2, count, 1))
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    places = a[chosen] + u * (b - a)[chosen] + v * (c - a)[chosen]
    tint = mesh.colours[mesh.triangles[chosen, 0], :3] / _shaded(normal[chosen])
    return places, normal[chosen], CROWN.shaded * tint


def _upness(normals: Floats) -> Floats:
    """Return 1 where a surface faces up, 0 on its sides and below, (n,)."""
    share = np.clip((normals[:, 2] - 0.25) / 0.5, 0.0, 1.0)
    return np.asarray(share * share * (3.0 - 2.0 * share))


def _shaded(normals: Floats) -> Floats:
    """Return the brightness of a surface by how much it faces up, (n, 1)."""
    shade = CROWN.shaded_side + (CROWN.shaded - CROWN.shaded_side) * _upness(normals)
    return np.asarray(shade)[:, None]


def _reach(crown: Crown, direction: Floats) -> Floats:
    """Return the distance of the surface from the middle in each direction (n, 3)."""
    farthest = 1.35 * float(np.linalg.norm(crown.size))
    reach = np.linspace(farthest, 0.0, CROWN.steps)
    inside = np.stack([_inside(crown, crown.middle + t * direction) for t in reach])
    inside[-1] = np.maximum(inside[-1], 1e-6)
    first = np.maximum(np.argmax(inside > 0.0, axis=0), 1)
    column = np.arange(len(direction))
    before, after = inside[first - 1, column], inside[first, column]
    share = np.clip(before / np.minimum(before - after, -1e-9), 0.0, 1.0)
    return np.asarray(reach[first - 1] + share * (reach[first] - reach[first - 1]))


def _inside(crown: Crown, places: Floats) -> Floats:
    """Return the implicit function of the blended lobes, above 0 inside: after Blinn (1982)."""
    total = np.zeros(len(places))
    for lobe in crown.lobes:
        x, y, z = (((places - lobe.centre) / lobe.radii) ** 2).T
        total += np.exp(CROWN.softness * (1.0 - (x + y + z)))
    return np.log(np.maximum(total, 1e-30))


def _dents(places: Floats, rng: np.random.Generator) -> Floats:
    """Return noise at places (n, 3), metres: a sum of waves in all directions."""
    count, total = CROWN.waves, np.zeros(len(places))
    for wavelength, depth in CROWN.dents:
        way = unit(rng.normal(0.0, 1.0, (count, 3))) * rng.uniform(0.75, 1.35, (count, 1))
        phase = rng.uniform(0.0, 2.0 * math.pi, count)
        waves = np.sin(places @ way.T * (2.0 * math.pi / wavelength) + phase)
        total += depth * waves.sum(axis=1) * math.sqrt(2.0 / count)
    return total


def _colours(crown: Crown, points: Floats, dents: Floats, rng: np.random.Generator) -> Floats:
    """Return red, green, blue: a brightness for each lobe, darker in dents and low down."""
    centres = np.array([lobe.centre for lobe in crown.lobes])
    sizes = np.array([lobe.radii.mean() for lobe in crown.lobes])
    spread = crown.variety * 0.5
    tones = 1.0 + rng.uniform(-spread, spread, (len(sizes), 1))
    tones = tones + rng.normal(0.0, 0.05, (len(sizes), 3))
    apart = np.linalg.norm(points[:, None] - centres, axis=2) / sizes
    weight = np.exp(-5.0 * (apart - apart.min(axis=1, keepdims=True)))
    tone = weight @ tones / weight.sum(axis=1, keepdims=True)
    up = (points[:, 2] - crown.middle[2]) / crown.size[2]
    deep = np.clip(1.0 + 1.9 * dents, 0.55, 1.25) * np.clip(0.92 + 0.14 * up, 0.7, 1.0)
    return np.asarray(np.array(crown.leaf) * tone * deep[:, None])


@lru_cache(maxsize=32)
def _sphere(frequency: int) -> tuple[Floats, Floats]:
    """Return a unit sphere: an icosahedron with edges divided into `frequency` parts.

    Triangles run anticlockwise seen from outside. The highest come first: seen from above they
    hide those behind before these are drawn.
    """
    corners, faces = _icosahedron()
    grid = [(i, j) for i in range(frequency + 1) for j in range(frequency + 1 - i)]
    share = np.array([(frequency - i - j, i, j) for i, j in grid]) / frequency
    number = {place: k for k, place in enumerate(grid)}
    cells = [(number[i, j], number[i + 1, j], number[i, j + 1])
             for i, j in grid if i + j < frequency]  # fmt: skip
    cells += [(number[i + 1, j], number[i + 1, j + 1], number[i, j + 1])
              for i, j in grid if i + j < frequency - 1]  # fmt: skip
    points = (share @ corners[faces]).reshape(-1, 3)
    triangles = (np.array(cells) + len(grid) * np.arange(len(faces))[:, None, None]).reshape(-1, 3)
    _, first, place = np.unique(np.rint(points * 1e7), axis=0, return_index=True,
                                return_inverse=True)  # fmt: skip
    sphere = unit(points[first])
    triangles = place.reshape(-1)[triangles]
    order = np.argsort(-sphere[triangles][..., 2].sum(axis=1), kind='stable')
    return sphere, np.ascontiguousarray(triangles[order].astype(np.int32))


def _icosahedron() -> tuple[Floats, Floats]:
    golden = 0.5 * (1.0 + math.sqrt(5.0))
    ring = [(a, b * golden) for a in (-1.0, 1.0) for b in (-1.0, 1.0)]
    corners = np.array([np.roll((0.0, a, b), shift) for shift in range(3) for a, b in ring])
    apart = np.linalg.norm(corners[:, None] - corners, axis=2)
    faces = []
    for a, b, c in combinations(range(12), 3):
        if max(apart[a, b], apart[b, c], apart[a, c]) < 2.1:
            is_outward = np.linalg.det(corners[[a, b, c]]) > 0.0
            faces.append((a, b, c) if is_outward else (a, c, b))
    return corners, np.array(faces)
