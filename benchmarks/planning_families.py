# SPDX-License-Identifier: Apache-2.0
"""Routing instances of whole families, drawn by seed: what the search is developed and judged on.

A seed below 100 is for developing, from 100 on for validating, from 200 on for the one opening at
the end. Families differ in where places lie and where the depot is: see `FAMILIES` and `DEPOTS`.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
SIDE_M = 1000.0
SETS = {'develop': 0, 'validate': 100, 'open': 200}
"""First seed of each set."""
VEHICLES = (2, 3, 5, 8, 12, 20)
LEAST_PLACES, MOST_PLACES = 40, 2400


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """An instance: its name, its places (n, 2) with the depot first, its number of vehicles."""

    name: str
    places: Floats
    vehicles: int


def drawn(which: str, number: int) -> Drawn:
    """Return instance `number` of a set; every family and depot has its turn."""
    generator = np.random.default_rng(SETS[which] + number)
    family = tuple(FAMILIES)[number % len(FAMILIES)]
    depot = tuple(DEPOTS)[(number // len(FAMILIES) + number) % len(DEPOTS)]
    wanted = int(LEAST_PLACES * (MOST_PLACES / LEAST_PLACES) ** generator.random())
    vehicles = int(generator.choice([m for m in VEHICLES if m <= wanted // 8]))
    places = FAMILIES[family](generator, wanted)
    places = places[generator.permutation(len(places))]
    name = f'{which} {number}: {family} n={len(places)} m={vehicles} depot {depot}'
    home = DEPOTS[depot](places)
    return Drawn(name=name, places=np.vstack([home, places]), vehicles=vehicles)


def _uniform(generator: np.random.Generator, count: int) -> Floats:
    return SIDE_M * generator.random((count, 2))


def _clustered(generator: np.random.Generator, count: int) -> Floats:
    """Towns of unlike size and width, and a tenth of the places anywhere."""
    towns = SIDE_M * generator.random((int(generator.integers(4, 20)), 2))
    shares = generator.dirichlet(np.full(len(towns), 0.7))
    town = generator.choice(len(towns), count, p=shares)
    widths = generator.uniform(10.0, 80.0, len(towns))[town]
    places = towns[town] + widths[:, None] * generator.normal(size=(count, 2))
    alone = generator.random(count) < 0.1
    return np.where(alone[:, None], _uniform(generator, count), places)


def _board(generator: np.random.Generator, count: int) -> Floats:
    """Holes of a drilling board: blocks of a fine pattern, rows of pins between, doubles apart."""
    blocks: list[Floats] = []
    made = 0
    while made < count:
        rows, columns = (int(k) for k in generator.integers(2, 14, 2))
        pitch = float(generator.choice([2.54, 5.08, 10.16]))
        spots = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), -1).reshape(-1, 2)
        corner = np.round(SIDE_M * generator.random(2) / 2.54) * 2.54
        blocks.append(corner + pitch * spots)
        made += len(spots)
    return np.unique(np.vstack(blocks)[:count], axis=0)


def _grid(generator: np.random.Generator, count: int) -> Floats:
    """A survey grid of any aspect, turned, without some of its corners."""
    aspect = 2.0 ** generator.uniform(0.0, 3.0)
    columns = max(2, round((count * aspect) ** 0.5))
    rows = max(2, round(count / columns))
    spots = np.stack(np.meshgrid(25.0 * np.arange(columns), 18.0 * np.arange(rows)), -1)
    return _turned(generator, spots.reshape(-1, 2))


def _road(generator: np.random.Generator, count: int) -> Floats:
    """Places along bent roads between towns."""
    roads: list[Floats] = []
    for _ in range(int(generator.integers(3, 9))):
        bends = np.cumsum(generator.normal(size=(8, 2)) * 120.0, axis=0)
        bends += SIDE_M * generator.random(2)
        at = np.sort(generator.uniform(0.0, 7.0, count))
        along = np.column_stack([np.interp(at, np.arange(8), bends[:, k]) for k in (0, 1)])
        roads.append(along + 4.0 * generator.normal(size=along.shape))
    return generator.permutation(np.vstack(roads))[:count]


def _survey(generator: np.random.Generator, count: int) -> Floats:
    """Several surveyed fields: grids of unlike directions, apart from each other."""
    parts = generator.multinomial(count, generator.dirichlet(np.full(4, 2.0)))
    fields = [_grid(generator, max(4, int(part))) + 1500.0 * generator.random(2) for part in parts]
    return np.unique(np.vstack(fields), axis=0)


def _turned(generator: np.random.Generator, places: Floats) -> Floats:
    angle = generator.uniform(0.0, np.pi)
    cos, sin = np.cos(angle), np.sin(angle)
    turned: Floats = places @ np.array([[cos, sin], [-sin, cos]])
    return turned


FAMILIES: dict[str, Callable[[np.random.Generator, int], Floats]] = {
    'uniform': _uniform,
    'clustered': _clustered,
    'board': _board,
    'grid': _grid,
    'road': _road,
    'survey': _survey,
}
DEPOTS: dict[str, Callable[[Floats], Floats]] = {
    'corner': lambda places: places.min(axis=0),
    'centre': lambda places: 0.5 * (places.min(axis=0) + places.max(axis=0)),
    'outside': lambda places: 1.6 * places.min(axis=0) - 0.6 * places.max(axis=0),
}
