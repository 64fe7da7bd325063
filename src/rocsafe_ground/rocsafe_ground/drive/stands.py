# SPDX-License-Identifier: Apache-2.0
"""Where the vehicle stands to take evidence: a free cell in reach, with the lowest dose rate."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label

from rocsafe_geo.arrays import BoolArray, FloatArray, IndexArray
from rocsafe_geo.position import GeoPosition
from rocsafe_ground.drivable.drivable_ground import Reason
from rocsafe_ground.drive.ground_map import GroundMap
from rocsafe_ground.errors import NoMapError, NoWayError
from rocsafe_ground.evidence.evidence_point import EvidencePoint

# A start that the map takes for blocked, such as the shadow of a tent, is moved by no more.
START_REACH_M = 3.0
# Cells that a vehicle does not cross to get away from an obstacle that it stands too near to.
CROSSED_BY_NOTHING = (Reason.KEEP_OUT, Reason.OBSTACLE, Reason.STEEP, Reason.ROUGH)
REASON_TEXTS = {
    Reason.UNKNOWN: 'ground that was not seen',
    Reason.KEEP_OUT: 'a zone not to be entered',
    Reason.OBSTACLE: 'an obstacle',
    Reason.STEEP: 'ground that is too steep',
    Reason.ROUGH: 'ground that is too rough',
    Reason.TOO_NEAR: 'ground too near an obstacle',
    Reason.HOT: 'a dose rate at which the vehicle turns back',
    Reason.GASSED: 'a concentration of gas at which the vehicle turns back',
    Reason.FREE: 'ground that nothing drivable leads to',
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Stand:
    """Where the vehicle stands for a point: a cell; None: nowhere, `why` says the reason."""

    point: EvidencePoint
    cell: int | None
    why: str = ''


def start_cell(ground: GroundMap, start: GeoPosition) -> int:
    """Return the free cell nearest to the start, of those on its side of obstacles.

    Raises
    ------
    NoMapError
        If the start is beyond the map.
    NoWayError
        If no free cell is near.
    """
    place = ground.grid.enu_of(start)
    cell = ground.grid.cell_of(*place)
    if cell is None:
        raise NoMapError(f'the start {_text(start)} is beyond the map{_by(ground, place)}')
    is_here = _on_this_side(ground, cell)
    near, distance = _near(ground, place, START_REACH_M, ground.is_free & is_here)
    if not len(near):
        raise NoWayError(
            f'the start {_text(start)} is on {_reason(ground, place)}: no drivable ground is '
            f'within {START_REACH_M:g} m'
        )
    return int(near[distance.argmin()])


def _on_this_side(ground: GroundMap, cell: int) -> BoolArray:
    """Return the cells that a start leads to without a way over obstacles; on one: all cells."""
    sides, _ = label(~np.isin(ground.reasons, CROSSED_BY_NOTHING))
    here = int(sides.ravel()[cell])
    return np.asarray((sides == here) | (here == 0))


def stand_of(ground: GroundMap, point: EvidencePoint, is_reached: BoolArray) -> Stand:
    """Return where to stand for a point, of the free cells that can be reached."""
    place = ground.grid.enu_of(point.position)
    if ground.grid.cell_of(*place) is None:
        return Stand(point=point, cell=None, why=f'it is beyond the map{_by(ground, place)}')
    near, distance = _near(ground, place, point.reach_m, is_reached)
    if not len(near):
        return Stand(
            point=point, cell=None,
            why=f'it is on {_reason(ground, place)}, and nothing within {point.reach_m:g} m of it '
            f'can be driven to{_nearest(ground, place, is_reached)}',
        )  # fmt: skip
    row, column = np.divmod(near, ground.grid.columns)
    rates = ground.field.upper_usvh[row, column]
    # The lowest dose rate; among equal ones the nearest.
    best = np.lexsort((distance, np.round(rates, 6)))[0]
    return Stand(point=point, cell=int(near[best]))


def _near(
    ground: GroundMap, place: tuple[float, float], reach_m: float, is_wanted: BoolArray
) -> tuple[IndexArray, FloatArray]:
    """Return wanted cells within reach of a place, and their distances."""
    # The middle of the cell that the place is in may be half a diagonal away.
    cells, distances = ground.grid.cells_within(*place, max(reach_m, 0.75 * ground.grid.cell_m))
    is_found = is_wanted.ravel()[cells]
    return cells[is_found], distances[is_found]


def _nearest(ground: GroundMap, place: tuple[float, float], is_reached: BoolArray) -> str:
    """Return how far from a place the vehicle could get, and where."""
    cells, distance = _near(ground, place, math.inf, is_reached)
    if not len(cells):
        return ''
    best = int(distance.argmin())
    there = ground.grid.position_at(*ground.grid.place_of(int(cells[best]))[0].tolist())
    return f': {_text(there)} is the nearest place that can be, {distance[best]:.1f} m from it'


def _reason(ground: GroundMap, place: tuple[float, float]) -> str:
    cell = ground.grid.cell_of(*place)
    if cell is None:
        return ''
    reason = Reason(int(ground.reasons.ravel()[cell]))
    if reason is not Reason.HOT:
        return REASON_TEXTS[reason]
    rate = float(ground.field.upper_usvh.ravel()[cell])
    return f'{REASON_TEXTS[reason]}, {rate:.4g} uSv/h of {ground.turn_back_usvh:.4g}'


def _by(ground: GroundMap, place: tuple[float, float]) -> str:
    """Return by how far a place is beyond the map; far ones hint at a wrong datum."""
    grid = ground.grid
    east = max(grid.west_m - place[0], place[0] - grid.west_m - grid.columns * grid.cell_m, 0.0)
    north = max(grid.south_m - place[1], place[1] - grid.south_m - grid.rows * grid.cell_m, 0.0)
    away = math.hypot(east, north)
    hint = ': is it latitude,longitude in WGS84?' if away > 5000.0 else ''
    return f', by {away:.0f} m{hint}'


def _text(place: GeoPosition) -> str:
    return f'{place.latitude_deg:.6f}, {place.longitude_deg:.6f}'
