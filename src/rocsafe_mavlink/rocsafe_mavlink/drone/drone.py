# SPDX-License-Identifier: Apache-2.0
"""One real vehicle, looked at as the rest of the suite looks at vehicles."""

from dataclasses import dataclass, replace

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_mavlink.drone.command_services import OperatorOrders
from rocsafe_mavlink.drone.line import Line
from rocsafe_mavlink.drone.observation import (
    FlightSummary,
    Left,
    Observation,
    Sight,
    left_of,
    observe,
)
from rocsafe_mavlink.drone.station import Target
from rocsafe_mavlink.flight.flight import Flight
from rocsafe_mavlink.flight.flight_journal import Assignment, Entry, FlightJournal
from rocsafe_mavlink.flight.flight_outcome import Outcome
from rocsafe_mavlink.flight.flight_plan import FlightPlan
from rocsafe_mavlink.flight.preflight import Check, FlightLimits, failures, is_failed_for_good
from rocsafe_mavlink.knowledge.vehicle import Contact, Landed, MissionPhase, Vehicle
from rocsafe_mavlink.wire.dialect import Message

# A step between two positions longer than this is a jump, not a way that was flown.
LARGEST_STEP_M = 60.0


class WaitError(Exception):
    """It cannot be said yet whether a route may be flown: ask again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DroneSpec:
    """What a drone is made of.

    Attributes
    ----------
    name: of the vehicle.
    target: its (system, component).
    frame: of the mission.
    limits: of its flights.
    speed_mps: over ground.
    hover_s: time that it stands at a viewpoint.
    takes_photographs, trigger_distance_m: as in `FlightPlan`.
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
    """A vehicle on a line, with the plan it was given.

    Parameters
    ----------
    spec: what it is.
    line: where it is heard.
    journal: remembers its plan.
    """

    def __init__(self, spec: DroneSpec, line: Line, journal: FlightJournal) -> None:
        self.spec = spec
        self._line = line
        self._journal = journal
        self._distance_m = 0.0
        self._last: GeoPosition | None = None
        self._began_s: float | None = None
        self.orders = OperatorOrders(spec.target, line.station, spec.limits)

    @property
    def vehicle(self) -> Vehicle:
        """What is known of it."""
        return self._line.station.vehicle(self.spec.target)

    @property
    def flight(self) -> Flight | None:
        """Its present or last flight since this process began."""
        return self._line.station.flight(self.spec.target)

    @property
    def assignment(self) -> Assignment | None:
        """The plan it was given last."""
        return None if self._journal.entry is None else self._journal.entry.assignment

    def on_message(self, message: Message) -> None:
        """Take note of a message that the station has taken."""
        motion = self.vehicle.motion
        if message.name != 'GLOBAL_POSITION_INT' or motion is None or self.vehicle.is_on_ground:
            return
        if self._last is not None:
            step_m = distance_m(self._last, motion.position)
            self._distance_m += step_m if step_m < LARGEST_STEP_M else 0.0
        self._last = motion.position

    def step(self, now_s: float) -> None:
        """Pick up a flight that is found in the air, and note how far the flight is."""
        entry, flight = self._journal.entry, self.flight
        if entry is None:
            return
        if flight is None or (flight.is_over and self.is_in_air and entry.outcome is None):
            self._pick_up(entry)
            return
        if entry.outcome is None:
            self._note(entry, flight, now_s)

    @property
    def home(self) -> GeoPosition | None:
        """Where it will return to; its altitude is above the ellipsoid, NaN if not known."""
        home = self.vehicle.home
        if home is None:
            return None
        altitude_m = home.altitude_msl_m + self.vehicle.geoid_separation_m
        return GeoPosition(home.latitude_deg, home.longitude_deg, altitude_m)

    def news(self) -> tuple[object, ...]:
        """Return what of its state is told as soon as it changes."""
        vehicle, entry = self.vehicle, self._journal.entry
        return (
            vehicle.custom_mode,
            vehicle.is_armed,
            vehicle.landed,
            vehicle.mission.phase,
            entry and (entry.assignment.plan_id, entry.visited, entry.outcome),
        )

    @property
    def is_in_air(self) -> bool:
        """Whether it says that it flies."""
        in_air = (Landed.IN_AIR, Landed.TAKEOFF, Landed.LANDING)
        return self.vehicle.is_armed and self.vehicle.landed in in_air

    def observe(self, now_s: float) -> Observation:
        """Return what there is to say of it at `now_s`."""
        return observe(self._sight(), now_s)

    def left(self) -> Left:
        """Return what is left of its plan."""
        return left_of(self._sight(), self.spec.limits)

    def _sight(self) -> Sight:
        return Sight(
            vehicle=self.vehicle,
            member=self._line.station.member(self.spec.target),
            entry=self._journal.entry,
            frame=self.spec.frame,
            distance_m=self._distance_m,
        )

    def checks(self, now_s: float) -> tuple[Check, ...]:
        """Return every look before a flight of its plan, or at the vehicle alone.

        Raises
        ------
        ValueError: if it was never heard, or is of no kind that is known.
        """
        plan = None if self.assignment is None else self.assignment.plan
        return self.checks_of(plan, now_s)

    def checks_of(self, plan: FlightPlan | None, now_s: float) -> tuple[Check, ...]:
        """Return every look before a flight of `plan`; raises as `checks`."""
        return self._line.station.checks(self.spec.target, plan, self.spec.limits, now_s)

    # Flights.

    def fly(self, assignment: Assignment, now_s: float, time_s: float) -> None:
        """Begin to fly a plan, or join the flight of it that is under way or over.

        Raises
        ------
        WaitError: if the vehicle has not yet been looked at.
        ValueError: saying why not.
        """
        entry = self._journal.entry
        is_same = entry is not None and entry.assignment == assignment
        if self._is_busy:
            if not is_same:
                raise ValueError('is flying another route')
            return
        if is_same and entry is not None and (entry.outcome or entry.was_airborne):
            self._settle(entry)
            return
        if self.vehicle.contact(now_s) is not Contact.FRESH or self.vehicle.is_armed:
            raise WaitError(self._why_it_waits(now_s))
        station = self._line.station
        _wait_for(station.checks(self.spec.target, assignment.plan, self.spec.limits, now_s))
        outgoing = station.fly(self.spec.target, assignment.plan, self.spec.limits, now_s, time_s)
        # Noted before the first byte goes out: a kill in between finds the plan.
        self._journal.write(Entry(assignment=assignment))
        self._distance_m, self._began_s = 0.0, None
        self._line.send(outgoing)

    def flies_another(self, assignment: Assignment) -> bool:
        """Whether a flight of another plan is under way."""
        return self._is_busy and self.assignment != assignment

    def fly_instead(self, assignment: Assignment, now_s: float) -> None:
        """Begin to fly another plan in place of the one under way; see `take_over`.

        Raises
        ------
        WaitError: if its fence has not yet been read.
        ValueError: saying why not.
        """
        station, target, limits = self._line.station, self.spec.target, self.spec.limits
        station.require_contact(target, now_s)
        _wait_for(station.route_checks(target, assignment.plan, limits))
        station.fly_instead(target, assignment.plan, limits)
        if self._journal.entry is not None:
            self._journal.write(replace(self._journal.entry, successor=assignment))

    def take_over(self, assignment: Assignment) -> None:
        """Count by another plan from now on: it lies on the vehicle and is flown."""
        member = self._line.station.member(self.spec.target)
        if member.flight is not None:
            member.flight = member.flight.replanned(assignment.plan)
        mission = replace(self.vehicle.mission, reached=-1)
        member.vehicle = replace(member.vehicle, mission=mission)
        self._journal.write(Entry(assignment=assignment, was_airborne=True))

    def gave_up(self) -> None:
        """Note that an order to return or to land was obeyed: the flight ends by request."""
        member = self._line.station.member(self.spec.target)
        if member.flight is not None and not member.flight.is_over:
            member.flight = member.flight.stopped()

    def _why_it_waits(self, now_s: float) -> str:
        contact = self.vehicle.contact(now_s)
        if contact is not Contact.FRESH:
            return f'the vehicle is not in contact ({contact.value})'
        return 'the motors run'

    @property
    def _is_busy(self) -> bool:
        """Whether a flight is under way, ours or one that we found."""
        flight = self.flight
        return flight is not None and not flight.is_over

    def _pick_up(self, entry: Entry) -> None:
        """Take up the flight of a bridge that is no more; nothing is sent for it."""
        if entry.outcome is not None or not self.is_in_air:
            return
        station, target = self._line.station, self.spec.target
        if station.adopt(target, entry.assignment.plan) or entry.successor is None:
            return
        if station.adopt(target, entry.successor.plan):
            self._journal.write(Entry(assignment=entry.successor, was_airborne=True))
            return
        # A part of each lies on it: it stands still, and can be sent the new route again.
        station.adopt(target, entry.assignment.plan, is_torn=True)

    def _settle(self, entry: Entry) -> None:
        """Say how a flight ended that nobody watched to its end."""
        if entry.outcome is not None:
            return
        if self.vehicle.is_armed or self.vehicle.autopilot is None:
            raise WaitError('the vehicle is being looked at')
        if self.vehicle.mission.current < 0:
            raise WaitError('the vehicle has not told of its mission')
        count = len(entry.assignment.plan.stops)
        is_done = entry.visited == count or self.vehicle.mission.phase is MissionPhase.COMPLETE
        self._journal.write(
            replace(
                entry,
                visited=count if is_done else entry.visited,
                outcome=Outcome.COMPLETED if is_done else Outcome.ABORTED_BY_OPERATOR,
                reason='' if is_done else 'it landed while nobody watched',
            )
        )

    def _note(self, entry: Entry, flight: Flight, now_s: float) -> None:
        if self.is_in_air and self._began_s is None:
            self._began_s = now_s
        is_begun = entry.was_airborne or self.is_in_air
        changed = replace(
            entry,
            was_airborne=is_begun,
            visited=max(entry.visited, flight.visited),
            outcome=flight.outcome,
            reason=flight.reason,
        )
        if changed != entry:
            began_s = now_s if self._began_s is None else self._began_s
            self._journal.write(
                replace(changed, distance_m=self._distance_m, duration_s=now_s - began_s)
            )

    def summary(self) -> FlightSummary | None:
        """Return how the last plan ended; None before."""
        entry = self._journal.entry
        if entry is None or entry.outcome is None:
            return None
        return FlightSummary(
            outcome=entry.outcome,
            text=entry.reason,
            visited=entry.visited,
            distance_m=entry.distance_m,
            duration_s=entry.duration_s,
        )


def _wait_for(checks: tuple[Check, ...]) -> None:
    """Raise `WaitError` if nothing failed but what may pass soon."""
    if not is_failed_for_good(checks) and failures(checks):
        raise WaitError(failures(checks))
