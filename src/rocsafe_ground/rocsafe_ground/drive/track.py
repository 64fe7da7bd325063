# SPDX-License-Identifier: Apache-2.0
"""The straight lines of a tour, and the cells that the vehicle is in for how long."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_geo.motion.ground_motion import GroundMotion
from rocsafe_ground.drivable.route_grid import RouteGrid
from rocsafe_ground.route.edges import Edges, GridPath
from rocsafe_ground.route.straightening import Surface, straightened

# Acceleration and turns of the vehicle that is planned for.
MOTION = GroundMotion()


@dataclass(frozen=True, slots=True, kw_only=True)
class Bend:
    """A cell where lines meet.

    Attributes
    ----------
    cell
        The cell.
    leg, is_end
        Leg that leads to it, and whether that ends there.
    speed_mps
        Of the line that leads to it, when it is driven without a stop.
    duration_s
        Of that line, with speeding up, braking and the turn in place before it.
    samples
        First sample of that line and the one after its last.
    """

    cell: int
    leg: int
    is_end: bool
    speed_mps: float
    duration_s: float = 0.0
    samples: tuple[int, int] = (0, 0)


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


def track_of(
    legs: Sequence[GridPath],
    edges: Edges,
    surface: Surface,
    looks_rad: Sequence[float | None] = (),
) -> Track:
    """Return the straight lines in place of the ways of a tour.

    `looks_rad` says where the vehicle looks while it stands at the end of each leg; None, or no
    entry: it drives on.
    """
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
            speed = length / max(float(times.sum()), 1e-9)
            bends.append(
                Bend(
                    cell=b, leg=number, is_end=b == corners[-1], speed_mps=speed,
                    samples=(count, count + len(line)),
                )
            )  # fmt: skip
            count += len(line)
        leg_ends.append(max(count - 1, 0))
    if not spots:
        spots, seconds = [np.array([divmod(first, edges.shape[1])], np.float64)], [np.zeros(1)]
    places = np.concatenate(spots)
    rows, columns = np.rint(places).astype(np.int64).T
    driven = _driven(bends, edges, looks_rad)
    return Track(
        bends=driven, spots=places, cells=rows * edges.shape[1] + columns,
        seconds=_stretched(np.concatenate(seconds), driven), leg_ends=tuple(leg_ends),
    )  # fmt: skip


def _driven(
    bends: Sequence[Bend], edges: Edges, looks_rad: Sequence[float | None]
) -> tuple[Bend, ...]:
    """Return the bends with the time that each line takes a vehicle with inertia."""
    looks = [
        looks_rad[bend.leg] if bend.is_end and 0 <= bend.leg < len(looks_rad) else None
        for bend in bends
    ]
    cells = [divmod(bend.cell, edges.shape[1]) for bend in bends]
    places = [(column * edges.cell_m, row * edges.cell_m) for row, column in cells]
    speeds = [max(bend.speed_mps, 1e-3) for bend in bends]
    durations = MOTION.durations_s(places, speeds, looks)
    return tuple(
        replace(bend, duration_s=duration) for bend, duration in zip(bends, durations, strict=True)
    )


def _stretched(seconds: FloatArray, bends: Sequence[Bend]) -> FloatArray:
    """Return the times of samples, each line with its duration; turns are at its beginning."""
    found = seconds.copy()
    for bend in bends:
        begin, end = bend.samples
        if end > begin:
            found[begin] += max(0.0, bend.duration_s - float(seconds[begin:end].sum()))
    return found


def _times(line: FloatArray, length_m: float, surface: Surface) -> FloatArray:
    """Return the time that each sample of a line stands for."""
    rows, columns = np.rint(line).astype(np.int64).T
    weights = np.full(len(line), length_m / max(len(line) - 1, 1))
    weights[[0, -1]] *= 0.5
    return np.asarray(weights * surface.slowness_spm[rows, columns])
