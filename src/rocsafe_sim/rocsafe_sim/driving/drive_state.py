# SPDX-License-Identifier: Apache-2.0
"""State of a driving vehicle: all that must survive its process."""

import math
from dataclasses import dataclass
from enum import Enum

from rocsafe_sim.driving.drive_route import DrivenRoute
from rocsafe_sim.driving.way_back import Mark


class DriveMode(Enum):
    """What the vehicle does."""

    PARKED = 'parked'
    DRIVING = 'driving'
    HOLDING = 'holding'
    RETURNING = 'returning'
    ARRIVED = 'arrived'
    CRASHED = 'crashed'

    @property
    def is_moving(self) -> bool:
        """Whether it follows a way, stands included."""
        return self in (DriveMode.DRIVING, DriveMode.RETURNING)


class DriveOutcome(Enum):
    """How a drive ends, as in the action DriveRoute."""

    COMPLETED = 'completed'
    CANCELLED = 'cancelled'
    RETURNED_EARLY = 'returned early'
    BATTERY_LOW = 'battery low'
    TURNED_BACK_DOSE = 'turned back for its dose'
    BLOCKED = 'blocked'
    COLLISION = 'collided'
    TURNED_BACK_GAS = 'turned back for gas'
    DOSE_UNEXPECTED = 'readings outside the prediction'


@dataclass(slots=True, kw_only=True)
class Ledger:
    """What a drive has taken so far, since it began.

    Attributes
    ----------
    began_ns
        Start of the drive.
    ended_ns
        Its end; 0: it goes on.
    distance_m
        Driven.
    dose_usv
        By the vehicle's own readings.
    after_usv
        By its readings since the drive ended.
    predicted_usv
        For the lines and stands that are done.
    evidence
        Ids of what was photographed.
    outcome, text
        How it ends, and why; empty before that is known.
    blocked
        East and north of what stands in the way, and around; empty: nothing.
    """

    began_ns: int = 0
    ended_ns: int = 0
    distance_m: float = 0.0
    dose_usv: float = 0.0
    after_usv: float = 0.0
    predicted_usv: float = 0.0
    evidence: tuple[str, ...] = ()
    outcome: DriveOutcome | None = None
    text: str = ''
    blocked: tuple[tuple[float, float], ...] = ()


@dataclass(slots=True, kw_only=True)
class DriveState:
    """State of the vehicle at a tick.

    Attributes
    ----------
    time_ns
        Time of the tick.
    east_m, north_m, yaw_rad, speed_mps
        True motion: place, direction in which it moves, speed.
    is_backing
        Whether it moves backwards: it looks the other way.
    mode
        What it does.
    held_mode
        What it did before a hold.
    route
        That is driven, or was last; None before the first.
    next_stop
        Number of the stop that it drives to, or stands at.
    is_standing
        Whether it stands at that stop.
    stood_s
        For how long.
    shots
        Photographs since power-up.
    charge_j
        Left in the battery.
    odometer_m
        Distance since power-up.
    read_ns, read_usvh
        The newest reading that counts.
    way
        The way back.
    ledger
        Of the last drive.
    """

    time_ns: int
    east_m: float
    north_m: float
    yaw_rad: float = 0.0
    speed_mps: float = 0.0
    is_backing: bool = False
    mode: DriveMode = DriveMode.PARKED
    held_mode: DriveMode = DriveMode.DRIVING
    route: DrivenRoute | None = None
    next_stop: int = 1
    is_standing: bool = False
    stood_s: float = 0.0
    shots: int = 0
    charge_j: float = 0.0
    odometer_m: float = 0.0
    read_ns: int = 0
    read_usvh: float = 0.0
    way: tuple[Mark, ...] = ()
    ledger: Ledger

    @property
    def place(self) -> tuple[float, float]:
        """True east and north."""
        return self.east_m, self.north_m

    @property
    def looks_rad(self) -> float:
        """Direction in which it looks, from east to north."""
        return math.remainder(self.yaw_rad + math.pi * self.is_backing, math.tau)

    def back(self) -> None:
        """Move the other way without a turn, as tracks can."""
        self.yaw_rad = math.remainder(self.yaw_rad + math.pi, math.tau)
        self.is_backing = not self.is_backing
