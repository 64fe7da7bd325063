# SPDX-License-Identifier: Apache-2.0
"""A bound that knows of batteries: every battery pays its own ways out and home, and its change.

Vehicles that change batteries fly several flights each. k flights contain a forest of k trees and
2k legs to and from where they may begin and end; m vehicles change k - m batteries at least; and k
batteries must last for all that. The least over k of what remains for the vehicle that is done
last holds for any plan: few flights are more than their batteries last for, many cost many ways.
How few there can be is also counted: no battery lasts for more than so many far customers.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_planner.solver.bounds.certificate import climb, shortest_leg
from rocsafe_planner.solver.bounds.forest import ROUNDING, Ascent
from rocsafe_planner.solver.bounds.relaxation import Relaxation, relax
from rocsafe_planner.solver.model.problem import RoutingProblem

STEPS = 480
"""Steps of the ascent at most."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Batteries:
    """What is the least that batteries ask of anybody.

    Raises
    ------
    ValueError
        If the endurance is not positive or the time of a change is negative.
    """

    endurance: float
    """Most that a flight costs, its fixed cost included."""
    change: float
    """Least that a change costs."""

    def __post_init__(self) -> None:
        """Refuse batteries that are none."""
        if not (self.endurance > 0 and self.change >= 0):
            raise ValueError(
                f'endurance is {self.endurance} and change {self.change}: they must be above 0, '
                'and 0 or more'
            )


def flight_bounds(
    problem: RoutingProblem, flights: RoutingProblem, batteries: Batteries, target: float
) -> Iterator[float]:
    """Yield ever better bounds of when the last vehicle is done.

    Parameters
    ----------
    problem
        What each vehicle would fly with a battery that never ends.
    flights
        The same, with a vehicle for each way in which a single flight of any vehicle may begin
        and end.
    batteries
        Of the vehicles.
    target
        When the last vehicle of a known plan is done: steers the ascent, proves nothing.
    """
    relaxed = relaxed_flights(problem, flights, batteries)
    everybody = np.arange(problem.customers, dtype=np.int32)
    ascent = Ascent(relaxed=relaxed, members=everybody, total=False)
    yield from climb(ascent, target, STEPS)


def relaxed_flights(
    problem: RoutingProblem, flights: RoutingProblem, batteries: Batteries
) -> Relaxation:
    """Return the relaxation whose routes are flights, up to one for every customer.

    Where vehicle v flies f flights, f >= 1, it is done after the legs of all, f fixed costs and
    f - 1 changes; its legs cost a(v) times what the relaxation says, or more. Over all vehicles,
    divided by a(v), m of them flying, that is at least all legs, m fixed costs, and for each
    further flight another one and a change, divided by the largest a.
    """
    m, n = len(problem.vehicles), problem.customers
    vehicles = relax(problem, tuple(range(m)))
    legs = relax(flights, tuple(range(len(flights.vehicles))))
    fixed = min(vehicle.fixed_cost for vehicle in flights.vehicles)
    shares = vehicles.shares[np.minimum(np.arange(n), m - 1)]
    least_share = float(np.diff(vehicles.shares, prepend=0.0)[-1])
    further = np.maximum(np.arange(1, n + 1) - m, 0)
    longest = batteries.endurance - fixed
    return replace(
        legs,
        fewest=fewest_flights(legs, longest),
        shares=shares,
        fixed=fixed + further * (fixed + batteries.change) * least_share / shares,
        longest=longest,
        one_depot=False,
        own=legs.own[:, :0],  # flights need not be of different vehicles
    )


def fewest_flights(legs: Relaxation, longest: float) -> int:
    """Return how many flights any plan needs, were all legs between customers the shortest.

    Among the customers beyond some distance, c in one flight cost the least first leg, the least
    last leg and c - 1 legs between them, whoever is served besides (if legs are closed under
    detours).
    """
    order = np.argsort(-(legs.start + legs.end), kind='stable')
    counts = np.arange(1, len(order) + 1)
    ways = np.minimum.accumulate(legs.start[order]) + np.minimum.accumulate(legs.end[order])
    with np.errstate(divide='ignore', invalid='ignore'):
        more = np.floor((longest - ways) / shortest_leg(legs) * (1 + ROUNDING) + ROUNDING)
    # Nobody in reach: there is no plan, and nothing to be proven.
    flights = np.where(ways <= longest, np.ceil(counts / (1 + more)), 1)
    return int(np.nan_to_num(flights if legs.closed else flights[-1:], nan=1.0).max())
