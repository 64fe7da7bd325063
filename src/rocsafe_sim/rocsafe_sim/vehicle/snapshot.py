# SPDX-License-Identifier: Apache-2.0
"""State of a vehicle after a step, and summary of a flight after its end."""

from dataclasses import dataclass

from rocsafe_sim.flight.segment import FlightPose, Mode
from rocsafe_sim.vehicle.flight_record import FlightOutcome


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotDue:
    """A photograph to be taken: number, viewpoint, time, and pose of the vehicle."""

    sequence: int
    viewpoint_id: int
    time_ns: int
    pose: FlightPose


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleSnapshot:
    """True state of a vehicle after a step.

    Attributes
    ----------
    time_ns
        Simulated time, nanoseconds.
    pose
        True pose at that time.
    mode
        Mode of the vehicle.
    viewpoints_visited
        Viewpoints photographed on the last flight; also the index of the next one.
    shots_taken
        Photographs since power-up.
    battery_fraction
        Charge of the battery, 0 to 1.
    power_w
        Power of the motors, W.
    distance_flown_m
        Horizontal distance since power-up, metres.
    shots
        Photographs due since the last step, in order of time.
    waits_s
        Time on the ground before it takes off by itself, seconds.
    """

    time_ns: int
    pose: FlightPose
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
    """Summary of a flight, see the fields of the action FlyRoute."""

    outcome: FlightOutcome
    text: str
    viewpoints_visited: int
    distance_flown_m: float
    duration_s: float
