# SPDX-License-Identifier: Apache-2.0
"""State of a running mission, gathered from the messages of the nodes."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum

from rocsafe_geo.evidence.place_marks import PlaceMark
from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.mission_state.presence import Sighting


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
_ALOFT = frozenset(
    {FlightState.TAKING_OFF, FlightState.FLYING, FlightState.HOLDING, FlightState.RETURNING}
    | {FlightState.LANDING}
)
# A vehicle that holds counts as still below this speed: a simulated one, and a real one, whose
# receiver shows some tenths of a metre per second at rest.
STILL_MPS = 0.05
STILL_REAL_MPS = 0.5
# Vehicles that an operator sends home one after the other all announce it within this time,
# seconds: until then the others are not made to hold.
SETTLE_S = 2.0
# Places on the way of a vehicle are kept so far apart, metres.
TRACK_STEP_M = 10.0


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleStatus:
    """Latest state of one vehicle.

    Attributes
    ----------
    time_s
        Stamp of the state, seconds since the epoch.
    ending
        Why its present flight will end otherwise than planned; empty: it will not.
    is_by_request
        Whether an operator ended its flight.
    taken_by
        Who has it in the air instead of the suite; empty: nobody.
    """

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
    is_simulated: bool = True
    ending: str = ''
    is_by_request: bool = False
    taken_by: str = ''

    @property
    def is_aloft(self) -> bool:
        """Whether it is in the air."""
        return self.state in _ALOFT

    @property
    def may_turn_back(self) -> bool:
        """Whether it can be called home; a vehicle that lands already cannot."""
        return self.is_waiting or (self.is_aloft and self.state is not FlightState.LANDING)

    @property
    def is_waiting(self) -> bool:
        """Whether it stands on the ground and will take off by itself."""
        return self.state is FlightState.WAITING

    @property
    def is_still(self) -> bool:
        """Whether it does not move, in the air or on the ground."""
        if self.state is FlightState.HOLDING:
            return self.speed_mps < (STILL_MPS if self.is_simulated else STILL_REAL_MPS)
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
    driver
        The ground vehicle.
    images_expected
        Photographs of all plans that are flown one after the other.
    viewpoints_planned, viewpoints_visited
        Viewpoints of the present plan, and those of them that were visited.
    flight_time_s
        Simulated or real seconds from the first take-off to the end of the last flight or drive
        so far.
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
    driver: VehicleStatus | None = None
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
    contamination_usvh
        Dose rate from which a vehicle may be contaminated; 0: none.
    driver
        Name of the ground vehicle; empty: there is none.

    Attributes
    ----------
    driver
        Its latest status.
    marks
        Tells the places that operators have marked.
    """

    def __init__(
        self, vehicles: tuple[str, ...], contamination_usvh: float = 0.0, driver: str = ''
    ) -> None:
        self.driver = VehicleStatus(name=driver)
        self._vehicles = {name: VehicleStatus(name=name) for name in vehicles}
        self._heard_s: dict[str, float] = {}
        self._ending_s: dict[str, float] = {}
        self._stored: set[str] = set()
        self._rejected: dict[str, str] = {}
        self._takeoff_s: float | None = None
        self._flown_s = -math.inf
        self.peak: DosePeak | None = None
        self.turned_back: dict[str, str] = {}
        self.contaminated: dict[str, str] = {}
        self._contamination_usvh = contamination_usvh
        self.sources: tuple[tuple[GeoPosition, float], ...] = ()
        self.releases: tuple[tuple[GeoPosition, float], ...] = ()
        self.release_unit = 'g/s'
        self.marks: Callable[[], Sequence[PlaceMark]] = tuple
        self._flown: dict[str, list[tuple[GeoPosition, float]]] = {}
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
    def unsettled(self) -> frozenset[str]:
        """Names of the vehicles with photographs that are not stored yet."""
        return frozenset(n for n, status in self._vehicles.items() if status.shots_pending)

    def heard_ago_s(self, name: str, now_s: float) -> float:
        """Return the wall time since a vehicle was heard; 0 before it was ever heard."""
        return now_s - self._heard_s.get(name, now_s)

    def sighting(
        self,
        name: str,
        now_s: float,
        silent_s: float,
        *,
        is_led_by_others: bool = False,
        is_left_out: bool = False,
    ) -> Sighting:
        """Return what is known of a vehicle that has been silent for `silent_s`.

        `is_left_out`: simulated time goes on without it.
        """
        status = self._vehicles[name]
        if not status.ending:
            self._ending_s.pop(name, None)
        ending_s = now_s - self._ending_s.setdefault(name, now_s) if status.ending else 0.0
        is_settling = status.is_by_request and ending_s < SETTLE_S
        return Sighting(
            silent_s=silent_s,
            ending='' if is_settling else status.ending,
            taken_by='operator' if is_settling or is_led_by_others else status.taken_by,
            is_grounded=status.state in GROUNDED,
            is_unheard=is_left_out or status.state is FlightState.LOST,
        )

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
        """Seconds from the first take-off to the end of the last flight or drive so far."""
        return 0.0 if self._takeoff_s is None else max(0.0, self._flown_s - self._takeoff_s)

    def on_vehicle(self, status: VehicleStatus, wall_s: float = 0.0) -> None:
        """Note the state of a vehicle, heard at `wall_s`; unknown vehicles are ignored."""
        if status.name == self.driver.name:
            self._note_time(self.driver, status)
            self.driver = status
        if status.name not in self._vehicles:
            return
        self._heard_s[status.name] = wall_s
        self._note_time(self._vehicles[status.name], status)
        self._vehicles[status.name] = status
        # A stamp of 0 is none: the vehicle has not heard the clock yet.
        if self._takeoff_s is None and status.state.has_left and status.time_s > 0.0:
            self._takeoff_s = status.time_s

    def _note_time(self, before: VehicleStatus, now: VehicleStatus) -> None:
        if before.state.is_in_air or now.state.is_in_air:
            self._flown_s = max(self._flown_s, now.time_s)
        if now.time_s > self.time_s:
            self.time_s = now.time_s

    def on_dose_rate(self, vehicle: str, dose_rate_usvh: float, position: GeoPosition) -> None:
        """Note a reading, and on the way of a vehicle one every few metres."""
        flown = self._flown.setdefault(vehicle, [])
        if not flown or distance_m(flown[-1][0], position) >= TRACK_STEP_M:
            flown.append((position, dose_rate_usvh))
        if 0.0 < self._contamination_usvh <= dose_rate_usvh and vehicle not in self.contaminated:
            self.contaminated[vehicle] = f'it read {dose_rate_usvh:.3g} uSv/h'
        if dose_rate_usvh > (self.peak.dose_rate_usvh if self.peak else 0.0):
            self.peak = DosePeak(dose_rate_usvh=dose_rate_usvh, vehicle=vehicle, position=position)

    def flown(self, vehicle: str) -> tuple[tuple[GeoPosition, float], ...]:
        """Return places that a vehicle has flown over, with the dose rate that it read there."""
        return tuple(self._flown.get(vehicle, ()))

    def on_turn_back(self, vehicle: str, why: str) -> None:
        """Note that a vehicle is to return because of its dose rate or dose."""
        self.turned_back.setdefault(vehicle, why)

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
