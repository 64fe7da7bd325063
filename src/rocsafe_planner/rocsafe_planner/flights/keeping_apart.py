# SPDX-License-Identifier: Apache-2.0
"""Routes of vehicles that keep apart: they wait, or fly in layers of height."""

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass

from rocsafe_planner.errors import BeyondEnduranceError
from rocsafe_planner.flights.flight_choice import FlightChoice
from rocsafe_planner.flights.routes import route_of
from rocsafe_planner.flights.separation import minimum_separation_m
from rocsafe_planner.flights.timetable import Timetable, timetable
from rocsafe_planner.flights.unheard_space import unheard_spaces
from rocsafe_planner.plan.plan import Route
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_planner.problem.fleet_problem import Order
from rocsafe_planner.routing.sorties import sorties
from rocsafe_planner.site.free_layers import free_layers_m
from rocsafe_planner.site.survey_site import SurveySite

MAX_TURNS = 12
"""Flights of a vehicle that are tried as its first."""

Orders = list[Order]


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptApart:
    """Routes, how high each vehicle flies above the others, and the least distance of any two.

    `near_unheard` names vehicles that come near to a possible place of an unheard vehicle.
    """

    routes: tuple[Route, ...]
    layers_m: tuple[float, ...]
    separation_m: float
    near_unheard: tuple[str, ...] = ()


def kept_apart(site: SurveySite, orders: Orders) -> KeptApart:
    """Return the routes of these orders, apart as the site's request wants it.

    Vehicles wait, fly their routes backwards, begin with another of their flights between battery
    changes, or fly in layers if the request says so, where that lets all land earlier.

    Raises
    ------
    BeyondEnduranceError
        If a battery does not last and cannot be swapped in between.
    NoFreeHeightError
        If layers are wanted and vehicles that nobody hears leave none.
    """
    separation_m = site.request.separation.distance_m
    choices = {k: FlightChoices(site, k, order) for k, order in enumerate(orders)}
    flying = {k: one for k, one in choices.items() if next(iter(one)).flights}
    if separation_m > 0.0:
        found = timetable(flying, separation_m)
    else:
        found = Timetable(
            choices={k: next(iter(one)) for k, one in flying.items()},
            starts_s=dict.fromkeys(flying, 0),
        )
    return _flown(site, choices, found)


def _flown(site: SurveySite, choices: 'dict[int, FlightChoices]', found: Timetable) -> KeptApart:
    """Return what is flown by a timetable."""
    chosen = [found.choices.get(k, next(iter(one))) for k, one in choices.items()]
    layers = tuple(choice.layer_m for choice in chosen)
    higher = in_layers(site, layers)
    routes = tuple(
        dataclasses.replace(
            route_of(higher, k, choice.flights), delay_s=float(found.starts_s.get(k, 0))
        )
        for k, choice in enumerate(chosen)
    )
    tracks = [choice.track for choice in found.choices.values()]
    return KeptApart(
        routes=routes,
        layers_m=layers,
        separation_m=minimum_separation_m(tracks, [found.starts_s[k] for k in found.choices]),
        near_unheard=tuple(
            site.problem.vehicles[k].name
            for k, choice in sorted(found.choices.items())
            if choice.is_near
        ),
    )


class FlightChoices:
    """What a vehicle may fly to visit its points in order, the preferred first."""

    def __init__(self, site: SurveySite, vehicle: int, order: Order) -> None:
        self._made: list[FlightChoice] = []
        self._more = self._all(site, vehicle, order)

    def __iter__(self) -> Iterator[FlightChoice]:
        number = 0
        while True:
            if number == len(self._made):
                made = next(self._more, None)
                if made is None:
                    return
                self._made.append(made)
            yield self._made[number]
            number += 1

    @staticmethod
    def _all(site: SurveySite, vehicle: int, order: Order) -> Iterator[FlightChoice]:
        problem, spaces = site.problem, unheard_spaces(site)
        layers = [problem.layer_m(vehicle)]
        if site.request.separation.by == 'layers' and site.request.separation.distance_m > 0.0:
            layers = free_layers_m(site.request)
        for number, layer_m in enumerate(layers):
            own = [problem.layer_m(k) for k in range(len(problem.vehicles))]
            own[vehicle] = layer_m
            higher = problem.in_layers(tuple(own))
            try:
                flights = sorties(higher, vehicle, order)
            except BeyondEnduranceError:
                if number == 0:
                    raise
                return
            yield FlightChoice(higher, vehicle, flights, layer_m, spaces)
            for other in _others(site, vehicle, flights) if number == 0 else []:
                choice = FlightChoice(higher, vehicle, other, layer_m, spaces)
                if choice.track.keeps_to_batteries:
                    yield choice


def _others(site: SurveySite, vehicle: int, flights: Orders) -> Iterator[Orders]:
    """Yield the flights beginning with another of them, and then all backwards."""
    spec = site.problem.vehicles[vehicle]
    turns = _turns(spec, flights)
    yield from turns[1:]
    is_round = spec.aloft is None and spec.end is None and not spec.is_open
    if is_round and not site.request.continuation.last:
        yield from ([flight[::-1] for flight in turn] for turn in turns)


def _turns(spec: Vehicle, flights: Orders) -> list[Orders]:
    """Return the flights, and them again beginning with each that begins and ends at home."""
    first = 0 if spec.aloft is None else 1
    # One flight may be both: the first of a vehicle in the air, and the one that ends elsewhere.
    last = max(first, len(flights) - (1 if spec.is_open or spec.end is not None else 0))
    head, free, tail = flights[:first], flights[first:last], flights[last:]
    turns = [free[k:] + free[:k] for k in range(min(len(free), MAX_TURNS))]
    return [[*head, *turn, *tail] for turn in turns or [free]]


def in_layers(site: SurveySite, layers_m: tuple[float, ...]) -> SurveySite:
    """Return the site with vehicles that fly so much higher."""
    return dataclasses.replace(site, problem=site.problem.in_layers(layers_m))
