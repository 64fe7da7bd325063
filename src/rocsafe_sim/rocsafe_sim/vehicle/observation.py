# SPDX-License-Identifier: Apache-2.0
"""What a vehicle says of itself after a step, and of a flight after its end."""

from dataclasses import dataclass

from rocsafe_sim.flight.segment import Mode, Pose
from rocsafe_sim.vehicle.flight_record import Outcome


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotDue:
    """A photograph to be taken: when, where, and which one."""

    sequence: int
    viewpoint_id: int
    time_ns: int
    pose: Pose


@dataclass(frozen=True, slots=True, kw_only=True)
class Observation:
    """What is true of a vehicle after a step.

    Attributes
    ----------
    time_ns : simulated time.
    pose : true pose at that time.
    mode : what the vehicle is about.
    viewpoints_visited : on the last flight; also the index of the next one to be flown to.
    shots_taken : since power-up.
    battery_fraction : charge left, 0 to 1.
    power_w : that the motors take.
    distance_flown_m : horizontal, since power-up.
    shots : due since the step before, in order of time.
    waits_s : on the ground, before it takes off by itself.
    """

    time_ns: int
    pose: Pose
    mode: Mode
    viewpoints_visited: int
    shots_taken: int
    battery_fraction: float
    power_w: float
    distance_flown_m: float
    shots: tuple[ShotDue, ...] = ()
    waits_s: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightSummary:
    """What a flight came to; see the fields of the action FlyRoute."""

    outcome: Outcome
    text: str
    viewpoints_visited: int
    distance_flown_m: float
    duration_s: float
