# SPDX-License-Identifier: Apache-2.0
"""Trees, hedges, shrubs and tufts.

Every leaf is a small folded polygon, no cut-out picture: what the labels, the rays and the
shadows see is what the camera sees. Crowns of trees have a skin besides, see `crowns`.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_sim.scene.mesh import Colour, Floats, Mesh, joined, unit
from rocsafe_sim.scene.parts.crowns import Blob, Crown, scattered, skin
from rocsafe_sim.scene.shapes import tube
from rocsafe_sim.scene.surfaces import Surface

# Of a tuft of grass.
BLADES, POINTS_OF_BLADE = 6, 5
_BARK: Colour = (88, 74, 60)
# Leaves on a square metre of the side of a crown.
_LEAVES_PER_M2 = 15.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Species:
    """What a kind of tree looks like.

    Attributes
    ----------
    leaf : red, green, blue in the light.
    variety : how much leaves differ in brightness, 0 to 1.
    leaf_m : length of a leaf polygon.
    crown_from : height of the lowest leaves, share of the tree's.
    slimness : height of the crown's blobs by their width.
    is_conical : crown narrows upwards.
    """

    leaf: Colour
    variety: float = 0.3
    leaf_m: float = 0.34
    crown_from: float = 0.22
    slimness: float = 0.85
    is_conical: bool = False


SPECIES: dict[str, Species] = {
    'oak': Species(leaf=(84, 108, 44)),
    'ash': Species(leaf=(104, 126, 54), variety=0.35, leaf_m=0.3, slimness=1.05),
    'beech': Species(leaf=(70, 98, 42), variety=0.25),
    'willow': Species(leaf=(128, 142, 84), variety=0.3, leaf_m=0.3, crown_from=0.12),
    'pine': Species(leaf=(46, 70, 42), leaf_m=0.3, crown_from=0.12, is_conical=True),
    'blackthorn': Species(leaf=(76, 92, 50), variety=0.4, leaf_m=0.22, crown_from=0.03),
    'gorse': Species(leaf=(150, 142, 44), variety=0.5, leaf_m=0.2, crown_from=0.02),
}


def leaves(
    centres: Floats, outward: Floats, species: Species, rng: np.random.Generator, size: float = 1.0
) -> Mesh:
    """Return a leaf at each of `centres` (n, 3), roughly facing `outward` (n, 3).

    Each is two triangles folded along the midrib. Their normals lean outwards, which lights a
    crown as a volume rather than as confetti.
    """
    count = len(centres)
    facing = unit(outward + rng.normal(0.0, 0.32, (count, 3)) + np.array([0.0, 0.0, 0.35]))
    along = unit(np.cross(facing, rng.normal(0.0, 1.0, (count, 3))))
    across = np.cross(facing, along)
    long = species.leaf_m * size * rng.uniform(0.6, 1.25, (count, 1))
    wide, fold = 0.62 * long, 0.12 * long
    tip, stem = centres + 0.5 * long * along, centres - 0.5 * long * along
    left = centres + 0.5 * wide * across + fold * facing
    right = centres - 0.5 * wide * across + fold * facing
    points = np.stack([stem, right, tip, left], axis=1)
    lit = unit(0.75 * outward + 0.45 * facing + np.array([0.0, 0.0, 0.25]))
    base = 4 * np.arange(count)[:, None]
    triangles = np.concatenate([base + np.array([0, 1, 2]), base + np.array([0, 2, 3])])
    return Mesh(
        points=points.reshape(-1, 3),
        normals=np.repeat(lit, 4, axis=0),
        places=np.repeat(centres[:, :2] * 0.7 + centres[:, 2:] * 0.4, 4, axis=0),
        colours=np.repeat(_leaf_colours(outward, species, rng), 4, axis=0),
        triangles=triangles.astype(np.int32),
    )


def _leaf_colours(outward: Floats, species: Species, rng: np.random.Generator) -> Floats:
    count = len(outward)
    tone = 1.0 + species.variety * rng.normal(0.0, 0.34, (count, 1))
    # Depth in the crown travels in the length of `outward`: inner leaves are darker.
    depth = np.clip(np.linalg.norm(outward, axis=1, keepdims=True), 0.0, 1.0)
    warm = rng.normal(0.0, 0.06, (count, 1)) * np.array([1.0, 0.15, -0.6])
    colours = np.array(species.leaf) * (tone * (0.45 + 0.55 * depth) + warm)
    surface = np.full((count, 1), Surface.LEAF)
    return np.concatenate([np.clip(colours, 8, 250), surface], axis=1).astype(np.uint8)


def _filled(blob: Blob, count: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Return places in a blob, most near its skin, and directions out of it."""
    direction = unit(rng.normal(0.0, 1.0, (count, 3)))
    depth = rng.uniform(0.0, 1.0, (count, 1)) ** 0.3
    ripple = 1.0 + 0.1 * np.sin(direction @ np.array([[7.0], [9.0], [8.0]]) + blob.centre[0])
    outward = unit(direction / blob.radii) * depth
    return blob.centre + direction * depth * blob.radii * ripple, outward


def tree(
    rng: np.random.Generator,
    height: float = 10.0,
    radius: float = 3.5,
    species: str = 'oak',
    density: float = 1.0,
) -> Mesh:
    """Return a tree of `height` and crown `radius`; `density` scales the number of triangles."""
    kind = _species(species)
    blobs = (
        _cone(rng, height, radius, kind) if kind.is_conical else _crown(rng, height, radius, kind)
    )
    middle = np.array([0.0, 0.0, (0.5 + 0.5 * kind.crown_from) * height])
    size = np.array([radius, radius, 0.5 * (1.0 - kind.crown_from) * height])
    # Between the lobes the skin does not fall in further than this.
    core = Blob(centre=middle, radii=(0.45 if kind.is_conical else 0.75) * size)
    crown = Crown(
        lobes=[*blobs, core],
        middle=middle,
        size=size,
        leaf=kind.leaf,
        variety=kind.variety,
    )
    surface = skin(crown, rng, density)
    fringe = _fringe(surface, kind, density, rng)
    return joined([surface, fringe, *_wood(rng, height, radius, blobs)])


def _fringe(surface: Mesh, kind: Species, density: float, rng: np.random.Generator) -> Mesh:
    """Return leaves on the skin of a crown, lit and coloured nearly as it is.

    They make its outline ragged; of their own they show little, so that photographs from two
    places see the same crown.
    """
    # Fewer leaves are larger, so that the outline stays as ragged.
    per_m2 = density * _LEAVES_PER_M2 * (0.34 / kind.leaf_m) ** 2
    centres, outward, tint = scattered(surface, per_m2, rng)
    centres = centres + outward * rng.uniform(-0.05, 0.1, (len(centres), 1))
    fringe = leaves(centres, outward, kind, rng, 0.85 / math.sqrt(density))
    tone = 1.0 + 0.6 * kind.variety * rng.normal(0.0, 0.34, (len(centres), 1))
    colours = fringe.colours.copy()
    colours[:, :3] = np.clip(np.repeat(tint * tone, 4, axis=0), 6.0, 250.0)
    normals = unit(0.35 * fringe.normals + np.repeat(outward, 4, axis=0))
    return replace(fringe, colours=colours, normals=normals)


def _species(name: str) -> Species:
    if name not in SPECIES:
        raise ValueError(f'species is {name!r}: must be one of {", ".join(SPECIES)}')
    return SPECIES[name]


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


def _cone(rng: np.random.Generator, height: float, radius: float, kind: Species) -> list[Blob]:
    blobs = []
    # As high as the layers are apart, so that the crown closes up to its tip.
    least_up = 0.62 * (0.94 - kind.crown_from) * height / 8.0
    for layer in range(9):
        share = layer / 8.0
        girth = 0.75 * radius * (1.0 - share) + 0.2 * radius
        z = kind.crown_from * height + share * (0.94 - kind.crown_from) * height
        for k in range(max(1, round(6 * (1.0 - share)))):
            angle = rng.uniform(0.0, 2.0 * math.pi) + k
            reach = 0.62 * girth
            centre = np.array([reach * math.cos(angle), reach * math.sin(angle), z])
            radii = np.array([0.62 * girth, 0.62 * girth, max(0.45 * girth, least_up)])
            blobs.append(Blob(centre=centre, radii=radii))
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
    kind = _species(species)
    blobs = []
    for _ in range(6):
        angle, reach = rng.uniform(0.0, 2.0 * math.pi), radius * rng.uniform(0.0, 0.6)
        size = radius * rng.uniform(0.4, 0.65)
        centre = np.array([reach * math.cos(angle), reach * math.sin(angle), 0.45 * height])
        blobs.append(Blob(centre=centre, radii=np.array([size, size, 0.55 * height])))
    count = max(8, int(density * 230 * radius**2 * (0.22 / kind.leaf_m) ** 2 * 1.4))
    filled = [_filled(blob, count, rng) for blob in blobs]
    centres = np.concatenate([places for places, _ in filled])
    outward = np.concatenate([directions for _, directions in filled])
    is_above = centres[:, 2] > 0.0
    return leaves(centres[is_above], outward[is_above], kind, rng, 1.0 / math.sqrt(density))


def hedge(
    rng: np.random.Generator, course: Floats, width: float = 1.6, height: float = 1.9,
    species: str = 'blackthorn', density: float = 1.0,
) -> Mesh:  # fmt: skip
    """Return a hedge along `course` (k, 3), trimmed long ago: bulges, gaps, shoots.

    Leaves are spread over a rounded section that swells and shrinks along the way.
    """
    kind = _species(species)
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
