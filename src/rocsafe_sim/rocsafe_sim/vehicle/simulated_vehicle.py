# SPDX-License-Identifier: Apache-2.0
"""A simulated multirotor: executes commands, flies, triggers its camera, watches its battery.

Its motion is a closed-form function of the time since its last command, so that neither the step
of the simulation nor a restart of the process changes a flight. It has no sensors, writes no files
and knows nothing of ROS: see `rocsafe_sim.rav.rav`.
"""

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import replace

from rocsafe_geo.limits import require_positive
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.flight.commands import Command, CommandKind
from rocsafe_sim.flight.course import Course
from rocsafe_sim.flight.fence import Fence
from rocsafe_sim.flight.route import FlightRoute, horizontal_m
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
    require_ready,
    with_new_battery,
)
from rocsafe_sim.vehicle.flight_record import FlightOutcome, FlightRecord, VehicleRecord
from rocsafe_sim.vehicle.snapshot import FlightSummary, ShotDue, VehicleSnapshot
from rocsafe_sim.vehicle.surroundings import Surroundings, grounded, on_ground

# Command with which a held flight continues, by its ending; all others return home.
_RESUMED = {
    FlightOutcome.COMPLETED: CommandKind.FLY,
    FlightOutcome.BATTERY_LOW: CommandKind.DIVERT,
}


class SimulatedVehicle:
    """A vehicle without sensors. Commands take effect at the time of the last step.

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
    def ends_early(self) -> bool:
        """Whether its flight ends, or has ended, otherwise than planned."""
        ending = FlightOutcome.COMPLETED if self.flight is None else self.flight.ending
        return ending is not FlightOutcome.COMPLETED

    @property
    def stands(self) -> bool:
        """Whether it holds and has come to a stop."""
        return self.mode is Mode.HOLDING and self.pose_at(self.time_ns).motion.is_still

    @property
    def waits_s(self) -> float:
        """Time on the ground before it takes off by itself, seconds; 0 if it does not wait."""
        if self.flight is None or self.mode is not Mode.WAITING:
            return 0.0
        return (self.flight.command.start_ns - self.time_ns) / NS_PER_S

    def restore(self, record: VehicleRecord) -> None:
        """Continue from a record; the next step continues the flight as without interruption."""
        self._record = record
        if record.flight is not None:
            self.time_ns = record.flight.command.start_ns - record.flight.command.wait_ns
            self._follow(record.flight)

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

    def fly_route(self, route: FlightRoute, *, replaces: bool = False) -> None:
        """Fly `route`. The route of the running or the last flight is not begun again.

        If that flight was cancelled or is held, it continues. With `replaces` the route replaces
        another one that is being flown, from the place of the vehicle.

        Raises
        ------
        CommandRefusedError
            If another flight runs, home is elsewhere, or the charge is too low.
        """
        if self.surroundings is not None:
            route = grounded(route, self.surroundings)
        flight = self.flight
        if flight is not None and flight.route == route:
            if self.mode is Mode.HOLDING:
                self._give(replace(flight, outcome=None, text='', ended_ns=None), CommandKind.FLY)
            return
        mode = self.mode
        if flight is None:
            stand = self._record.home_enu
        else:
            stand = (
                flight.route.home_enu
                if mode.is_airborne
                else self.pose_at(self.time_ns).position_enu
            )
        require_ready(route, flight, mode, stand, replaces=replaces)
        if not mode.is_airborne:
            self._record = replace(self._record, speed_mps=0.0)
        command = self._beginning(route)
        if self.mode.is_airborne:
            begins = stopped(self.airframe, command.start)[1].position_enu
            route = replace(route, begins_enu=begins)
        self._record.fence.require(route)
        if Course(command, route, self.airframe).low_ns <= command.start_ns:
            raise CommandRefusedError(
                f'battery {command.charge_fraction:.0%}: must be more, to keep a reserve of '
                f'{self.airframe.reserve_fraction:.0%}'
            )
        self._follow(
            FlightRecord(
                route=route,
                command=command,
                take_off_ns=command.start_ns,
                take_off_distance_m=command.distance_m,
            )
        )

    def cancel(self) -> None:
        """Cancel the running flight, if any: the vehicle holds, or continues its landing.

        A vehicle that waits on the ground stays there.
        """
        if self.flight is None or self.flight.outcome is not None:
            return
        cancelled = replace(
            self.flight, outcome=FlightOutcome.CANCELLED, text='by request', ended_ns=self.time_ns
        )
        mode = self.mode
        self._record = replace(self._record, flight=cancelled)
        if mode is Mode.WAITING:
            self._give(cancelled, CommandKind.LAND)
        elif mode not in (Mode.LANDING, Mode.HOLDING, Mode.FALLING):
            self._give(cancelled, CommandKind.HOLD)

    def hold(self) -> None:
        """Hold in the air until the next command.

        Raises
        ------
        CommandRefusedError
            If on the ground, landing, or holding already.
        """
        flight = self._require_mode('hold', Mode.TAKING_OFF, Mode.FLYING, Mode.RETURNING)
        self._give(flight, CommandKind.HOLD)

    def resume(self) -> None:
        """Continue a held flight.

        Raises
        ------
        CommandRefusedError
            If not holding, or if the flight was cancelled.
        """
        modes = (Mode.HOLDING, Mode.FLYING) if self._is_sent_away else (Mode.HOLDING,)
        flight = self._require_mode('resume', *modes)
        if flight.outcome is not None:
            raise CommandRefusedError('cannot resume: the flight was cancelled, send a route')
        self._give(flight, _RESUMED.get(flight.ending, CommandKind.RETURN))

    def return_home(self) -> None:
        """End the route, fly home or to the nearest rally point, and land.

        Raises
        ------
        CommandRefusedError
            If on the ground, landing, or returning already.
        """
        flight = self._require_mode('return home', Mode.TAKING_OFF, Mode.FLYING, Mode.HOLDING)
        ended = cut_short(flight, FlightOutcome.RETURNED_EARLY, 'told to return home')
        self._give(ended, CommandKind.RETURN, goal_enu=self._nearest_rally())

    def land(self) -> None:
        """Land at the present place.

        Raises
        ------
        CommandRefusedError
            If on the ground or landing already.
        """
        flight = self._require_mode(
            'land', Mode.TAKING_OFF, Mode.FLYING, Mode.HOLDING, Mode.RETURNING
        )
        self._give(
            cut_short(flight, FlightOutcome.RETURNED_EARLY, 'told to land'), CommandKind.LAND
        )

    def go_to(self, place_enu: Enu) -> None:
        """Fly to a place in the air and stay there; `resume` continues the flight.

        Raises
        ------
        CommandRefusedError
            If on the ground or landing, or if the way leaves the fence.
        """
        flight = self._require_mode(
            'go there', Mode.TAKING_OFF, Mode.FLYING, Mode.HOLDING, Mode.RETURNING
        )
        height_m = place_enu[2] - flight.route.home_enu[2]
        require_positive('height_m', height_m, 'm')
        here = stopped(self.airframe, self.pose_at(self.time_ns))[1].position_enu
        way = (here, *flight.route.around(here, place_enu), place_enu)
        if not self._record.fence.holds(way):
            raise CommandRefusedError('cannot go there: the way leaves the fence')
        self._give(flight, CommandKind.GO_TO, goal_enu=place_enu)

    def set_speed(self, speed_mps: float) -> None:
        """Fly at another speed until the end of the flight; it stops first.

        Raises
        ------
        CommandRefusedError
            If on the ground or landing.
        ValueError
            If it is above its own speed, or not positive.
        """
        flight = self._require_mode(
            'change its speed', Mode.TAKING_OFF, Mode.FLYING, Mode.HOLDING, Mode.RETURNING
        )
        self.airframe.at_speed(require_positive('speed_mps', speed_mps, 'm/s'))
        self._record = replace(self._record, speed_mps=speed_mps)
        self._give(flight, flight.command.kind, goal_enu=flight.command.goal_enu)

    def set_home(self, place_enu: Enu) -> None:
        """Stand at another place on the ground, and have its home there.

        Raises
        ------
        CommandRefusedError
            If it has taken off, or was told to.
        """
        if self.mode is not Mode.DISARMED:
            text = f'cannot move its home: {self.mode.value}, must be before the first take-off'
            raise CommandRefusedError(text)
        self._record = replace(self._record, home_enu=self._on_ground(place_enu))

    def push_fence(self, fence: Fence) -> None:
        """Replace the fence.

        Raises
        ------
        CommandRefusedError
            If the vehicle is outside of it, or the rest of its flight leaves it.
        """
        if not fence.holds([self.pose_at(self.time_ns).position_enu]):
            raise CommandRefusedError('is outside of this fence')
        if self.flight is not None and not self.is_idle:
            fence.require(self.flight.route, self.flight.visited)
        self._record = replace(self._record, fence=fence)

    def push_rally(self, places_enu: tuple[Enu, ...]) -> None:
        """Replace the rally points; those outside the fence are refused as ValueError."""
        if not all(self._record.fence.holds([place]) for place in places_enu):
            raise ValueError('a rally point is outside of the fence')
        self._record = replace(self._record, rally_enu=tuple(map(self._on_ground, places_enu)))

    def summary(self) -> FlightSummary | None:
        """Return the summary of the last flight; None while it runs and before the first."""
        flight = self.flight
        if flight is None or flight.outcome is None or flight.ended_ns is None:
            return None
        return FlightSummary(
            outcome=flight.outcome,
            text=flight.text,
            viewpoints_visited=flight.visited,
            distance_flown_m=self._distance_m(flight.ended_ns) - flight.take_off_distance_m,
            duration_s=(flight.ended_ns - flight.take_off_ns) / NS_PER_S,
        )

    def left(self) -> tuple[float, float]:
        """Return horizontal distance (m) and time (s) to touch-down; a hold counts as ended."""
        if self.flight is None or self._course is None:
            return 0.0, 0.0
        course = self._course
        if self.mode is Mode.HOLDING or self._is_sent_away:
            command = self._command(CommandKind.FLY, self.time_ns, self.flight.visited)
            course = Course(command, self.flight.route, self.airframe)
        left_m, left_s = course.left(self.time_ns)
        return left_m, left_s + self.waits_s

    def _beginning(self, route: FlightRoute) -> Command:
        """Return the command to fly `route` from here, after its delay.

        In the air the vehicle stands meanwhile. A change of the battery in progress is completed
        first.
        """
        command = self._command(CommandKind.FLY, self.time_ns, first_index=0)
        command = replace(command, number=0)
        if self.mode.is_airborne:
            return replace(command, hover_s=route.delay_s)
        place = command.start.position_enu
        # The height of the ground at home is that of the plan.
        start = standing((*place[:2], route.home_enu[2]), command.start.yaw_rad)
        ready_ns = self.time_ns
        if self.flight is not None and self.flight.command.number and self.mode is Mode.WAITING:
            ready_ns = self.flight.command.start_ns
        start_ns = ready_ns + round(route.delay_s * NS_PER_S)
        return replace(command, start=start, start_ns=start_ns, wait_ns=start_ns - self.time_ns)

    @property
    def _is_sent_away(self) -> bool:
        return self.flight is not None and self.flight.command.kind is CommandKind.GO_TO

    def _nearest_rally(self) -> Enu | None:
        """Return the rally point that is nearer than home and all others; None: home."""
        here = self.pose_at(self.time_ns).position_enu
        places = (self.home_enu, *self._record.rally_enu)
        nearest = min(places, key=lambda place: horizontal_m(place, here))
        return None if nearest == self.home_enu else nearest

    def _on_ground(self, place_enu: Enu) -> Enu:
        if self.surroundings is None:
            return (*place_enu[:2], self.home_enu[2])
        return on_ground(self.surroundings, place_enu)

    def _require_mode(self, what: str, *modes: Mode) -> FlightRecord:
        if self.flight is None or self.mode not in modes:
            raise CommandRefusedError(f'cannot {what}: {self.mode.value}')
        return self.flight

    def _give(
        self,
        flight: FlightRecord,
        kind: CommandKind,
        time_ns: int | None = None,
        goal_enu: Enu | None = None,
    ) -> None:
        """Put a command of `kind` in force at `time_ns`, or now."""
        command = self._command(kind, self.time_ns if time_ns is None else time_ns, flight.visited)
        self._follow(replace(flight, command=replace(command, goal_enu=goal_enu)))

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
