# SPDX-License-Identifier: Apache-2.0
"""Splits an order of all points into consecutive parts, one for each vehicle."""

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_planner.problem.fleet_problem import FleetProblem, Order

# Bisections of the interval that contains the best makespan: to a millionth of its width.
_HALVINGS = 20


def makespan_s(problem: FleetProblem, orders: list[Order]) -> float:
    """Return the duration of the longest route, battery swaps left out."""
    return max(problem.duration_s(k, order) for k, order in enumerate(orders))


def equal_parts(problem: FleetProblem, tour: Order) -> list[Order]:
    """Split a tour into parts whose sizes differ by one point at most."""
    sequence = _vehicles_along(problem, tour)
    cuts = np.array_split(np.array(tour, dtype=np.intp), len(sequence))
    return _dealt(problem, [part.tolist() for part in cuts], sequence)


def min_max_parts(problem: FleetProblem, tour: Order) -> list[Order]:
    """Cut a tour so that the longest route is as short as consecutive parts allow.

    The vehicles take their parts in the order in which the tour passes their starts. For a given
    time each takes as much as it can fly; the least time that leaves nothing is found by halving.
    """
    sequence = _vehicles_along(problem, tour)
    flights = _PartFlights(problem, tour)
    high = makespan_s(problem, _dealt(problem, _parts(tour, [len(tour)]), sequence))
    low, cuts = 0.0, [len(tour)]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        found = flights.cuts_within(middle, sequence)
        if found is None:
            low = middle
        else:
            high, cuts = middle, found
    return _dealt(problem, _parts(tour, cuts), sequence)


class _PartFlights:
    """Times of flights over consecutive parts of a tour."""

    def __init__(self, problem: FleetProblem, tour: Order) -> None:
        self._problem = problem
        self._stops = np.array(tour, dtype=np.intp)
        known: dict[object, tuple[FloatArray, FloatArray, FloatArray]] = {}
        self._ways = []
        for k in range(len(problem.vehicles)):
            key = problem.alike(k)
            if key not in known:
                known[key] = self._of_vehicle(k)
            self._ways.append(known[key])

    def _of_vehicle(self, vehicle: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return ways out, ways back and time elapsed along the tour, shape (n,) each."""
        problem, stops = self._problem, self._stops
        out = problem.legs_s(vehicle, np.array([problem.start_site(vehicle)]), stops)
        end = problem.end_site(vehicle)
        back = (
            np.zeros(len(stops))
            if end is None
            else problem.legs_s(vehicle, stops, np.array([end]))
        )
        legs = problem.legs_s(vehicle, stops[:-1], stops[1:])
        hover = problem.vehicles[vehicle].hover_s
        elapsed = np.concatenate([[0.0], np.cumsum(legs + hover)])
        return out + hover + problem.first_fixed_s(vehicle), back, elapsed

    def cuts_within(self, time_s: float, sequence: list[int]) -> list[int] | None:
        """Return where parts end if each flight may take `time_s`; None if points are left."""
        begin, cuts = 0, []
        for vehicle in sequence:
            out, back, elapsed = self._ways[vehicle]
            if begin < len(out):
                times = out[begin] + elapsed[begin:] - elapsed[begin] + back[begin:]
                late = times > time_s
                begin += int(late.argmax()) if late.any() else len(times)
            cuts.append(begin)
        return cuts if begin == len(self._stops) else None


def _vehicles_along(problem: FleetProblem, tour: Order) -> list[int]:
    """Return the vehicles in the order in which the tour comes nearest to their starts."""
    n = len(problem.points)
    stops = np.array(tour, dtype=np.intp)
    passed = [
        int(np.argmin(np.round(problem.distances_m(problem.start_site(k))[:n][stops], 6)))
        for k in range(len(problem.vehicles))
    ]
    return sorted(range(len(passed)), key=lambda k: (passed[k], k))


def _parts(tour: Order, cuts: list[int]) -> list[Order]:
    return [tour[begin:end] for begin, end in zip([0, *cuts], cuts, strict=False)]


def _dealt(problem: FleetProblem, parts: list[Order], sequence: list[int]) -> list[Order]:
    """Return the orders of the vehicles; `sequence` names the vehicle of each part."""
    orders: list[Order] = [[] for _ in problem.vehicles]
    for vehicle, part in zip(sequence, parts, strict=False):
        orders[vehicle] = part
    return orders
