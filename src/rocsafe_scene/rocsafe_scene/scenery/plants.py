# SPDX-License-Identifier: Apache-2.0
"""Trees, hedges and shrubs, each from leaf clumps of its own."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_scene.scenery.light import SUN_ENU, shadow_of_box, shadow_of_discs
from rocsafe_scene.scenery.marks import (
    Colour,
    Coordinates,
    Dots,
    Mark,
    Placing,
    Points,
)
from rocsafe_scene.scenery.outlines import generator, smooth_line
from rocsafe_scene.scenery.scene import Thing

LEAVES: tuple[Colour, ...] = ((58, 84, 38), (70, 92, 40), (50, 76, 42), (84, 98, 44))
PINE: Colour = (40, 62, 44)
BLOSSOM: Colour = (196, 172, 60)
_GRAIN = 150


def tree(
    name: str,
    at: tuple[float, float],
    radius_m: float,
    height_m: float,
    seed: int,
    colour: Colour = LEAVES[0],
) -> Thing:
    """Return a broad-leaved tree: clumps of leaves, lit from the sun's side."""
    rng = generator(seed, int(at[0] * 100) & 0xFFFF, int(at[1] * 100) & 0xFFFF)
    clumps = _crown(rng, radius_m, int(30 + 26 * radius_m)).at(at)
    high = height_m * (0.35 + 0.5 * clumps.heights)
    trunk = Placing(*at)
    return Thing(
        name=name,
        kind='tree',
        placing=trunk,
        size_m=(2 * radius_m, 2 * radius_m, height_m),
        colour=colour,
        shadow=(
            shadow_of_discs(clumps.places, 1.1 * clumps.radii_m, high),
            shadow_of_discs(clumps.places, 0.9 * clumps.radii_m, 0.35 * high),
            shadow_of_box(trunk, 0.5, 0.5, 0.5 * height_m),
        ),
        body=(_lit(rng, clumps, colour),),
    )


def hedge(name: str, line: Coordinates, width_m: float, height_m: float, seed: int) -> Thing:
    """Return a hedge along a line (n, 2)."""
    rng = generator(seed, len(name), int(abs(np.asarray(line).sum()) * 10) & 0xFFFF)
    path = np.repeat(smooth_line(line, 0.55), 3, axis=0)
    count = len(path)
    places = path + rng.normal(0.0, 0.24 * width_m, path.shape)
    clumps = _Clumps(
        places, rng.uniform(0.16, 0.36, count) * width_m, rng.uniform(0.1, 1.0, count)
    )
    colour = LEAVES[int(rng.integers(len(LEAVES)))]
    middle = path.mean(axis=0)
    return Thing(
        name=name,
        kind='hedge',
        placing=Placing(float(middle[0]), float(middle[1])),
        size_m=(1.0, 1.0, 0.0),
        colour=colour,
        shadow=(
            shadow_of_discs(places, 1.3 * clumps.radii_m, np.full(count, 0.8 * height_m)),
            shadow_of_discs(places, 1.3 * clumps.radii_m, np.full(count, 0.3 * height_m)),
        ),
        body=(_lit(rng, clumps, colour),),
    )


def shrubs(
    name: str,
    centre: tuple[float, float],
    spread_m: float,
    count: int,
    seed: int,
    colour: Colour = LEAVES[2],
) -> Thing:
    """Return a loose group of low shrubs."""
    rng = generator(seed, count, int(centre[0]) & 0xFFFF, int(centre[1]) & 0xFFFF)
    shadow: list[Mark] = []
    body: list[Mark] = []
    for place in np.asarray(centre) + rng.normal(0.0, spread_m, (count, 2)):
        size = rng.uniform(0.35, 1.1)
        clumps = _crown(rng, size, 16).at(place)
        shadow.append(shadow_of_discs(clumps.places, clumps.radii_m, 0.9 * size * clumps.heights))
        body.append(_lit(rng, clumps, colour))
    return Thing(
        name=name,
        kind='shrubs',
        placing=Placing(*centre),
        size_m=(1.0, 1.0, 0.0),
        colour=colour,
        shadow=tuple(shadow),
        body=tuple(body),
    )


@dataclass(frozen=True, slots=True)
class _Clumps:
    """Clumps of leaves, low ones first: places (n, 2), radii, heights from 0 to 1."""

    places: Points
    radii_m: Points
    heights: Points

    def at(self, place: Sequence[float] | Points) -> '_Clumps':
        """Return the clumps of a plant that stands at `place`."""
        return _Clumps(self.places + np.asarray(place, float), self.radii_m, self.heights)


def _crown(rng: np.random.Generator, radius_m: float, count: int) -> _Clumps:
    """Return the clumps of a rounded crown about the origin; its outline is lobed."""
    angles = rng.uniform(0.0, 2.0 * np.pi, count)
    lobes = (
        1.0
        + 0.13 * np.sin(3 * angles + rng.uniform(0, 6))
        + 0.1 * np.sin(5 * angles + rng.uniform(0, 6))
    )
    share = np.sqrt(rng.uniform(0.0, 1.0, count)) * lobes
    distances = 0.88 * radius_m * share
    places = np.column_stack([distances * np.cos(angles), distances * np.sin(angles)])
    heights = 1.0 - 0.8 * share**2 + rng.normal(0.0, 0.1, count)
    sizes = radius_m * rng.uniform(0.10, 0.26, count)
    order = np.argsort(heights)
    return _Clumps(places[order], sizes[order], heights[order].clip(0.02, 1.0))


def _lit(rng: np.random.Generator, clumps: _Clumps, colour: Colour) -> Dots:
    """Return clumps painted: the sun's side of the plant and of each clump is brighter."""
    to_sun = np.array(SUN_ENU[:2]) / np.hypot(*SUN_ENU[:2])
    count = len(clumps.heights)
    centre = clumps.places.mean(axis=0)
    reach = np.abs(clumps.places - centre).max() + 1e-9
    towards = ((clumps.places - centre) @ to_sun / reach).clip(-1.0, 1.0)
    light = 0.58 + 0.42 * clumps.heights + 0.22 * towards
    tints = np.array(colour, float) * rng.uniform(0.86, 1.14, (count, 1))
    tints += rng.normal(0.0, 3.5, (count, 3))
    parts = (
        (0.0, 1.0, 0.66),
        (0.2, 0.82, 0.9),
        (0.42, 0.52, 1.12),
        (0.55, 0.26, 1.3),
    )
    centres = np.stack(
        [clumps.places + shift * clumps.radii_m[:, None] * to_sun for shift, _, _ in parts], axis=1
    )
    radii = np.stack([size * clumps.radii_m for _, size, _ in parts], axis=1)
    colours = np.stack([tints * (light * factor)[:, None] for _, _, factor in parts], axis=1)
    values = np.dstack([colours.clip(0, 255), np.full(radii.shape, float(_GRAIN))])
    return Dots(centres.reshape(-1, 2), radii.ravel(), values.reshape(-1, 4))
