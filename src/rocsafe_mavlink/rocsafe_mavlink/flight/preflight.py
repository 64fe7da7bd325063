# SPDX-License-Identifier: Apache-2.0
"""Checks before a flight, each with value and limit.

An autopilot accepts a waypoint in another country and one at 40 km height, so distances and
heights are checked here.
"""

import math
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_mavlink.autopilots.ardupilot import ARDUPILOT
from rocsafe_mavlink.autopilots.autopilot import Autopilot
from rocsafe_mavlink.autopilots.parameters import SPELLINGS, Parameter, ParameterReader
from rocsafe_mavlink.autopilots.px4 import PX4
from rocsafe_mavlink.flight.fence import Fence
from rocsafe_mavlink.flight.flight_plan import FlightPlan
from rocsafe_mavlink.flight.homeward import ReturnPlaces, holds_exclusions, return_fault
from rocsafe_mavlink.knowledge.fix import fix_fault
from rocsafe_mavlink.knowledge.telemetry import Contact, Home, VehicleTelemetry

# Value of a setting that was asked for and may still be answered.
NOT_READ = 'not read yet'
# Link-loss actions that bring a vehicle home: FS_GCS_ENABLE 1 (RTL), 3 and 4 (SmartRTL, else RTL
# or landing), 6 (landing sequence of the mission, else RTL); NAV_DLL_ACT 2 (return).
RETURNING = {ARDUPILOT: frozenset({1.0, 3.0, 4.0, 6.0}), PX4: frozenset({2.0})}
# Bits by which a vehicle goes on with its mission without a link: of FS_OPTIONS, COM_DLL_EXCEPT.
GOES_ON_BIT = {ARDUPILOT: 2, PX4: 1}
# System that QGroundControl and Mission Planner have unless somebody changes it.
USUAL_STATION = 255
# Bits of ArduPilot's FENCE_TYPE.
FENCE_HEIGHT_BIT, FENCE_CIRCLE_BIT, FENCE_POLYGON_BIT = 1, 2, 4
# OA_TYPE of ArduPilot that plan around the polygons of its fence, on the return, too: Dijkstra,
# and Dijkstra with BendyRuler.
PLANS_AROUND = frozenset({2.0, 3.0})
# RTL_TYPE of PX4 that flies back along its mission.
RETURNS_BY_ROUTE = 2.0
# RALLY_LIMIT_KM of an ArduCopter that does not answer.
USUAL_RALLY_LIMIT_M = 300.0
_REMEDY = {
    ARDUPILOT: 'OA_TYPE 2 with the exclusions in its fence, or other rally points',
    PX4: 'RTL_TYPE 2, or other rally points',
}
# For corners: on a recorded survey the time at constant speed is 23 % too short.
LEVEL_ALLOWANCE = 1.25


# Checks that may pass a while after a vehicle was switched on or first heard.
_PASSING_SOON = frozenset({'contact', 'fix', 'satellites', 'self-test', 'home', 'settings'})


class CheckVerdict(Enum):
    """Result of a check."""

    PASS = 'pass'  # noqa: S105 - the opposite of fail
    WARN = 'warn'
    FAIL = 'fail'


@dataclass(frozen=True, slots=True)
class Check:
    """One check: what it is about, what was found, and what it must be."""

    name: str
    verdict: CheckVerdict
    value: str
    limit: str

    @property
    def may_pass_soon(self) -> bool:
        """Whether waiting can help, as after a vehicle was switched on."""
        is_untold = self.value == NOT_READ or 'not known' in self.value
        return is_untold or self.name in _PASSING_SOON


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightLimits:
    """Limits of a flight.

    Attributes
    ----------
    lowest_m, highest_m
        Height above home of a waypoint.
    furthest_m
        Distance of a waypoint from home.
    longest_s
        Duration of the flight.
    smallest_charge
        Charge of the battery at the start, 0 to 1.
    fewest_satellites
        Satellites that the receiver must use.
    climb_mps, descent_mps
        Vertical speeds from which the duration is estimated.
    longest_to_home_m
        Distance between the home of the plan and that of the vehicle.
    must_return_on_link_loss
        Whether a vehicle that loses its link has to come back.
    reserve
        Share of the charge that must be left after the flight.
    """

    lowest_m: float = 5.0
    highest_m: float = 120.0
    furthest_m: float = 2000.0
    longest_s: float = 1500.0
    smallest_charge: float = 0.5
    fewest_satellites: int = 6
    climb_mps: float = 2.5
    descent_mps: float = 1.0
    longest_to_home_m: float = 30.0
    must_return_on_link_loss: bool = False
    reserve: float = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleSettings:
    """What was read from a vehicle besides its telemetry.

    Attributes
    ----------
    parameters
        Its parameters; None: not read.
    fence
        Polygons of its fence; None: not read.
    fence_error
        Why its fence cannot be read; empty while it may be.
    rally
        Its rally points; None: not read.
    rally_error
        Why its rally points cannot be read; empty while they may be.
    station
        Our own system; -1: not known.
    """

    parameters: ParameterReader | None = None
    fence: Fence | None = None
    fence_error: str = ''
    rally: tuple[GeoPosition, ...] | None = None
    rally_error: str = ''
    station: int = -1


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
        *_setting_checks(known.parameters, limits, known.station),
    ]
    if vehicle.home is None:
        return (*checks, Check('home', CheckVerdict.FAIL, 'not known', 'told by the vehicle'))
    if plan is None:
        return tuple(checks)
    checks += [] if plan.home is None else [_home_check(plan.home, _place(vehicle.home), limits)]
    energy = _energy_check(plan, vehicle, limits)
    *way, fence = route_checks(vehicle, plan, limits, known)
    return (*checks, *way, energy, fence)


def route_checks(
    vehicle: VehicleTelemetry, plan: FlightPlan, limits: FlightLimits, known: VehicleSettings
) -> tuple[Check, ...]:
    """Return the checks of the way of `plan`, from the ground or in the air."""
    if vehicle.home is None:
        return (Check('home', CheckVerdict.FAIL, 'not known', 'told by the vehicle'),)
    home = _place(vehicle.home)
    way = (*_plan_checks(plan, home, limits), *_fence_limits(plan, home, known.parameters))
    return (*way, *_homeward_checks(plan, home, known), _fence_check(plan, home, known))


def failures(checks: tuple[Check, ...]) -> str:
    """Return what failed, in one line; empty if nothing did."""
    failed = (check for check in checks if check.verdict is CheckVerdict.FAIL)
    return '; '.join(f'{check.name} is {check.value}: must be {check.limit}' for check in failed)


def is_failed_for_good(checks: tuple[Check, ...]) -> bool:
    """Whether a check failed that cannot pass by waiting."""
    return any(check.verdict is CheckVerdict.FAIL and not check.may_pass_soon for check in checks)


def estimated_duration_s(plan: FlightPlan, home: GeoPosition, limits: FlightLimits) -> float:
    """Return a coarse duration, home to home: constant speed and an allowance for corners."""
    places = [home, *(waypoint.position for waypoint in plan.waypoints), home]
    level_s = LEVEL_ALLOWANCE * sum(distance_m(a, b) for a, b in pairwise(places)) / plan.speed_mps
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
            CheckVerdict.PASS if known else CheckVerdict.WARN,
            f'{vehicle.geoid_separation_m:.1f} m' if known else 'not known',
            'known, or altitudes are NaN',
        ),
    ]


def _setting_checks(
    reader: ParameterReader | None, limits: FlightLimits, station: int
) -> list[Check]:
    """Return the checks of what the vehicle does by itself when something goes wrong."""
    must_return = limits.must_return_on_link_loss
    if reader is None:
        verdict = CheckVerdict.FAIL if must_return else CheckVerdict.WARN
        return [Check('settings', verdict, NOT_READ, 'read')]
    return [
        *_link_loss_checks(reader, station, is_required=must_return),
        _setting(reader, Parameter.LOW_BATTERY_ACTION),
        _setting(reader, Parameter.RADIO_LOSS_ACTION),
        _setting(reader, Parameter.FENCE_ENABLED),
        *_return_checks(reader, limits),
        *_arming_checks(reader),
        *_heading_checks(reader),
    ]


def _heading_checks(reader: ParameterReader) -> list[Check]:
    """Return the check that it keeps the heading of its mission, not that of its way."""
    if Parameter.YAW_BEHAVIOUR not in SPELLINGS[reader.autopilot]:
        return []
    text = _setting_text(reader, Parameter.YAW_BEHAVIOUR)
    verdict = (
        CheckVerdict.PASS if reader.value(Parameter.YAW_BEHAVIOUR) == 0.0 else CheckVerdict.WARN
    )
    limit = '0, or photographs lie turned'
    return [Check(Parameter.YAW_BEHAVIOUR.value, verdict, text, limit)]


def _link_loss_checks(reader: ParameterReader, station: int, *, is_required: bool) -> list[Check]:
    """Return the checks that the vehicle comes back if this bridge falls silent."""
    bad = CheckVerdict.FAIL if is_required else CheckVerdict.WARN
    action = reader.value(Parameter.LINK_LOSS_ACTION)
    checks = [
        _judged(
            reader,
            Parameter.LINK_LOSS_ACTION,
            CheckVerdict.PASS if action in RETURNING[reader.autopilot] else bad,
            'one that returns' if is_required else 'one that returns, or chosen otherwise',
        )
    ]
    exceptions = reader.value(Parameter.LINK_LOSS_EXCEPTIONS)
    if math.isfinite(exceptions) and int(exceptions) & GOES_ON_BIT[reader.autopilot]:
        limit = f'without bit {GOES_ON_BIT[reader.autopilot]}, by which its mission goes on'
        checks.append(_judged(reader, Parameter.LINK_LOSS_EXCEPTIONS, bad, limit))
    heard = reader.value(Parameter.STATION)
    if math.isfinite(heard) and station >= 0:
        is_ours, is_usual = heard == station, heard == USUAL_STATION
        verdict = bad if not is_ours else CheckVerdict.WARN if is_usual else CheckVerdict.PASS
        limit = f'{station}, our own, or the vehicle does not notice that this bridge is silent'
        if is_ours and is_usual:
            limit = 'one that no other station has: a station with 255 hides a silent bridge'
        checks.append(_judged(reader, Parameter.STATION, verdict, limit))
    return checks


def _return_checks(reader: ParameterReader, limits: FlightLimits) -> list[Check]:
    """Return the check of the height at which the vehicle comes home by itself."""
    height_m = reader.value(Parameter.RETURN_HEIGHT_M)
    # 0: it comes home at the height at which it is.
    is_good = height_m == 0.0 or limits.lowest_m <= height_m <= limits.highest_m
    verdict = CheckVerdict.PASS if is_good else CheckVerdict.WARN
    limit = f'{limits.lowest_m:g} to {limits.highest_m:g} m'
    return [_judged(reader, Parameter.RETURN_HEIGHT_M, verdict, limit)]


def _arming_checks(reader: ParameterReader) -> list[Check]:
    """Return the check that an ArduPilot's own checks before arming are all on."""
    if Parameter.ARMING_CHECKS not in SPELLINGS[reader.autopilot]:
        return []
    complete = 0.0 if reader.spelling(Parameter.ARMING_CHECKS) == 'ARMING_SKIPCHK' else 1.0
    is_all = reader.value(Parameter.ARMING_CHECKS) == complete
    verdict = CheckVerdict.PASS if is_all else CheckVerdict.WARN
    return [_judged(reader, Parameter.ARMING_CHECKS, verdict, f'{complete:g}: all of them')]


def _setting(reader: ParameterReader, parameter: Parameter) -> Check:
    value = reader.value(parameter)
    is_on = math.isfinite(value) and value != 0.0
    verdict = CheckVerdict.PASS if is_on else CheckVerdict.WARN
    return _judged(reader, parameter, verdict, 'on, or chosen to be off')


def _judged(
    reader: ParameterReader, parameter: Parameter, verdict: CheckVerdict, limit: str
) -> Check:
    return Check(parameter.value, verdict, _setting_text(reader, parameter), limit)


def _setting_text(reader: ParameterReader, parameter: Parameter) -> str:
    value, spelling = reader.value(parameter), reader.spelling(parameter)
    if math.isfinite(value):
        return f'{spelling} = {value:g}'
    return f'{spelling} not answered' if reader.is_over else NOT_READ


def _energy_check(plan: FlightPlan, vehicle: VehicleTelemetry, limits: FlightLimits) -> Check:
    home = vehicle.home
    duration_s = 0.0 if home is None else estimated_duration_s(plan, _place(home), limits)
    needed = duration_s / limits.longest_s + limits.reserve
    charge = vehicle.battery.fraction
    return _check(
        'energy',
        charge >= needed,
        'charge not known' if math.isnan(charge) else f'{charge:.0%} charged',
        f'{needed:.0%} for this flight, its reserve included',
    )


def _home_check(planned: GeoPosition, home: GeoPosition, limits: FlightLimits) -> Check:
    away_m = distance_m(planned, home)
    return _check(
        'place of the plan',
        away_m <= limits.longest_to_home_m,
        f'{away_m:.1f} m from where the plan has it',
        f'at most {limits.longest_to_home_m:g} m',
    )


def _fence_check(plan: FlightPlan, home: GeoPosition, known: VehicleSettings) -> Check:
    name, limit = 'within fence', 'none outside'
    if known.fence is None:
        error = f'cannot be read: {known.fence_error}' if known.fence_error else NOT_READ
        return Check(name, CheckVerdict.FAIL, error, limit)
    places = [waypoint.position for waypoint in plan.waypoints]
    outside = sum(not known.fence.holds(place) for place in places)
    if outside:
        return _check(name, False, f'{outside} of {len(places)} waypoints outside', limit)
    legs = list(pairwise([home, *places, home]))
    outside = sum(not known.fence.holds_leg(*leg) for leg in legs)
    return _check(name, not outside, f'{outside} of {len(legs)} legs partly outside', limit)


def _homeward_checks(plan: FlightPlan, home: GeoPosition, known: VehicleSettings) -> list[Check]:
    """Return the check that a vehicle that gives up flies over no exclusion."""
    name, limit = 'way home', 'clear of exclusions from every leg'
    if not plan.exclusions:
        return []
    reader = known.parameters
    if reader is None or (known.rally is None and not known.rally_error):
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
    return [_check(name, not fault, fault or 'clear', f'{limit}, or {_REMEDY[reader.autopilot]}')]


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


def _fence_limits(
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
    has_types = Parameter.FENCE_TYPES in SPELLINGS[reader.autopilot]
    if has_types and math.isnan(types):
        text = _setting_text(reader, Parameter.FENCE_TYPES)
        # Old or reduced firmware does not answer: its owner is told.
        verdict = CheckVerdict.WARN if reader.is_over else CheckVerdict.FAIL
        return [Check(Parameter.FENCE_TYPES.value, verdict, text, 'read')]
    checks = []
    for bit, parameter, reached_m in (
        (FENCE_HEIGHT_BIT, Parameter.FENCE_HEIGHT_M, highest_m),
        (FENCE_CIRCLE_BIT, Parameter.FENCE_RADIUS_M, furthest_m),
    ):
        if has_types and not int(types) & bit:
            continue
        limit_m, text = reader.value(parameter), _setting_text(reader, parameter)
        # A PX4 has no such fence where its limit is 0.
        is_held = reached_m < limit_m or (limit_m == 0.0 and not has_types)
        is_untold = math.isnan(limit_m) and reader.is_over
        verdict = CheckVerdict.WARN if is_untold else CheckVerdict.FAIL
        verdict = CheckVerdict.PASS if is_held else verdict
        checks.append(Check(parameter.value, verdict, text, f'more than {reached_m:.0f} m'))
    return checks


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
    return Check(name, CheckVerdict.PASS if is_good else CheckVerdict.FAIL, value, limit)


def _ground(vehicle: VehicleTelemetry) -> str:
    return 'on the ground' if vehicle.is_on_ground else 'in the air'


def _place(home: Home) -> GeoPosition:
    return GeoPosition(home.latitude_deg, home.longitude_deg)
