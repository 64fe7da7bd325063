# SPDX-License-Identifier: Apache-2.0
"""The straight lines of a tour, and the cells that the vehicle is in for how long."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_ground.drivable.route_grid import RouteGrid
from rocsafe_ground.route.constrained import GridPath
from rocsafe_ground.route.edges import Edges
from rocsafe_ground.route.straightening import Surface, straightened


@dataclass(frozen=True, slots=True, kw_only=True)
class Bend:
    """A cell where lines meet: leg, whether it is the end of the leg, speed on the line to it."""

    cell: int
    leg: int
    is_end: bool
    speed_mps: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Track:
    """Samples along all lines.

    Attributes
    ----------
    bends
        Ends of the lines, the start first.
    spots : (n, 2)
        Row and column of each sample; whole numbers are the middles of cells.
    cells, seconds : (n,)
        Cell of each sample and the time that it stands for.
    leg_ends
        Sample at which each leg ends.
    """

    bends: tuple[Bend, ...]
    spots: FloatArray
    cells: IndexArray
    seconds: FloatArray
    leg_ends: tuple[int, ...]

    def places_m(self, grid: RouteGrid) -> FloatArray:
        """Return east and north of the samples, (n, 2)."""
        corner = np.array([grid.west_m, grid.south_m])
        return np.asarray(corner + (self.spots[:, ::-1] + 0.5) * grid.cell_m)


def track_of(legs: Sequence[GridPath], edges: Edges, surface: Surface) -> Track:
    """Return the straight lines in place of the ways of a tour."""
    first = int(legs[0].cells[0])
    bends = [Bend(cell=first, leg=-1, is_end=True, speed_mps=0.0)]
    spots, seconds, leg_ends, count = [], [], [], 0
    for number, leg in enumerate(legs):
        corners = straightened(leg.cells, edges.step_costs(leg.cells), surface).tolist()
        for a, b in itertools.pairwise(corners):
            line, length = surface.line(a, b)
            times = _times(line, length, surface)
            spots.append(line)
            seconds.append(times)
            count += len(line)
            speed = length / max(float(times.sum()), 1e-9)
            bends.append(Bend(cell=b, leg=number, is_end=b == corners[-1], speed_mps=speed))
        leg_ends.append(max(count - 1, 0))
    if not spots:
        spots, seconds = [np.array([divmod(first, edges.shape[1])], np.float64)], [np.zeros(1)]
    places = np.concatenate(spots)
    rows, columns = np.rint(places).astype(np.int64).T
    return Track(
        bends=tuple(bends), spots=places, cells=rows * edges.shape[1] + columns,
        seconds=np.concatenate(seconds), leg_ends=tuple(leg_ends),
    )  # fmt: skip


def _times(line: FloatArray, length_m: float, surface: Surface) -> FloatArray:
    """Return the time that each sample of a line stands for."""
    rows, columns = np.rint(line).astype(np.int64).T
    weights = np.full(len(line), length_m / max(len(line) - 1, 1))
    weights[[0, -1]] *= 0.5
    return np.asarray(weights * surface.slowness_spm[rows, columns])
