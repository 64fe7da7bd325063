# SPDX-License-Identifier: Apache-2.0
"""The flight that follows from a command, in simulated time."""

import math
from collections.abc import Iterator
from functools import cached_property

from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.flight.battery import low_battery_s
from rocsafe_sim.flight.commands import Command, CommandKind, timeline_of
from rocsafe_sim.flight.route import FlightRoute
from rocsafe_sim.flight.segment import FlightPose, Mode
from rocsafe_sim.flight.timeline import ShotTime


class Course:
    """The future of a vehicle as long as no other command comes.

    Attributes
    ----------
    command
        Command that it follows from.
    route
        Route of the command.
    timeline
        Motion as a function of time.
    touch_down_ns
        Time at which it stands on the ground, nanoseconds; infinite if never.
    """

    def __init__(self, command: Command, route: FlightRoute, airframe: Airframe) -> None:
        self.command = command
        self.route = route
        # A vehicle that is held on the ground never begins.
        self._begins_ns = math.inf if command.is_held else command.start_ns
        self._airframe = airframe.in_wind(command.wind_mps).at_speed(command.speed_mps)
        self.timeline = timeline_of(command, route, self._airframe)
        self._capacity_j = self._airframe.power.capacity_j
        self.touch_down_ns = self._after_start_ns(self.timeline.duration_s)

    @cached_property
    def low_ns(self) -> int | float:
        """Time at which it diverts because of its battery, nanoseconds; infinite if never.

        It costs most of a course, and is computed when it is asked for first: the answer to an
        order does not wait for it.
        """
        command = self.command
        low_s = low_battery_s(
            self._airframe,
            self.timeline,
            command.charge_fraction,
            self.route,
            command.number,
            climbs=command.kind in (CommandKind.GO_TO, CommandKind.MOVE),
        )
        return self._after_start_ns(low_s)

    def elapsed_s(self, time_ns: int) -> float:
        """Return the seconds from the command to `time_ns`; 0 before it takes effect."""
        if time_ns >= self.touch_down_ns:  # rounded to a nanosecond
            return self.timeline.duration_s
        return max(0, time_ns - self._begins_ns) / NS_PER_S

    def pose(self, time_ns: int) -> FlightPose:
        """Return the pose at `time_ns`."""
        return self.timeline.pose(self.elapsed_s(time_ns))

    def mode(self, time_ns: int) -> Mode:
        """Return the mode at `time_ns`."""
        if time_ns >= self.touch_down_ns:
            return Mode.CRASHED if self.command.kind is CommandKind.FALL else Mode.LANDED
        if time_ns < self._begins_ns:
            return Mode.WAITING
        return self.timeline.segment(self.elapsed_s(time_ns)).mode

    def charge_fraction(self, time_ns: int) -> float:
        """Return the charge left at `time_ns`, 0 to 1; on the ground none is used."""
        used = self.timeline.used_j(self.elapsed_s(time_ns)) / self._capacity_j
        return max(0.0, self.command.charge_fraction - used)

    def power_w(self, time_ns: int) -> float:
        """Return the power of the motors at `time_ns`; on the ground none."""
        if not self._begins_ns <= time_ns < self.touch_down_ns:
            return 0.0
        return self.timeline.power_w(self.elapsed_s(time_ns))

    def distance_m(self, time_ns: int) -> float:
        """Return the horizontal distance flown until `time_ns` since power-up."""
        return self.command.distance_m + self.timeline.progress_m(self.elapsed_s(time_ns))

    def left(self, time_ns: int) -> tuple[float, float]:
        """Return horizontal distance (m) and time (s) from `time_ns` to touch-down."""
        elapsed = self.elapsed_s(time_ns)
        left_m = self.timeline.distance_m - self.timeline.progress_m(elapsed)
        return left_m, max(0.0, self.timeline.duration_s - elapsed)

    def shots(self, first_index: int) -> Iterator[tuple[int, ShotTime]]:
        """Yield simulated time and photograph of each viewpoint from `first_index` on."""
        shots = () if self.command.is_held else self.timeline.shots()
        for shot in shots:
            if shot.viewpoint_index >= first_index:
                yield int(self._after_start_ns(shot.elapsed_s)), shot

    def _after_start_ns(self, elapsed_s: float) -> int | float:
        if math.isinf(elapsed_s) or self.command.is_held:
            return math.inf
        return self.command.start_ns + round(elapsed_s * NS_PER_S)
