# SPDX-License-Identifier: Apache-2.0
"""Which ways are free for a vehicle in the air: around exclusions, and within its fence.

A refusal is a text that names the reason; it is empty if there is none.
"""

from dataclasses import replace

from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.checks.check import failures
from rocsafe_mavlink.checks.way_checks import fence_check, homeward_checks
from rocsafe_mavlink.drone.vehicle_session import VehicleSession
from rocsafe_mavlink.errors import CommandRefusedError
from rocsafe_mavlink.flight.command_step import Refusal
from rocsafe_mavlink.flight.flight_journal import FlightJournal
from rocsafe_mavlink.flight.flight_signs import heights_moved
from rocsafe_mavlink.knowledge.fix import fix_fault
from rocsafe_mavlink.knowledge.telemetry import STALE_AFTER_S, Home, VehicleTelemetry
from rocsafe_mavlink.plan.fence import Fence
from rocsafe_mavlink.plan.flight_limits import FlightLimits, VehicleSettings
from rocsafe_mavlink.plan.flight_plan import FlightPlan, FlightWaypoint
from rocsafe_mavlink.plan.homeward import homeward_plan, way_fault, zone_at


class FreeWays:
    """Ways that one vehicle may take; the parameters are those of `DroneCommands`."""

    def __init__(
        self, session: VehicleSession, limits: FlightLimits, journal: FlightJournal
    ) -> None:
        self._session = session
        self._limits = limits
        self._journal = journal

    def outside_fence(self, place: GeoPosition) -> str:
        """Return why a place is not known to lie within the fence."""
        settings = self._session.readout.settings
        if settings.fence is None and not settings.fence_error:
            return 'its fence is still being read'
        if settings.fence is None:
            return f'its fence cannot be read: {settings.fence_error}'
        return '' if settings.fence.holds(place) else 'the place is outside the fence'

    def leaves(self, fence: Fence) -> str:
        """Return why the vehicle, or what is left of its flight, would leave another fence."""
        session = self._session
        vehicle, home = session.telemetry, session.telemetry.home
        if vehicle.is_on_ground or vehicle.motion is None:
            return ''
        if not fence.holds(vehicle.motion.position):
            return 'the vehicle would be outside the fence at once'
        settings = replace(session.readout.settings, fence=fence, fence_error='')
        left = ''
        if session.is_flying and self._plan is not None and home is not None:
            left = failures((fence_check(self._plan, home.place, settings),))
        return left or self.stranded(settings)

    def stranded(self, settings: VehicleSettings) -> str:
        """Return why a vehicle in the air could not give up with other settings; empty: it could.

        Empty, too, if it could not give up before: the change makes nothing worse.
        """
        session, plan, home = self._session, self._plan, self._session.telemetry.home
        if session.telemetry.is_on_ground or plan is None or home is None:
            return ''
        before = failures(tuple(homeward_checks(plan, home.place, session.readout.settings)))
        after = failures(tuple(homeward_checks(plan, home.place, settings)))
        return '' if before else after

    def blocked(self, place: GeoPosition) -> Refusal:
        """Return why a vehicle must not fly straight to a place, from where it is by then."""

        def refusal(vehicle: VehicleTelemetry, now_s: float) -> str:
            plan, motion = self._plan, vehicle.motion
            if unknown := self.unknown_way(vehicle, now_s):
                return unknown
            if plan is None or motion is None:
                return ''
            return way_fault(plan, [motion.position, place])

        return refusal

    @property
    def _plan(self) -> FlightPlan | None:
        """Plan whose exclusions hold."""
        return self._flown[0]

    @property
    def _flown(self) -> tuple[FlightPlan | None, Home | None]:
        """Plan and home of its flight, or of one that an earlier bridge flew; None: not known."""
        flight, entry = self._session.flight, self._journal.open_entry
        if flight is not None and not flight.is_over:
            return flight.plan, flight.home
        return (None, None) if entry is None else (entry.assignment.plan, entry.home)

    def unknown_way(
        self, vehicle: VehicleTelemetry, now_s: float, plan: FlightPlan | None = None
    ) -> str:
        """Return why nobody can tell where a vehicle would fly; empty if that is known.

        Heights are above home, and the way around the exclusions of `plan`, or of its own plan,
        begins where the vehicle is.
        """
        flown, home = self._flown
        exclusions = [zone for one in (flown, plan) if one is not None for zone in one.exclusions]
        fault = fix_fault(vehicle, now_s, STALE_AFTER_S) if exclusions else ''
        where = f'where it is cannot be told: {fault}' if fault else ''
        # Nothing is driven at a height above home.
        is_drive = flown is not None and flown.is_drive
        return ('' if is_drive else heights_moved(home, vehicle.home)) or where

    def fault_ahead(self, vehicle: VehicleTelemetry, now_s: float) -> str:
        """Return which exclusion lies between a vehicle and the next place of its mission."""
        flight, unknown = self._session.flight, self.unknown_way(vehicle, now_s)
        if flight is None or unknown or not flight.plan.exclusions:
            return unknown
        ahead = flight.next_place(vehicle)
        if ahead is None or vehicle.motion is None:
            return 'where it is, or its home, is not known'
        return way_fault(flight.plan, [vehicle.motion.position, ahead])

    def bends(self, vehicle: VehicleTelemetry, _now_s: float) -> str:
        """Return why a straight return must not be sent: the vehicle has flown on meanwhile."""
        try:
            is_straight = self.way_home(vehicle) is None
        except CommandRefusedError as refusal:
            return str(refusal)
        return (
            '' if is_straight else 'an exclusion lies on the straight way by now: order it again'
        )

    def way_home(self, vehicle: VehicleTelemetry) -> FlightPlan | None:
        """Return the way around exclusions; None if the vehicle may return straight.

        Refused if its home was set into one: no way leads there.
        """
        plan = self._plan
        if plan is None or vehicle.home is None or vehicle.motion is None:
            return None
        here = FlightWaypoint(
            position=vehicle.motion.position,
            height_m=max(vehicle.motion.height_above_home_m, self._limits.lowest_m),
        )
        home = vehicle.home.place
        if zone := zone_at(plan, home):
            words = 'another station has set it: let it land, or go to a place'
            raise CommandRefusedError(f'its home lies in exclusion {zone}, {words}')
        return homeward_plan(plan, here, home)
