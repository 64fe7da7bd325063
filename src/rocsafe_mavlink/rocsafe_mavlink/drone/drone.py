# SPDX-License-Identifier: Apache-2.0
"""One real vehicle, with the interface of a simulated one."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.autopilots.autopilot import FlightState
from rocsafe_mavlink.checks.check import Check, failures, is_failed_for_good
from rocsafe_mavlink.checks.preflight import preflight
from rocsafe_mavlink.drone.advice import RETURN_HOME, advice_of
from rocsafe_mavlink.drone.commands import DroneCommands
from rocsafe_mavlink.drone.flight_record import FlightRecord, FlightSummary
from rocsafe_mavlink.drone.readout import Target
from rocsafe_mavlink.drone.status import (
    DroneStatus,
    RemainingRoute,
    StatusInputs,
    remaining_route,
    status_of,
)
from rocsafe_mavlink.drone.take_off_space import ARMING_SHOWS_S, in_the_way
from rocsafe_mavlink.drone.vehicle_session import VehicleSession
from rocsafe_mavlink.drone.wind_return import WindReturn
from rocsafe_mavlink.errors import WaitError
from rocsafe_mavlink.flight.flight import MissionFlight, adopted, fly
from rocsafe_mavlink.flight.flight_journal import Assignment, FlightJournal, JournalEntry
from rocsafe_mavlink.knowledge.events import Event
from rocsafe_mavlink.knowledge.telemetry import Contact, Landed, VehicleTelemetry
from rocsafe_mavlink.plan.flight_limits import FlightLimits
from rocsafe_mavlink.plan.flight_plan import FlightPlan
from rocsafe_mavlink.protocols.mission_item import MissionItem
from rocsafe_mavlink.wire.dialect import Message

OnMessage = Callable[[Message], None]
OnEvent = Callable[[Event], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class DroneSpec:
    """Fixed properties of a drone.

    Attributes
    ----------
    name
        Name of the vehicle, which is its namespace.
    target
        Its (system, component).
    frame
        Frame of the mission.
    limits
        Limits of its flights.
    speed_mps
        Speed over ground.
    hover_s
        Time that it stays at a viewpoint.
    takes_photographs, trigger_distance_m
        As in `FlightPlan`.
    """

    name: str
    target: Target
    frame: LocalFrame
    limits: FlightLimits
    speed_mps: float = 5.0
    hover_s: float = 1.0
    takes_photographs: bool = True
    trigger_distance_m: float = 0.0


class Drone:
    """A vehicle on a link, with the plan it was given.

    Parameters
    ----------
    spec
        Its fixed properties.
    session
        The exchange of messages with it.
    journal
        Keeps its plan over restarts of this process.

    Attributes
    ----------
    commands
        What people may command.
    others
        Vehicles of the same bridge: none takes off while another is in the way.
    """

    def __init__(self, spec: DroneSpec, session: VehicleSession, journal: FlightJournal) -> None:
        self.spec = spec
        self.session = session
        self.commands = DroneCommands(session, spec.limits, journal)
        # What was announced to the bridge before is not announced again.
        session.custody = session.custody.remembering(journal.failsafe)
        self._journal = journal
        self._record = FlightRecord(journal)
        self._wind_return = WindReturn(self.commands)
        self._armed_by_us_s = -math.inf
        self.others: Sequence[Drone] = ()
        self._listeners: list[tuple[OnMessage, OnEvent]] = []

    @property
    def vehicle(self) -> VehicleTelemetry:
        """What it said of itself."""
        return self.session.telemetry

    @property
    def flight(self) -> MissionFlight | None:
        """Its present or last flight since this process began."""
        return self.session.flight

    @property
    def assignment(self) -> Assignment | None:
        """The plan it was given last."""
        return None if self._record.entry is None else self._record.entry.assignment

    @property
    def home(self) -> GeoPosition | None:
        """Place it returns to; the altitude is above the ellipsoid, NaN if it is not known."""
        home = self.vehicle.home
        if home is None:
            return None
        altitude_m = home.altitude_msl_m + self.vehicle.geoid_separation_m
        return GeoPosition(home.latitude_deg, home.longitude_deg, altitude_m)

    @property
    def is_in_air(self) -> bool:
        """Whether it says that it flies, or is far above its home."""
        vehicle = self.vehicle
        is_moving = vehicle.landed in (Landed.TAKEOFF, Landed.LANDING)
        return vehicle.is_armed and (vehicle.is_airborne or is_moving)

    @property
    def is_waiting(self) -> bool:
        """Whether a route is to be begun by itself later."""
        return self.session.starts_at_s is not None

    def wait_until(self, starts_at_s: float | None) -> None:
        """Note when a route is to be begun, steady seconds; None: none is."""
        self.session.starts_at_s = starts_at_s

    def listen(self, on_message: OnMessage, on_event: OnEvent) -> None:
        """Call these for each message and event of the vehicle from now on."""
        self._listeners.append((on_message, on_event))

    def take(self, message: Message, now_s: float) -> None:
        """Take a message of the vehicle."""
        before = self.vehicle
        events = self.session.take(message, now_s)
        self._watch_motors(before)
        if message.name == 'GLOBAL_POSITION_INT':
            self._record.on_position(self.vehicle)
        for on_message, on_event in self._listeners:
            on_message(message)
            for event in events:
                on_event(event)

    def take_beside(self, message: Message) -> None:
        """Take a message of a payload of the vehicle; it changes nothing that is known of it."""
        for on_message, _ in self._listeners:
            on_message(message)

    def step(self, now_s: float) -> None:
        """Take up a flight that is found in the air, and note how far the flight is."""
        if self.spec.limits.returns_in_wind:
            self._return_in_wind(now_s)
        if self.vehicle.autopilot is not None:
            self._journal.keep_failsafe(self.session.custody.failsafe)
        entry, flight = self._record.entry, self.flight
        if entry is None:
            return
        if flight is None:
            self._adopt(entry)
        else:
            self._record.note(flight, now_s, is_in_air=self.is_in_air)

    def news(self) -> tuple[object, ...]:
        """Return the part of its state that is published as soon as it changes."""
        vehicle, entry = self.vehicle, self._record.entry
        return (
            vehicle.custom_mode,
            vehicle.is_armed,
            vehicle.landed,
            vehicle.mission.phase,
            self.is_waiting,
            self.flight and self.flight.cause,
            entry and (entry.assignment.plan_id, entry.visited, entry.outcome),
        )

    def status(self, now_s: float) -> DroneStatus:
        """Return what there is to say of it at `now_s`, steady seconds."""
        advice = advice_of(self.session, self.spec.limits, now_s)
        seen = status_of(replace(self._status_inputs(), advice=advice), now_s)
        is_ready = seen.state in (FlightState.DISARMED, FlightState.LANDED)
        starts_at_s = self.session.starts_at_s
        if starts_at_s is None or not is_ready:
            return seen
        text = f'keeps away from others: takes off in {max(0.0, starts_at_s - now_s):.0f} s'
        return replace(seen, state=FlightState.WAITING, text=f'{text}; {seen.text}')

    def remaining(self) -> RemainingRoute:
        """Return what is left of its plan."""
        return remaining_route(self._status_inputs(), self.spec.limits)

    def summary(self) -> FlightSummary | None:
        """Return how its last plan ended; None before."""
        return self._record.summary()

    def checks(self, plan: FlightPlan | None, now_s: float) -> tuple[Check, ...]:
        """Return all checks before a flight of `plan`; without a plan those of the vehicle alone.

        Raises
        ------
        ValueError
            If the vehicle was never heard, or its kind is not known.
        """
        session = self.session
        settings = replace(
            session.readout.settings, station=session.us[0], has_twin=session.has_twin(now_s)
        )
        limits = self.spec.limits
        return preflight(self.vehicle, session.autopilot(), plan, limits, now_s, settings)

    def checks_of_plan(self, now_s: float) -> tuple[Check, ...]:
        """Return the checks before a flight of its present plan; raises as `checks`."""
        return self.checks(None if self.assignment is None else self.assignment.plan, now_s)

    def fly(self, assignment: Assignment, now_s: float) -> None:
        """Begin to fly a plan, or join the flight of it that is under way or over.

        Raises
        ------
        WaitError
            If the vehicle is not ready yet, but may become so.
        ValueError
            Saying why the plan cannot be flown.
        """
        entry = self._record.entry
        is_same = entry is not None and entry.assignment == assignment
        if self.session.is_flying:
            if not is_same:
                raise ValueError('is flying another route')
            return
        if is_same and entry is not None and (entry.outcome or entry.was_airborne):
            self._record.settle(self.vehicle)
            return
        is_busy = self.vehicle.is_armed or self.session.is_commanded
        if self.vehicle.contact(now_s) is not Contact.FRESH or is_busy:
            raise WaitError(self._why_it_waits(now_s))
        checks = self.checks(assignment.plan, now_s)
        _require_passed(checks)
        if blocker := self._in_the_way(now_s):
            raise WaitError(blocker)
        commands = self.session.commands()

        def may_not_arm(_vehicle: VehicleTelemetry, at_s: float) -> str:
            try:
                failed = failures(self.checks(assignment.plan, at_s))
            except ValueError as error:
                # A heartbeat named another kind of vehicle meanwhile.
                return str(error)
            reason = failed or self._in_the_way(at_s)
            if not reason:
                self._armed_by_us_s = at_s
            return reason

        flight, sent = fly(assignment.plan, commands, self.vehicle, now_s, may_not_arm)
        # Noted before the first byte is sent: a bridge that is killed in between finds the plan.
        try:
            self._record.begin(assignment, self.vehicle.home)
        except OSError as error:
            raise ValueError(f'its flight cannot be kept over a restart: {error}') from error
        self.session.flight = flight
        self.session.send(sent, now_s)

    def flies_another(self, assignment: Assignment) -> bool:
        """Whether a flight of another plan is under way."""
        return self.session.is_flying and self.assignment != assignment

    def replace_route(self, assignment: Assignment, now_s: float) -> None:
        """Begin to fly another plan in place of the one under way; see `switch_to`.

        Raises
        ------
        WaitError
            If its fence has not been read yet, or it has not left the ground: the new route
            begins past its take-off item.
        CommandRefusedError
            Saying why the plan cannot be flown.
        """
        self.commands.require_in_air(now_s)
        if not self.vehicle.has_left_ground:
            raise WaitError('it has not left the ground yet')
        _wait_for(self.commands.route_checks(assignment.plan))
        self.commands.replace_route(assignment.plan, now_s)
        self._record.begin_replacing(assignment)

    def switch_to(self, assignment: Assignment) -> None:
        """Count waypoints by another plan from now on: it lies on the vehicle and is flown."""
        session = self.session
        if session.flight is not None:
            session.flight = session.flight.replanned(assignment.plan)
        mission = replace(self.vehicle.mission, reached=-1)
        session.telemetry = replace(self.vehicle, mission=mission)
        self._record.switch_to(assignment)

    def gave_up(self) -> None:
        """Note that a command to return or to land was obeyed: the flight ends by request.

        Also one that is not found yet, or was lost: it is not resumed once it is found.
        """
        session = self.session
        self._record.note_called_down()
        if session.flight is not None and not session.flight.is_over:
            sequence = session.sequence
            homeward = None if sequence is None else sequence.verified_mission
            session.flight = session.flight.stopped(homeward)

    def _watch_motors(self, before: VehicleTelemetry) -> None:
        """Withdraw a start that waits once somebody else has switched the motors on, or off.

        That person may stand beside the vehicle when the start is due.
        """
        after, entry = self.vehicle, self._record.entry
        is_switched = before.autopilot is not None and after.is_armed is not before.is_armed
        if not is_switched or self.session.is_flying:
            return
        # The end of a flight of ours that an earlier bridge began.
        is_open = entry is not None and entry.outcome is None and entry.was_airborne
        is_our_landing = before.is_armed and is_open
        if not is_our_landing:
            self.session.withdraw_start('somebody else switched its motors')

    def _in_the_way(self, now_s: float) -> str:
        """Return which other vehicle is in the way of its take-off; empty: none."""
        motion = self.vehicle.motion
        if motion is None:
            return ''  # the checks before a flight refuse it
        running = [one for one in self.others if one is not self and one._may_lift_off(now_s)]
        places = ((one.spec.name, one.vehicle.motion) for one in running)
        return in_the_way(motion, places, self.spec.limits.separation_m, now_s)

    def _may_lift_off(self, now_s: float) -> bool:
        """Return whether its motors run, or may soon, since we ordered it."""
        return self.vehicle.is_armed or now_s - self._armed_by_us_s < ARMING_SHOWS_S

    def _return_in_wind(self, now_s: float) -> None:
        advice = advice_of(self.session, self.spec.limits, now_s)
        is_advised = any(one.order == RETURN_HOME for one in advice)
        if self._wind_return.step(now_s, is_advised=is_advised, is_in_air=self.is_in_air):
            self.gave_up()

    def _status_inputs(self) -> StatusInputs:
        return StatusInputs(
            session=self.session,
            entry=self._record.entry,
            frame=self.spec.frame,
            distance_m=self._record.distance_m,
            journal_fault=self._record.fault,
        )

    def _why_it_waits(self, now_s: float) -> str:
        contact = self.vehicle.contact(now_s)
        if contact is not Contact.FRESH:
            return f'the vehicle is not in contact ({contact.value})'
        return 'the motors run' if self.vehicle.is_armed else 'a command is under way'

    def _adopt(self, entry: JournalEntry) -> None:
        """Take up the flight of a bridge that ended; nothing is sent for it."""
        if entry.outcome is not None or not self.is_in_air:
            return
        stored = self.session.readout.mission.items
        if self.session.known_autopilot() is None or stored is None:
            return
        if self._is_adopted(entry.assignment.plan, stored) or entry.successor is None:
            return
        if self._is_adopted(entry.successor.plan, stored):
            self._record.switch_to(entry.successor)
            if entry.is_successor_given_up:
                self.gave_up()
            return
        # A part of each plan lies on it: it stands still, and can be sent the new one again.
        self._is_adopted(entry.assignment.plan, None)

    def _is_adopted(self, plan: FlightPlan, stored: tuple[MissionItem, ...] | None) -> bool:
        """Take up the flight of `plan` if the vehicle flies it; return whether it does."""
        entry = self._record.entry
        home = None if entry is None else entry.home
        try:
            flight = adopted(plan, self.session.commands(), self.vehicle, stored, home)
        except ValueError:
            # A heartbeat named a kind of vehicle that flies no such plan.
            return False
        if flight is None or entry is None:
            return False
        if plan == entry.assignment.plan:
            flight = flight.remembering(
                entry.cause, entry.reason, was_called_down=entry.was_called_down
            )
        # A noted order to return was for that plan: nothing is noted yet of the plan after it.
        self.session.flight = flight
        return True


def _require_passed(checks: tuple[Check, ...]) -> None:
    _wait_for(checks)
    failed = failures(checks)
    if failed:
        raise ValueError(failed)


def _wait_for(checks: tuple[Check, ...]) -> None:
    """Raise `WaitError` if all that failed may pass soon."""
    if not is_failed_for_good(checks) and failures(checks):
        raise WaitError(failures(checks))
