# SPDX-License-Identifier: Apache-2.0
"""Motion of a simulated ground vehicle, in ticks of its own.

The step of the simulation therefore does not change a drive.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

from rocsafe_geo.motion.ground_motion import Place
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.driving.drive_route import RouteStop
from rocsafe_sim.driving.drive_state import DriveMode, DriveOutcome, DriveState
from rocsafe_sim.driving.rover_parts import EvidenceShot, RoverParts
from rocsafe_sim.driving.steering import (
    ARRIVED_M,
    Line,
    along,
    is_aligned,
    pivoted,
    speed_mps,
    turn_rate_radps,
)
from rocsafe_sim.driving.way_back import Mark, WayBack

TICK_NS = 100_000_000
TICK_S = TICK_NS / NS_PER_S
# Something that stands ahead is seen so far beyond the distance in which the vehicle stops.
SEEN_BEYOND_M = 0.6
# Distance between the places ahead that are looked at.
AHEAD_STEP_M = 0.3
# A vehicle that looks so far away from its line stops before it turns.
WRONG_WAY_RAD = math.radians(60.0)
# The picture is taken after so much of the stand.
SHOT_SHARE = 0.5


class RoverMotion:
    """Follows its way, stands at evidence, stops before obstacles; `Rover` gives it commands.

    Parameters
    ----------
    parts
        What it is made of.
    state
        At power-up, or from a journal.

    Attributes
    ----------
    state
        At the last tick.
    changes
        Number of commands, stands and ends so far: what a journal must not lose.
    """

    def __init__(self, parts: RoverParts, state: DriveState) -> None:
        self.parts = parts
        self.state = state
        self.changes = 0
        self._way = WayBack(state.way or (Mark(east_m=state.east_m, north_m=state.north_m,
                                               limit_mps=0.5),))  # fmt: skip
        self._back: tuple[RouteStop, ...] = ()
        self._speeds: list[float] = []
        self._shots: list[EvidenceShot] = []
        self._is_at_stop = False
        if state.mode is DriveMode.RETURNING or state.held_mode is DriveMode.RETURNING:
            self._turn_round()
        self._plan_speeds()

    @property
    def is_idle(self) -> bool:
        """Whether nothing happens until the next command."""
        return not self.state.mode.is_moving and self.state.speed_mps == 0.0

    @property
    def is_over(self) -> bool:
        """Whether the last drive has ended."""
        return self.state.ledger.ended_ns > 0

    @property
    def home(self) -> Place:
        """Place to which it comes back."""
        return self._way.marks[0].place

    @property
    def stops(self) -> tuple[RouteStop, ...]:
        """What is being followed: the route, or the way back."""
        if self.state.mode is DriveMode.RETURNING or (
            self.state.mode is DriveMode.HOLDING and self.state.held_mode is DriveMode.RETURNING
        ):
            return self._back
        return () if self.state.route is None else self.state.route.stops

    def step(self, time_ns: int) -> list[EvidenceShot]:
        """Advance to `time_ns` and return the photographs that are due.

        Raises
        ------
        ValueError
            If time runs backwards.
        """
        if time_ns < self.state.time_ns:
            raise ValueError(f'time_ns is {time_ns}: must be {self.state.time_ns} or later')
        if self.is_idle or self.state.time_ns == 0:
            self.state.time_ns = time_ns - time_ns % TICK_NS
            self._spend(TICK_S if not self.is_idle else 0.0)
        while self.state.time_ns + TICK_NS <= time_ns:
            self.state.time_ns += TICK_NS
            self._tick()
        self.state.way = tuple(self._way.marks)
        shots, self._shots = self._shots, []
        return shots

    def measured_place(self) -> Place:
        """Return where its receiver says that it is."""
        error = self.parts.noise.gps_error_m(self.state.time_ns)
        return self.state.east_m + error[0], self.state.north_m + error[1]

    def left(self) -> tuple[float, float]:
        """Return distance (m) and predicted time (s) to the end of the route."""
        stops, k = self.stops, self.state.next_stop
        if not self.state.mode.is_moving or k >= len(stops):
            return 0.0, 0.0
        rest = stops[k:]
        places = [self.state.place, *(stop.place for stop in rest)]
        length = sum(math.dist(a, b) for a, b in pairwise(places))
        return length, sum(stop.predicted_s for stop in rest)

    def predicted_usv(self) -> float:
        """Return the dose that was predicted for the way so far."""
        stops, k = self.stops, self.state.next_stop
        done = self.state.ledger.predicted_usv
        if self.state.mode is not DriveMode.DRIVING or k >= len(stops):
            return done
        stop = stops[k]
        length = max(math.dist(stops[k - 1].place, stop.place), 1e-6)
        share = 1.0 - min(math.dist(self.state.place, stop.place) / length, 1.0)
        line_s = max(stop.predicted_s, stop.dwell_s, 1e-9)
        stood = min(self.state.stood_s, stop.dwell_s) if self.state.is_standing else 0.0
        return done + stop.predicted_usv * (
            stood / line_s + share * max(line_s - stop.dwell_s, 0.0) / line_s
        )

    def _tick(self) -> None:
        state = self.state
        if state.mode.is_moving and not state.is_standing:
            self._drive_on()
        elif state.mode.is_moving:
            self._stand()
        else:
            braked = state.speed_mps - 2.0 * self.parts.chassis.motion.acceleration_mps2 * TICK_S
            self._move(max(0.0, braked), 0.0)
        self._spend(TICK_S)

    def _drive_on(self) -> None:
        """Turn in place, or follow the line to the next stop."""
        state, place = self.state, self.measured_place()
        chassis, motion = self.parts.chassis, self.parts.chassis.motion
        line = self._line(self.stops)
        # A stop that is driven through takes no time.
        while (left := line.left_m(place)) <= ARRIVED_M or line.length_m <= ARRIVED_M:
            self._arrive(self.stops[state.next_stop])
            if state.is_standing or not state.mode.is_moving:
                return
            line = self._line(self.stops)
        off = abs(math.remainder(line.yaw_rad - state.yaw_rad, math.tau))
        braked = state.speed_mps - 2.0 * motion.acceleration_mps2 * TICK_S
        if off > WRONG_WAY_RAD and braked > 0.0:
            self._move(braked, 0.0)
            return
        if off > 0.5 * math.pi and state.mode is DriveMode.RETURNING:
            # It leaves at once: a turn would cost a dose.
            state.speed_mps = 0.0
            state.back()
        elif off > 0.5 * motion.pivot_rad and braked <= 0.0:
            state.speed_mps = 0.0
            state.yaw_rad = pivoted(state.yaw_rad, line.yaw_rad, motion, TICK_S)
            return
        fastest = chassis.fastest_mps(self._grade())
        if fastest < line.limit_mps:
            line = replace(line, limit_mps=fastest, end_mps=min(line.end_mps, fastest))
        speed = speed_mps(line, left, state.speed_mps, motion, TICK_S)
        if self._is_blocked(line.yaw_rad):
            return
        rate = turn_rate_radps(line, place, state.yaw_rad, max(speed, 0.1), motion)
        self._move(speed, rate)

    def _line(self, stops: tuple[RouteStop, ...]) -> Line:
        k = self.state.next_stop
        end_mps = self._speeds[k]
        return Line(
            begin=stops[k - 1].place, end=stops[k].place, limit_mps=stops[k].limit_mps,
            end_mps=end_mps,
        )  # fmt: skip

    def _move(self, speed: float, rate: float) -> None:
        """Move for a tick: the ground takes some of the speed, and pushes aside."""
        state, before = self.state, self.state.place
        slip, drift = self.parts.skid.at(state.time_ns)
        state.yaw_rad = math.remainder(state.yaw_rad + rate * TICK_S, math.tau)
        state.speed_mps = speed
        along, aside = speed * (1.0 - slip) * TICK_S, speed * drift * TICK_S
        cos, sin = math.cos(state.yaw_rad), math.sin(state.yaw_rad)
        state.east_m += along * cos - aside * sin
        state.north_m += along * sin + aside * cos
        step = math.dist(before, state.place)
        state.odometer_m += step
        state.ledger.distance_m += 0.0 if self.is_over else step
        if state.mode is DriveMode.DRIVING and speed > 0.0:
            limit = self.stops[state.next_stop].limit_mps
            self._way.note(self.measured_place(), limit, TICK_S)
        thing = self.parts.touched(state.place) if speed > 0.0 else ''
        if thing:
            state.speed_mps = 0.0
            self._end(DriveOutcome.COLLISION, f'drove into {thing}', DriveMode.CRASHED)

    def _arrive(self, stop: RouteStop) -> None:
        """Stand at a stop, or go on to the next one."""
        if self._speeds[self.state.next_stop] <= 0.0:
            self.state.speed_mps = 0.0
        if stop.is_stand:
            self.state.is_standing, self.state.stood_s = True, 0.0
            self.changes += 1
            return
        self._go_on(stop)

    def _stand(self) -> None:
        """Look at the evidence, photograph it, and drive on when the time is over."""
        state, stop = self.state, self.stops[self.state.next_stop]
        if not is_aligned(state.yaw_rad, stop.look_rad):
            motion = self.parts.chassis.motion
            state.yaw_rad = pivoted(state.yaw_rad, stop.look_rad, motion, TICK_S)
        before = state.stood_s
        state.stood_s += TICK_S
        due = SHOT_SHARE * stop.dwell_s
        is_new = stop.evidence and stop.evidence not in state.ledger.evidence
        if is_new and before <= due < state.stood_s:
            self._photograph(stop)
        if state.stood_s >= stop.dwell_s and is_aligned(state.yaw_rad, stop.look_rad):
            state.is_standing = False
            self._go_on(stop)

    def _photograph(self, stop: RouteStop) -> None:
        state = self.state
        self._shots.append(
            EvidenceShot(
                sequence=state.shots, evidence=stop.evidence, stop=state.next_stop,
                time_ns=state.time_ns, place=state.place, yaw_rad=state.looks_rad,
            )
        )  # fmt: skip
        state.shots += 1
        state.ledger.evidence = (*state.ledger.evidence, stop.evidence)
        self.changes += 1

    def _go_on(self, stop: RouteStop) -> None:
        state = self.state
        self._is_at_stop = True
        state.ledger.predicted_usv += stop.predicted_usv
        if state.next_stop + 1 < len(self.stops):
            state.next_stop += 1
            return
        outcome = state.ledger.outcome or DriveOutcome.COMPLETED
        state.speed_mps = 0.0
        self._end(outcome, state.ledger.text, DriveMode.ARRIVED)

    def _is_blocked(self, yaw_rad: float) -> bool:
        """Return whether something stands on the way ahead; the vehicle stops before it."""
        if self.parts.surroundings is None:
            return False
        for ahead, line_rad in self._ahead():
            if thing := self.parts.in_the_way(ahead, line_rad):
                break
        else:
            return False
        things = self.parts.things_beside(ahead) or (ahead,)
        seen = self.parts.seen_from(self.state.place, yaw_rad)
        self.state.ledger.blocked = (*things, *seen)
        self._end(DriveOutcome.BLOCKED, f'{thing} stands in the way', DriveMode.HOLDING)
        return True

    def _ahead(self) -> Iterator[tuple[Place, float]]:
        """Yield places on the way in which it stops and the direction of the way there.

        Also around the next bends.
        """
        stopping = self.state.speed_mps**2 / (4.0 * self.parts.chassis.motion.acceleration_mps2)
        reach, here = stopping + SEEN_BEYOND_M, self.state.place
        for stop in self.stops[self.state.next_stop :]:
            length = min(math.dist(here, stop.place), reach)
            count = math.ceil(length / AHEAD_STEP_M)
            yaw_rad = math.atan2(stop.north_m - here[1], stop.east_m - here[0])
            for k in range(1, count + 1):
                yield along(here, stop.place, k * length / count), yaw_rad
            reach, here = reach - length, stop.place
            if reach <= 0.0:
                return

    def _turn_round(self) -> None:
        """Make the way back a way to follow."""
        marks = self._way.homeward
        here = self.state.place
        stops = [RouteStop(east_m=here[0], north_m=here[1])]
        stops += [
            RouteStop(east_m=m.east_m, north_m=m.north_m, limit_mps=max(m.limit_mps, 0.1))
            for m in marks
            if math.dist((m.east_m, m.north_m), here) > ARRIVED_M or m is marks[-1]
        ]
        self._back = tuple(stops)

    def _begin(self, mode: DriveMode) -> None:
        state = self.state
        state.mode, state.next_stop = mode, 1
        state.is_standing, state.stood_s = False, 0.0
        self._is_at_stop = False
        self._plan_speeds()
        self.changes += 1

    def _plan_speeds(self) -> None:
        stops = self.stops
        if stops:
            self._speeds = self.parts.chassis.motion.corner_speeds_mps(
                [stop.place for stop in stops],
                [stop.limit_mps for stop in stops],
                [stop.is_stand for stop in stops],
            )

    def _end(self, outcome: DriveOutcome, text: str, mode: DriveMode) -> None:
        ledger = self.state.ledger
        ledger.outcome, ledger.text = outcome, text
        ledger.ended_ns = self.state.time_ns
        self.state.mode = mode
        self.state.is_standing = False
        self.changes += 1

    def _grade(self) -> float:
        """Return the slope ahead, rise over run."""
        if self.parts.surroundings is None:
            return 0.0
        state = self.state
        ahead = (state.east_m + math.cos(state.yaw_rad), state.north_m + math.sin(state.yaw_rad))
        return self.parts.ground_up_m(ahead) - self.parts.ground_up_m(state.place)

    def _spend(self, seconds: float) -> None:
        power = self.parts.chassis.power_w(self.state.speed_mps, self._grade())
        self.state.charge_j = max(0.0, self.state.charge_j - power * seconds)
