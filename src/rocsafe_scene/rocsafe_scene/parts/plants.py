# SPDX-License-Identifier: Apache-2.0
"""Trees, hedges, shrubs and tufts.

Every leaf is a small folded polygon and not a transparent image, so that labels, rays and shadows
agree with the photograph. Crowns of trees also have a closed surface, see `crowns`.
"""

import math
from dataclasses import replace

import numpy as np

from rocsafe_scene.mesh.mesh import Colour, Floats, Mesh, joined, unit
from rocsafe_scene.mesh.shapes import tube
from rocsafe_scene.mesh.surfaces import Surface
from rocsafe_scene.parts.conifers import cone, needles
from rocsafe_scene.parts.crowns import Blob, Crown, scattered, skin
from rocsafe_scene.parts.leaves import Species, filled, leaves, species_of

# Size of a tuft of grass.
BLADES, POINTS_OF_BLADE = 6, 5
_BARK: Colour = (88, 74, 60)
# Number of leaves on a square metre of the side of a crown.
_LEAVES_PER_M2 = 15.0


def tree(
    rng: np.random.Generator,
    height: float = 10.0,
    radius: float = 3.5,
    species: str = 'oak',
    density: float = 1.0,
) -> Mesh:
    """Return a tree of `height` and crown `radius`; `density` scales the number of triangles."""
    kind = species_of(species)
    if kind.is_conical:
        blobs = cone(rng, height, radius, kind)
        crown = needles(rng, height, radius, kind, (blobs, density))
        return joined([crown, *_wood(rng, height, radius, blobs)])
    blobs = _crown(rng, height, radius, kind)
    middle = np.array([0.0, 0.0, (0.5 + 0.5 * kind.crown_from) * height])
    size = np.array([radius, radius, 0.5 * (1.0 - kind.crown_from) * height])
    # The surface sinks no deeper than this between lobes.
    core = Blob(centre=middle, radii=0.8 * size)
    lobed = Crown(
        lobes=[*blobs, core],
        middle=middle,
        size=size,
        leaf=kind.leaf,
        variety=kind.variety,
    )
    surface = skin(lobed, rng, density)
    fringe = _fringe(surface, kind, density, rng)
    return joined([surface, fringe, *_wood(rng, height, radius, blobs)])


def _fringe(surface: Mesh, kind: Species, density: float, rng: np.random.Generator) -> Mesh:
    """Return leaves on the surface of a crown, nearly in its colours.

    They make the outline ragged. They hardly stand out, so that photographs from two places show
    the same crown.
    """
    # Fewer leaves are drawn larger, so that the outline stays as ragged.
    per_m2 = density * _LEAVES_PER_M2 * (0.34 / kind.leaf_m) ** 2
    centres, outward, tint = scattered(surface, per_m2, rng)
    centres = centres + outward * rng.uniform(-0.05, 0.1, (len(centres), 1))
    fringe = leaves(centres, outward, kind, rng, 0.85 / math.sqrt(density))
    tone = 1.0 + 0.6 * kind.variety * rng.normal(0.0, 0.34, (len(centres), 1))
    colours = fringe.colours.copy()
    colours[:, :3] = np.clip(np.repeat(tint * tone, 4, axis=0), 6.0, 250.0)
    normals = unit(0.35 * fringe.normals + np.repeat(outward, 4, axis=0))
    return replace(fringe, colours=colours, normals=normals)


def _crown(rng: np.random.Generator, height: float, radius: float, kind: Species) -> list[Blob]:
    low = kind.crown_from * height
    blobs = []
    for _ in range(22):
        share = rng.uniform(0.0, 1.0)
        # Widest a little below the middle.
        girth = radius * math.sqrt(max(0.05, 1.0 - (2.0 * share - 0.82) ** 2 * 0.8))
        size = radius * rng.uniform(0.26, 0.46)
        angle, reach = rng.uniform(0.0, 2.0 * math.pi), max(0.0, girth - 0.8 * size)
        reach *= math.sqrt(rng.uniform(0.1, 1.0))
        z = low + size * 0.7 + share * (height - low - 1.4 * size)
        centre = np.array([reach * math.cos(angle), reach * math.sin(angle), z])
        blobs.append(Blob(centre=centre, radii=size * np.array([1.0, 1.0, kind.slimness])))
    return blobs


def _wood(rng: np.random.Generator, height: float, radius: float, blobs: list[Blob]) -> list[Mesh]:
    thick = 0.035 * height
    top = np.array([rng.normal(0.0, 0.3), rng.normal(0.0, 0.3), 0.75 * height])
    stem = np.linspace([0.0, 0.0, -0.3], top, 6)
    stem[1:-1, :2] += rng.normal(0.0, 0.03 * radius, (4, 2))
    flare = np.array([1.5, 1.0, 0.85, 0.65, 0.45, 0.2]) * thick
    parts = [tube(stem, flare, 8)]
    for blob in blobs[:4]:
        start = stem[2] + (stem[4] - stem[2]) * rng.uniform(0.0, 1.0)
        middle = 0.5 * (start + blob.centre) + np.array([0.0, 0.0, -0.08 * height])
        parts.append(
            tube([start, middle, blob.centre], [0.4 * thick, 0.3 * thick, 0.08 * thick], 5)
        )
    return [joined(parts).painted(_BARK, Surface.BARK)]


def shrub(
    rng: np.random.Generator,
    height: float = 1.6,
    radius: float = 1.1,
    species: str = 'blackthorn',
    density: float = 1.0,
) -> Mesh:
    """Return a bush without a trunk."""
    kind = species_of(species)
    blobs = []
    for _ in range(6):
        angle, reach = rng.uniform(0.0, 2.0 * math.pi), radius * rng.uniform(0.0, 0.6)
        size = radius * rng.uniform(0.4, 0.65)
        centre = np.array([reach * math.cos(angle), reach * math.sin(angle), 0.45 * height])
        blobs.append(Blob(centre=centre, radii=np.array([size, size, 0.55 * height])))
    count = max(8, int(density * 230 * radius**2 * (0.22 / kind.leaf_m) ** 2 * 1.4))
    grown = [filled(blob, count, rng) for blob in blobs]
    centres = np.concatenate([places for places, _ in grown])
    outward = np.concatenate([directions for _, directions in grown])
    is_above = centres[:, 2] > 0.0
    return leaves(centres[is_above], outward[is_above], kind, rng, 1.0 / math.sqrt(density))


def hedge(
    rng: np.random.Generator, course: Floats, width: float = 1.6, height: float = 1.9,
    species: str = 'blackthorn', density: float = 1.0,
) -> Mesh:  # fmt: skip
    """Return an untrimmed hedge along `course` (k, 3), with bulges, gaps and shoots.

    Leaves are spread over a rounded cross-section that varies along the course.
    """
    kind = species_of(species)
    steps = np.linalg.norm(np.diff(course, axis=0), axis=1)
    run = np.concatenate([[0.0], np.cumsum(steps)])
    count = int(density * run[-1] * 240 * (0.22 / kind.leaf_m) ** 2)
    along = rng.uniform(0.0, run[-1], count)
    middle = np.column_stack([np.interp(along, run, course[:, k]) for k in range(3)])
    ahead = unit(
        np.column_stack([np.interp(along, run, np.gradient(course[:, k])) for k in range(2)])
    )
    angle = rng.uniform(-0.25, math.pi + 0.25, count)
    phase = rng.uniform(0.0, 6.0, 4)
    swell = 1.0 + 0.16 * np.sin(along / 1.7 + phase[0]) + 0.12 * np.sin(along / 0.63 + phase[1])
    tall = 1.0 + 0.14 * np.sin(along / 2.9 + phase[2]) + 0.08 * np.sin(along / 0.8 + phase[3])
    depth = rng.uniform(0.0, 1.0, count) ** 0.28
    aside = 0.5 * width * swell * np.cos(angle) * depth
    up = 0.4 * height + 0.6 * height * tall * np.sin(angle) * depth
    left = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    centres = middle + np.column_stack([left * aside[:, None], np.maximum(up, 0.05)])
    outward = np.column_stack([left * np.cos(angle)[:, None], np.sin(angle)]) * depth[:, None]
    return leaves(centres, outward, kind, rng, 1.0 / math.sqrt(density))


def tufts(
    rng: np.random.Generator, feet: Floats, height: float = 0.35, colour: Colour = (92, 106, 54)
) -> Mesh:
    """Return long grass: a bunch of bent blades at each of `feet` (n, 3)."""
    count = len(feet) * BLADES
    turn = rng.uniform(0.0, 2.0 * math.pi, count)
    lean = np.column_stack([np.cos(turn), np.sin(turn)])
    tall = height * rng.uniform(0.5, 1.3, count)
    foot = np.repeat(feet, BLADES, axis=0)
    foot[:, :2] += lean * rng.uniform(0.0, 0.16, (count, 1))
    bend = tall * rng.uniform(0.3, 0.9, count)
    tip = foot + np.column_stack([lean * bend[:, None], tall])
    knee = foot + np.column_stack([lean * 0.35 * bend[:, None], 0.62 * tall])
    side = np.column_stack([-lean[:, 1], lean[:, 0], np.zeros(count)]) * rng.uniform(
        0.012, 0.03, (count, 1)
    )
    points = np.stack(
        [foot - side, foot + side, knee + 0.8 * side, tip, knee - 0.8 * side], axis=1
    )
    base = POINTS_OF_BLADE * np.arange(count)[:, None]
    triangles = np.concatenate([base + np.array(c) for c in ((0, 1, 2), (0, 2, 4), (4, 2, 3))])
    tone = np.repeat(rng.uniform(0.75, 1.25, len(feet)), BLADES) * rng.uniform(0.8, 1.2, count)
    dry = rng.uniform(0.0, 1.0, (count, 1)) ** 3 * np.array([60.0, 30.0, 20.0])
    shade = np.array([0.55, 0.55, 0.9, 1.15, 0.9])
    tint = (np.array(colour) * tone[:, None] + dry)[:, None] * shade[:, None]
    colours = np.full((count * 5, 4), Surface.GRASS)
    colours[:, :3] = np.clip(tint.reshape(-1, 3), 5, 250)
    up = unit(np.column_stack([lean * 0.35, np.ones(count)]))
    return Mesh(
        points=points.reshape(-1, 3),
        normals=np.repeat(up, 5, axis=0),
        places=points.reshape(-1, 3)[:, :2],
        colours=colours.astype(np.uint8),
        triangles=triangles.astype(np.int32),
    )
