# SPDX-License-Identifier: Apache-2.0
"""State of a running mission, gathered from the messages of the nodes."""

import math
from dataclasses import dataclass, field
from enum import IntEnum

from rocsafe_geo.position import GeoPosition
from rocsafe_orchestrator.mission.phase import Phase


class FlightState(IntEnum):
    """State of a vehicle; numbers are those of ``VehicleState.msg``."""

    UNKNOWN = 0
    DISARMED = 1
    ARMED = 2
    TAKING_OFF = 3
    FLYING = 4
    HOLDING = 5
    RETURNING = 6
    LANDING = 7
    LANDED = 8
    LOST = 9
    CRASHED = 10
    WAITING = 11

    @property
    def is_in_air(self) -> bool:
        """True from take-off to touch-down."""
        return FlightState.TAKING_OFF <= self <= FlightState.LANDING

    @property
    def has_left(self) -> bool:
        """True once the vehicle has taken off, wherever it is now."""
        is_flying = FlightState.TAKING_OFF <= self <= FlightState.LANDED
        return is_flying or self is FlightState.CRASHED


GROUNDED = frozenset(
    {FlightState.DISARMED, FlightState.WAITING, FlightState.LANDED, FlightState.CRASHED}
)
# A vehicle that holds counts as still below this speed.
STILL_MPS = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleStatus:
    """Latest state of one vehicle; `time_s` is its stamp, seconds since the epoch."""

    name: str
    state: FlightState = FlightState.UNKNOWN
    time_s: float = math.nan
    viewpoint_count: int = 0
    viewpoints_visited: int = 0
    shots_taken: int = 0
    shots_pending: int = 0
    battery_fraction: float = math.nan
    plan_id: str = ''
    position: GeoPosition | None = None
    speed_mps: float = math.nan

    @property
    def is_still(self) -> bool:
        """Whether it does not move, in the air or on the ground."""
        if self.state is FlightState.HOLDING:
            return self.speed_mps < STILL_MPS
        return self.state in GROUNDED


@dataclass(frozen=True, slots=True, kw_only=True)
class DosePeak:
    """The highest dose rate so far, microsievert per hour, and who measured it where."""

    dose_rate_usvh: float
    vehicle: str
    position: GeoPosition


@dataclass(frozen=True, slots=True, kw_only=True)
class RunStatus:
    """A mission at one moment.

    Attributes
    ----------
    text
        Why the mission failed or was cancelled, empty if neither.
    images_expected
        Photographs of all plans that are flown one after the other.
    viewpoints_planned, viewpoints_visited
        Viewpoints of the present plan, and those of them that were visited.
    flight_time_s
        Simulated or real seconds from the first take-off to the last touch-down so far.
    wall_time_s
        Seconds since the run began.
    real_time_factor
        Recent simulated time over wall time; NaN while nothing flies.
    restarts
        How often each process was started again.
    """

    phase: Phase
    text: str = ''
    vehicles: tuple[VehicleStatus, ...] = ()
    images_stored: int = 0
    images_expected: int = 0
    viewpoints_planned: int = 0
    viewpoints_visited: int = 0
    peak: DosePeak | None = None
    flight_time_s: float = 0.0
    wall_time_s: float = 0.0
    real_time_factor: float = math.nan
    restarts: dict[str, int] = field(default_factory=dict)


class Monitor:
    """Keeps the latest state from the messages of the nodes.

    Parameters
    ----------
    vehicles
        Names, in the order in which they are shown.
    """

    def __init__(self, vehicles: tuple[str, ...]) -> None:
        self._vehicles = {name: VehicleStatus(name=name) for name in vehicles}
        self._stored: set[str] = set()
        self._rejected: dict[str, str] = {}
        self._takeoff_s: float | None = None
        self._flown_s = -math.inf
        self.peak: DosePeak | None = None
        self.images_expected = 0
        self.time_s = 0.0
        self._plan_id = ''
        self._viewpoints_planned = 0

    @property
    def vehicles(self) -> tuple[VehicleStatus, ...]:
        """Latest status of each vehicle."""
        return tuple(self._vehicles.values())

    def vehicle(self, name: str) -> VehicleStatus:
        """Return the latest status of one vehicle."""
        return self._vehicles[name]

    @property
    def viewpoints_planned(self) -> int:
        """Viewpoints of the present plan."""
        return self._viewpoints_planned

    @property
    def viewpoints_visited(self) -> int:
        """Viewpoints of the present plan that were visited; none of an earlier plan."""
        own = (v for v in self._vehicles.values() if v.plan_id == self._plan_id)
        return min(sum(v.viewpoints_visited for v in own), self._viewpoints_planned)

    def begin_plan(self, plan_id: str, viewpoints: int) -> None:
        """Note the plan that is flown from now on."""
        self._plan_id, self._viewpoints_planned = plan_id, viewpoints

    @property
    def still(self) -> frozenset[str]:
        """Names of the vehicles that do not move."""
        return frozenset(name for name, status in self._vehicles.items() if status.is_still)

    @property
    def images_stored(self) -> int:
        """Number of photographs in the store."""
        return len(self._stored)

    @property
    def rejections(self) -> dict[str, str]:
        """Photographs that the store refuses, each with its reason."""
        return dict(self._rejected)

    @property
    def flight_time_s(self) -> float:
        """Seconds from the first take-off to the last touch-down so far, 0 before."""
        return 0.0 if self._takeoff_s is None else max(0.0, self._flown_s - self._takeoff_s)

    def on_vehicle(self, status: VehicleStatus) -> None:
        """Note the state of a vehicle; unknown vehicles are ignored."""
        if status.name not in self._vehicles:
            return
        before = self._vehicles[status.name].state
        if before.is_in_air or status.state.is_in_air:
            self._flown_s = max(self._flown_s, status.time_s)
        self._vehicles[status.name] = status
        if status.time_s > self.time_s:
            self.time_s = status.time_s
        # A stamp of 0 is none: the vehicle has not heard the clock yet.
        if self._takeoff_s is None and status.state.has_left and status.time_s > 0.0:
            self._takeoff_s = status.time_s

    def on_dose_rate(self, vehicle: str, dose_rate_usvh: float, position: GeoPosition) -> None:
        """Note a reading."""
        if self.peak is None or dose_rate_usvh > self.peak.dose_rate_usvh:
            self.peak = DosePeak(dose_rate_usvh=dose_rate_usvh, vehicle=vehicle, position=position)

    def on_stored(self, shot_id: str) -> None:
        """Note that a photograph is stored."""
        self._stored.add(shot_id)
        self._rejected.pop(shot_id, None)

    def on_rejected(self, shot_id: str, reason: str) -> None:
        """Note that a photograph will never be stored."""
        if shot_id not in self._stored:
            self._rejected[shot_id] = reason


class Pace:
    """Simulated time over wall time in the last few seconds.

    Parameters
    ----------
    window_s
        Length of the window, seconds of wall time.
    """

    def __init__(self, window_s: float = 3.0) -> None:
        self._window_s = window_s
        self._samples: list[tuple[float, float]] = []

    def note(self, wall_s: float, simulated_s: float) -> None:
        """Note the simulated time at `wall_s`."""
        self._samples.append((wall_s, simulated_s))
        start = wall_s - self._window_s
        while len(self._samples) > 2 and self._samples[1][0] <= start:
            self._samples.pop(0)

    @property
    def factor(self) -> float:
        """Simulated over wall time; NaN while it is not known or nothing moves."""
        if len(self._samples) < 2:
            return math.nan
        (wall_0, simulated_0), (wall_1, simulated_1) = self._samples[0], self._samples[-1]
        if wall_1 <= wall_0 or simulated_1 <= simulated_0:
            return math.nan
        return (simulated_1 - simulated_0) / (wall_1 - wall_0)
