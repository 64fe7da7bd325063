# SPDX-License-Identifier: Apache-2.0
"""Checks of the path of a plan against fence and exclusions, on the ground or in the air."""

import math
from itertools import pairwise

from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_mavlink.autopilots.ardupilot import COPTER, ROVER
from rocsafe_mavlink.autopilots.parameters import SPELLINGS, Parameter, ParameterReader
from rocsafe_mavlink.autopilots.px4 import MULTICOPTER
from rocsafe_mavlink.checks.check import NOT_READ, Check, CheckVerdict, check_that
from rocsafe_mavlink.checks.setting_checks import setting_text
from rocsafe_mavlink.knowledge.telemetry import VehicleTelemetry
from rocsafe_mavlink.plan.flight_limits import VehicleSettings
from rocsafe_mavlink.plan.flight_plan import FlightPlan
from rocsafe_mavlink.plan.homeward import ReturnPlaces, holds_exclusions, return_fault, way_fault

# Bits of ArduPilot's FENCE_TYPE.
FENCE_HEIGHT_BIT, FENCE_CIRCLE_BIT, FENCE_POLYGON_BIT = 1, 2, 4
# OA_TYPE of ArduPilot that plan around the polygons of its fence, on the return, too: Dijkstra,
# and Dijkstra with BendyRuler.
PLANS_AROUND = frozenset({2.0, 3.0})
# RTL_TYPE of PX4 that flies back along its mission.
RETURNS_BY_ROUTE = 2.0
# RALLY_LIMIT_KM of an ArduCopter that does not answer.
USUAL_RALLY_LIMIT_M = 300.0
_PLANS_AROUND = 'OA_TYPE 2 with the exclusions in its fence, or other rally points'
_REMEDY = {
    COPTER.name: _PLANS_AROUND,
    ROVER.name: _PLANS_AROUND,
    MULTICOPTER.name: 'RTL_TYPE 2, or other rally points',
}


def start_of(vehicle: VehicleTelemetry, home: GeoPosition) -> GeoPosition | None:
    """Return where a vehicle begins a route: home, or where it flies; None: not known."""
    if vehicle.is_on_ground:
        return home
    return None if vehicle.motion is None else vehicle.motion.position


def exclusion_checks(
    plan: FlightPlan, start: GeoPosition | None, home: GeoPosition
) -> list[Check]:
    """Return the check that the way, from `start` to home, keeps clear of the exclusions."""
    name, limit = 'way', 'clear of exclusions'
    if not plan.exclusions:
        return []
    if start is None:
        return [Check(name, CheckVerdict.FAIL, NOT_READ, limit)]
    fault = way_fault(plan, [start, *(waypoint.position for waypoint in plan.waypoints), home])
    return [check_that(name, not fault, fault or 'clear', limit)]


def fence_check(
    plan: FlightPlan,
    home: GeoPosition,
    known: VehicleSettings,
    start: GeoPosition | None = None,
) -> Check:
    """Return the check that the way, from `start` or home to home, stays within the fence."""
    name, limit = 'within fence', 'none outside'
    if known.fence is None:
        error = f'cannot be read: {known.fence_error}' if known.fence_error else NOT_READ
        return Check(name, CheckVerdict.FAIL, error, limit)
    places = [waypoint.position for waypoint in plan.waypoints]
    outside = sum(not known.fence.holds(place) for place in places)
    if outside:
        return check_that(name, False, f'{outside} of {len(places)} waypoints outside', limit)
    legs = list(pairwise([start or home, *places, home]))
    outside = sum(not known.fence.holds_leg(*leg) for leg in legs)
    return check_that(name, not outside, f'{outside} of {len(legs)} legs partly outside', limit)


def fence_limits(
    plan: FlightPlan, home: GeoPosition, reader: ParameterReader | None
) -> list[Check]:
    """Return the checks of the fence that parameters make: a cylinder about home."""
    if reader is None:
        return []
    enabled = reader.value(Parameter.FENCE_ENABLED)
    if enabled == 0.0 or (math.isnan(enabled) and reader.is_over):
        return []
    furthest_m = max(distance_m(home, waypoint.position) for waypoint in plan.waypoints)
    highest_m = max(waypoint.height_m for waypoint in plan.waypoints)
    types = reader.value(Parameter.FENCE_TYPES)
    has_types = Parameter.FENCE_TYPES in SPELLINGS[reader.kind]
    if has_types and math.isnan(types):
        text = setting_text(reader, Parameter.FENCE_TYPES)
        # Old or reduced firmware does not answer; the check says so.
        verdict = CheckVerdict.WARN if reader.is_over else CheckVerdict.FAIL
        return [Check(Parameter.FENCE_TYPES.value, verdict, text, 'read')]
    checks = []
    for bit, parameter, reached_m in (
        (FENCE_HEIGHT_BIT, Parameter.FENCE_HEIGHT_M, highest_m),
        (FENCE_CIRCLE_BIT, Parameter.FENCE_RADIUS_M, furthest_m),
    ):
        is_known = parameter in SPELLINGS[reader.kind]
        if not is_known or (has_types and not int(types) & bit):
            continue
        limit_m, text = reader.value(parameter), setting_text(reader, parameter)
        # A PX4 has no such fence where its limit is 0.
        is_held = reached_m < limit_m or (limit_m == 0.0 and not has_types)
        is_untold = math.isnan(limit_m) and reader.is_over
        verdict = CheckVerdict.WARN if is_untold else CheckVerdict.FAIL
        verdict = CheckVerdict.PASS if is_held else verdict
        checks.append(Check(parameter.value, verdict, text, f'more than {reached_m:.0f} m'))
    return checks


def homeward_checks(plan: FlightPlan, home: GeoPosition, known: VehicleSettings) -> list[Check]:
    """Return the check that a vehicle that gives up flies over no exclusion."""
    name, limit = 'way home', 'clear of exclusions from every leg'
    if not plan.exclusions:
        return []
    reader = known.parameters
    is_fence_read = known.fence is not None or bool(known.fence_error)
    is_rally_read = known.rally is not None or bool(known.rally_error)
    if reader is None or not reader.is_over or not (is_fence_read and is_rally_read):
        return [Check(name, CheckVerdict.FAIL, NOT_READ, limit)]
    if _returns_around(plan, known, reader):
        return [Check(name, CheckVerdict.PASS, 'around the exclusions, by itself', limit)]
    if known.rally is None:
        text = f'not known: rally points cannot be read ({known.rally_error})'
        return [Check(name, CheckVerdict.FAIL, text, limit)]
    limit_m = reader.value(Parameter.RALLY_LIMIT_M)
    places = ReturnPlaces(
        home=home,
        rally=known.rally,
        limit_m=limit_m if math.isfinite(limit_m) else USUAL_RALLY_LIMIT_M,
        includes_home=reader.value(Parameter.RALLY_INCLUDES_HOME) != 0.0,
    )
    fault = return_fault(plan, places)
    return [check_that(name, not fault, fault or 'clear', f'{limit}, or {_REMEDY[reader.kind]}')]


def _returns_around(plan: FlightPlan, known: VehicleSettings, reader: ParameterReader) -> bool:
    """Whether the autopilot itself finds a way home around the exclusions."""
    if reader.value(Parameter.RETURN_KIND) == RETURNS_BY_ROUTE:
        return True
    types = reader.value(Parameter.FENCE_TYPES)
    has_polygons = math.isfinite(types) and bool(int(types) & FENCE_POLYGON_BIT)
    is_fenced = reader.value(Parameter.FENCE_ENABLED) == 1.0 and has_polygons
    is_planning = reader.value(Parameter.PATH_PLANNER) in PLANS_AROUND
    fence = known.fence
    return (
        is_fenced
        and is_planning
        and fence is not None
        and holds_exclusions(fence, plan.exclusions)
    )
