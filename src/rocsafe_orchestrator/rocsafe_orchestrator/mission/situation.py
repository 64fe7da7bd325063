# SPDX-License-Identifier: Apache-2.0
"""Who takes part in a mission, and what its surroundings look like."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Situation:
    """What the surroundings look like now.

    Attributes
    ----------
    ready
        Processes that can be used.
    simulated_s
        Simulated time, seconds.
    waiting_for
        Whom simulated time waits for, as far as is known.
    images_stored
        Photographs that are safe in the store.
    images_rejected
        Photographs that never will be.
    still
        Vehicles that stand, in the air or on the ground.
    """

    ready: frozenset[str]
    simulated_s: float = 0.0
    waiting_for: tuple[str, ...] = ()
    images_stored: int = 0
    images_rejected: int = 0
    still: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True, kw_only=True)
class Crew:
    """Who takes part: for each vehicle its process, and all processes that must be ready."""

    vehicle_processes: Mapping[str, str]
    processes: frozenset[str]
