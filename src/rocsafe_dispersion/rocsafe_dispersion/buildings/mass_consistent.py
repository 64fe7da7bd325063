# SPDX-License-Identifier: Apache-2.0
"""The wind nearest to a first guess that loses no air and enters no wall.

Sherman 1978 (J. Appl. Meteorol. 17, 312): the correction is the gradient of a potential. Air may
pass the sides and the top of the box (potential 0), not the ground and no wall (gradient 0).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import fft

from rocsafe_geo.arrays import BoolArray
from rocsafe_geo.wind.air_grid import AirGrid, Cells, FaceVelocities, sum_of


@dataclass(frozen=True, slots=True, kw_only=True)
class CorrectionOptions:
    """How exactly air is conserved.

    Attributes
    ----------
    divergence
        Largest divergence of a cell, as a share of the largest speed over the cell size.
    most_steps
        Steps after which the search ends without having reached it.
    """

    divergence: float = 1e-3
    most_steps: int = 60


def corrected(
    guess: FaceVelocities,
    solid: BoolArray,
    grid: AirGrid,
    options: CorrectionOptions | None = None,
) -> FaceVelocities:
    """Return the velocities nearest to `guess` without divergence and without flow into walls.

    The equation of the potential is solved by conjugate gradients; the same box without walls,
    which cosine transforms solve at once, is the preconditioner.

    Parameters
    ----------
    guess
        First guess.
    solid : (columns, rows, layers)
        Cells without air.
    grid
        Where the cells lie.
    options
        How exactly.
    """
    options = options or CorrectionOptions()
    opened = _openings(solid)
    velocity = [part * gate for part, gate in zip(guess.parts, opened, strict=True)]
    speed = max(float(np.abs(part).max()) for part in velocity)
    if speed == 0.0:
        return FaceVelocities(east=velocity[0], north=velocity[1], up=velocity[2])
    limit = options.divergence * speed / float(grid.sizes_m.max())
    wanted = FaceVelocities(east=velocity[0], north=velocity[1], up=velocity[2]).divergence(grid)
    potential = _solve(wanted, opened, solid, grid, limit, options.most_steps)
    for axis, (part, gate) in enumerate(zip(velocity, opened, strict=True)):
        part -= gate * _gradient(potential, axis, grid)
    return FaceVelocities(east=velocity[0], north=velocity[1], up=velocity[2])


def _openings(solid: BoolArray) -> list[Cells]:
    """Return 1 for each face that air may pass and 0 for walls and the ground."""
    gates = []
    for axis in range(3):
        padded = np.concatenate(
            [np.take(solid, [0], axis), solid, np.take(solid, [-1], axis)], axis=axis
        )
        size = padded.shape[axis]
        first = np.take(padded, range(size - 1), axis)
        second = np.take(padded, range(1, size), axis)
        gates.append((~(first | second)).astype(np.float32))
    gates[2][:, :, 0] = 0.0
    return gates


def _gradient(potential: Cells, axis: int, grid: AirGrid) -> Cells:
    """Return the gradient through the faces across an axis; outside the potential is 0."""
    pad = [(1, 1) if i == axis else (0, 0) for i in range(3)]
    # The value 0 lies on the outer face itself, half a cell from the middle.
    padded = np.pad(potential, pad)
    first: list[Any] = [slice(None)] * 3
    last: list[Any] = [slice(None)] * 3
    first[axis], last[axis] = 0, -1
    inner_first, inner_last = list(first), list(last)
    inner_first[axis], inner_last[axis] = 1, -2
    padded[tuple(first)] = -padded[tuple(inner_first)]
    padded[tuple(last)] = -padded[tuple(inner_last)]
    return np.asarray(np.diff(padded, axis=axis) / np.float32(grid.sizes_m[axis]))


def _solve(
    wanted: Cells,
    opened: list[Cells],
    solid: BoolArray,
    grid: AirGrid,
    limit: float,
    most_steps: int,
) -> Cells:
    """Return the potential whose flow through the open faces has the divergence `wanted`."""
    free = (~solid).astype(np.float32)
    sizes = [np.float32(size) for size in grid.sizes_m]

    def leaving(potential: Cells) -> Cells:
        flows = (opened[i] * _gradient(potential, i, grid) for i in range(3))
        return sum_of(np.diff(flow, axis=i) / sizes[i] for i, flow in enumerate(flows))

    eigenvalues = _eigenvalues(grid)
    potential = np.zeros_like(wanted)
    residual = wanted * free
    step = free * _solve_empty(residual, eigenvalues)
    strength = _dot(residual, step)
    for _ in range(most_steps):
        if float(np.abs(residual).max()) <= 0.5 * limit:
            break
        change = leaving(step) * free
        length = np.float32(strength / _dot(step, change))
        potential += length * step
        residual -= length * change
        better = free * _solve_empty(residual, eigenvalues)
        strength, last = _dot(residual, better), strength
        step = better + np.float32(strength / last) * step
    return potential


def _dot(first: Cells, second: Cells) -> float:
    return float(np.dot(first.ravel(), second.ravel()))


def _eigenvalues(grid: AirGrid) -> Cells:
    """Return those of the Laplacian of the box: 0 outside on all faces but the lowest."""
    columns, rows, layers = grid.shape
    east = -4.0 / grid.cell_m**2 * np.sin(np.pi * np.arange(1, columns + 1) / 2 / columns) ** 2
    north = -4.0 / grid.cell_m**2 * np.sin(np.pi * np.arange(1, rows + 1) / 2 / rows) ** 2
    halves = np.arange(layers) + 0.5
    up = -4.0 / grid.layer_m**2 * np.sin(np.pi * halves / 2 / layers) ** 2
    return np.asarray(east[:, None, None] + north[:, None] + up, np.float32)


def _solve_empty(wanted: Cells, eigenvalues: Cells) -> Cells:
    """Return the potential in the box without walls whose Laplacian is `wanted`."""
    waves = fft.dstn(wanted, type=2, axes=(0, 1), overwrite_x=False)
    waves = fft.dct(waves, type=4, axis=2, overwrite_x=True)
    waves /= eigenvalues
    waves = fft.idct(waves, type=4, axis=2, overwrite_x=True)
    return np.asarray(fft.idstn(waves, type=2, axes=(0, 1), overwrite_x=True))
