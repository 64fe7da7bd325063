# SPDX-License-Identifier: Apache-2.0
"""Routes of vehicles that keep apart: they wait, or fly in layers of height."""

import dataclasses
import math
from dataclasses import dataclass

from rocsafe_planner.errors import BeyondEnduranceError, NoFreeHeightError
from rocsafe_planner.flights.flight_track import FlightTrack
from rocsafe_planner.flights.routes import route_of, routes_of
from rocsafe_planner.flights.separation import (
    TOLERANCE_M,
    Placed,
    delays_apart,
    flying_order,
    minimum_separation_m,
)
from rocsafe_planner.flights.unheard_space import UnheardSpace, keeps_away, unheard_spaces
from rocsafe_planner.plan.plan import Route
from rocsafe_planner.problem.fleet_problem import Order
from rocsafe_planner.site.survey_site import SurveySite

MAX_LAYERS = 8
"""Layers that are tried; the highest flies that many separations higher, less one."""

MAX_TURNS = 12
"""Flights of a vehicle that are tried as its first."""

Orders = list[Order]


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptApart:
    """Routes, how high each vehicle flies above the others, and the least distance of any two.

    `near_unheard` names vehicles that come near to where one may be of which nobody hears.
    """

    routes: tuple[Route, ...]
    layers_m: tuple[float, ...]
    separation_m: float
    near_unheard: tuple[str, ...] = ()


def kept_apart(site: SurveySite, orders: Orders) -> KeptApart:
    """Return the routes of these orders, apart as the site's request wants it.

    Where batteries are changed, flights may take their turns in another order. Vehicles in the air
    that meet are given their places in another order.
    """
    apart = _kept_apart(site, orders)
    aloft = sum(vehicle.aloft is not None for vehicle in site.problem.vehicles)
    for turn in range(1, aloft if aloft > 1 else 0):
        if apart.separation_m >= site.request.separation.distance_m:
            break
        other = _kept_apart(site, orders, turn)
        apart = max(apart, other, key=lambda one: one.separation_m)
    turned = _turned(site, apart.routes) if any(r.delay_s for r in apart.routes) else orders
    if turned == orders:
        return apart
    other = _kept_apart(site, turned)
    return min(apart, other, key=lambda one: max(route.finish_s for route in one.routes))


def _kept_apart(site: SurveySite, orders: Orders, turn: int = 0) -> KeptApart:
    request = site.request
    is_wanted = request.separation.distance_m > 0.0
    layers = site.problem.layers_m or (0.0,) * len(orders)
    routes, spaces = routes_of(site, orders), unheard_spaces(site)
    if is_wanted and request.separation.by == 'layers':
        layers = _layers(site, orders, routes, turn, spaces)
        site = in_layers(site, layers)
        routes = routes_of(site, orders)
    flying = [k for k, route in enumerate(routes) if route.sorties]
    tracks = [_track(site, k, routes[k]) for k in flying]
    delays = [0.0] * len(tracks)
    if is_wanted:
        delays = delays_apart(tracks, request.separation.distance_m, turn)
    late = dict(zip(flying, delays, strict=True))
    delayed = tuple(
        dataclasses.replace(route, delay_s=late.get(k, 0.0)) for k, route in enumerate(routes)
    )
    return KeptApart(
        routes=delayed,
        layers_m=layers,
        separation_m=minimum_separation_m(tracks, delays),
        near_unheard=tuple(
            routes[k].vehicle.name
            for k, track in zip(flying, tracks, strict=True)
            if not keeps_away(spaces, track, site.problem.flight_height_m(k))
        ),
    )


def _turned(site: SurveySite, routes: tuple[Route, ...]) -> Orders:
    """Return the orders of routes whose flights take the turns that let them take off earliest.

    In the order in which places are given, each vehicle tries all turns of its flights.
    """
    orders = [_points(site, route) for route in routes]
    flying = [k for k, route in enumerate(routes) if route.sorties]
    tracks = {k: FlightTrack(site.problem, k, orders[k]) for k in flying}
    placed = Placed(site.request.separation.distance_m)
    for k in (flying[i] for i in flying_order(list(tracks.values()))):
        best = (math.inf, tracks[k], orders[k])
        for flights in _turns(routes[k], orders[k]):
            track = FlightTrack(site.problem, k, flights)
            delay_s = placed.delay_s(track, best[0])
            if delay_s < best[0]:
                best = (delay_s, track, flights)
            if best[0] == 0.0:
                break
        orders[k] = best[2]
        placed.add(best[1], best[0])
    return [[point for flight in flights for point in flight] for flights in orders]


def _turns(route: Route, flights: Orders) -> list[Orders]:
    """Return the flights, and them again beginning with each that begins and ends at home."""
    vehicle = route.vehicle
    first = 0 if vehicle.aloft is None else 1
    # One flight may be both: the first of a vehicle in the air, and the one that ends elsewhere.
    last = max(first, len(flights) - (1 if vehicle.is_open or vehicle.end is not None else 0))
    head, free, tail = flights[:first], flights[first:last], flights[last:]
    turns = [free[k:] + free[:k] for k in range(min(len(free), MAX_TURNS))]
    return [[*head, *turn, *tail] for turn in turns or [free]]


def in_layers(site: SurveySite, layers_m: tuple[float, ...]) -> SurveySite:
    """Return the site with vehicles that fly so much higher."""
    return dataclasses.replace(site, problem=site.problem.in_layers(layers_m))


def _layers(
    site: SurveySite,
    orders: Orders,
    routes: tuple[Route, ...],
    turn: int,
    spaces: list[UnheardSpace],
) -> tuple[float, ...]:
    """Return the height above the others at which each vehicle lands earliest.

    In the order in which places are given each vehicle takes the layer in which it lands first,
    waiting included; the lowest of those that are equal. Layers nearer than the separation to the
    height of a vehicle that nobody hears are left out, and, where there are others, those in which
    it comes near to where that one may be.

    Raises
    ------
    NoFreeHeightError
        If there is no other.
    """
    step = site.request.separation.distance_m
    placed = Placed(step)
    airspace, coverage = site.request.airspace, site.request.coverage
    highest_m = airspace.max_height_agl_m - coverage.height_agl_m
    layers = [0.0] * len(orders)
    flying = [k for k, route in enumerate(routes) if route.sorties]
    tracks = [_track(site, k, routes[k]) for k in flying]
    for k in (flying[i] for i in flying_order(tracks, turn)):
        free = [layer for layer in _free_layers(site) if layer <= highest_m]
        if not free:
            unheard = site.request.continuation.unheard
            heights = ', '.join(f'{one.flight_height_m:g} m' for one in unheard)
            raise NoFreeHeightError(
                f'no flight height up to {airspace.max_height_agl_m:g} m keeps {step:g} m from '
                f'vehicles that nobody hears, at {heights}'
            )
        best = (True, math.inf, 0.0, free[0], tracks[flying.index(k)])
        for layer in free:
            trial = in_layers(site, tuple(layer if i == k else 0.0 for i in range(len(orders))))
            try:
                track = _track(trial, k, route_of(trial, k, orders[k]))
            except BeyondEnduranceError:
                break
            is_near = not keeps_away(spaces, track, trial.problem.flight_height_m(k))
            limit_s = best[1] if is_near == best[0] else math.inf
            if is_near > best[0]:
                continue
            delay = placed.delay_s(track, limit_s - track.duration_s)
            if delay + track.duration_s < limit_s - 1e-9:
                best = (is_near, delay + track.duration_s, delay, layer, track)
            if not best[0] and best[2] == 0.0:
                break
        layers[k] = best[3]
        placed.add(best[4], best[2])
    return tuple(layers)


def _free_layers(site: SurveySite) -> list[float]:
    """Return the layers that are not occupied, as heights above the lowest."""
    step, base_m = site.request.separation.distance_m, site.request.coverage.height_agl_m
    occupied_m = [one.flight_height_m for one in site.request.continuation.unheard]
    layers = [number * step for number in range(MAX_LAYERS)]
    return [
        layer
        for layer in layers
        if all(abs(base_m + layer - height_m) >= step - TOLERANCE_M for height_m in occupied_m)
    ]


def _track(site: SurveySite, vehicle: int, route: Route) -> FlightTrack:
    return FlightTrack(site.problem, vehicle, _points(site, route))


def _points(site: SurveySite, route: Route) -> Orders:
    """Return the points of each of a route's flights."""
    points = {view.id: point for point, view in enumerate(site.viewpoints)}
    return [[points[view.id] for view in sortie.viewpoints] for sortie in route.sorties]
