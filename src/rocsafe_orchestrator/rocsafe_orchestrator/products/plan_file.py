# SPDX-License-Identifier: Apache-2.0
"""The plan of a run as the report shows it, from the plan that the planner's reader returns."""

import math
from pathlib import Path

from rocsafe_orchestrator.products.run_record import Plan, PlannedRoute, PlannedViewpoint
from rocsafe_planner.plan import plan_reading
from rocsafe_planner.plan.flight_path import flight_path
from rocsafe_planner.plan.objective import OBJECTIVE_VALUES
from rocsafe_planner.plan.plan import Route


def read_plan(path: Path) -> Plan:
    """Return the plan in `path`.

    Raises
    ------
    ValueError
        If it is no plan, or one of another format.
    """
    plan = plan_reading.read_plan(path, needs_terrain=False)
    request, coverage = plan.request, plan.request.coverage
    areas = [region.area for region in request.regions]
    nearest = plan.minimum_separation_m
    return Plan(
        plan_id=plan.plan_id,
        method=request.effort.method,
        region=areas[0],
        other_regions=tuple(areas[1:]),
        exclusions=request.exclusions,
        height_agl_m=coverage.height_agl_m,
        spacing_rule=coverage.spacing_rule,
        overlap_fraction=coverage.overlap_fraction,
        spacing_m=plan.spacing_m,
        routes=tuple(map(_route, plan.routes)),
        makespan_s=plan.makespan_s,
        lower_bound_s=plan.lower_bound_s,
        lower_bound_method=plan.lower_bound_method,
        gap_fraction=plan.gap_fraction,
        region_area_m2=plan.region_area_m2,
        covered_area_m2=plan.covered_area_m2,
        covered_fraction=plan.covered_fraction,
        horizontal_fov_rad=request.camera.horizontal_fov_rad,
        image_width_px=request.camera.image_width_px,
        image_height_px=request.camera.image_height_px,
        objective=request.effort.objective,
        objective_value=OBJECTIVE_VALUES[request.effort.objective](plan),
        largest_hole_m2=plan.largest_hole_m2,
        separation_m=request.separation.distance_m,
        minimum_separation_m=nearest if math.isfinite(nearest) else math.nan,
    )


def _route(route: Route) -> PlannedRoute:
    return PlannedRoute(
        vehicle=route.vehicle.name,
        home=route.vehicle.home,
        viewpoints=tuple(
            PlannedViewpoint(
                id=view.id,
                position=view.position,
                height_agl_m=view.height_agl_m,
                yaw_rad=view.yaw_rad,
            )
            for view in route.viewpoints
        ),
        length_m=route.length_m,
        duration_s=route.duration_s,
        way=tuple(
            stop.position
            for number in range(len(route.sorties))
            for stop in flight_path(route, number)
        ),
        delay_s=route.delay_s,
        flights=len(route.sorties),
    )
