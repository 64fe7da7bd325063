# SPDX-License-Identifier: Apache-2.0
"""A request on a map: what is searched, and what the drive of a tour takes."""

import math
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_ground.dose.forecast import DoseForecast, Draws, forecast_of
from rocsafe_ground.dose.toxic_load import GasExposure
from rocsafe_ground.drive.drive_plan import DriveRequest, LeftOut
from rocsafe_ground.drive.ground_map import GroundMap
from rocsafe_ground.drive.stands import Stand, stand_of, start_cell
from rocsafe_ground.drive.track import Track, track_of
from rocsafe_ground.errors import NoMapError, NoWayError
from rocsafe_ground.route.edges import SECONDS_PER_HOUR, Searcher, edges_of
from rocsafe_ground.route.straightening import Surface
from rocsafe_ground.tour.tour import TourSearch
from rocsafe_ground.tour.trip import Budgets, Tour, TourPoint


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drive:
    """A tour as it is driven, in straight lines and with inertia.

    Attributes
    ----------
    tour
        Over cells.
    track
        Its lines.
    time_s
        Driving and dwells.
    forecast
        Dose.
    gas
        Gas along it; None: none was found.
    """

    tour: Tour
    track: Track
    time_s: float
    forecast: DoseForecast
    gas: GasExposure | None

    @property
    def load(self) -> float:
        """Toxic load at the upper 95 % bound of the gas, over that of its level; 0: not known."""
        share = self.gas.load_upper_share if self.gas else 0.0
        return share if math.isfinite(share) else 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Task:
    """A request on a map: the search, and where the vehicle can stand."""

    request: DriveRequest
    ground: GroundMap
    searcher: Searcher
    surface: Surface
    search: TourSearch
    stands: tuple[Stand, ...]

    @property
    def budgets(self) -> Budgets:
        """What the drive may take."""
        request = self.request
        return Budgets(
            dose_usv=request.dose_budget_usv,
            time_s=request.vehicle.endurance_s,
            load=request.load_budget,
        )

    def within(self, budgets: Budgets) -> 'Task':
        """Return the same task with other budgets."""
        vehicle = replace(self.request.vehicle, endurance_s=budgets.time_s)
        request = replace(
            self.request, dose_budget_usv=budgets.dose_usv, load_budget=budgets.load,
            vehicle=vehicle,
        )  # fmt: skip
        return replace(self, request=request)

    def drive(self, tour: Tour) -> Drive:
        """Return a tour as it is driven."""
        request, gas = self.request, self.ground.gas
        looks = [self.look_rad(k) for k in tour.order]
        track = track_of(tour.legs, self.searcher.edges, self.surface, looks)
        cells, seconds = self._spent(tour, track)
        draws = Draws(count=request.draws, seed=request.seed, confidence=request.confidence)
        return Drive(
            tour=tour,
            track=track,
            time_s=float(seconds.sum()),
            forecast=forecast_of(
                self.ground.field, cells, seconds, request.dose_budget_usv, draws
            ),
            gas=None if gas is None else gas.exposure(cells, seconds),
        )

    def look_rad(self, number: int) -> float:
        """Return the direction from a stand to its evidence, from east to north."""
        stand, grid = self.stands[number], self.ground.grid
        east, north = grid.place_of(int(stand.cell or 0))[0].tolist()
        to_east, to_north = grid.enu_of(stand.point.position)
        return math.atan2(to_north - north, to_east - east)

    def standing_usv(self, tour: Tour) -> float:
        """Return the estimated dose of the dwells."""
        rates = self.ground.field.mean_usvh.ravel()
        stands = [self.stands[k] for k in tour.order]
        return sum(
            float(rates[stand.cell]) * stand.point.dwell_s / SECONDS_PER_HOUR for stand in stands
        )

    def _spent(self, tour: Tour, track: Track) -> tuple[IndexArray, FloatArray]:
        """Return cells and the seconds in each, dwells included."""
        dwells = [self.stands[k] for k in tour.order]
        cells = np.concatenate([track.cells, [stand.cell for stand in dwells]]).astype(np.int64)
        seconds = np.concatenate([track.seconds, [stand.point.dwell_s for stand in dwells]])
        return cells, seconds


def task_of(request: DriveRequest, ground: GroundMap) -> tuple[Task, tuple[LeftOut, ...]]:
    """Return the task of a request, and the points that nothing drivable leads to.

    Raises
    ------
    NoMapError, NoWayError
        If the start cannot be driven from, or no evidence be driven to; if the toxic load is to
        be limited and that of the gas is not known.
    """
    loads, vehicle, cell_m = _loads(request, ground), request.vehicle, ground.grid.cell_m
    is_free, slowness, upper = ground.is_free, ground.ground.slowness_spm, ground.field.upper_usvh
    edges = edges_of(is_free, slowness, np.nan_to_num(upper), cell_m, loads)
    searcher = Searcher(edges)
    start = start_cell(ground, request.start)
    reached = np.isfinite(searcher.tree(start, (1.0, 0.0, 0.0)).costs).reshape(ground.grid.shape)
    stands = [stand_of(ground, point, reached) for point in request.evidence]
    refused = tuple(
        LeftOut(evidence=one.point.id, why=one.why) for one in stands if one.cell is None
    )
    found = tuple(one for one in stands if one.cell is not None)
    if not found:
        raise NoWayError('; '.join(f'{one.evidence}: {one.why}' for one in refused))
    end = None if request.end is None else start_cell(ground, request.end)
    points = [_tour_point(one, upper, loads) for one in found]
    surface = Surface(
        is_free=is_free, slowness_spm=slowness, rates_usvh=upper, cell_m=cell_m,
        aside_m=vehicle.kept_m(cell_m) - vehicle.clearance_m, loads_per_s=loads,
    )  # fmt: skip
    task = Task(
        request=request, ground=ground, searcher=searcher, surface=surface,
        search=TourSearch(searcher, start, points, end), stands=found,
    )  # fmt: skip
    return task, refused


def _loads(request: DriveRequest, ground: GroundMap) -> FloatArray | None:
    """Return the toxic load a second adds in each cell, None if it is not to be limited."""
    if math.isinf(request.load_budget) or ground.gas is None:
        return None
    loads = ground.gas.loads_per_s()
    if loads is None:
        raise NoMapError(
            f'{ground.gas.agent}: its toxic load is not known: it cannot be limited to '
            f'{request.load_budget:g}'
        )
    return loads


def _tour_point(stand: Stand, rates_usvh: FloatArray, loads: FloatArray | None) -> TourPoint:
    cell, dwell_s = int(stand.cell or 0), stand.point.dwell_s
    return TourPoint(
        cell=cell,
        dwell_s=dwell_s,
        dwell_usv=float(rates_usvh.ravel()[cell]) * dwell_s / SECONDS_PER_HOUR,
        dwell_load=0.0 if loads is None else float(loads.ravel()[cell]) * dwell_s,
        priority=stand.point.priority,
    )
