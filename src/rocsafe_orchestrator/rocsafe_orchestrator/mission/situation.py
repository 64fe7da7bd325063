# SPDX-License-Identifier: Apache-2.0
"""Participants of a mission, and the present state of processes, clock and image store."""

from collections.abc import Mapping
from dataclasses import dataclass


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
    still
        Vehicles that do not move, in the air or on the ground.
    """

    ready: frozenset[str]
    simulated_s: float = 0.0
    waiting_for: tuple[str, ...] = ()
    images_stored: int = 0
    images_rejected: int = 0
    still: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True, kw_only=True)
class Crew:
    """Participants: the process of each vehicle, and all processes that must be ready."""

    vehicle_processes: Mapping[str, str]
    processes: frozenset[str]
