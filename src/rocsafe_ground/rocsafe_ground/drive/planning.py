# SPDX-License-Identifier: Apache-2.0
"""Planning of a drive: stands at the evidence, the tour, straight lines, the check by draws."""

import math
from dataclasses import replace

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_ground.drive.drive_plan import DrivePlan, DriveRequest, DriveStop, LeftOut
from rocsafe_ground.drive.ground_map import GroundMap
from rocsafe_ground.drive.sureness import beyond_text, needed_text, sure_drive
from rocsafe_ground.drive.task import Drive, Task, task_of
from rocsafe_ground.errors import BeyondBudgetError
from rocsafe_ground.route.constrained import ROUNDING
from rocsafe_ground.route.edges import SECONDS_PER_HOUR
from rocsafe_ground.tour.trip import Budgets, Tour

# How exactly a range finder tells the places of things in the way.
BLOCKED_M = 0.1
# Between two stops dose rates differ by no larger factor.
SAME_RATE = 1.5


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
        kept_m = request.vehicle.kept_m(ground.grid.cell_m)
        ground = ground.blocked_at(request.blocked, kept_m + BLOCKED_M)
    task, refused = task_of(request, ground)
    return _plan(task, _safe_drive(task), refused)


def _safe_drive(task: Task) -> Drive:
    """Return the drive through the worthiest points that keeps the budgets surely.

    A set of points of which no tour is sure enough is given up.
    """
    refused: list[int] = []
    while True:
        try:
            tour = task.search.best(task.budgets, refused)
        except BeyondBudgetError as error:
            raise BeyondBudgetError(beyond_text(task)) from error
        found = sure_drive(task, tour)
        if found is not None:
            return found
        refused.append(tour.chosen)


def _plan(task: Task, drive: Drive, refused: tuple[LeftOut, ...]) -> DrivePlan:
    tour, curve = drive.tour, _curve(task, drive.tour)
    # The fastest tour over cells is not always driven the fastest: it may have more bends.
    best = min((drive, *(one for budget, one in curve if budget <= task.request.dose_budget_usv)),
               key=lambda one: one.time_s)  # fmt: skip
    drive = drive if best is drive else task.drive(best.tour)
    quickest = task.drive(task.search.fastest(tour.chosen))
    quick = min(quickest, drive, key=lambda one: one.time_s)
    return DrivePlan(
        request=task.request,
        stops=_stops(task, drive),
        track=_timed(task, drive),
        time_s=drive.time_s,
        forecast=drive.forecast,
        bound_s=tour.bound_s,
        grid_time_s=drive.tour.time_s,
        price_s_per_usv=tour.price_s_per_usv,
        fastest_s=quick.time_s,
        fastest_usv=quick.forecast.mean_usv,
        standing_usv=task.standing_usv(drive.tour),
        left_out=(*refused, *_left_out(task, tour)),
        curve=tuple((budget, one.time_s) for budget, one in curve),
        gas=drive.gas,
        oldest_s=_oldest_s(task, drive),
    )


def _oldest_s(task: Task, drive: Drive) -> float:
    """Return the greatest age of the cells of a drive that are known, NaN if none is."""
    ages = task.ground.ground.ages_s
    known = np.empty(0) if ages is None else ages.ravel()[drive.track.cells]
    known = known[np.isfinite(known)]
    return float(known.max()) if len(known) else math.nan


def _curve(task: Task, tour: Tour) -> list[tuple[float, Drive]]:
    """Return budgets of dose, from the least, and a drive to the same points within each.

    Of drives that take more dose and no less time none is told.
    """
    search, count = task.search, task.request.curve_points
    load = task.budgets.load
    cleanest = search.cleanest(tour.chosen, load)
    if not count or cleanest is None:
        return []
    low, high = (
        max(drive.tour.dose_usv, drive.forecast.upper_usv)
        for drive in map(task.drive, (cleanest, search.fastest(tour.chosen)))
    )
    curve: list[tuple[float, Drive]] = []
    for budget in (np.geomspace(low, max(low, high), count) * (1.0 + ROUNDING)).tolist():
        within = Budgets(dose_usv=budget, load=load)
        drive = sure_drive(task.within(replace(task.budgets, dose_usv=budget)),
                           search.within(tour.chosen, within))  # fmt: skip
        if drive is not None and (not curve or drive.time_s < curve[-1][1].time_s):
            curve.append((budget, drive))
    return curve


def _left_out(task: Task, tour: Tour) -> list[LeftOut]:
    return [
        LeftOut(
            evidence=task.stands[k].point.id,
            why=f'it would take {needed_text(task, tour.chosen | 1 << k)} with the others',
        )
        for k in tour.left_out
    ]


def _stops(task: Task, drive: Drive) -> tuple[DriveStop, ...]:
    """Return the bends, and between them the places that tell how the dose rate changes.

    A vehicle compares what it takes with what was predicted for the way so far: that is linear
    between two stops.
    """
    grid, track = task.ground.grid, drive.track
    rates = task.ground.field.mean_usvh.ravel()
    doses = rates[track.cells] * track.seconds / SECONDS_PER_HOUR
    places, stops = track.places_m(grid), list[DriveStop]()
    for bend in track.bends:
        line = slice(*bend.samples)
        cuts = _cuts(rates[track.cells[line]])
        times, taken = (_so_far(values[line], cuts) for values in (track.seconds, doses))
        for number, cut in enumerate(cuts[1:-1], start=1):
            east, north = places[bend.samples[0] + cut].tolist()
            stops.append(
                DriveStop(
                    place=grid.position_at(east, north), east_m=east, north_m=north,
                    speed_mps=bend.speed_mps,
                    duration_s=float(times[number]), dose_usv=float(taken[number]),
                )
            )  # fmt: skip
        east, north = grid.place_of(bend.cell)[0].tolist()
        stand = (
            drive.tour.order[bend.leg]
            if bend.is_end and 0 <= bend.leg < len(drive.tour.order)
            else None
        )
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
                duration_s=float(times[-1]) + dwell,
                dose_usv=float(taken[-1]) + float(rates[bend.cell]) * dwell / SECONDS_PER_HOUR,
            )
        )
    return tuple(stops)


def _cuts(rates_usvh: FloatArray) -> list[int]:
    """Return the samples at which a line is divided, so that rates differ little within a part."""
    cuts, low, high = [0], math.inf, 0.0
    for number, rate in enumerate(rates_usvh.tolist()):
        low, high = min(low, rate), max(high, rate)
        if high > SAME_RATE * low and 0 < number < len(rates_usvh) - 1:
            cuts.append(number)
            low = high = rate
    return [*cuts, max(len(rates_usvh) - 1, 0)]


def _so_far(values: FloatArray, cuts: list[int]) -> FloatArray:
    """Return the sums of values of samples from each cut to the next; first is 0.

    A sample within a line stands for half a step before it and half a step after it.
    """
    if not len(values):
        return np.zeros(len(cuts))
    sums = np.cumsum(values) - 0.5 * values
    sums[0], sums[-1] = 0.0, float(values.sum())
    return np.diff(sums[cuts], prepend=0.0)


def _timed(task: Task, drive: Drive) -> FloatArray:
    """Return east, north, seconds after the start and estimated dose rate of all samples."""
    tour, track = drive.tour, drive.track
    dwells = np.zeros(len(track.cells))
    for number, k in enumerate(tour.order):
        dwells[track.leg_ends[number]] = task.stands[k].point.dwell_s
    # A sample has half of its time before it and half after it; dwells are after it.
    times = np.cumsum(track.seconds) - 0.5 * track.seconds + np.cumsum(dwells) - dwells
    rates = task.ground.field.mean_usvh.ravel()[track.cells]
    return np.column_stack([track.places_m(task.ground.grid), times, rates])
