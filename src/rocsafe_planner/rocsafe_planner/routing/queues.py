# SPDX-License-Identifier: Apache-2.0
"""Vehicles that take off or land at one place, one after another.

Two that keep a distance d apart do not take off at one place before the first is d above it, nor
does one land while the other is lower than d. Of u vehicles, one thus waits in all at least
u (u - 1) / 2 times for a take-off, and as often for a landing. Routes of equal length would all
wait for the last landing; a search that knows the waits gives those that wait longer less to do.
"""

import math
from collections.abc import Collection
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np

from rocsafe_geo.motion.performance import Performance
from rocsafe_planner.problem.fleet_problem import FleetProblem
from rocsafe_planner.routing.tours.boustrophedon import grid_rows, serpentine


@dataclass(frozen=True, slots=True, kw_only=True)
class Queue:
    """Vehicles that take off, or that land, at one place at least `interval_s` apart."""

    vehicles: tuple[int, ...]
    interval_s: float


def take_off_queues(problem: FleetProblem) -> list[Queue]:
    """Return the queues of the vehicles that begin on the ground; no vehicle is in two."""
    grounded = [k for k, vehicle in enumerate(problem.vehicles) if vehicle.aloft is None]
    return _queues(problem, {k: problem.home_site(k) for k in grounded}, is_landing=False)


def landing_queues(problem: FleetProblem) -> list[Queue]:
    """Return the queues of the vehicles that land at a given place; no vehicle is in two."""
    ends = {k: problem.end_site(k) for k in range(len(problem.vehicles))}
    given = {k: end for k, end in ends.items() if end is not None}
    return _queues(problem, given, is_landing=True)


def interval_s(problem: FleetProblem) -> float:
    """Return of how many seconds each two vehicles wait one, if all wait in the same queues."""
    queues = [*take_off_queues(problem), *landing_queues(problem)]
    everybody = len(problem.vehicles)
    return sum(queue.interval_s for queue in queues if len(queue.vehicles) == everybody)


def waits_s(problem: FleetProblem, flying: Collection[int]) -> list[float]:
    """Return how long each vehicle waits for others that fly; who takes off first lands first."""
    waits = [0.0] * len(problem.vehicles)
    for queue in take_off_queues(problem):
        for turn, k in enumerate(k for k in queue.vehicles if k in flying):
            waits[k] += math.ceil(queue.interval_s) * turn
    for queue in landing_queues(problem):
        for turn, k in enumerate(k for k in reversed(queue.vehicles) if k in flying):
            waits[k] += math.ceil(queue.interval_s) * turn
    return waits


def worthwhile(problem: FleetProblem) -> list[int]:
    """Return the vehicles without which a survey would not be done earlier.

    Of u like vehicles each flies a part of one track over all points, W seconds long, and waits
    (u - 1) / 2 intervals s on average: W / u + s (u - 1) / 2 is least at the root of 2 W / s.
    """
    every = list(range(len(problem.vehicles)))
    interval, first = interval_s(problem), problem.vehicles[0]
    is_like = len({problem.alike(k) for k in every}) == 1 and problem.may_visit is None
    if interval == 0.0 or not is_like:
        return every
    tour = np.array(serpentine(grid_rows(problem)), dtype=np.intp)
    track_s = float(problem.legs_s(0, tour[:-1], tour[1:]).sum()) + first.hover_s * len(tour)
    count = max(1, round(math.sqrt(2.0 * track_s / interval)))
    far_s = max(problem.duration_s(0, [point]) for point in (tour[0], tour[-1]))
    if count >= len(every) or track_s / count + far_s > first.first_endurance_s:
        return every
    return every[:count]


def _queues(problem: FleetProblem, site_of: dict[int, int], *, is_landing: bool) -> list[Queue]:
    """Return those of these vehicles whose places are all nearer than the separation."""
    together: list[list[int]] = []
    for k, site in site_of.items():
        near = [
            own
            for own in together
            if all(_gap_m(problem, site, site_of[i]) < problem.separation_m for i in own)
        ]
        if near:
            near[0].append(k)
        else:
            together.append([k])
    queues = []
    for own in together:
        gaps = [_gap_m(problem, site_of[i], site_of[j]) for i, j in combinations(own, 2)]
        low_m = math.sqrt(problem.separation_m**2 - max(gaps, default=0.0) ** 2)
        times = [
            _low_s(problem.flight(k).performance, problem.flight_height_m(k), low_m)[is_landing]
            for k in own
        ]
        if gaps:
            queues.append(Queue(vehicles=tuple(own), interval_s=min(times)))
    return queues


@lru_cache(maxsize=256)
def _low_s(performance: Performance, height_m: float, low_m: float) -> tuple[float, float]:
    """Return the same for all vehicles alike, which are asked for often."""
    return performance.low_s(height_m, low_m)


def _gap_m(problem: FleetProblem, a: int, b: int) -> float:
    return float(np.hypot(*(problem.sites[a] - problem.sites[b])))
