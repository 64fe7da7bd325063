# SPDX-License-Identifier: Apache-2.0
"""A multirotor in motion: follows its command, triggers its camera, watches its battery.

Its motion is a closed-form function of the time since its last command, so that neither the step
of the simulation nor a restart of the process changes a flight.
"""

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from rocsafe_geo.motion.state import Enu
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.flight.commands import Command, CommandKind
from rocsafe_sim.flight.course import Course
from rocsafe_sim.flight.segment import FlightPose, Mode, standing
from rocsafe_sim.flight.tasks import stopped
from rocsafe_sim.flight.timeline import ShotTime
from rocsafe_sim.vehicle.collision import CollisionWatch
from rocsafe_sim.vehicle.flight_ends import (
    collided,
    cut_short,
    failed,
    failure_ns,
    is_over,
    with_new_battery,
)
from rocsafe_sim.vehicle.flight_record import FlightOutcome, FlightRecord, VehicleRecord
from rocsafe_sim.vehicle.snapshot import ShotDue, VehicleSnapshot
from rocsafe_sim.vehicle.surroundings import Surroundings, on_ground


class FlyingVehicle:
    """A vehicle that follows its command; `SimulatedVehicle` gives it commands.

    Parameters
    ----------
    airframe
        Performance of the vehicle.
    home_enu
        Place on the ground where it stands, metres.
    surroundings
        Ground and obstacles; None: the ground of its route, without obstacles.
    """

    def __init__(
        self, airframe: Airframe, home_enu: Enu, surroundings: Surroundings | None = None
    ) -> None:
        self.airframe = airframe
        self.surroundings = surroundings
        self.time_ns = 0
        self._record = VehicleRecord(home_enu=home_enu)
        self._course: Course | None = None
        self._shots: deque[tuple[int, ShotTime]] = deque()
        self._watch: CollisionWatch | None = None

    @property
    def record(self) -> VehicleRecord:
        """State that must survive the process; see `restore`."""
        return self._record

    @property
    def flight(self) -> FlightRecord | None:
        """The last flight, running or ended; None before the first."""
        return self._record.flight

    @property
    def home_enu(self) -> Enu:
        """Place on the ground that it returns to, without rally points."""
        return self._record.home_enu if self.flight is None else self.flight.route.home_enu

    @property
    def mode(self) -> Mode:
        """Mode after the last step or command."""
        return Mode.DISARMED if self._course is None else self._course.mode(self.time_ns)

    @property
    def is_idle(self) -> bool:
        """Whether nothing happens until the next command."""
        return not self.mode.is_airborne and self.mode is not Mode.WAITING

    @property
    def stands(self) -> bool:
        """Whether it holds and has come to a stop."""
        return self.mode is Mode.HOLDING and self.pose_at(self.time_ns).motion.is_still

    @property
    def waits_s(self) -> float:
        """Time on the ground before it takes off by itself, seconds; 0 if it does not wait.

        Infinite while it is held there.
        """
        if self.flight is None or self.mode is not Mode.WAITING:
            return 0.0
        if self.flight.command.is_held:
            return math.inf
        return (self.flight.command.start_ns - self.time_ns) / NS_PER_S

    def restore(self, record: VehicleRecord) -> None:
        """Continue from a record; the next step continues the flight as without interruption."""
        self._record = record
        if record.flight is not None:
            self.time_ns = record.flight.command.start_ns - record.flight.command.wait_ns
            self._follow(record.flight)

    def look_ahead(self) -> None:
        """Compute what the next step would: when the battery will be low."""
        if self._course is not None:
            _ = self._course.low_ns

    def step(self, time_ns: int) -> VehicleSnapshot:
        """Advance to `time_ns`, simulated nanoseconds, and return the state at that time.

        Raises
        ------
        ValueError
            If time runs backwards.
        """
        if time_ns < self.time_ns:
            raise ValueError(f'time_ns is {time_ns}: must be {self.time_ns} or later')
        shots = tuple(self._run_to(time_ns))
        self.time_ns = time_ns
        return self.observe(shots)

    def observe(self, shots: tuple[ShotDue, ...] = ()) -> VehicleSnapshot:
        """Return the state after the last step and command."""
        flight, course, time_ns = self.flight, self._course, self.time_ns
        visited = 0 if flight is None else flight.visited
        return VehicleSnapshot(
            time_ns=time_ns,
            pose=self.pose_at(time_ns),
            mode=self.mode,
            viewpoints_visited=visited,
            shots_taken=self._record.shots_taken,
            battery_fraction=1.0 if course is None else course.charge_fraction(time_ns),
            power_w=0.0 if course is None else course.power_w(time_ns),
            distance_flown_m=self._distance_m(time_ns),
            shots=shots,
            waits_s=self.waits_s,
        )

    def pose_at(self, time_ns: int) -> FlightPose:
        """Return the pose at a time without further commands; constant before the last one."""
        if self._course is None:
            return standing(self._record.home_enu, 0.0)
        return self._course.pose(time_ns)

    def _give(
        self,
        flight: FlightRecord,
        kind: CommandKind,
        time_ns: int | None = None,
        goal_enu: Enu | None = None,
        **aims: Any,
    ) -> None:
        """Put a command in force at `time_ns`, or now; `aims` are further fields of it."""
        command = self._command(kind, self.time_ns if time_ns is None else time_ns, flight.visited)
        self._follow(replace(flight, command=replace(command, goal_enu=goal_enu, **aims)))

    def _command(self, kind: CommandKind, time_ns: int, first_index: int) -> Command:
        course, start = self._course, self.pose_at(time_ns)
        return Command(
            kind=kind,
            start_ns=time_ns,
            start=start,
            ground_up_m=self._ground_for(kind, start),
            first_index=first_index,
            charge_fraction=1.0 if course is None else course.charge_fraction(time_ns),
            distance_m=self._distance_m(time_ns),
            number=0 if self.flight is None else self.flight.command.number,
            speed_mps=self._record.speed_mps,
            wind_mps=self._record.wind_mps,
        )

    def _ground_for(self, kind: CommandKind, start: FlightPose) -> float | None:
        """Return the height of the ground on which a command ends; None: that of its route."""
        if self.surroundings is None or kind not in (CommandKind.LAND, CommandKind.FALL):
            return None
        at = start if kind is CommandKind.FALL else stopped(self.airframe, start)[1]
        return on_ground(self.surroundings, at.position_enu)[2]

    def _follow(self, flight: FlightRecord) -> None:
        """Make `flight` the current one."""
        self._record = replace(self._record, flight=flight)
        self._course = Course(flight.command, flight.route, self.airframe)
        self._shots = deque(self._course.shots(flight.visited))
        self._watch = None
        if self.surroundings is not None and self.airframe.collision_radius_m:
            self._watch = CollisionWatch(self._course, self.surroundings, self.airframe)

    def _run_to(self, time_ns: int) -> Iterator[ShotDue]:
        """Process all events until `time_ns` in order of time; yield the photographs."""
        while self.flight is not None and self._course is not None:
            flight, course = self.flight, self._course
            low_ns, down_ns = course.low_ns, course.touch_down_ns
            fails_ns = failure_ns(flight, course, self.airframe)
            due_ns = self._shots[0][0] if self._shots else math.inf
            next_ns = min(due_ns, low_ns, down_ns, fails_ns)
            hit = self._watch and self._watch.first_until(min(next_ns, time_ns))
            if hit:
                self._give(collided(flight, hit.thing), CommandKind.FALL, hit.time_ns)
                continue
            if next_ns > time_ns or math.isinf(next_ns):
                return
            if next_ns == due_ns:
                yield self._take_shot(course, flight, *self._shots.popleft())
            elif next_ns == down_ns:
                if flight.outcome is not None:
                    return
                self._touch_down(flight, int(down_ns))
            elif next_ns == fails_ns:
                self._fail(flight, int(fails_ns))
            else:
                self._divert_on_low_battery(flight, int(low_ns))

    def _take_shot(
        self, course: Course, flight: FlightRecord, due_ns: int, shot: ShotTime
    ) -> ShotDue:
        sequence = self._record.shots_taken
        visited = replace(flight, visited=shot.viewpoint_index + 1)
        self._record = replace(self._record, shots_taken=sequence + 1, flight=visited)
        waypoint = flight.route.waypoints[shot.viewpoint_index]
        return ShotDue(
            sequence=sequence,
            viewpoint_id=waypoint.viewpoint_id,
            time_ns=due_ns,
            pose=standing(waypoint.position_enu, waypoint.yaw_rad)
            if self.airframe.hover_s
            else course.timeline.pose(shot.elapsed_s),
        )

    def _divert_on_low_battery(self, flight: FlightRecord, time_ns: int) -> None:
        charge = 0.0 if self._course is None else self._course.charge_fraction(time_ns)
        text = f'battery {charge:.0%} after {flight.visited} viewpoints'
        ended = cut_short(flight, FlightOutcome.BATTERY_LOW, text)
        self._give(ended, CommandKind.DIVERT, time_ns)

    def _fail(self, flight: FlightRecord, time_ns: int) -> None:
        """Descend at the present place."""
        self._give(failed(flight), CommandKind.LAND, time_ns)

    def _touch_down(self, flight: FlightRecord, down_ns: int) -> None:
        """Change the battery and continue, or end the flight."""
        if is_over(flight):
            landed = replace(flight, outcome=flight.ending, ended_ns=down_ns)
            self._record = replace(self._record, flight=landed)
        else:
            self._follow(
                with_new_battery(flight, self._command(CommandKind.FLY, down_ns, flight.visited))
            )

    def _distance_m(self, time_ns: int) -> float:
        return 0.0 if self._course is None else self._course.distance_m(time_ns)
