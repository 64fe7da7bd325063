# SPDX-License-Identifier: Apache-2.0
"""Collisions of a flight with the ground and with objects.

Overlapping places along the course are checked, at times that follow from the command in force.
Neither the step of the simulation nor a restart changes what is hit, and when.
"""

from dataclasses import dataclass

from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.flight.commands import CommandKind
from rocsafe_sim.flight.course import Course
from rocsafe_sim.flight.segment import Mode
from rocsafe_sim.vehicle.surroundings import GROUND, Surroundings

# Longest time between two checks, s.
LONGEST_STEP_S = 0.1
# Modes in which a vehicle may not come near the ground.
_LEVEL = frozenset({Mode.FLYING, Mode.HOLDING, Mode.RETURNING})


@dataclass(frozen=True, slots=True)
class Collision:
    """Time of a collision, nanoseconds, and name of the object."""

    time_ns: int
    thing: str


class CollisionWatch:
    """Checks one course for collisions.

    Parameters
    ----------
    course
        Course of the vehicle.
    surroundings
        Ground and obstacles.
    airframe
        Performance of the vehicle; its collision radius is above 0.
    """

    def __init__(self, course: Course, surroundings: Surroundings, airframe: Airframe) -> None:
        self._course = course
        self._surroundings = surroundings
        self._radius_m = airframe.collision_radius_m
        performance = airframe.performance
        fastest_mps = max(
            performance.cruise_speed_mps, performance.climb_rate_mps, performance.descent_rate_mps
        )
        # Two checks are less than the diameter apart, even where two legs add up in a corner.
        step_s = min(LONGEST_STEP_S, self._radius_m / fastest_mps)
        self._step_ns = round(step_s * NS_PER_S)
        self._next_ns = course.command.start_ns + self._step_ns

    def first_until(self, time_ns: int | float) -> Collision | None:
        """Return the first collision up to a time, `time_ns` included; None if there is none.

        Times must not decrease from call to call.
        """
        if self._course.command.kind is CommandKind.FALL:
            return None
        last_ns = min(time_ns, self._course.touch_down_ns)
        while self._next_ns <= last_ns:
            thing = self._thing_at(self._next_ns)
            if thing:
                return Collision(self._next_ns, thing)
            self._next_ns += self._step_ns
        return None

    def _thing_at(self, time_ns: int) -> str:
        place = self._course.pose(time_ns).position_enu
        is_level = self._course.mode(time_ns) in _LEVEL
        if is_level and place[2] - self._surroundings.ground_up_m(*place[:2]) < self._radius_m:
            return GROUND
        return self._surroundings.touched(place, self._radius_m)
