# SPDX-License-Identifier: Apache-2.0
"""A route longer than a battery lasts, cut into flights with battery swaps at home."""

import numpy as np
from numpy.typing import NDArray

from rocsafe_planner.errors import BeyondEnduranceError
from rocsafe_planner.fleet_problem import FleetProblem, Order

FloatArray = NDArray[np.float64]


def sorties(problem: FleetProblem, vehicle: int, order: Order) -> list[Order]:
    """Return the flights of one vehicle: its order, cut where that costs least time.

    Every flight but the last ends at home, where the battery is swapped. Among all ways to cut
    the order into flights that a battery lasts for, the one that ends first is returned (dynamic
    programming over the last cut).

    Raises
    ------
    BeyondEnduranceError
        If the vehicle cannot swap its battery and needs to, or has a viewpoint out of its reach.
    """
    spec = problem.vehicles[vehicle]
    needed = problem.duration_s(vehicle, order)
    if needed <= spec.endurance_s:
        return [order] if order else []
    if spec.battery_swap_s is None:
        raise BeyondEnduranceError(
            f'{spec.name} needs {needed:.0f} s for its {len(order)} viewpoints: its endurance_s '
            f'is {spec.endurance_s:.0f} s'
        )
    return _cut(order, _Flights(problem, vehicle, order), spec.battery_swap_s)


class _Flights:
    """Times of all flights over consecutive parts of an order."""

    def __init__(self, problem: FleetProblem, vehicle: int, order: Order) -> None:
        stops = np.array(order, dtype=np.intp)
        home = np.array([problem.home_site(vehicle)])
        self._spec = problem.vehicles[vehicle]
        self._fixed = problem.fixed_s(vehicle)
        self._out = problem.legs_s(vehicle, home, stops)
        self._back = problem.legs_s(vehicle, stops, home)
        end = problem.end_site(vehicle)
        self._to_end = (
            np.zeros(len(order))
            if end is None
            else problem.legs_s(vehicle, stops, np.array([end]))
        )
        legs = problem.legs_s(vehicle, stops[:-1], stops[1:])
        self._elapsed = np.concatenate([[0.0], np.cumsum(legs)])
        self.endurance_s = self._spec.endurance_s

    def ending_at(self, last: int) -> FloatArray:
        """Return the times of flights from each position 0..last to position `last`."""
        is_final = last == len(self._out) - 1
        back = self._to_end[last] if is_final else self._back[last]
        first = np.arange(last + 1)
        hover = (last - first + 1) * self._spec.hover_s
        times: FloatArray = (
            self._fixed
            + self._out[first]
            + self._elapsed[last]
            - self._elapsed[first]
            + hover
            + back
        )
        return times

    def refusal(self, position: int, point: int) -> BeyondEnduranceError:
        """Return the error of a viewpoint that even a flight of its own does not reach."""
        needed = float(self.ending_at(position)[position])
        return BeyondEnduranceError(
            f'{self._spec.name} needs {needed:.0f} s for viewpoint {point} alone: its endurance_s '
            f'is {self.endurance_s:.0f} s'
        )


def _cut(order: Order, flights: _Flights, swap_s: float) -> list[Order]:
    """Return the parts of the order whose flights and swaps take least time."""
    best = np.zeros(len(order) + 1)
    begin = np.zeros(len(order), dtype=np.intp)
    for last in range(len(order)):
        times = flights.ending_at(last)
        swaps = np.where(np.arange(last + 1) > 0, swap_s, 0.0)
        totals = np.where(times <= flights.endurance_s, best[: last + 1] + swaps + times, np.inf)
        begin[last] = int(totals.argmin())
        best[last + 1] = totals[begin[last]]
        if np.isinf(best[last + 1]) and last < len(order) - 1:
            alone = flights.ending_at(last)[last]
            if alone > flights.endurance_s:
                raise flights.refusal(last, order[last])
    if np.isinf(best[-1]):
        raise flights.refusal(len(order) - 1, order[-1])
    parts: list[Order] = []
    end = len(order)
    while end > 0:
        first = int(begin[end - 1])
        parts.append(order[first:end])
        end = first
    return parts[::-1]
