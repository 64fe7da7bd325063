# SPDX-License-Identifier: Apache-2.0
"""Flights that a vehicle may fly."""

from functools import cached_property

from rocsafe_planner.flights.flight_track import FlightTrack
from rocsafe_planner.flights.unheard_space import UnheardSpace, keeps_away
from rocsafe_planner.problem.fleet_problem import FleetProblem, Order


class FlightChoice:
    """Flights that a vehicle may fly.

    Parameters
    ----------
    problem
        In which it flies at its height.
    vehicle, flights
        Who flies, and the points of each flight.
    layer_m
        How much higher than the lowest it flies, metres.
    spaces
        Where vehicles may be that nobody hears.
    """

    def __init__(
        self,
        problem: FleetProblem,
        vehicle: int,
        flights: list[Order],
        layer_m: float,
        spaces: list[UnheardSpace],
    ) -> None:
        self._problem, self._vehicle, self._spaces = problem, vehicle, spaces
        self.flights, self.layer_m = flights, layer_m

    @cached_property
    def track(self) -> FlightTrack:
        """Where it is when."""
        return FlightTrack(self._problem, self._vehicle, self.flights)

    @cached_property
    def is_near(self) -> bool:
        """Whether it comes near to a possible place of an unheard vehicle."""
        height_m = self._problem.flight_height_m(self._vehicle)
        return bool(self._spaces) and not keeps_away(self._spaces, self.track, height_m)
