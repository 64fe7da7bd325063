# SPDX-License-Identifier: Apache-2.0
"""A simulated multirotor that flies freely, without a route: along places and at velocities."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from rocsafe_geo.angle import wrap_rad
from rocsafe_geo.limits import (
    require_between,
    require_finite,
    require_not_negative,
    require_positive,
)
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.flight.commands import CommandKind
from rocsafe_sim.flight.course import Course
from rocsafe_sim.flight.route import FlightRoute, require_enu
from rocsafe_sim.flight.segment import Mode
from rocsafe_sim.flight.tasks import stopped
from rocsafe_sim.flight.timeline import Timeline
from rocsafe_sim.vehicle.flight_ends import BROKEN
from rocsafe_sim.vehicle.flight_record import FlightRecord
from rocsafe_sim.vehicle.simulated_vehicle import SimulatedVehicle

LONGEST_S = 3600.0
# Far above what multirotors turn at.
FASTEST_TURN_RADPS = 2.0 * math.pi
_IN_THE_AIR = (Mode.TAKING_OFF, Mode.FLYING, Mode.HOLDING, Mode.RETURNING)
_ON_GROUND = (Mode.DISARMED, Mode.LANDED)


class FreeVehicle(SimulatedVehicle):
    """A vehicle that also takes orders of single movements; after each it stands in the air."""

    def fly_along(self, places_enu: Sequence[Enu], speed_mps: float = 0.0) -> None:
        """Fly along places in the air, and stay at the last; on the ground it takes off first.

        Parameters
        ----------
        places_enu
            At least one, metres.
        speed_mps
            Speed over ground until the end of the flight, at most its own; 0: as before.

        Raises
        ------
        CommandRefusedError
            If landing or waiting, if the battery is too low, if it was in an accident, or if the
            way leaves the fence or crosses an exclusion.
        ValueError
            If a place is not above home, or the speed is negative.
        """
        places = tuple(places_enu)
        if not places:
            raise ValueError('places: there must be one at least')
        flight = self._flight_for('fly there')
        for place in places:
            require_enu('place', place)
            require_positive('height_m', place[2] - flight.route.home_enu[2], 'm')
        require_not_negative('speed_mps', speed_mps, 'm/s')
        here = stopped(self.airframe, self.pose_at(self.time_ns))[1].position_enu
        way = [here]
        for place in places:
            way += [*flight.route.around(way[-1], place), place]
        self._require_free(flight, way)
        if speed_mps:
            own_mps = self.airframe.performance.cruise_speed_mps
            self._record = replace(self._record, speed_mps=min(speed_mps, own_mps))
        self._move(flight, CommandKind.GO_TO, goal_enu=places[-1], via_enu=places[:-1])

    def fly_at(
        self,
        velocity_enu: Enu,
        flown_s: float,
        turn_rate_radps: float = 0.0,
        yaw_rad: float | None = None,
    ) -> None:
        """Fly at a velocity for some time, turning meanwhile, and then stop.

        Parameters
        ----------
        velocity_enu
            Metres per second; what exceeds its own speeds is limited to them.
        flown_s
            Up to an hour; the stop comes after it.
        turn_rate_radps
            Yaw rate meanwhile, anticlockwise from above.
        yaw_rad
            Yaw to turn to instead, rad, ENU; None: it turns at the rate.

        Raises
        ------
        CommandRefusedError
            If on the ground, or as `fly_along`.
        ValueError
            If a value is out of its range.
        """
        flight = self._require_mode('fly at a velocity', *_IN_THE_AIR)
        velocity_enu = self._limited(velocity_enu)
        require_between('duration_s', flown_s, 0.0, LONGEST_S, 's')
        fastest = FASTEST_TURN_RADPS
        require_between('turn_rate_radps', turn_rate_radps, -fastest, fastest, 'rad/s')
        if yaw_rad is not None:
            require_finite('yaw_rad', yaw_rad)
        aims: dict[str, Any] = {
            'velocity_enu': velocity_enu,
            'flown_s': flown_s,
            'turn_rate_radps': turn_rate_radps,
            'yaw_rad': yaw_rad,
        }
        command = replace(self._command(CommandKind.MOVE, self.time_ns, flight.visited), **aims)
        course = Course(command, flight.route, self.airframe)
        if isinstance(course.timeline, Timeline):
            end_s = course.timeline.segments[-1].begin_s
            way = [course.timeline.pose(end_s * n / 16.0).position_enu for n in range(17)]
            self._require_free(flight, way)
        self._move(flight, CommandKind.MOVE, **aims)

    def turn_to(self, yaw_rad: float) -> None:
        """Stop, and turn to a yaw (rad, ENU) at the place.

        Raises
        ------
        CommandRefusedError
            If on the ground or landing.
        """
        flight = self._require_mode('turn', *_IN_THE_AIR)
        require_finite('yaw_rad', yaw_rad)
        here = stopped(self.airframe, self.pose_at(self.time_ns))[1].position_enu
        self._move(flight, CommandKind.GO_TO, goal_enu=here, yaw_rad=wrap_rad(yaw_rad))

    def set_wind(self, wind_mps: tuple[float, float]) -> None:
        """Fly in another wind, east and north, m/s; a flight under way stops, and goes on in it.

        A landing is not changed.

        Raises
        ------
        ValueError
            If it could not fly in so much wind.
        """
        self.airframe.in_wind(wind_mps)
        self._record = replace(self._record, wind_mps=wind_mps)
        flight = self.flight
        if flight is None or self.mode not in (Mode.WAITING, *_IN_THE_AIR):
            return
        command = flight.command
        if self.mode is Mode.WAITING:
            self._follow(replace(flight, command=replace(command, wind_mps=wind_mps)))
            return
        flown_s = (self.time_ns - command.start_ns) / NS_PER_S
        self._give(
            flight,
            command.kind,
            goal_enu=command.goal_enu,
            via_enu=command.via_enu,
            velocity_enu=command.velocity_enu,
            flown_s=max(0.0, command.flown_s - flown_s),
            turn_rate_radps=command.turn_rate_radps,
            yaw_rad=command.yaw_rad,
        )

    def _flight_for(self, what: str) -> FlightRecord:
        """Return the flight under way, or a new one without a route."""
        mode = self.mode
        if mode not in _ON_GROUND:
            return self._require_mode(what, *_IN_THE_AIR)
        if self.flight is not None and self.flight.ending in BROKEN:
            raise CommandRefusedError(f'cannot {what}: {self.flight.text}')
        command = replace(self._command(CommandKind.GO_TO, self.time_ns, 0), number=0)
        return FlightRecord(
            route=FlightRoute(plan_id='', home_enu=command.start.position_enu, waypoints=()),
            command=command,
            take_off_ns=command.start_ns,
            take_off_distance_m=command.distance_m,
        )

    def _move(self, flight: FlightRecord, kind: CommandKind, **aims: Any) -> None:
        """Put a movement in force, unless its battery would end it at once."""
        command = replace(self._command(kind, self.time_ns, flight.visited), **aims)
        if Course(command, flight.route, self.airframe).low_ns <= command.start_ns:
            raise CommandRefusedError(
                f'battery {command.charge_fraction:.0%}: must be more, to keep a reserve of '
                f'{self.airframe.reserve_fraction:.0%}'
            )
        self._follow(replace(flight, command=command))

    def _require_free(self, flight: FlightRecord, way: Sequence[Enu]) -> None:
        if not self._record.fence.holds(way):
            raise CommandRefusedError('cannot fly there: the way leaves the fence')
        if flight.route.crossed(tuple(way)):
            raise CommandRefusedError('cannot fly there: the way crosses an exclusion')

    def _limited(self, velocity_enu: Enu) -> Enu:
        """Return a velocity of the same direction over ground, within its own speeds."""
        require_enu('velocity_enu', velocity_enu)
        performance, (east, north, up) = self.airframe.performance, velocity_enu
        share = min(1.0, performance.cruise_speed_mps / max(math.hypot(east, north), 1e-9))
        up = min(max(up, -performance.descent_rate_mps), performance.climb_rate_mps)
        return share * east, share * north, up
