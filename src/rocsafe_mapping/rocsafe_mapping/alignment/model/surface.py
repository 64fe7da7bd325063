# SPDX-License-Identifier: Apache-2.0
"""The ground's height as a coarse grid, where photographs show that it is not level."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.sparse import csr_matrix, diags, identity, kron, vstack

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.model.normal_equations import factored
from rocsafe_mapping.alignment_options import GroundOptions


@dataclass(frozen=True, slots=True, kw_only=True)
class Surface:
    """Heights at the nodes of a grid, bilinear between them, level beyond its edge.

    Attributes
    ----------
    west_m, south_m
        Local place of node (0, 0).
    cell_m
        Distance of nodes.
    heights_m
        Shape (rows northwards, columns eastwards); a single 0 for level ground.
    """

    west_m: float = 0.0
    south_m: float = 0.0
    cell_m: float = 1.0
    heights_m: FloatArray = field(default_factory=lambda: np.zeros((1, 1)))

    @property
    def is_level(self) -> bool:
        """Whether all ground is at height 0."""
        return self.heights_m.size == 1

    def at(self, ground_m: FloatArray) -> FloatArray:
        """Return the heights (n,) at points (n, 2)."""
        if self.is_level:
            return np.full(len(ground_m), self.heights_m[0, 0])
        nodes, weights = self.weights(ground_m)
        return np.sum(self.heights_m.ravel()[nodes] * weights, axis=1)

    def weights(self, ground_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the four nodes about each point (n, 4) and their weights (n, 4)."""
        rows, columns = self.heights_m.shape
        x = np.clip((ground_m[:, 0] - self.west_m) / self.cell_m, 0.0, columns - 1.001)
        y = np.clip((ground_m[:, 1] - self.south_m) / self.cell_m, 0.0, rows - 1.001)
        column, row = x.astype(int), y.astype(int)
        x, y = x - column, y - row
        node = row * columns + column
        nodes = np.stack([node, node + 1, node + columns, node + columns + 1], axis=1)
        weights = np.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y], axis=1)
        return nodes, weights

    def fitted(
        self,
        ground_m: FloatArray,
        heights_m: FloatArray,
        std_m: FloatArray,
        options: GroundOptions,
    ) -> 'Surface':
        """Return this grid fitted to points of the ground, smoothly and robustly.

        Parameters
        ----------
        ground_m
            (east, north), shape (n, 2).
        heights_m, std_m
            Measured there and how well, shape (n,).
        """
        rows, columns = self.heights_m.shape
        design = self._design(ground_m)
        rest = _stiffness(rows, columns, options)
        variance = std_m**2 + options.clutter_std_m**2
        found: FloatArray = self.heights_m.ravel()
        for _ in range(options.rounds):
            off = heights_m - design @ found
            trust = 1.0 / (variance * np.sqrt(1.0 + off**2 / (4.0 * variance)))
            normal = design.T @ diags(trust) @ design + rest
            before, found = found, factored(normal).solve(design.T @ (trust * heights_m))
            if np.max(np.abs(found - before)) < options.settled_m:
                break
        return self.with_heights(found.reshape(rows, columns))

    def uncertainty_m(
        self, ground_m: FloatArray, std_m: FloatArray, options: GroundOptions
    ) -> FloatArray:
        """Return the standard errors of the nodes of a grid fitted to points, see `fitted`.

        It is computed from random grounds drawn with the covariance of the fit.
        """
        rows, columns = self.heights_m.shape
        design = diags(1.0 / std_m) @ self._design(ground_m)
        roots = vstack([design, *_stiffness_roots(rows, columns, options)]).tocsr()
        factor = factored(roots.T @ roots)
        draws = np.random.default_rng(0).standard_normal((roots.shape[0], options.samples))
        found = np.sqrt(np.mean(factor.solve(np.asarray(roots.T @ draws)) ** 2, axis=1))
        return np.asarray(found).reshape(rows, columns)

    def with_heights(self, heights_m: FloatArray) -> 'Surface':
        """Return this grid with other heights."""
        return replace(self, heights_m=heights_m)

    def _design(self, ground_m: FloatArray) -> csr_matrix:
        """Return the matrix (n, nodes) that interpolates heights at points (n, 2)."""
        nodes, weights = self.weights(ground_m)
        line = np.repeat(np.arange(len(nodes)), 4)
        shape = (len(nodes), self.heights_m.size)
        return csr_matrix((weights.ravel(), (line, nodes.ravel())), shape=shape)


def level_grid(ground_m: FloatArray, cell_m: float, most_nodes: int) -> Surface:
    """Return level ground as a grid that holds all points (n, 2)."""
    low, high = ground_m.min(axis=0), ground_m.max(axis=0)
    columns, rows = (np.ceil((high - low) / cell_m).astype(int) + 2).tolist()
    while rows * columns > most_nodes:
        cell_m *= 1.5
        columns, rows = (np.ceil((high - low) / cell_m).astype(int) + 2).tolist()
    return Surface(
        west_m=float(low[0]) - 0.5 * cell_m,
        south_m=float(low[1]) - 0.5 * cell_m,
        cell_m=cell_m,
        heights_m=np.zeros((rows, columns)),
    )


def _stiffness(rows: int, columns: int, options: GroundOptions) -> csr_matrix:
    """Return the information that heights are small and change evenly."""
    roots = vstack(_stiffness_roots(rows, columns, options)).tocsr()
    stiffness: csr_matrix = roots.T @ roots
    return stiffness


def _stiffness_roots(rows: int, columns: int, options: GroundOptions) -> tuple[csr_matrix, ...]:
    """Return matrices whose products with heights have unit variance."""
    along = kron(identity(rows), _second_differences(columns))
    across = kron(_second_differences(rows), identity(columns))
    level = identity(rows * columns) / options.relief_std_m
    return along / options.bend_std_m, across / options.bend_std_m, level


def _second_differences(count: int) -> csr_matrix:
    return diags([1.0, -2.0, 1.0], [0, 1, 2], shape=(max(count - 2, 0), count)).tocsr()
