# SPDX-License-Identifier: Apache-2.0
"""A flight as a function of time, past or future."""

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from rocsafe_geo.motion.battery import Discharge
from rocsafe_geo.motion.route_motion import RouteMotion, Way
from rocsafe_geo.motion.state import Motion, MotionState
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.flight.segment import FlightPose, Mode, Segment


@dataclass(frozen=True, slots=True)
class ShotTime:
    """A photograph at a viewpoint, `elapsed_s` seconds after the start of the timeline."""

    elapsed_s: float
    viewpoint_index: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """A leg with the stand at its end, and its purpose.

    Attributes
    ----------
    way
        Leg and stand.
    mode
        Mode of the vehicle meanwhile.
    yaw_rad
        Yaw at its end.
    viewpoint_index
        Index in the route of the viewpoint flown to; None on the way home.
    takes_shot
        Whether its end is photographed.
    """

    way: Way
    mode: Mode
    yaw_rad: float
    viewpoint_index: int | None = None
    takes_shot: bool = False


class Timeline:
    """A lead motion, mostly a stop, if the vehicle moves, then tasks one after the other.

    Elapsed times are seconds since the start. Before the start the vehicle is at its begin, after
    the last task at its end.

    Parameters
    ----------
    airframe
        Performance of the vehicle.
    start
        Pose at time 0.
    stop
        Motion from that pose to standstill; None if it stands.
    tasks
        Tasks, at least one; they begin where the stop ends.
    lead_yaws
        Times within the stop, seconds, and the yaw at each, rad, in order; the yaw stays from the
        last on. Less than half a turn lies between two.
    """

    def __init__(
        self,
        airframe: Airframe,
        start: FlightPose,
        stop: Motion | None,
        tasks: Sequence[Task],
        *,
        lead_yaws: Sequence[tuple[float, float]] = (),
    ) -> None:
        self._airframe = airframe
        self._stop = stop
        self._stop_s = 0.0 if stop is None else stop.duration_s
        at = start.position_enu if stop is None else stop.state(self._stop_s).position_enu
        radius = airframe.performance.corner_radius_m
        self._route = RouteMotion(at, [task.way for task in tasks], radius)
        self.segments = tuple(self._segments(start.yaw_rad, lead_yaws, tasks))
        self._ends = [segment.end_s for segment in self.segments]

    @property
    def duration_s(self) -> float:
        """Time of the end, seconds; infinite for a stand without end."""
        return self._stop_s + self._route.duration_s

    @property
    def stands_from_s(self) -> float:
        """Begin of a stand without end, seconds; infinite if there is none."""
        last = self.segments[-1]
        return last.begin_s if math.isinf(last.end_s) else math.inf

    @property
    def distance_m(self) -> float:
        """Horizontal distance flown in all."""
        return self._stop_m + self._route.distance_m

    def pose(self, elapsed_s: float) -> FlightPose:
        """Return the pose at a time."""
        state = self._state(elapsed_s)
        return FlightPose(
            position_enu=state.position_enu,
            velocity_enu=state.velocity_enu,
            yaw_rad=self.segment(elapsed_s).yaw_rad(elapsed_s),
            acceleration_enu=state.acceleration_enu,
        )

    def segment(self, elapsed_s: float) -> Segment:
        """Return the segment at a time."""
        return self.segments[min(bisect_right(self._ends, elapsed_s), len(self._ends) - 1)]

    def progress_m(self, elapsed_s: float) -> float:
        """Return the horizontal distance flown until a time."""
        if self._stop is not None and elapsed_s < self._stop_s:
            return self._stop.progress_m(elapsed_s)
        return self._stop_m + self._route.progress_m(elapsed_s - self._stop_s)

    def used_j(self, elapsed_s: float) -> float:
        """Return the energy that the motors have used until a time."""
        first, second = self._discharges
        used = 0.0 if first is None else first.used_j(min(elapsed_s, self._stop_s))
        return used + second.used_j(max(0.0, elapsed_s - self._stop_s))

    def power_w(self, elapsed_s: float) -> float:
        """Return the power of the motors at a time."""
        first, second = self._discharges
        if first is not None and elapsed_s < self._stop_s:
            return first.power_w(elapsed_s)
        return second.power_w(elapsed_s - self._stop_s)

    def shots(self) -> Iterator[ShotTime]:
        """Yield the photographs of this timeline, in order of time."""
        for segment in self.segments:
            if segment.takes_shot and segment.viewpoint_index is not None:
                yield ShotTime(segment.end_s, segment.viewpoint_index)

    def first_start_s(self, *modes: Mode) -> float:
        """Return the begin of the first segment in one of `modes`; infinite if there is none."""
        begins = (segment.begin_s for segment in self.segments if segment.mode in modes)
        return next(begins, math.inf)

    @cached_property
    def _stop_m(self) -> float:
        return 0.0 if self._stop is None else self._stop.distance_m

    @cached_property
    def _discharges(self) -> tuple[Discharge | None, Discharge]:
        def discharge(motion: Motion) -> Discharge:
            return Discharge(motion, self._airframe.power, self._airframe.performance.wind_mps)

        first = None if self._stop is None else discharge(self._stop)
        return first, discharge(self._route)

    def _state(self, elapsed_s: float) -> MotionState:
        if self._stop is not None and elapsed_s < self._stop_s:
            return self._stop.state(elapsed_s)
        return self._route.state(elapsed_s - self._stop_s)

    def _segments(
        self, yaw: float, lead_yaws: Sequence[tuple[float, float]], tasks: Sequence[Task]
    ) -> Iterator[Segment]:
        now = 0.0
        for time_s, next_yaw in lead_yaws:
            yield _segment(tasks[0], now, time_s, (yaw, next_yaw))
            now, yaw = time_s, next_yaw
        if self._stop is not None and now < self._stop_s:
            yield _segment(tasks[0], now, self._stop_s, (yaw, yaw))
        now = self._stop_s
        times = zip(self._route.arrivals_s, self._route.departures_s, strict=True)
        for task, (arrival, departure) in zip(tasks, times, strict=True):
            arrives, departs = self._stop_s + arrival, self._stop_s + departure
            has_stand = departs > arrives
            shoots = task.takes_shot
            # A vehicle that goes nowhere turns while it stands; photographs are as commanded.
            stand_yaw = yaw if arrives == now and not shoots else task.yaw_rad
            yield _segment(task, now, arrives, (yaw, stand_yaw), shoots and not has_stand)
            if has_stand:
                yield _segment(task, arrives, departs, (stand_yaw, task.yaw_rad), shoots)
            now, yaw = departs, task.yaw_rad


def _segment(
    task: Task,
    begin_s: float,
    end_s: float,
    yaws_rad: tuple[float, float],
    takes_shot: bool = False,
) -> Segment:
    return Segment(
        mode=task.mode,
        begin_s=begin_s,
        end_s=end_s,
        yaw_start_rad=yaws_rad[0],
        yaw_end_rad=yaws_rad[1],
        viewpoint_index=task.viewpoint_index,
        takes_shot=takes_shot,
    )
