# SPDX-License-Identifier: Apache-2.0
"""Trees, hedges and shrubs, each from leaf clumps of its own."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from rocsafe_sim.scenery.light import SUN_ENU, shadow_of_disc
from rocsafe_sim.scenery.marks import Colour, Mark, Paint, Placing, Points, disc
from rocsafe_sim.scenery.outlines import generator, smooth_line
from rocsafe_sim.scenery.scene import Thing

LEAVES: tuple[Colour, ...] = ((58, 84, 38), (70, 92, 40), (50, 76, 42), (84, 98, 44))
PINE: Colour = (40, 62, 44)
BLOSSOM: Colour = (196, 172, 60)
_GRAIN = 150


def tree(
    name: str, at: tuple[float, float], radius_m: float, height_m: float, seed: int,
    colour: Colour = LEAVES[0],
) -> Thing:
    """Return a broad-leaved tree: clumps of leaves, lit from the sun's side."""
    rng = generator(seed, int(at[0] * 100) & 0xFFFF, int(at[1] * 100) & 0xFFFF)
    count = int(14 + 9 * radius_m)
    places, sizes, heights = _clumps(rng, radius_m, count)
    centre = np.asarray(at, float)
    body = tuple(_lit_clumps(rng, centre + places, sizes, heights, colour))
    high = height_m * (0.45 + 0.4 * heights)
    shadow = tuple(
        shadow_of_disc(centre + place, 1.05 * size, up)
        for place, size, up in zip(places, sizes, high, strict=True)
    )
    return Thing(
        name=name,
        kind='tree',
        placing=Placing(*at),
        size_m=(2 * radius_m, 2 * radius_m, height_m),
        colour=colour,
        shadow=shadow,
        body=body,
    )


def hedge(
    name: str, line: ArrayLike, width_m: float, height_m: float, seed: int
) -> Thing:
    """Return a hedge along a line (n, 2)."""
    rng = generator(seed, len(name), int(abs(np.asarray(line).sum()) * 10) & 0xFFFF)
    path = smooth_line(line, 0.75)
    places = path + rng.normal(0.0, 0.16 * width_m, path.shape)
    sizes = rng.uniform(0.38, 0.62, len(path)) * width_m
    colour = LEAVES[int(rng.integers(len(LEAVES)))]
    body = _lit_clumps(rng, places, sizes, rng.uniform(0.2, 1.0, len(path)), colour)
    shadow = tuple(
        shadow_of_disc(place, size, 0.75 * height_m)
        for place, size in zip(places, sizes, strict=True)
    )
    middle = path.mean(axis=0)
    return Thing(
        name=name,
        kind='hedge',
        placing=Placing(float(middle[0]), float(middle[1])),
        size_m=(1.0, 1.0, 0.0),
        colour=colour,
        shadow=shadow,
        body=tuple(body),
    )


def shrubs(
    name: str, centre: tuple[float, float], spread_m: float, count: int, seed: int,
    colour: Colour = LEAVES[2],
) -> Thing:
    """Return a loose group of low shrubs."""
    rng = generator(seed, count, int(centre[0]) & 0xFFFF, int(centre[1]) & 0xFFFF)
    places = np.asarray(centre) + rng.normal(0.0, spread_m, (count, 2))
    sizes = rng.uniform(0.35, 1.1, count)
    shadow = tuple(
        shadow_of_disc(place, size, size) for place, size in zip(places, sizes, strict=True)
    )
    body: list[Mark] = []
    for place, size in zip(places, sizes, strict=True):
        offsets, clump_sizes, heights = _clumps(rng, size, 7)
        body += _lit_clumps(rng, place + offsets, clump_sizes, heights, colour)
    return Thing(
        name=name, kind='shrubs', placing=Placing(*centre), size_m=(1.0, 1.0, 0.0),
        colour=colour, shadow=shadow, body=tuple(body),
    )


def _clumps(
    rng: np.random.Generator, radius_m: float, count: int
) -> tuple[Points, Points, Points]:
    """Return places about the crown's centre, radii and relative heights of clumps, low first."""
    distances = radius_m * np.sqrt(rng.uniform(0.0, 1.0, count)) * 0.82
    angles = rng.uniform(0.0, 2.0 * np.pi, count)
    places = np.column_stack([distances * np.cos(angles), distances * np.sin(angles)])
    heights = 1.0 - 0.75 * (distances / radius_m) ** 2 + rng.normal(0.0, 0.08, count)
    sizes = radius_m * rng.uniform(0.20, 0.40, count)
    order = np.argsort(heights)
    return places[order], sizes[order], heights[order].clip(0.05, 1.0)


def _lit_clumps(
    rng: np.random.Generator, places: Points, sizes: Points, heights: Points, colour: Colour
) -> Iterator[Mark]:
    """Yield each clump as a dark rim, a body, and a lit cap towards the sun."""
    to_sun = np.array(SUN_ENU[:2])
    for place, size, height in zip(places, sizes, heights, strict=True):
        tint = np.array(colour) * rng.uniform(0.85, 1.15) + rng.normal(0.0, 4.0, 3)
        red, green, blue = (int(part) for part in tint.clip(0, 255))
        paint = Paint((red, green, blue), _GRAIN)
        light = 0.62 + 0.5 * height
        yield disc(place, size, paint.lit(0.62 * light))
        yield disc(place + 0.16 * size * to_sun, 0.86 * size, paint.lit(light))
        yield disc(place + 0.42 * size * to_sun, 0.48 * size, paint.lit(1.28 * light))
