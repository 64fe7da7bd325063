# SPDX-License-Identifier: Apache-2.0
"""State of a motion at one time, and the interface of every motion."""

import math
from dataclasses import dataclass
from typing import Protocol

Enu = tuple[float, float, float]
"""East, north, up."""

STILL: Enu = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class MotionState:
    """Position (m), velocity (m/s) and acceleration (m/s^2), each east, north, up."""

    position_enu: Enu
    velocity_enu: Enu = STILL
    acceleration_enu: Enu = STILL

    @property
    def speed_mps(self) -> float:
        """Horizontal speed."""
        return math.hypot(self.velocity_enu[0], self.velocity_enu[1])

    @property
    def is_still(self) -> bool:
        """Whether velocity and acceleration are zero."""
        return self.velocity_enu == STILL and self.acceleration_enu == STILL


class Motion(Protocol):
    """A motion from time 0 on."""

    @property
    def duration_s(self) -> float:
        """Time at which it ends, seconds; infinite for a stand without end."""

    @property
    def distance_m(self) -> float:
        """Horizontal length, metres."""

    @property
    def knots_s(self) -> list[float]:
        """Times between which it is a polynomial of fourth degree, ascending from 0, seconds."""

    def state(self, elapsed_s: float) -> MotionState:
        """Return the state at a time; before 0 that at 0, after the end that at the end."""

    def progress_m(self, elapsed_s: float) -> float:
        """Return the horizontal distance covered until a time."""
