# SPDX-License-Identifier: Apache-2.0
"""Splits a route that one battery is too small for into flights, with swaps at home."""

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_planner.errors import BeyondEnduranceError
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_planner.problem.fleet_problem import FleetProblem, Order
from rocsafe_planner.problem.flight_time import turn_s

_MOST_RECUTS = 12
_HAIR_S = 1e-6


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
    if needed <= spec.first_endurance_s:
        return [order] if problem.flies(vehicle, order) else []
    if spec.battery_swap_s is None or not order:
        task = _task(problem, order)
        raise BeyondEnduranceError(f'{spec.name} needs {needed:.0f} s {task}: {_battery(spec)}')
    if not problem.flight(vehicle).passes:
        return _parts(problem, vehicle, order)
    # Legs that share their corners are known together only: as long as they turn out to take
    # longer than thought, less is asked of the batteries.
    slack_s = 2.0 * turn_s(problem.flight(vehicle).performance)
    for _ in range(_MOST_RECUTS):
        parts = _parts(problem, vehicle, order, slack_s)
        late_s = _late_s(problem, vehicle, parts)
        if late_s <= 0.0:
            return parts
        slack_s += late_s + _HAIR_S
    raise BeyondEnduranceError(
        f'{spec.name} finds no flights within its endurance_s of {spec.endurance_s:.0f} s'
    )


def _task(problem: FleetProblem, order: Order) -> str:
    """Return what an order asks for as text."""
    if len(order) == 1:
        return f'for {problem.name_of(order[0])} alone'
    return f'for its {len(order)} viewpoints' if order else 'to land'


def _battery(spec: Vehicle) -> str:
    """Return the endurance of a vehicle's battery as text."""
    left_s = spec.first_endurance_s
    left = '' if left_s == spec.endurance_s else f', {left_s:.0f} s of it left'
    return f'its endurance_s is {spec.endurance_s:.0f} s{left}'


def _parts(problem: FleetProblem, vehicle: int, order: Order, slack_s: float = 0.0) -> list[Order]:
    """Return the flights by the times of single legs, with so much of each battery left."""
    flights = _Flights(problem, vehicle, order, slack_s)
    swap_s = problem.vehicles[vehicle].battery_swap_s or 0.0
    if problem.vehicles[vehicle].aloft is None:
        return _cut(order, flights, swap_s)[1]
    return _from_the_air(order, flights, swap_s)


def _late_s(problem: FleetProblem, vehicle: int, parts: list[Order]) -> float:
    """Return the largest time by which a flight exceeds its battery, seconds."""
    spec, last = problem.vehicles[vehicle], len(parts) - 1
    worst = -np.inf
    for number, part in enumerate(parts):
        limit_s = spec.endurance_s if number else spec.first_endurance_s
        motion = problem.motion(vehicle, part, is_first=number == 0, is_last=number == last)
        worst = max(worst, motion.duration_s - limit_s)
    return worst


def _from_the_air(order: Order, flights: '_Flights', swap_s: float) -> list[Order]:
    """Return the better of two: go on from the vehicle's position, or swap the battery first."""
    if flights.home_s > flights.first_endurance_s:
        return _cut(order, flights, swap_s)[1]
    try:
        onward = _cut(order, flights, swap_s)
    except BeyondEnduranceError:
        onward = (np.inf, [])
    flights.land_first()
    afresh = _cut(order, flights, swap_s)
    if afresh[0] + flights.home_s + swap_s < onward[0]:
        return [[], *afresh[1]]
    return onward[1]


class _Flights:
    """Times of all flights over consecutive parts of an order."""

    def __init__(self, problem: FleetProblem, vehicle: int, order: Order, slack_s: float) -> None:
        stops = np.array(order, dtype=np.intp)
        home = np.array([problem.home_site(vehicle)])
        start = np.array([problem.start_site(vehicle)])
        self._spec = problem.vehicles[vehicle]
        self._name_of = problem.name_of
        self._fixed = problem.fixed_s(vehicle)
        self._out = problem.legs_s(vehicle, home, stops)
        first_fixed = problem.first_fixed_s(vehicle)
        self._first_out = first_fixed + problem.legs_s(vehicle, start, stops)
        self.home_s = first_fixed + float(problem.legs_s(vehicle, start, home)[0])
        self.first_endurance_s = self._spec.first_endurance_s
        self._back = problem.legs_s(vehicle, stops, home)
        end = problem.end_site(vehicle)
        self._to_end = (
            np.zeros(len(order))
            if end is None
            else problem.legs_s(vehicle, stops, np.array([end]))
        )
        legs = problem.legs_s(vehicle, stops[:-1], stops[1:])
        self._elapsed = np.concatenate([[0.0], np.cumsum(legs)])
        self.first_endurance_s -= slack_s
        self.endurance_s = self._spec.endurance_s - slack_s

    def land_first(self) -> None:
        """Let the first flight, too, begin at home with a full battery."""
        self._first_out = self._fixed + self._out
        self.first_endurance_s = self.endurance_s

    def within(self, times: FloatArray) -> FloatArray:
        """Return times of flights from each position 0.., infinite where a battery is too weak."""
        limits = np.full(len(times), self.endurance_s)
        limits[0] = self.first_endurance_s
        fitting: FloatArray = np.where(times <= limits, times, np.inf)
        return fitting

    def ending_at(self, last: int) -> FloatArray:
        """Return the times of flights from each position 0..last to position `last`."""
        is_final = last == len(self._out) - 1
        back = self._to_end[last] if is_final else self._back[last]
        first = np.arange(last + 1)
        hover = (last - first + 1) * self._spec.hover_s
        out = self._fixed + self._out[first]
        out[0] = self._first_out[0]
        times: FloatArray = out + self._elapsed[last] - self._elapsed[first] + hover + back
        return times

    def refusal(self, position: int, point: int) -> BeyondEnduranceError:
        """Return the error of a viewpoint that even a flight of its own does not reach."""
        needed = float(self.ending_at(position)[position])
        return BeyondEnduranceError(
            f'{self._spec.name} needs {needed:.0f} s for {self._name_of(point)} alone: '
            f'{_battery(self._spec)}'
        )


def _cut(order: Order, flights: _Flights, swap_s: float) -> tuple[float, list[Order]]:
    """Return the parts of the order whose flights and swaps take least time, and that time."""
    best = np.zeros(len(order) + 1)
    begin = np.zeros(len(order), dtype=np.intp)
    for last in range(len(order)):
        times = flights.ending_at(last)
        swaps = np.where(np.arange(last + 1) > 0, swap_s, 0.0)
        totals = best[: last + 1] + swaps + flights.within(times)
        begin[last] = int(totals.argmin())
        best[last + 1] = totals[begin[last]]
        is_last = last == len(order) - 1
        if not is_last and np.isinf(best[last + 1]) and np.isinf(flights.within(times)[last]):
            raise flights.refusal(last, order[last])
    if np.isinf(best[-1]):
        raise flights.refusal(len(order) - 1, order[-1])
    parts: list[Order] = []
    end = len(order)
    while end > 0:
        first = int(begin[end - 1])
        parts.append(order[first:end])
        end = first
    return float(best[-1]), parts[::-1]
