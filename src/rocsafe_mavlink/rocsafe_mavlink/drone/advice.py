# SPDX-License-Identifier: Apache-2.0
"""Alarms of a flight for its operator, each with the command that answers it."""

from dataclasses import dataclass
from functools import lru_cache

from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.autopilots.autopilot import Verb
from rocsafe_mavlink.checks.check import CheckVerdict, failures
from rocsafe_mavlink.checks.way_checks import fence_check, homeward_checks
from rocsafe_mavlink.checks.wind_checks import wind_fault
from rocsafe_mavlink.drone.vehicle_session import VehicleSession
from rocsafe_mavlink.flight.flight_signs import home_moved
from rocsafe_mavlink.knowledge.traffic import encounters
from rocsafe_mavlink.plan.fence import Fence
from rocsafe_mavlink.plan.flight_limits import FlightLimits, VehicleSettings
from rocsafe_mavlink.plan.flight_plan import FlightPlan

HOLD, RETURN_HOME = 'hold', 'return_home'
OTHER_MISSION = 'it flies another mission than that of its plan: another station has changed it'


@dataclass(frozen=True, slots=True)
class Advice:
    """An order that is offered, and why."""

    order: str
    reason: str


def advice_of(session: VehicleSession, limits: FlightLimits, now_s: float) -> tuple[Advice, ...]:
    """Return what should be answered now, the most urgent first; nothing on the ground.

    A vehicle that somebody else has is left to him: what he should know is told all the same.
    """
    vehicle = session.telemetry
    if vehicle.is_on_ground:
        return ()
    close = next((e for e in encounters(vehicle, now_s) if e.is_close), None)
    found = [] if close is None else [Advice(HOLD, close.text)]
    fence = _fence_fault(session)
    found += [Advice(HOLD, fence)] if fence else []
    homeward = '' if fence else _return_fault(session)
    found += [Advice(HOLD, homeward)] if homeward else []
    home = _home_fault(session)
    found += [Advice(HOLD, home)] if home else []
    found += [Advice(HOLD, OTHER_MISSION)] if session.flies_another() else []
    # A vehicle that returns or lands already obeys an order that counts for more.
    wind = '' if _comes_down(session) else wind_fault(vehicle.wind, limits, now_s)
    return (*found, *([Advice(RETURN_HOME, wind)] if wind else []))


def _comes_down(session: VehicleSession) -> bool:
    """Return whether a vehicle returns or lands, by its mode or by a mission home."""
    kind, vehicle, flight = session.known_autopilot(), session.telemetry, session.flight
    if kind is None:
        return False
    is_homeward = flight is not None and not flight.is_over and not flight.mission.waypoint_items
    verbs = (Verb.RETURN, Verb.LAND, *((Verb.MISSION,) if is_homeward else ()))
    return any(kind.is_in(vehicle, verb) for verb in verbs)


def _fence_fault(session: VehicleSession) -> str:
    """Return how the fence of a flight has changed; empty if its route lies within."""
    flight, home = session.flight, session.telemetry.home
    settings = session.readout.settings
    if flight is None or flight.is_over or home is None or settings.fence is None:
        return ''
    return _outside(flight.plan, home.place, settings.fence)


def _return_fault(session: VehicleSession) -> str:
    """Return that a flight that gives up would cross an exclusion now; empty if it would not."""
    flight, home = session.flight, session.telemetry.home
    settings = session.readout.settings
    is_read = settings.fence is not None and settings.rally is not None
    if flight is None or flight.is_over or home is None or not is_read:
        return ''
    fault = failures(tuple(homeward_checks(flight.plan, home.place, settings)))
    return f'its rally points or its fence were changed: {fault}' if fault else ''


def _home_fault(session: VehicleSession) -> str:
    """Return how far the home of a flight was moved; empty if its heights and its return hold."""
    flight, home = session.flight, session.telemetry.home
    if flight is None or flight.is_over or flight.home is None or home is None:
        return ''
    return home_moved(flight.home, home, 'in flight')


@lru_cache(maxsize=16)
def _outside(plan: FlightPlan, home: GeoPosition, fence: Fence) -> str:
    check = fence_check(plan, home, VehicleSettings(fence=fence))
    is_good = check.verdict is not CheckVerdict.FAIL
    return '' if is_good else f'its fence was changed: {check.value}'
