# SPDX-License-Identifier: Apache-2.0
"""What the map shows of the plan: regions, exclusions, routes and what photographs will show."""

import math
from collections.abc import Iterable

import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_orchestrator.products.run_record import Plan, RunRecord
from rocsafe_planner.plan.viewpoint import Viewpoint

Point = tuple[float, float]
Rings = tuple[tuple[Point, ...], ...]


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
        return _rings((record.plan.region, *record.plan.other_regions), frame)
    if record.scenario is not None:
        return _rings((record.scenario.area(), *record.scenario.other_areas()), frame)
    return ()


def exclusion_rings(record: RunRecord, frame: LocalFrame) -> Rings:
    """Return the rings of all exclusions, holes included."""
    return _rings(record.plan.exclusions, frame) if record.plan is not None else ()


def route_lines(record: RunRecord, frame: LocalFrame) -> dict[str, tuple[Point, ...]]:
    """Return the planned routes, with their bends, of the vehicles that have viewpoints."""
    routes = record.plan.routes if record.plan else ()
    return {route.vehicle: points(frame, route.way) for route in routes if route.viewpoints}


def planned_footprints(record: RunRecord, frame: LocalFrame) -> dict[str, Rings]:
    """Return the corners of the ground that each vehicle's photographs are to show."""
    plan = record.plan
    if plan is None:
        return {}
    footprints = {}
    for route in plan.routes:
        places = points(frame, (viewpoint.position for viewpoint in route.viewpoints))
        views = zip(route.viewpoints, places, strict=True)
        footprints[route.vehicle] = tuple(_footprint(plan, view, place) for view, place in views)
    return footprints


def _footprint(plan: Plan, viewpoint: Viewpoint, place: Point) -> tuple[Point, ...]:
    camera = PinholeCamera(plan.horizontal_fov_rad, plan.image_width_px, plan.image_height_px)
    across, along = camera.footprint_m(viewpoint.height_agl_m)
    ahead = (math.cos(viewpoint.yaw_rad), math.sin(viewpoint.yaw_rad))
    corners = [(-across, -along), (across, -along), (across, along), (-across, along)]
    return tuple(
        (
            place[0] + 0.5 * (right * ahead[1] + forward * ahead[0]),
            place[1] - 0.5 * (forward * ahead[1] - right * ahead[0]),
        )
        for right, forward in corners
    )


def _rings(areas: Iterable[SurveyArea], frame: LocalFrame) -> Rings:
    return tuple(points(frame, ring) for area in areas for ring in (area.boundary, *area.holes))
