# SPDX-License-Identifier: Apache-2.0
"""How short any plan's makespan can be, from each vehicle's own home to its own end.

The ROCSAFE paper divides the optimal tour by the number of agents, which holds only for closed
routes from one shared depot: two drones that stand on their own waypoints need no time at all.
Here every vehicle has its own home, end, speed and time of climb. Legs between points cost what
the vehicle fastest on them would need, photographs what the quickest one would, half to each of
the two legs; legs from home, climb and descent are each vehicle's own. No routes cost less, so the
forest bound of these costs holds; so does the time of the farthest point photographed alone by
the vehicle best placed for it. The better of the two is returned. In wind, over a
terrain and around exclusions a leg costs what it does in the better direction; among very many
points it costs what it would straight, level and with the wind in the back. The end of an open
route costs nothing; battery swaps, delays, layers and, in the forest, sensors are left out. All
that only lowers the bound.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.motion import MotionLimits, leg_duration_s
from rocsafe_planner.fleet_problem import FleetProblem
from rocsafe_planner.forest import FleetCosts, makespan_bound

FloatArray = NDArray[np.float64]

# Above this, costs are computed row by row (a matrix of 2000 points takes 32 MB), for one forest.
_DENSE_POINTS = 2000
# The ascent's effort: points times steps. By count, not by clock: the bound is reproducible.
_EFFORT = 20_000
_MAX_STEPS = 300


@dataclass(frozen=True, slots=True, kw_only=True)
class LowerBound:
    """No plan for the problem has a makespan below `makespan_s`; `method` proved it."""

    makespan_s: float
    method: str


def lower_bound(
    problem: FleetProblem, known_makespan_s: float, keep_going: Callable[[float], bool]
) -> LowerBound:
    """Return the best bound known here: ``'farthest_trip'`` or ``'held_karp_forest'``.

    Parameters
    ----------
    problem
        With at least one point.
    known_makespan_s
        Of any plan; it steers the ascent and does not change what is proven.
    keep_going
        Told the best bound so far; the work ends early when it returns False.
    """
    costs = _undercut_costs(problem)
    trip_s = _farthest_trip_s(problem)
    n = len(problem.points)
    steps = min(_MAX_STEPS, max(1, _EFFORT // n)) if n <= _DENSE_POINTS else 1
    forest_s = makespan_bound(
        costs, known_makespan_s, steps, lambda bound: keep_going(max(trip_s, bound))
    )
    if forest_s > trip_s:
        return LowerBound(makespan_s=forest_s, method='held_karp_forest')
    return LowerBound(makespan_s=trip_s, method='farthest_trip')


def trip_bound(problem: FleetProblem) -> LowerBound:
    """Return the time of the farthest trip alone, which takes no time to find."""
    return LowerBound(makespan_s=_farthest_trip_s(problem), method='farthest_trip')


def _farthest_trip_s(problem: FleetProblem) -> float:
    """Return the time of the point that is worst to photograph alone, by the best vehicle."""
    trips = []
    for k, vehicle in enumerate(problem.vehicles):
        ways = sum(_ways_s(problem, k), start=np.zeros(len(problem.points)))
        times = problem.first_fixed_s(k) + ways + vehicle.hover_s
        trips.append(np.where(problem.allowed(k), times, np.inf))
    return float(np.min(trips, axis=0).max())


def _ways_s(problem: FleetProblem, vehicle: int) -> tuple[FloatArray, FloatArray]:
    """Return times that no way from start to each point, and from there to the end, undercuts."""
    n = len(problem.points)
    if _is_exact(problem):
        return _exact_ways_s(problem, vehicle)
    motion = problem.flight(vehicle).fastest()
    out = leg_duration_s(problem.distances_m(problem.start_site(vehicle))[:n], motion)
    end = problem.end_site(vehicle)
    back = np.zeros(n) if end is None else leg_duration_s(problem.distances_m(end)[:n], motion)
    return out, back


def _is_exact(problem: FleetProblem) -> bool:
    """Return whether legs are timed as they are flown: where length alone does not tell it."""
    if any(vehicle.hover_s == 0.0 for vehicle in problem.vehicles):
        return False  # who passes viewpoints saves at corners: legs are estimates
    return not problem.legs_are_plain and len(problem.points) <= _DENSE_POINTS


def _exact_ways_s(problem: FleetProblem, vehicle: int) -> tuple[FloatArray, FloatArray]:
    points = np.arange(len(problem.points))
    start, end = np.array([problem.start_site(vehicle)]), problem.end_site(vehicle)
    out = problem.legs_s(vehicle, start, points)
    if end is None:
        return out, np.zeros(len(points))
    return out, problem.legs_s(vehicle, points, np.array([end]))


def _exact_legs_s(problem: FleetProblem) -> FloatArray:
    """Return the leg times between points, either way, of the vehicle fastest there, (n, n)."""
    points = np.arange(len(problem.points))
    kinds = {(problem.flight(k), problem.layer_m(k)): k for k in range(len(problem.vehicles))}
    fastest = np.full((len(points), len(points)), np.inf)
    for vehicle in kinds.values():
        legs = problem.legs_s(vehicle, points[:, None], points[None, :])
        fastest = np.minimum(fastest, np.minimum(legs, legs.T))
    return fastest


def _undercut_costs(problem: FleetProblem) -> FleetCosts:
    """Return the costs of the module's text."""
    n = len(problem.points)
    hover = min(vehicle.hover_s for vehicle in problem.vehicles)
    ways = [_ways_s(problem, k) for k in range(len(problem.vehicles))]

    motions = {problem.flight(k).fastest() for k in range(len(problem.vehicles))}

    def row(point: int) -> FloatArray:
        return _fastest_legs_s(problem, point, motions) + hover

    matrix = None
    if _is_exact(problem):
        matrix = _exact_legs_s(problem) + hover
    elif n <= _DENSE_POINTS:
        matrix = np.vstack([row(point) for point in range(n)])
    fixed = np.array([problem.first_fixed_s(k) for k in range(len(problem.vehicles))])
    return FleetCosts(
        fixed=fixed,
        # Either way may be the one that joins a point: the shorter one costs no more.
        home=np.vstack([np.minimum(out, back) for out, back in ways]) + 0.5 * hover,
        row=row if matrix is None else matrix.__getitem__,
    )


def _fastest_legs_s(problem: FleetProblem, point: int, motions: set[MotionLimits]) -> FloatArray:
    """Return the leg times from one point to all, by the vehicle fastest on each, shape (n,)."""
    distances = problem.distances_m(point)[: len(problem.points)]
    fastest: FloatArray = np.min([leg_duration_s(distances, motion) for motion in motions], axis=0)
    return fastest
