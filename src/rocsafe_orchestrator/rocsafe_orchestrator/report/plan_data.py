# SPDX-License-Identifier: Apache-2.0
"""Content of the map from the plan: regions, exclusions, routes and footprints."""

from collections.abc import Iterable, Iterator

import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_orchestrator.products.run_record import RunRecord
from rocsafe_planner.plan.flight_path import flight_path
from rocsafe_planner.plan.plan import Route
from rocsafe_view.svg import Point, Rings


def points(frame: LocalFrame, positions: Iterable[GeoPosition]) -> tuple[Point, ...]:
    """Return `positions` in map coordinates: east, and down the page."""
    listed = list(positions)
    if not listed:
        return ()
    enu = frame.to_enu(
        np.array([p.latitude_deg for p in listed]),
        np.array([p.longitude_deg for p in listed]),
        np.array([p.altitude_m for p in listed]),
    )
    return tuple(zip(enu[:, 0].tolist(), (-enu[:, 1]).tolist(), strict=True))


def region_rings(record: RunRecord, frame: LocalFrame) -> Rings:
    """Return the rings of all regions, holes included."""
    if record.plan is not None:
        return _rings((region.area for region in record.plan.request.regions), frame)
    if record.scenario is not None:
        return _rings((record.scenario.area(), *record.scenario.other_areas()), frame)
    return ()


def exclusion_rings(record: RunRecord, frame: LocalFrame) -> Rings:
    """Return the rings of all exclusions, holes included."""
    return _rings(record.plan.request.exclusions, frame) if record.plan is not None else ()


def route_lines(record: RunRecord, frame: LocalFrame) -> dict[str, tuple[Point, ...]]:
    """Return the planned routes, with their bends, of the vehicles that have viewpoints."""
    routes = record.plan.routes if record.plan else ()
    return {
        route.vehicle.name: points(frame, _path(route)) for route in routes if route.viewpoints
    }


def further_lines(record: RunRecord, frame: LocalFrame) -> dict[str, Rings]:
    """Return the routes of each vehicle in the plans that followed the first."""
    lines: dict[str, Rings] = {}
    for plan in record.further:
        for route in plan.routes:
            if route.sorties:
                name = route.vehicle.name
                lines[name] = (*lines.get(name, ()), points(frame, _path(route)))
    return lines


def _path(route: Route) -> Iterator[GeoPosition]:
    for number in range(len(route.sorties)):
        for stop in flight_path(route, number):
            yield stop.position


def planned_footprints(record: RunRecord, frame: LocalFrame) -> dict[str, Rings]:
    """Return the corners of the ground that each vehicle's photographs are to show."""
    routes = record.plan.routes if record.plan else ()
    return {
        route.vehicle.name: tuple(points(frame, view.footprint) for view in route.viewpoints)
        for route in routes
    }


def _rings(areas: Iterable[SurveyArea], frame: LocalFrame) -> Rings:
    return tuple(points(frame, ring) for area in areas for ring in (area.boundary, *area.holes))
