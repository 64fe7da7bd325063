# SPDX-License-Identifier: Apache-2.0
"""Single leaves, and how they look for each species."""

from dataclasses import dataclass

import numpy as np

from rocsafe_scene.mesh.mesh import Colour, Floats, Mesh, unit
from rocsafe_scene.mesh.surfaces import Surface
from rocsafe_scene.parts.crowns import Blob


@dataclass(frozen=True, slots=True, kw_only=True)
class Species:
    """What a kind of tree looks like.

    Attributes
    ----------
    leaf
        Red, green, blue of a leaf in full light.
    variety
        How much leaves differ in brightness, 0 to 1.
    leaf_m
        Length of a leaf polygon, metres.
    crown_from
        Height of the lowest leaves as a share of that of the tree.
    slimness
        Ratio of height to width of the blobs of a crown.
    is_conical
        Whether the crown narrows upwards.
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

    Each is two triangles folded along the midrib. Their normals lean outwards, so that a crown is
    lit as a volume and not leaf by leaf.
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
    # The length of `outward` encodes the depth in the crown: inner leaves are darker.
    depth = np.clip(np.linalg.norm(outward, axis=1, keepdims=True), 0.0, 1.0)
    warm = rng.normal(0.0, 0.06, (count, 1)) * np.array([1.0, 0.15, -0.6])
    colours = np.array(species.leaf) * (tone * (0.45 + 0.55 * depth) + warm)
    surface = np.full((count, 1), Surface.LEAF)
    return np.concatenate([np.clip(colours, 8, 250), surface], axis=1).astype(np.uint8)


def species_of(name: str) -> Species:
    """Return the kind of plant called so.

    Raises
    ------
    ValueError
        If none is.
    """
    if name not in SPECIES:
        raise ValueError(f'species is {name!r}: must be one of {", ".join(SPECIES)}')
    return SPECIES[name]


def filled(blob: Blob, count: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Return places in a blob, most near its surface, and outward directions."""
    direction = unit(rng.normal(0.0, 1.0, (count, 3)))
    depth = rng.uniform(0.0, 1.0, (count, 1)) ** 0.3
    ripple = 1.0 + 0.1 * np.sin(direction @ np.array([[7.0], [9.0], [8.0]]) + blob.centre[0])
    outward = unit(direction / blob.radii) * depth
    return blob.centre + direction * depth * blob.radii * ripple, outward
