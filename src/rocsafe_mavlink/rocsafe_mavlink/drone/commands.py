# SPDX-License-Identifier: Apache-2.0
"""Commands of an operator to one vehicle, started or refused with the reason.

The suite itself calls nothing here; services and actions do.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.autopilots.autopilot import Verb
from rocsafe_mavlink.checks.check import Check, failures
from rocsafe_mavlink.checks.preflight import route_checks
from rocsafe_mavlink.checks.way_checks import (
    exclusion_checks,
    start_of,
)
from rocsafe_mavlink.drone.free_ways import FreeWays
from rocsafe_mavlink.drone.vehicle_session import VehicleSession
from rocsafe_mavlink.errors import CommandRefusedError
from rocsafe_mavlink.flight.command_sequence import CommandSequence
from rocsafe_mavlink.flight.flight_journal import FlightJournal
from rocsafe_mavlink.flight.vehicle_commands import VehicleCommands, require_reachable
from rocsafe_mavlink.knowledge.telemetry import Contact, VehicleTelemetry
from rocsafe_mavlink.plan.fence import Fence, rally_items
from rocsafe_mavlink.plan.flight_limits import FlightLimits
from rocsafe_mavlink.plan.flight_plan import FlightPlan, mission_of
from rocsafe_mavlink.protocols.mission_results import MissionType
from rocsafe_mavlink.protocols.onboard_mission import MissionCondition

Writer = Callable[[VehicleCommands], CommandSequence]


class DroneCommands:
    """Commands to one vehicle.

    Hold, return and land may replace a command under way; others wait for its end. In the air none
    is taken while the pilot or a failsafe has the vehicle, see `Custody`. Every method
    raises `CommandRefusedError`, saying why, if the command cannot be given at all; how a given
    one ends is told by `outcome`.

    Parameters
    ----------
    session
        The exchange with the vehicle.
    limits
        Limits of its flights.
    journal
        Its flight as it was noted last: its exclusions hold also where no flight is found.
    """

    def __init__(
        self, session: VehicleSession, limits: FlightLimits, journal: FlightJournal
    ) -> None:
        self._session = session
        self._limits = limits
        self._ways = FreeWays(session, limits, journal)

    @property
    def count(self) -> int:
        """Number of the present or last command."""
        return self._session.sequence_count

    def outcome(self, number: int) -> str | None:
        """Return why command `number` failed, empty if it was obeyed; None while under way."""
        sequence = self._session.sequence
        if self.count != number or sequence is None:
            return 'another command took its place'
        if not sequence.is_over:
            return None
        return f'{sequence.name}: {sequence.error}' if sequence.error else ''

    def hold(self, now_s: float) -> None:
        """Stop where it is, within the mission if one is flown; on the ground stay there."""
        if self._is_under_way('hold') or self._stays_down('hold', Verb.HOLD, now_s):
            return
        self._require_ours(now_s, is_always_taken=True)
        self._begin(lambda commands: commands.hold(self._session.telemetry), now_s, preempts=True)

    def resume(self, now_s: float) -> None:
        """Continue the mission."""
        if self._is_under_way('resume'):
            return
        self._require_ours(now_s)
        session = self._session
        if not session.is_flying:
            # The flight of an earlier bridge is found by these.
            telemetry = session.telemetry
            needed = (session.readout.mission.items, telemetry.home, telemetry.landed or None)
            is_read = None not in needed
            reason = 'no route is being flown' if is_read else 'it is still being read'
            raise CommandRefusedError(reason)
        flight = session.flight
        if flight is None or flight.is_given_up:
            raise CommandRefusedError('its route was given up: send a route')
        self._require_verified()
        _refuse(self._ways.fault_ahead(session.telemetry, now_s))
        self._begin(
            lambda commands: commands.resume(
                session.telemetry, flight.mission, self._ways.fault_ahead
            ),
            now_s,
        )
        # The command reads it again: until that is done it is not known.
        session.readout.forget_mission()

    def return_home(self, now_s: float) -> None:
        """Give up the route, fly home and land: straight, or around exclusions.

        On the ground it stays there.
        """
        name = 'return home'
        if self._is_under_way(name) or self._stays_down(name, Verb.RETURN, now_s):
            return
        self._require_ours(now_s, is_always_taken=True)
        way = self._ways.way_home(self._session.telemetry)
        if way is None:
            self._begin(
                lambda commands: commands.return_home(self._ways.bends), now_s, preempts=True
            )
        else:
            self._require_no_failsafe()
            self._begin(
                lambda commands: commands.fly_home(
                    mission_of(way, commands.autopilot),
                    self._ways.blocked(way.waypoints[0].position),
                ),
                now_s,
                preempts=True,
            )

    def land(self, now_s: float) -> None:
        """Give up the route and land where it is; on the ground stay there."""
        if self._is_under_way('land') or self._stays_down('land', Verb.LAND, now_s):
            return
        self._require_ours(now_s, is_always_taken=True)
        self._begin(lambda commands: commands.land(), now_s, preempts=True)

    def change_speed(self, speed_mps: float, now_s: float) -> None:
        """Fly faster or slower from now on."""
        self._require_ours(now_s)
        self._begin(lambda commands: commands.change_speed(speed_mps), now_s)

    def go_to(self, place: GeoPosition, height_m: float, now_s: float) -> None:
        """Fly to a place, `height_m` above home, and stay there."""
        self._require_ours(now_s)
        try:
            home = require_reachable(place, height_m, self._session.telemetry.home, self._limits)
        except ValueError as error:
            raise CommandRefusedError(str(error)) from error
        _refuse(self._ways.outside_fence(place))
        blocked = self._ways.blocked(place)
        _refuse(blocked(self._session.telemetry, now_s))
        self._begin(lambda commands: commands.go_to(place, height_m, home, blocked), now_s)

    def push_fence(self, fence: Fence, now_s: float) -> None:
        """Replace the polygons of the fence; in the air they must hold what is flown."""
        self._require_contact(now_s)
        self._require_not_others(now_s)
        _refuse(self._ways.leaves(fence))
        self._begin(lambda commands: commands.push_fence(fence), now_s)
        # It is read again as it lies there then: until that is done no flight begins.
        self._session.readout.overwritten(MissionType.FENCE)

    def push_rally(self, points: Sequence[GeoPosition], height_m: float, now_s: float) -> None:
        """Replace the rally points; in the air the way to them must be free of exclusions."""
        self._require_contact(now_s)
        self._require_not_others(now_s)
        try:
            items = rally_items(points, height_m)
        except ValueError as error:
            raise CommandRefusedError(str(error)) from error
        settings = replace(self._session.readout.settings, rally=tuple(points), rally_error='')
        _refuse(self._ways.stranded(settings))
        self._begin(lambda commands: commands.push(MissionType.RALLY, items), now_s)

    def replace_route(self, plan: FlightPlan, now_s: float) -> None:
        """Fly another plan in the place of the one under way."""
        self._require_ours(now_s)
        if not self._session.is_flying:
            raise CommandRefusedError('no flight is under way')
        _refuse(self._ways.unknown_way(self._session.telemetry, now_s, plan))
        _refuse(failures(self.route_checks(plan)))

        def strays(vehicle: VehicleTelemetry, now_s: float) -> str:
            # It has stopped a little further on than where it was when the order came.
            home = None if vehicle.home is None else vehicle.home.place
            checks = [] if home is None else exclusion_checks(plan, start_of(vehicle, home), home)
            return self._ways.unknown_way(vehicle, now_s, plan) or failures(tuple(checks))

        self._begin(
            lambda commands: commands.replace_mission(
                mission_of(plan, commands.autopilot), strays
            ),
            now_s,
        )

    def route_checks(self, plan: FlightPlan) -> tuple[Check, ...]:
        """Return the checks of the way of a plan that is to be flown in place of another."""
        session = self._session
        return route_checks(session.telemetry, plan, self._limits, session.readout.settings)

    def require_in_air(self, now_s: float) -> None:
        """Refuse a command to a vehicle that is on the ground or not in contact."""
        self._require_contact(now_s)
        if self._session.telemetry.is_on_ground:
            raise CommandRefusedError('the vehicle is on the ground')

    def _is_under_way(self, name: str) -> bool:
        """Whether this very order is under way: given again it goes on, and is not begun anew."""
        sequence = self._session.sequence
        return sequence is not None and not sequence.is_over and sequence.name == name

    def _stays_down(self, name: str, verb: Verb, now_s: float) -> bool:
        """Withdraw every start; return whether that is all: the vehicle is on the ground.

        Motors that the start of a flight has started, or may have, are stopped; if that is too
        late the vehicle is switched to the mode for `verb`.
        """
        session = self._session
        was_waiting = session.starts_at_s is not None
        session.withdraw_start(name)
        vehicle, flight = session.telemetry, session.flight
        if not vehicle.is_on_ground:
            return False
        if flight is not None and flight.is_beginning and flight.may_be_armed(vehicle):
            self._require_not_others(now_s, is_always_taken=True)
            self._begin(lambda commands: commands.stay_down(name, verb), now_s, preempts=True)
            return True
        is_known = was_waiting or vehicle.contact(now_s) is Contact.FRESH
        if vehicle.is_armed or not is_known:
            return False
        if flight is not None and flight.is_beginning:
            session.flight = flight.called_off(f'told to {name} before it took off')
        if session.known_autopilot() is not None:
            self._begin(lambda commands: commands.nothing(name), now_s, preempts=True)
        return True

    def _require_verified(self) -> None:
        """Refuse to fly a mission that is not known to be the one of the plan."""
        condition = self._session.mission_condition()
        if condition is MissionCondition.TORN:
            raise CommandRefusedError('its mission was not verified: send a route again')
        if condition is MissionCondition.UNKNOWN:
            is_read = self._session.readout.mission.items is not None
            words = 'another mission lies on it' if is_read else 'its mission is still being read'
            raise CommandRefusedError(words)

    def _require_contact(self, now_s: float) -> None:
        contact = self._session.telemetry.contact(now_s)
        if contact is not Contact.FRESH:
            raise CommandRefusedError(f'the vehicle is not in contact ({contact.value})')

    def _require_ours(self, now_s: float, *, is_always_taken: bool = False) -> None:
        """Refuse a command to a vehicle on the ground, or one that its pilot or a failsafe has."""
        if is_always_taken:
            self._require_contact(now_s)
        else:
            self.require_in_air(now_s)
        self._require_not_others(now_s, is_always_taken=is_always_taken)

    def _require_not_others(self, now_s: float, *, is_always_taken: bool = False) -> None:
        """Refuse a command while the pilot or a failsafe has the vehicle in the air."""
        session = self._session
        kind = session.known_autopilot()
        if kind is None:
            raise CommandRefusedError('its kind of autopilot is not known')
        vehicle = session.telemetry
        refusal = session.custody.refusal(vehicle, kind, now_s, is_always_taken=is_always_taken)
        if refusal:
            raise CommandRefusedError(refusal)

    def _require_no_failsafe(self) -> None:
        """Refuse to upload a way home after a failsafe: no mission is flown then."""
        session = self._session
        failsafe = session.custody.failsafe
        if failsafe is not None or session.telemetry.is_in_failsafe:
            name = 'failsafe' if failsafe is None else failsafe.value
            raise CommandRefusedError(
                f'{name}: no way around exclusions is sent any more: hold, or land'
            )

    def _begin(self, write: Writer, now_s: float, *, preempts: bool = False) -> None:
        try:
            self._session.begin(write(self._session.commands()), now_s, preempts=preempts)
        except ValueError as error:
            raise CommandRefusedError(str(error)) from error


def _refuse(reason: str) -> None:
    """Refuse a command if there is a reason to."""
    if reason:
        raise CommandRefusedError(reason)
