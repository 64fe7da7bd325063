# SPDX-License-Identifier: Apache-2.0
"""Grids to route on."""

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_ground.route.edges import Edges, edges_of

Grid = tuple[BoolArray, FloatArray, FloatArray]


def random_grid(rows: int, columns: int, seed: int, blocked: float = 0.15) -> Grid:
    """Return free cells, slowness (s/m) and dose rates (uSv/h) with hot sources in the way."""
    generator = np.random.default_rng([seed, rows, columns])
    is_free = generator.random((rows, columns)) >= blocked
    is_free[:2, :2] = is_free[-2:, -2:] = True
    slowness = generator.uniform(0.7, 2.2, (rows, columns))
    east, north = np.meshgrid(np.arange(columns), np.arange(rows))
    rates = np.full((rows, columns), 0.1)
    for _ in range(2):
        x, y = generator.uniform(0.2, 0.8, 2) * (columns, rows)
        rates += 10.0 ** generator.uniform(3, 5) / ((east - x) ** 2 + (north - y) ** 2 + 1.0)
    return is_free, slowness, rates


def random_edges(rows: int, columns: int, seed: int, blocked: float = 0.15) -> Edges:
    """Return the edges of a random grid with cells of 1 m."""
    return edges_of(*random_grid(rows, columns, seed, blocked), cell_m=1.0)
