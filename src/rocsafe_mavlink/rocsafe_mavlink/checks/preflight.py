# SPDX-License-Identifier: Apache-2.0
"""Checks before a flight, each with value and limit.

An autopilot accepts a waypoint in another country and one at 40 km height, so distances and
heights are checked here.
"""

import math
from itertools import pairwise

from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_mavlink.autopilots.autopilot import Autopilot
from rocsafe_mavlink.checks.check import Check, CheckVerdict, check_that
from rocsafe_mavlink.checks.setting_checks import setting_checks
from rocsafe_mavlink.checks.way_checks import (
    exclusion_checks,
    fence_check,
    fence_limits,
    homeward_checks,
    start_of,
)
from rocsafe_mavlink.checks.wind_checks import wind_checks
from rocsafe_mavlink.knowledge.fix import fix_fault
from rocsafe_mavlink.knowledge.telemetry import Contact, VehicleTelemetry
from rocsafe_mavlink.plan.flight_limits import FlightLimits, VehicleSettings
from rocsafe_mavlink.plan.flight_plan import FlightPlan

# For corners: on a recorded survey the time at constant speed is 23 % too short.
LEVEL_ALLOWANCE = 1.25


def preflight(
    vehicle: VehicleTelemetry,
    autopilot: Autopilot,
    plan: FlightPlan | None,
    limits: FlightLimits,
    now_s: float,
    knowledge: VehicleSettings | None = None,
) -> tuple[Check, ...]:
    """Return all checks of `vehicle` and `plan`, passed or failed.

    Without `plan` only the vehicle is checked.
    """
    known = knowledge or VehicleSettings()
    checks = [
        *_vehicle_checks(vehicle, autopilot, limits, now_s),
        *wind_checks(vehicle.wind, limits, now_s),
        *setting_checks(known, limits),
    ]
    if vehicle.home is None:
        return (*checks, Check('home', CheckVerdict.FAIL, 'not known', 'told by the vehicle'))
    if plan is None:
        return tuple(checks)
    checks += [] if plan.home is None else [_home_check(plan.home, vehicle.home.place, limits)]
    energy = _energy_check(plan, vehicle, limits)
    *way, fence = route_checks(vehicle, plan, limits, known)
    return (*checks, *way, energy, fence)


def route_checks(
    vehicle: VehicleTelemetry, plan: FlightPlan, limits: FlightLimits, known: VehicleSettings
) -> tuple[Check, ...]:
    """Return the checks of the way of `plan`, from home, or in the air from where it is."""
    if vehicle.home is None:
        return (Check('home', CheckVerdict.FAIL, 'not known', 'told by the vehicle'),)
    home = vehicle.home.place
    start = start_of(vehicle, home)
    way = (*_plan_checks(plan, home, limits), *fence_limits(plan, home, known.parameters))
    clear = (*exclusion_checks(plan, start, home), *homeward_checks(plan, home, known))
    return (*way, *clear, fence_check(plan, home, known, start))


def estimated_duration_s(plan: FlightPlan, home: GeoPosition, limits: FlightLimits) -> float:
    """Return a coarse duration, home to home: constant speed and an allowance for corners."""
    ends = [] if plan.is_drive else [home]
    places = [home, *(waypoint.position for waypoint in plan.waypoints), *ends]
    speeds = [waypoint.speed_mps or plan.speed_mps for waypoint in plan.waypoints]
    legs = zip(pairwise(places), [*speeds, plan.speed_mps], strict=False)
    level_s = LEVEL_ALLOWANCE * sum(distance_m(*leg) / speed for leg, speed in legs)
    climb_s = plan.waypoints[0].height_m / limits.climb_mps
    descent_s = plan.waypoints[-1].height_m / limits.descent_mps
    return level_s + climb_s + descent_s + sum(waypoint.hold_s for waypoint in plan.waypoints)


def _vehicle_checks(
    vehicle: VehicleTelemetry, autopilot: Autopilot, limits: FlightLimits, now_s: float
) -> list[Check]:
    contact, fault = vehicle.contact(now_s), fix_fault(vehicle, now_s)
    charge = vehicle.battery.fraction
    tested = CheckVerdict.PASS if autopilot.is_tested else CheckVerdict.WARN
    known = math.isfinite(vehicle.geoid_separation_m)
    satellites = vehicle.gps.satellites
    return [
        check_that('contact', contact is Contact.FRESH, contact.value, 'fresh'),
        Check('autopilot', tested, autopilot.name, 'one that was tried here'),
        check_that('place', vehicle.is_on_ground, _ground(vehicle), 'on the ground'),
        check_that('motors', not vehicle.is_armed, 'on' if vehicle.is_armed else 'off', 'off'),
        check_that('fix', not fault, fault or 'good', 'good'),
        check_that(
            'satellites',
            satellites >= limits.fewest_satellites,
            str(satellites),
            f'{limits.fewest_satellites} or more',
        ),
        check_that(
            'self-test',
            vehicle.is_prearm_ok,
            'passed' if vehicle.is_prearm_ok else 'not passed',
            'passed',
        ),
        check_that(
            'charge',
            charge >= limits.smallest_charge,
            'not known' if math.isnan(charge) else f'{charge:.0%}',
            f'{limits.smallest_charge:.0%} or more',
        ),
        Check(
            'geoid',
            CheckVerdict.PASS if known else CheckVerdict.WARN,
            f'{vehicle.geoid_separation_m:.1f} m' if known else 'not known',
            'known, or altitudes are NaN',
        ),
    ]


def _energy_check(plan: FlightPlan, vehicle: VehicleTelemetry, limits: FlightLimits) -> Check:
    home = vehicle.home
    duration_s = 0.0 if home is None else estimated_duration_s(plan, home.place, limits)
    needed = duration_s / limits.longest_s + limits.reserve
    charge = vehicle.battery.fraction
    return check_that(
        'energy',
        charge >= needed,
        'charge not known' if math.isnan(charge) else f'{charge:.0%} charged',
        f'{needed:.0%} for this flight, its reserve included',
    )


def _home_check(planned: GeoPosition, home: GeoPosition, limits: FlightLimits) -> Check:
    away_m = distance_m(planned, home)
    return check_that(
        'place of the plan',
        away_m <= limits.longest_to_home_m,
        f'{away_m:.1f} m from where the plan has it',
        f'at most {limits.longest_to_home_m:g} m',
    )


def _plan_checks(plan: FlightPlan, home: GeoPosition, limits: FlightLimits) -> list[Check]:
    heights = [waypoint.height_m for waypoint in plan.waypoints]
    highest_m = max(waypoint.height_above_ground_m for waypoint in plan.waypoints)
    furthest_m = max(distance_m(home, waypoint.position) for waypoint in plan.waypoints)
    duration_s = estimated_duration_s(plan, home, limits)
    low, high = limits.lowest_m, limits.max_height_agl_m
    in_height = check_that(
        'heights',
        low <= min(heights) and highest_m <= high,
        f'{min(heights):g} to {highest_m:g} m',
        f'{low:g} m above home to {high:g} m above the ground',
    )
    return [
        *([] if plan.is_drive else [in_height]),
        check_that(
            'distance',
            furthest_m <= limits.furthest_m,
            f'{furthest_m:.0f} m from home',
            f'at most {limits.furthest_m:g} m',
        ),
        check_that(
            'duration',
            duration_s <= limits.longest_s,
            f'{duration_s:.0f} s',
            f'at most {limits.longest_s:g} s',
        ),
    ]


def _ground(vehicle: VehicleTelemetry) -> str:
    return 'on the ground' if vehicle.is_on_ground else 'in the air'
