# SPDX-License-Identifier: Apache-2.0
"""A simulated multirotor: takes commands and refuses those that it cannot carry out.

It has no sensors, writes no files and knows nothing of ROS: see `rocsafe_sim.rav.rav`.
"""

from dataclasses import replace

from rocsafe_geo.limits import require_positive
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.flight.commands import Command, CommandKind
from rocsafe_sim.flight.course import Course
from rocsafe_sim.flight.fence import Fence
from rocsafe_sim.flight.route import FlightRoute, horizontal_m
from rocsafe_sim.flight.segment import Mode, standing
from rocsafe_sim.flight.tasks import stopped
from rocsafe_sim.vehicle.flight_ends import (
    cut_short,
    require_ready,
)
from rocsafe_sim.vehicle.flight_record import FlightOutcome, FlightRecord
from rocsafe_sim.vehicle.flying_vehicle import FlyingVehicle
from rocsafe_sim.vehicle.snapshot import FlightSummary
from rocsafe_sim.vehicle.surroundings import grounded, on_ground

# On the ground, with nothing to come.
_DOWN = frozenset({Mode.DISARMED, Mode.LANDED, Mode.CRASHED})
_STANDING = _DOWN | {Mode.HOLDING}
# Command with which a held flight continues, by its ending; all others return home.
_RESUMED = {
    FlightOutcome.COMPLETED: CommandKind.FLY,
    FlightOutcome.BATTERY_LOW: CommandKind.DIVERT,
}


class SimulatedVehicle(FlyingVehicle):
    """A vehicle without sensors. Commands take effect at the time of the last step."""

    @property
    def ends_early(self) -> bool:
        """Whether its flight ends, or has ended, otherwise than planned."""
        ending = FlightOutcome.COMPLETED if self.flight is None else self.flight.ending
        return ending is not FlightOutcome.COMPLETED

    def fly_route(self, route: FlightRoute, *, replaces: bool = False) -> None:
        """Fly `route`. The route of the running or the last flight is not begun again.

        If that flight was cancelled, it continues; if it is held, it stays so until `resume`. With
        `replaces` the route replaces another one that is being flown, from the place of the
        vehicle.

        Raises
        ------
        CommandRefusedError
            If another flight runs, home is elsewhere, or the charge is too low.
        """
        if self.surroundings is not None:
            route = grounded(route, self.surroundings)
        flight = self.flight
        if flight is not None and flight.route == route:
            if self.mode is Mode.HOLDING and flight.outcome is FlightOutcome.CANCELLED:
                self._require_clear(route, flight.visited, flight.command.number)
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
        self._require_clear(route)
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
        """Hold until the next command: in the air, or where it waits on the ground.

        Where it stands anyway, nothing changes.

        Raises
        ------
        CommandRefusedError
            If landing or falling.
        """
        if self.mode in _STANDING:
            return
        flight = self._require_mode(
            'hold', Mode.WAITING, Mode.TAKING_OFF, Mode.FLYING, Mode.RETURNING
        )
        if self.mode is Mode.WAITING:
            self._follow(replace(flight, command=replace(flight.command, is_held=True)))
        else:
            self._give(flight, CommandKind.HOLD)

    def resume(self) -> None:
        """Continue a held flight; one that was held on the ground begins when it was due, or now.

        If it flies its route anyway, or waits to, nothing changes.

        Raises
        ------
        CommandRefusedError
            If it does neither, or if the flight was cancelled.
        """
        if self._is_held_down:
            self._release()
            return
        flight = self._require_mode(
            'resume', Mode.WAITING, Mode.HOLDING, Mode.TAKING_OFF, Mode.FLYING
        )
        if self.mode is not Mode.HOLDING and not self._is_sent_away:
            return
        if flight.outcome is not None:
            raise CommandRefusedError('cannot resume: the flight was cancelled, send a route')
        if not flight.route.waypoints:
            raise CommandRefusedError('cannot resume: it flies no route')
        if flight.ending is FlightOutcome.COMPLETED:
            self._require_clear(flight.route, flight.visited, flight.command.number)
        self._give(flight, _RESUMED.get(flight.ending, CommandKind.RETURN))

    def return_home(self) -> None:
        """End the route, fly home or to the nearest rally point, and land.

        On the ground it stays there. If it returns anyway, nothing changes.

        Raises
        ------
        CommandRefusedError
            If it is landing or falling.
        """
        if self.mode in _DOWN or self.mode is Mode.RETURNING:
            return
        flight = self._require_mode(
            'return home', Mode.WAITING, Mode.TAKING_OFF, Mode.FLYING, Mode.HOLDING
        )
        ended = cut_short(flight, FlightOutcome.RETURNED_EARLY, 'told to return home')
        if self.mode is Mode.WAITING:
            self._give(ended, CommandKind.LAND)
        else:
            self._give(ended, CommandKind.RETURN, goal_enu=self._nearest_rally())

    def land(self) -> None:
        """Land at the present place.

        On the ground it stays there. If it lands anyway, nothing changes.

        Raises
        ------
        CommandRefusedError
            If it is falling.
        """
        if self.mode in _DOWN or self.mode is Mode.LANDING:
            return
        flight = self._require_mode(
            'land', Mode.WAITING, Mode.TAKING_OFF, Mode.FLYING, Mode.HOLDING, Mode.RETURNING
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
        if flight.route.crossed(way):
            raise CommandRefusedError('cannot go there: no way around the exclusions')
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
        command = flight.command
        if command.kind is CommandKind.MOVE:
            raise CommandRefusedError('cannot change its speed: it flies at a commanded velocity')
        self.airframe.at_speed(require_positive('speed_mps', speed_mps, 'm/s'))
        self._record = replace(self._record, speed_mps=speed_mps)
        self._give(
            flight,
            command.kind,
            goal_enu=command.goal_enu,
            via_enu=command.via_enu,
            yaw_rad=command.yaw_rad,
        )

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
    def _is_held_down(self) -> bool:
        return self.flight is not None and self.flight.command.is_held

    def _release(self) -> None:
        """Let a flight that was held on the ground begin when it was due, or now."""
        if self.flight is None:
            return
        flight, command = self.flight, self.flight.command
        start_ns = max(command.start_ns, self.time_ns)
        wait_ns = start_ns - self.time_ns
        released = replace(command, is_held=False, start_ns=start_ns, wait_ns=wait_ns)
        # The time to a failure of the battery counts from the first take-off.
        is_first = flight.take_off_ns == command.start_ns
        take_off_ns = start_ns if is_first else flight.take_off_ns
        self._follow(replace(flight, command=released, take_off_ns=take_off_ns))

    @property
    def _is_sent_away(self) -> bool:
        kinds = (CommandKind.GO_TO, CommandKind.MOVE)
        return self.flight is not None and self.flight.command.kind in kinds

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

    def _require_clear(self, route: FlightRoute, index: int = 0, number: int = 0) -> None:
        """Refuse to fly what is left of a route from here if an exclusion lies on the way."""
        here = stopped(self.airframe, self.pose_at(self.time_ns))[1].position_enu
        fault = route.fault(here, index, number)
        if fault:
            raise CommandRefusedError(f'cannot fly the route from here: {fault}')

    def _require_mode(self, what: str, *modes: Mode) -> FlightRecord:
        if self.flight is None or self.mode not in modes:
            raise CommandRefusedError(f'cannot {what}: {self.mode.value}')
        return self.flight
