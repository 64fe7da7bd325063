# SPDX-License-Identifier: Apache-2.0
"""Participants of a mission, and the present state of processes, clock and image store."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from rocsafe_orchestrator.mission_state.presence import Sighting


@dataclass(frozen=True, slots=True, kw_only=True)
class Situation:
    """Present state of processes, clock, image store and vehicles.

    Attributes
    ----------
    ready
        Processes that are ready.
    simulated_s
        Simulated time, seconds.
    waiting_for
        Participants that simulated time waits for, as far as known.
    images_stored
        Number of photographs in the store.
    images_rejected
        Number of photographs that the store refuses.
    images_expected
        Number of viewpoints of the plan.
    still
        Vehicles that do not move, in the air or on the ground.
    aloft
        Vehicles that are heard and in the air.
    unsettled
        Vehicles with photographs that are not stored yet.
    sightings
        What is known of each vehicle.
    is_driver_home
        Whether the ground vehicle stands and has no drive.
    is_driver_unsettled
        Whether it has photographs that are not stored yet.
    agents_are_done
        Whether all agents that are heard have nothing left to fly.
    agents_plan
        Whether an agent plans, for which simulated time stands still.
    """

    ready: frozenset[str]
    simulated_s: float = 0.0
    waiting_for: tuple[str, ...] = ()
    images_stored: int = 0
    images_rejected: int = 0
    images_expected: int = 0
    still: frozenset[str] = frozenset()
    aloft: frozenset[str] = frozenset()
    unsettled: frozenset[str] = frozenset()
    sightings: Mapping[str, Sighting] = field(default_factory=dict)
    is_driver_home: bool = False
    is_driver_unsettled: bool = False
    agents_are_done: bool = False
    agents_plan: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Crew:
    """Participants of a mission.

    Attributes
    ----------
    vehicle_processes
        Process of each vehicle.
    processes
        Processes that must be ready.
    in_lockstep
        Vehicles that simulated time waits for.
    driver
        Name of the ground vehicle, and of its process; empty: there is none.
    """

    vehicle_processes: Mapping[str, str]
    processes: frozenset[str]
    in_lockstep: frozenset[str] = frozenset()
    driver: str = ''
