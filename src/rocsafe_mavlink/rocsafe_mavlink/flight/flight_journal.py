# SPDX-License-Identifier: Apache-2.0
"""Journal of flights: the plan of each vehicle, kept over restarts of the bridge.

Position, state and progress are always asked of the vehicle itself.
"""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.storage.kept_file import KeptFile
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome
from rocsafe_mavlink.knowledge.telemetry import Home
from rocsafe_mavlink.plan.flight_plan import FlightPlan, FlightWaypoint


@dataclass(frozen=True, slots=True, kw_only=True)
class Assignment:
    """A plan that a vehicle was given.

    Attributes
    ----------
    plan_id
        Name of the plan, by its sender.
    plan
        What is flown.
    viewpoint_ids
        Numbers of its stops, in order.
    """

    plan_id: str
    plan: FlightPlan
    viewpoint_ids: tuple[int, ...]

    def __post_init__(self) -> None:
        if len(self.viewpoint_ids) != len(self.plan.stops):
            raise ValueError(
                f'viewpoint_ids has {len(self.viewpoint_ids)} of them: must have one for each of '
                f'{len(self.plan.stops)} stops'
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class JournalEntry:
    """Progress of an assignment, as last noted.

    Attributes
    ----------
    assignment
        What was given.
    home
        Home of the vehicle when it was begun; None: a bridge before 0.3 did not note it.
    was_airborne
        Whether the vehicle was seen in the air since.
    visited
        Waypoints behind it.
    distance_m, duration_s
        Distance and time flown.
    outcome, reason
        How it ended; None before.
    cause
        Why it left its mission: a failsafe, or an order; None: it has not.
    was_called_down
        Whether an operator had it return or land.
    successor
        Plan that was being sent to be flown in its place; None: none. Which of both is on the
        vehicle is asked of the vehicle.
    is_successor_given_up
        Whether an operator had it return or land since `successor` was sent.
    """

    assignment: Assignment
    home: Home | None = None
    was_airborne: bool = False
    visited: int = 0
    distance_m: float = 0.0
    duration_s: float = 0.0
    outcome: FlightOutcome | None = None
    reason: str = ''
    cause: FlightOutcome | None = None
    was_called_down: bool = False
    successor: Assignment | None = None
    is_successor_given_up: bool = False


class FlightJournal:
    """Keeps what is known of one vehicle, in memory and, if a path is given, in files.

    Attributes
    ----------
    entry
        Its last plan; None: it was given none.
    failsafe
        Failsafe that it announced or showed since its motors were started, whoever started them;
        None: none. It stands in a file of its own beside `path`.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._file = KeptFile(path)
        beside = None if path is None else path.with_name('failsafe.json')
        self._failsafe_file = KeptFile(beside)
        self.entry: JournalEntry | None = None if path is None else _read(path)
        self.failsafe = None if beside is None else _read_failsafe(beside)

    @property
    def fault(self) -> str:
        """Why the entry is not on disk; empty: it is."""
        return self._file.fault

    @property
    def open_entry(self) -> JournalEntry | None:
        """The entry of a flight that may be in the air yet; None: there is none."""
        may_fly = self.entry is not None and self.entry.outcome in (None, FlightOutcome.LOST)
        return self.entry if may_fly else None

    def begin(self, entry: JournalEntry) -> None:
        """Keep the entry of a flight that is to begin; once this returns, it survives a kill.

        Raises
        ------
        OSError
            If it cannot be written; the entry before is kept.
        """
        self._file.require(_content(entry))
        self.entry = entry

    def write(self, entry: JournalEntry) -> None:
        """Keep `entry`, also where it cannot be written: the flight goes on, see `fault`."""
        if entry == self.entry and not self.fault:
            return
        self.entry = entry
        self._file.keep(_content(entry))

    def keep_failsafe(self, failsafe: FlightOutcome | None) -> None:
        """Keep the failsafe that a vehicle has announced; None: its motors have stopped."""
        if failsafe is not self.failsafe:
            self.failsafe = failsafe
            self._failsafe_file.keep(json.dumps(failsafe and failsafe.name).encode())


_OUTCOMES = ('outcome', 'cause')


def _content(entry: JournalEntry) -> bytes:
    names = {name: getattr(entry, name) for name in _OUTCOMES}
    record = {**asdict(entry), **{name: one and one.name for name, one in names.items()}}
    return json.dumps(record).encode()


def _read(path: Path) -> JournalEntry | None:
    """Return the entry in `path`, None if there is none.

    Raises
    ------
    ValueError
        If the file is damaged.
    """
    if not path.exists():
        return None
    try:
        record: dict[str, Any] = json.loads(path.read_text(encoding='utf-8'))
        # An older bridge noted the outcome alone.
        ends = {name: _outcome(record.pop(name, None)) for name in _OUTCOMES}
        # An older bridge noted the failsafe here.
        record.pop('failsafe', None)
        assignment = _assignment(record.pop('assignment'))
        successor, home = record.pop('successor', None), record.pop('home', None)
        return JournalEntry(
            assignment=assignment,
            home=None if home is None else Home(**home),
            successor=None if successor is None else _assignment(successor),
            **ends,
            **record,
        )
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f'{path} is damaged: {error}') from error


def _read_failsafe(path: Path) -> FlightOutcome | None:
    """Return the failsafe in `path`; one that cannot be read counts as a failsafe."""
    if not path.exists():
        return None
    try:
        return _outcome(json.loads(path.read_text(encoding='utf-8')))
    except (KeyError, ValueError):
        return FlightOutcome.FAILSAFE_OTHER


def _outcome(name: str | None) -> Any:
    return None if name is None else FlightOutcome[name]


def _assignment(record: dict[str, Any]) -> Assignment:
    plan = record['plan']
    waypoints = tuple(
        FlightWaypoint(**{**waypoint, 'position': GeoPosition(**waypoint['position'])})
        for waypoint in plan.pop('waypoints')
    )
    home = plan.pop('home')
    # A bridge before 0.3 noted none.
    exclusions = tuple(
        tuple(GeoPosition(**corner) for corner in ring) for ring in plan.pop('exclusions', ())
    )
    return Assignment(
        plan_id=record['plan_id'],
        plan=FlightPlan(
            waypoints=waypoints,
            home=home and GeoPosition(**home),
            exclusions=exclusions,
            **plan,
        ),
        viewpoint_ids=tuple(record['viewpoint_ids']),
    )
