# SPDX-License-Identifier: Apache-2.0
"""From the points of flights to routes: bends, figures."""

from itertools import pairwise

import numpy as np

from rocsafe_planner.plan.plan import Bends, Route, Sortie
from rocsafe_planner.problem.fleet_problem import Order
from rocsafe_planner.site.survey_site import SurveySite

SECONDS_PER_HOUR = 3600.0


def route_of(site: SurveySite, vehicle: int, flights: list[Order]) -> Route:
    """Return the route of a vehicle that visits these points on each of its flights."""
    return Route(
        vehicle=site.problem.vehicles[vehicle],
        sorties=_sorties(site, vehicle, flights),
        flight_height_m=site.problem.flight_height_m(vehicle),
        ground_altitude_m=site.ground_altitude_m(vehicle),
        landing_height_m=site.landing_height_m(vehicle),
    )


def _sorties(site: SurveySite, vehicle: int, flights: list[Order]) -> tuple[Sortie, ...]:
    problem = site.problem
    made = []
    for number, flight in enumerate(flights, start=1):
        # All flights but the last come home, whatever the vehicle's end.
        end = problem.end_site(vehicle) if number == len(flights) else problem.home_site(vehicle)
        start = problem.start_site(vehicle) if number == 1 else problem.home_site(vehicle)
        stops = [start, *flight, *([] if end is None else [end])]
        made.append(_sortie(site, vehicle, flight, stops))
    return tuple(made)


def _sortie(site: SurveySite, vehicle: int, flight: Order, stops: list[int]) -> Sortie:
    problem, spec = site.problem, site.problem.vehicles[vehicle]
    # The type is stated, because a vehicle that lands where it is has a stop and no leg.
    sites = np.array(stops, dtype=np.intp)
    origins, targets = sites[:-1], sites[1:]
    hovering = len(flight) * spec.hover_s
    is_first = stops[0] == problem.start_site(vehicle)
    vertical = problem.first_fixed_s(vehicle) if is_first else problem.fixed_s(vehicle)
    moving = vertical + float(problem.legs_s(vehicle, origins, targets).sum())
    if spec.hover_s == 0.0:  # it passes viewpoints: corners depend on three places
        is_last = stops[-1] != problem.home_site(vehicle)
        motion = problem.motion(vehicle, flight, is_first=is_first, is_last=is_last)
        moving = motion.duration_s
    exit_m = problem.exit_m(vehicle) if is_first else 0.0
    energy = moving * spec.cruise_power_w + hovering * spec.hover_power_w
    return Sortie(
        viewpoints=tuple(site.viewpoint(vehicle, point) for point in flight),
        bends=tuple(_bends(site, vehicle, a, b) for a, b in pairwise(stops)),
        length_m=exit_m + float(problem.legs_m(origins, targets).sum()),
        duration_s=moving + hovering,
        energy_wh=energy / SECONDS_PER_HOUR,
    )


def _bends(site: SurveySite, vehicle: int, origin: int, target: int) -> Bends:
    problem = site.problem
    way = problem.way(vehicle, origin, target)
    is_way_out = origin == problem.start_site(vehicle) and problem.inside(vehicle) is not None
    return site.positions(way[:-1] if is_way_out else way[1:-1])
