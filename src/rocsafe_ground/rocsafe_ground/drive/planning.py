# SPDX-License-Identifier: Apache-2.0
"""Planning of a drive: stands at the evidence, the tour, straight lines, the check by draws."""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_ground.dose.forecast import DoseForecast, Draws, forecast_of
from rocsafe_ground.dose.toxic_load import GasExposure
from rocsafe_ground.drive.drive_plan import DrivePlan, DriveRequest, DriveStop, LeftOut
from rocsafe_ground.drive.ground_map import GroundMap
from rocsafe_ground.drive.stands import Stand, stand_of, start_cell
from rocsafe_ground.drive.track import Track, track_of
from rocsafe_ground.errors import BeyondBudgetError, NoWayError
from rocsafe_ground.route.edges import SECONDS_PER_HOUR, Searcher, edges_of
from rocsafe_ground.route.straightening import Surface
from rocsafe_ground.tour.orders import MOST_POINTS
from rocsafe_ground.tour.tour import Budgets, Tour, TourPoint, TourSearch

# Bisections of the budget that is planned for: to a hundredth of what is between.
MOST_TIGHTENINGS = 7
# How far something in the way may extend around where it was met.
BLOCKED_M = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class _Task:
    """A request on a map: the search, and where the vehicle can stand."""

    request: DriveRequest
    ground: GroundMap
    searcher: Searcher
    surface: Surface
    search: TourSearch
    stands: tuple[Stand, ...]

    def track(self, tour: Tour) -> Track:
        """Return the straight lines of a tour."""
        looks = [self.look_rad(k) for k in tour.order]
        return track_of(tour.legs, self.searcher.edges, self.surface, looks)

    def look_rad(self, number: int) -> float:
        """Return the direction from a stand to its evidence, from east to north."""
        stand, grid = self.stands[number], self.ground.grid
        east, north = grid.place_of(int(stand.cell or 0))[0].tolist()
        to_east, to_north = grid.enu_of(stand.point.position)
        return math.atan2(to_north - north, to_east - east)

    def forecast(self, tour: Tour) -> DoseForecast:
        """Return the dose of a tour, dwells included."""
        request = self.request
        cells, seconds = self._spent(tour)
        draws = Draws(count=request.draws, seed=request.seed, confidence=request.confidence)
        return forecast_of(self.ground.field, cells, seconds, request.dose_budget_usv, draws)

    def gas(self, tour: Tour) -> GasExposure | None:
        """Return the gas along a tour, dwells included; None: none was found."""
        gas = self.ground.gas
        return None if gas is None else gas.exposure(*self._spent(tour))

    def _spent(self, tour: Tour) -> tuple[IndexArray, FloatArray]:
        """Return cells and the seconds in each, dwells included."""
        track, dwells = self.track(tour), [self.stands[k] for k in tour.order]
        cells = np.concatenate([track.cells, [stand.cell for stand in dwells]]).astype(np.int64)
        seconds = np.concatenate([track.seconds, [stand.point.dwell_s for stand in dwells]])
        return cells, seconds


def plan_drive(request: DriveRequest, ground: GroundMap) -> DrivePlan:
    """Return the fastest drive to the evidence and back within the budgets.

    Raises
    ------
    NoMapError, NoWayError
        If the start cannot be driven from, or no evidence be driven to.
    BeyondBudgetError
        If no evidence point can be visited within the budgets; names what would do.

    Examples
    --------
    A meadow of 60 x 60 m, hot in its middle; the evidence is on the other side. `read_ground_map`
    makes such a map of the products of a run.

    >>> from rocsafe_geo.position import GeoPosition
    >>> from rocsafe_ground.dose.dose_field import DoseField
    >>> from rocsafe_ground.drivable.drivable_ground import DrivableGround
    >>> from rocsafe_ground.drivable.route_grid import RouteGrid
    >>> from rocsafe_ground.evidence.evidence_point import EvidencePoint
    >>> origin = GeoPosition(53.28, -9.06, 0.0)
    >>> grid = RouteGrid(origin=origin, west_m=-30, south_m=-30, cell_m=1.0, rows=60, columns=60)
    >>> east, north = grid.places()
    >>> rates = 0.1 + 5e4 / (east**2 + north**2)
    >>> ground = GroundMap(
    ...     grid=grid,
    ...     ground=DrivableGround(reasons=np.zeros(grid.shape, int), slowness_spm=rates * 0 + 1.0),
    ...     field=DoseField(mean_usvh=rates, upper_usvh=1.2 * rates, grid=grid, posterior=None,
    ...                     ratio=rates),
    ...     turn_back_usvh=1e5,
    ... )
    >>> def plan_within(budget_usv):
    ...     mark = EvidencePoint(id='mark', position=grid.position_at(25.0, 0.0))
    ...     start = grid.position_at(-25.0, 0.0)
    ...     return plan_drive(
    ...         DriveRequest(start=start, evidence=(mark,), dose_budget_usv=budget_usv), ground
    ...     )
    >>> straight, around = plan_within(1e4), plan_within(15.0)
    >>> straight.forecast.mean_usv > 50.0 > 15.0 > around.forecast.mean_usv
    True
    >>> straight.time_s < around.time_s
    True
    >>> around.gap_fraction < 0.01  # proven: no trip over these cells is 1 % faster
    True
    """
    if request.blocked:
        ground = ground.blocked_at(request.blocked, request.vehicle.reach_m + BLOCKED_M)
    task, refused = _task(request, ground)
    tour, forecast = _safe_tour(task)
    return _plan(task, tour, forecast, refused)


def _task(request: DriveRequest, ground: GroundMap) -> tuple[_Task, tuple[LeftOut, ...]]:
    upper = ground.field.upper_usvh
    is_free = ground.is_free
    slowness = ground.ground.slowness_spm
    edges = edges_of(is_free, slowness, np.nan_to_num(upper), ground.grid.cell_m)
    searcher = Searcher(edges)
    start = start_cell(ground, request.start)
    reached = np.isfinite(searcher.tree(start, (1.0, 0.0)).costs).reshape(ground.grid.shape)
    stands = [stand_of(ground, point, reached) for point in request.evidence]
    refused = tuple(
        LeftOut(evidence=one.point.id, why=one.why) for one in stands if one.cell is None
    )
    found = tuple(one for one in stands if one.cell is not None)
    if not found:
        raise NoWayError(f'{refused[0].evidence}: {refused[0].why}')
    if len(found) > MOST_POINTS:
        raise ValueError(f'{len(found)} evidence points: must be at most {MOST_POINTS}')
    end = None if request.end is None else start_cell(ground, request.end)
    search = TourSearch(searcher, start, [_tour_point(one, upper) for one in found], end)
    surface = Surface(
        is_free=is_free, slowness_spm=slowness, rates_usvh=upper, cell_m=ground.grid.cell_m
    )
    task = _Task(
        request=request, ground=ground, searcher=searcher, surface=surface, search=search,
        stands=found,
    )  # fmt: skip
    return task, refused


def _tour_point(stand: Stand, rates_usvh: FloatArray) -> TourPoint:
    cell = int(stand.cell or 0)
    return TourPoint(
        cell=cell,
        dwell_s=stand.point.dwell_s,
        dwell_usv=float(rates_usvh.ravel()[cell]) * stand.point.dwell_s / SECONDS_PER_HOUR,
        priority=stand.point.priority,
    )


def _safe_tour(task: _Task) -> tuple[Tour, DoseForecast]:
    """Return the tour whose dose is within the budget with the confidence asked for.

    The upper 95 % of each cell is mostly more than enough for the sum. Where it is not, the
    budget that is planned for is tightened; a set of points whose cleanest tour is not sure
    enough is given up.
    """
    request = task.request
    budgets = Budgets(dose_usv=request.dose_budget_usv, time_s=request.vehicle.endurance_s)
    refused: list[int] = []
    unsure = math.inf
    while True:
        try:
            tour = task.search.best(budgets, refused)
        except BeyondBudgetError as error:
            if not refused:
                raise
            raise BeyondBudgetError(
                f'the dose budget of {request.dose_budget_usv:.4g} uSv is not sure enough: '
                f'{upwards(unsure)} uSv are kept with a probability of {request.confidence:g}'
            ) from error
        found = _tightened(task, tour)
        if found is not None:
            return found
        refused.append(tour.chosen)
        unsure = min(unsure, needed_usv(task, tour.chosen))


def _tightened(task: _Task, tour: Tour) -> tuple[Tour, DoseForecast] | None:
    """Return the fastest tour to the same points that is sure enough, None if none is."""
    confidence, endurance = task.request.confidence, task.request.vehicle.endurance_s
    forecast = task.forecast(tour)
    if forecast.probability >= confidence:
        return tour, forecast
    low, high = task.search.least_dose(tour.chosen), tour.dose_usv
    tour = task.search.cleanest(tour.chosen)
    forecast = task.forecast(tour)
    if forecast.probability < confidence or tour.time_s > endurance:
        return None
    best = tour, forecast
    for _ in range(MOST_TIGHTENINGS):
        middle = 0.5 * (low + high)
        tour = task.search.of(best[0], middle)
        forecast = task.forecast(tour)
        if forecast.probability >= confidence and tour.time_s <= endurance:
            low, best = middle, (tour, forecast)
        else:
            high = middle
    return best


def needed_usv(task: _Task, chosen: int) -> float:
    """Return the least budget with which a set of points is sure enough to be visited."""
    tour = task.search.cleanest(chosen)
    return max(tour.dose_usv, task.forecast(tour).upper_usv)


def upwards(value: float) -> str:
    """Return a number with four digits, not below its value."""
    step = 10.0 ** (math.floor(math.log10(value)) - 3) if value > 0.0 else 1.0
    return f'{math.ceil(value / step) * step:.4g}'


def _plan(
    task: _Task, tour: Tour, forecast: DoseForecast, refused: tuple[LeftOut, ...]
) -> DrivePlan:
    quick = task.search.of(tour, math.inf)
    track = task.track(tour)
    return DrivePlan(
        request=task.request,
        stops=_stops(task, tour, track),
        track=_timed(task, tour, track),
        time_s=_duration_s(task, tour),
        forecast=forecast,
        bound_s=tour.bound_s,
        grid_time_s=tour.time_s,
        price_s_per_usv=tour.price_s_per_usv,
        fastest_s=_duration_s(task, quick),
        fastest_usv=task.forecast(quick).mean_usv,
        standing_usv=_standing_usv(task, tour),
        left_out=(*refused, *_left_out(task, tour)),
        curve=_curve(task, tour),
        gas=task.gas(tour),
    )


def _duration_s(task: _Task, tour: Tour) -> float:
    dwells = sum(task.stands[k].point.dwell_s for k in tour.order)
    return float(task.track(tour).seconds.sum()) + dwells


def _standing_usv(task: _Task, tour: Tour) -> float:
    """Return the estimated dose of the dwells."""
    rates = task.ground.field.mean_usvh.ravel()
    stands = [task.stands[k] for k in tour.order]
    return sum(
        float(rates[stand.cell]) * stand.point.dwell_s / SECONDS_PER_HOUR for stand in stands
    )


def _curve(task: _Task, tour: Tour) -> tuple[tuple[float, float], ...]:
    """Return budgets from the cleanest to the fastest trip to the same points, and their times."""
    if not task.request.curve_points:
        return ()
    low = task.search.least_dose(tour.chosen)
    high = max(task.search.of(tour, math.inf).dose_usv, low)
    budgets = np.geomspace(low, high, task.request.curve_points) * (1.0 + 1e-9)
    return tuple((float(one), task.search.of(tour, float(one)).time_s) for one in budgets)


def _left_out(task: _Task, tour: Tour) -> list[LeftOut]:
    request, found = task.request, []
    for k in tour.left_out:
        more = tour.chosen | 1 << k
        needs = []
        if (dose := needed_usv(task, more)) > request.dose_budget_usv:
            needs.append(f'a dose budget of {upwards(dose)} uSv')
        if (time := task.search.least_time(more)) > request.vehicle.endurance_s:
            needs.append(f'an endurance of {math.ceil(time)} s')
        text = ' and '.join(needs) or 'more of dose or endurance: both are nearly used up'
        found.append(
            LeftOut(evidence=task.stands[k].point.id, why=f'it would take {text} with the others')
        )
    return found


def _stops(task: _Task, tour: Tour, track: Track) -> tuple[DriveStop, ...]:
    grid, stops = task.ground.grid, []
    rates = task.ground.field.mean_usvh.ravel()
    doses = rates[track.cells] * track.seconds / SECONDS_PER_HOUR
    for bend in track.bends:
        east, north = grid.place_of(bend.cell)[0].tolist()
        stand = tour.order[bend.leg] if bend.is_end and 0 <= bend.leg < len(tour.order) else None
        point = None if stand is None else task.stands[stand].point
        dwell = point.dwell_s if point else 0.0
        stops.append(
            DriveStop(
                place=grid.position_at(east, north),
                east_m=east,
                north_m=north,
                speed_mps=bend.speed_mps,
                dwell_s=dwell,
                evidence=point.id if point else '',
                look_rad=0.0 if stand is None else task.look_rad(stand),
                duration_s=bend.duration_s + dwell,
                dose_usv=float(doses[slice(*bend.samples)].sum())
                + float(rates[bend.cell]) * dwell / SECONDS_PER_HOUR,
            )
        )
    return tuple(stops)


def _timed(task: _Task, tour: Tour, track: Track) -> FloatArray:
    """Return east, north, seconds after the start and estimated dose rate of all samples."""
    dwells = np.zeros(len(track.cells))
    for number, k in enumerate(tour.order):
        dwells[track.leg_ends[number]] = task.stands[k].point.dwell_s
    # A sample has half of its time before it and half after it; dwells are after it.
    times = np.cumsum(track.seconds) - 0.5 * track.seconds + np.cumsum(dwells) - dwells
    rates = task.ground.field.mean_usvh.ravel()[track.cells]
    return np.column_stack([track.places_m(task.ground.grid), times, rates])
