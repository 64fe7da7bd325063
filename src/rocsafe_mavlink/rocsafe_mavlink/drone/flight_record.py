# SPDX-License-Identifier: Apache-2.0
"""Record of the flights of one vehicle: plan, progress, distance, duration, outcome."""

from dataclasses import dataclass, replace

from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_mavlink.errors import WaitError
from rocsafe_mavlink.flight.flight import MissionFlight
from rocsafe_mavlink.flight.flight_journal import Assignment, FlightJournal, JournalEntry
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome
from rocsafe_mavlink.knowledge.telemetry import Home, MissionPhase, VehicleTelemetry

# A step between two positions longer than this is a jump, not flown.
LARGEST_STEP_M = 60.0


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightSummary:
    """How a flight ended."""

    outcome: FlightOutcome
    text: str
    visited: int
    distance_m: float
    duration_s: float


class FlightRecord:
    """Notes the flights of one vehicle in its journal.

    Parameters
    ----------
    journal
        Keeps the entry over restarts of this process.

    Attributes
    ----------
    distance_m
        Distance flown, metres.
    """

    def __init__(self, journal: FlightJournal) -> None:
        self._journal = journal
        self._last: GeoPosition | None = None
        self._began_s: float | None = None
        entry = journal.entry
        # A flight that an earlier process watched goes on.
        self._flown_s = 0.0 if entry is None else entry.duration_s
        self.distance_m = 0.0 if entry is None else entry.distance_m

    @property
    def entry(self) -> JournalEntry | None:
        """The plan that was given last and how far it is; None: none was given."""
        return self._journal.entry

    @property
    def fault(self) -> str:
        """Why the record is not on disk; empty: it is."""
        return self._journal.fault

    def begin(self, assignment: Assignment, home: Home | None = None) -> None:
        """Note a plan that is about to be flown; raises `OSError` if it cannot be written."""
        self._journal.begin(JournalEntry(assignment=assignment, home=home))
        self.distance_m, self._flown_s, self._began_s = 0.0, 0.0, None

    def begin_replacing(self, assignment: Assignment) -> None:
        """Note a plan that is being sent to be flown in place of the present one."""
        if self.entry is not None:
            self._journal.write(
                replace(self.entry, successor=assignment, is_successor_given_up=False)
            )

    def switch_to(self, assignment: Assignment) -> None:
        """Note a plan that is flown now in place of the one before."""
        home = None if self.entry is None else self.entry.home
        self._journal.write(JournalEntry(assignment=assignment, home=home, was_airborne=True))

    def on_position(self, vehicle: VehicleTelemetry) -> None:
        """Add the way to a new position of `vehicle`."""
        if vehicle.motion is None or vehicle.is_on_ground:
            return
        if self._last is not None:
            step_m = distance_m(self._last, vehicle.motion.position)
            self.distance_m += step_m if step_m < LARGEST_STEP_M else 0.0
        self._last = vehicle.motion.position

    def note(self, flight: MissionFlight, now_s: float, *, is_in_air: bool) -> None:
        """Note how far a flight is."""
        entry = self.entry
        if entry is None or entry.outcome is not None:
            return
        if is_in_air and self._began_s is None:
            self._began_s = now_s
        changed = replace(
            entry,
            was_airborne=entry.was_airborne or is_in_air,
            visited=max(entry.visited, flight.visited),
            outcome=flight.outcome,
            reason=flight.reason,
            cause=flight.cause,
            was_called_down=flight.was_called_down,
        )
        if changed != entry:
            began_s = now_s if self._began_s is None else self._began_s
            duration_s = self._flown_s + now_s - began_s
            self._journal.write(
                replace(changed, distance_m=self.distance_m, duration_s=duration_s)
            )

    def note_called_down(self) -> None:
        """Note that an operator had the flight that may be in the air return or land."""
        entry = self._journal.open_entry
        if entry is not None:
            cause = entry.cause or FlightOutcome.ABORTED_BY_OPERATOR
            is_given_up = entry.successor is not None
            self._journal.write(
                replace(
                    entry, cause=cause, was_called_down=True, is_successor_given_up=is_given_up
                )
            )

    def settle(self, vehicle: VehicleTelemetry) -> None:
        """Note how a flight ended that was not watched to its end.

        Raises
        ------
        WaitError
            If `vehicle` has not told enough yet.
        """
        entry = self.entry
        if entry is None or entry.outcome is not None:
            return
        if vehicle.is_armed or vehicle.autopilot is None:
            raise WaitError('the vehicle is being looked at')
        if vehicle.mission.current < 0:
            raise WaitError('the vehicle has not told of its mission')
        count = len(entry.assignment.plan.stops)
        is_done = entry.visited == count or vehicle.mission.phase is MissionPhase.COMPLETE
        self._journal.write(
            replace(
                entry,
                visited=count if is_done else entry.visited,
                outcome=FlightOutcome.COMPLETED if is_done else FlightOutcome.ABORTED_BY_OPERATOR,
                reason='' if is_done else 'it landed while nobody watched',
            )
        )

    def summary(self) -> FlightSummary | None:
        """Return how the last plan ended; None before."""
        entry = self.entry
        if entry is None or entry.outcome is None:
            return None
        return FlightSummary(
            outcome=entry.outcome,
            text=entry.reason,
            visited=entry.visited,
            distance_m=entry.distance_m,
            duration_s=entry.duration_s,
        )
