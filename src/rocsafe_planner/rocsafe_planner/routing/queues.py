# SPDX-License-Identifier: Apache-2.0
"""Vehicles that take off or land at one place, one after another.

Two that keep a distance d apart do not take off at one place before the first is d above it, nor
does one land while the other is lower than d. Of u vehicles, one thus waits in all at least
u (u - 1) / 2 times for a take-off, and as often for a landing. Routes of equal length would all
wait for the last landing; a search that knows the waits gives those that wait longer less to do.
"""

import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from rocsafe_planner.problem.fleet_problem import FleetProblem
from rocsafe_planner.routing.boustrophedon import grid_rows, serpentine


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


def waits_s(problem: FleetProblem) -> list[float]:
    """Return how long each vehicle waits for others, about: before its take-off and its landing.

    Who takes off first lands first. Fewer vehicles wait less: those that would do better on the
    ground are not counted.
    """
    waits = np.zeros(len(problem.vehicles))
    for queue in take_off_queues(problem):
        idle = len(queue.vehicles) - _worthwhile(problem, queue)
        turns = np.maximum(np.arange(len(queue.vehicles)) - idle, 0)
        waits[list(queue.vehicles)] += math.ceil(queue.interval_s) * turns
    for queue in landing_queues(problem):
        turns = np.arange(len(queue.vehicles))[::-1]
        waits[list(queue.vehicles)] += math.ceil(queue.interval_s) * turns
    return [float(wait) for wait in waits]


def _worthwhile(problem: FleetProblem, queue: Queue) -> int:
    """Return with how many vehicles of a queue all would be done first.

    Each climbs and descends, waits, and flies its share of one track over all points.
    """
    interval = interval_s(problem)
    first, most = queue.vehicles[0], len(queue.vehicles)
    tour = np.array(serpentine(grid_rows(problem)), dtype=np.intp)
    flown_s = float(problem.legs_s(first, tour[:-1], tour[1:]).sum())
    flown_s += problem.vehicles[first].hover_s * len(tour)
    counts = np.arange(1, most + 1)
    return int(counts[np.argmin(flown_s / counts + 0.5 * interval * (counts - 1))])


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
            problem.flight(k).performance.low_s(problem.flight_height_m(k), low_m)[is_landing]
            for k in own
        ]
        if gaps:
            queues.append(Queue(vehicles=tuple(own), interval_s=min(times)))
    return queues


def _gap_m(problem: FleetProblem, a: int, b: int) -> float:
    return float(np.hypot(*(problem.sites[a] - problem.sites[b])))
