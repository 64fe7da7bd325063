# SPDX-License-Identifier: Apache-2.0
"""From the orders of points to routes: flights within the battery, bends, figures."""

from itertools import pairwise

import numpy as np

from rocsafe_geo.position import GeoPosition
from rocsafe_planner.fleet_problem import FleetProblem, Order
from rocsafe_planner.plan import Bends, Route, Sortie
from rocsafe_planner.sorties import sorties
from rocsafe_planner.survey_site import SurveySite

SECONDS_PER_HOUR = 3600.0


def routes_of(site: SurveySite, orders: list[Order]) -> tuple[Route, ...]:
    """Return the routes that visit the points in these orders, one a vehicle.

    Raises
    ------
    BeyondEnduranceError
        If a battery does not last and cannot be swapped in between.
    """
    return tuple(
        Route(vehicle=vehicle, sorties=_sorties(site, k, order))
        for k, (vehicle, order) in enumerate(zip(site.problem.vehicles, orders, strict=True))
    )


def _sorties(site: SurveySite, vehicle: int, order: Order) -> tuple[Sortie, ...]:
    problem = site.problem
    flights = sorties(problem, vehicle, order)
    made = []
    for number, flight in enumerate(flights, start=1):
        # All flights but the last come home, whatever the vehicle's end.
        end = problem.end_site(vehicle) if number == len(flights) else problem.home_site(vehicle)
        stops = [problem.home_site(vehicle), *flight, *([] if end is None else [end])]
        made.append(_sortie(site, vehicle, flight, stops))
    return tuple(made)


def _sortie(site: SurveySite, vehicle: int, flight: Order, stops: list[int]) -> Sortie:
    problem, spec = site.problem, site.problem.vehicles[vehicle]
    origins, targets = np.array(stops[:-1]), np.array(stops[1:])
    hovering = len(flight) * spec.hover_s
    moving = problem.fixed_s(vehicle) + float(problem.legs_s(vehicle, origins, targets).sum())
    energy = moving * spec.cruise_power_w + hovering * spec.hover_power_w
    return Sortie(
        viewpoints=tuple(site.viewpoints[point] for point in flight),
        bends=tuple(_bends(site, problem, a, b) for a, b in pairwise(stops)),
        length_m=float(problem.legs_m(origins, targets).sum()),
        duration_s=moving + hovering,
        energy_wh=energy / SECONDS_PER_HOUR,
    )


def _bends(site: SurveySite, problem: FleetProblem, origin: int, target: int) -> Bends:
    places = problem.bends(origin, target)
    if not len(places):
        return ()
    height = site.viewpoints[0].height_agl_m
    geodetic = site.frame.to_geodetic(np.column_stack([places, np.full(len(places), height)]))
    altitude = site.viewpoints[0].position.altitude_m
    return tuple(
        GeoPosition(latitude, longitude, altitude if altitude != altitude else up)
        for latitude, longitude, up in geodetic.tolist()
    )
