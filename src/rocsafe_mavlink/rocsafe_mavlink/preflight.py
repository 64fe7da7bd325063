# SPDX-License-Identifier: Apache-2.0
"""What a careful pilot looks at before a flight: a list of checks with value and limit.

An autopilot accepts a waypoint in another country and one at 40 km height; so both are looked at
here.
"""

import math
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_mavlink.autopilot import Autopilot
from rocsafe_mavlink.fix import fix_fault
from rocsafe_mavlink.flight_plan import FlightPlan
from rocsafe_mavlink.vehicle import Contact, Home, Vehicle


class Verdict(Enum):
    """What a check says."""

    PASS = 'pass'  # noqa: S105 - the opposite of fail
    WARN = 'warn'
    FAIL = 'fail'


@dataclass(frozen=True, slots=True)
class Check:
    """One check: what was looked at, what it showed, and what it must be."""

    name: str
    verdict: Verdict
    value: str
    limit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightLimits:
    """What a flight may be.

    Attributes
    ----------
    lowest_m, highest_m: height above home of a waypoint.
    furthest_m: distance of a waypoint from home.
    longest_s: duration of the flight.
    smallest_charge: of the battery at the start, 0 to 1.
    fewest_satellites: that the receiver must use.
    climb_mps, descent_mps: for the duration.
    """

    lowest_m: float = 5.0
    highest_m: float = 120.0
    furthest_m: float = 2000.0
    longest_s: float = 1500.0
    smallest_charge: float = 0.5
    fewest_satellites: int = 6
    climb_mps: float = 2.5
    descent_mps: float = 1.0


def preflight(
    vehicle: Vehicle, autopilot: Autopilot, plan: FlightPlan, limits: FlightLimits, now_s: float
) -> tuple[Check, ...]:
    """Return every check of `vehicle` and `plan`, those that failed among them."""
    checks = [*_vehicle_checks(vehicle, autopilot, limits, now_s)]
    if vehicle.home is None:
        return (*checks, Check('home', Verdict.FAIL, 'not known', 'told by the autopilot'))
    return (*checks, *_plan_checks(plan, _place(vehicle.home), limits))


def failures(checks: tuple[Check, ...]) -> str:
    """Return what failed, in one line; empty if nothing did."""
    failed = (check for check in checks if check.verdict is Verdict.FAIL)
    return '; '.join(f'{check.name} is {check.value}: must be {check.limit}' for check in failed)


def estimated_duration_s(plan: FlightPlan, home: GeoPosition, limits: FlightLimits) -> float:
    """Return a coarse duration, home to home: a constant speed with 25 % on top for the corners.

    Measured on a recorded survey, a constant speed alone is 23 % too short.
    """
    places = [home, *(waypoint.position for waypoint in plan.waypoints), home]
    level_s = 1.25 * sum(distance_m(a, b) for a, b in pairwise(places)) / plan.speed_mps
    climb_s = plan.waypoints[0].height_m / limits.climb_mps
    descent_s = plan.waypoints[-1].height_m / limits.descent_mps
    return level_s + climb_s + descent_s + sum(waypoint.hold_s for waypoint in plan.waypoints)


def _vehicle_checks(
    vehicle: Vehicle, autopilot: Autopilot, limits: FlightLimits, now_s: float
) -> list[Check]:
    contact, fault = vehicle.contact(now_s), fix_fault(vehicle, now_s)
    charge = vehicle.battery.fraction
    tested = Verdict.PASS if autopilot.is_tested else Verdict.WARN
    known = math.isfinite(vehicle.geoid_separation_m)
    satellites = vehicle.gps.satellites
    return [
        _check('contact', contact is Contact.FRESH, contact.value, 'fresh'),
        Check('autopilot', tested, autopilot.name, 'one that was tried here'),
        _check('place', vehicle.is_on_ground, _ground(vehicle), 'on the ground'),
        _check('motors', not vehicle.is_armed, 'on' if vehicle.is_armed else 'off', 'off'),
        _check('fix', not fault, fault or 'good', 'good'),
        _check(
            'satellites',
            satellites >= limits.fewest_satellites,
            str(satellites),
            f'{limits.fewest_satellites} or more',
        ),
        _check(
            'self-test',
            vehicle.is_prearm_ok,
            'passed' if vehicle.is_prearm_ok else 'not passed',
            'passed',
        ),
        _check(
            'charge',
            charge >= limits.smallest_charge,
            'not known' if math.isnan(charge) else f'{charge:.0%}',
            f'{limits.smallest_charge:.0%} or more',
        ),
        Check(
            'geoid',
            Verdict.PASS if known else Verdict.WARN,
            f'{vehicle.geoid_separation_m:.1f} m' if known else 'not known',
            'known, or altitudes are NaN',
        ),
    ]


def _plan_checks(plan: FlightPlan, home: GeoPosition, limits: FlightLimits) -> list[Check]:
    heights = [waypoint.height_m for waypoint in plan.waypoints]
    furthest_m = max(distance_m(home, waypoint.position) for waypoint in plan.waypoints)
    duration_s = estimated_duration_s(plan, home, limits)
    low, high = limits.lowest_m, limits.highest_m
    return [
        _check(
            'heights',
            low <= min(heights) and max(heights) <= high,
            f'{min(heights):g} to {max(heights):g} m',
            f'{low:g} to {high:g} m above home',
        ),
        _check(
            'distance',
            furthest_m <= limits.furthest_m,
            f'{furthest_m:.0f} m from home',
            f'at most {limits.furthest_m:g} m',
        ),
        _check(
            'duration',
            duration_s <= limits.longest_s,
            f'{duration_s:.0f} s',
            f'at most {limits.longest_s:g} s',
        ),
    ]


def _check(name: str, is_good: bool, value: str, limit: str) -> Check:
    return Check(name, Verdict.PASS if is_good else Verdict.FAIL, value, limit)


def _ground(vehicle: Vehicle) -> str:
    return 'on the ground' if vehicle.is_on_ground else 'in the air'


def _place(home: Home) -> GeoPosition:
    return GeoPosition(home.latitude_deg, home.longitude_deg)
