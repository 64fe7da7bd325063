# SPDX-License-Identifier: Apache-2.0
"""What a simulated ground vehicle is made of, and what it photographs."""

import math
from dataclasses import dataclass

from rocsafe_geo.motion.ground_motion import ROUTE_MARGIN_M, Place
from rocsafe_sim.driving.caution import CautionOptions
from rocsafe_sim.driving.chassis import Chassis, Skid
from rocsafe_sim.sensors.sensing_noise import SensorNoise
from rocsafe_sim.vehicle.surroundings import Surroundings

# Height of the middle of the ball that must touch nothing, above the ground: the vehicle drives
# over what is lower than 5 cm and below barrier tape, which gives way to its mast.
BODY_UP_M = 0.4
# Kept from things beside the way: skid, and the curve of a bend. A route is planned with twice as
# much, so that nothing that was on its map is in the way.
CLEARANCE_M = 0.5 * ROUTE_MARGIN_M
# Its range finder: reach, directions, how exactly it tells a place, and the heights that it looks
# at: those of its body.
SCAN_M, PLACE_M = 8.0, 0.1
SCAN_RAD = [math.radians(angle) for angle in range(-90, 91, 5)]
SCAN_UP_M = (0.15, 0.4, 0.65)


@dataclass(frozen=True, slots=True, kw_only=True)
class EvidenceShot:
    """A photograph to be taken: number, evidence, and true pose of the vehicle."""

    sequence: int
    evidence: str
    stop: int
    time_ns: int
    place: Place
    yaw_rad: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RoverParts:
    """What a rover is made of.

    Attributes
    ----------
    chassis
        Size and motion.
    skid
        Of its tracks.
    noise
        Of its receiver.
    caution
        When it turns back.
    has_detector
        Whether it drives by readings: without any for a while it comes back.
    surroundings
        Ground and obstacles; None: level ground without any.
    """

    chassis: Chassis
    skid: Skid
    noise: SensorNoise
    caution: CautionOptions
    has_detector: bool = True
    surroundings: Surroundings | None = None

    def ground_up_m(self, place: Place) -> float:
        """Return the height of the ground."""
        return 0.0 if self.surroundings is None else self.surroundings.ground_up_m(*place)

    def touched(self, place: Place) -> str:
        """Return what the vehicle would touch there; empty: nothing."""
        if self.surroundings is None:
            return ''
        enu = (*place, self.ground_up_m(place) + BODY_UP_M)
        return self.surroundings.touched(enu, 0.5 * self.chassis.width_m)

    def in_the_way(self, place: Place, yaw_rad: float) -> str:
        """Return what comes too near on either side of a way through a place; empty: nothing.

        The clearance is beside the vehicle: what is above it or flat on the ground is as far away
        as before.
        """
        east, north = -CLEARANCE_M * math.sin(yaw_rad), CLEARANCE_M * math.cos(yaw_rad)
        left, right = (place[0] + east, place[1] + north), (place[0] - east, place[1] - north)
        return self.touched(left) or self.touched(right)

    def seen_from(self, place: Place, yaw_rad: float) -> tuple[Place, ...]:
        """Return where the range finder sees the surfaces of things from a place."""
        seen = []
        for angle in SCAN_RAD:
            cos, sin = math.cos(yaw_rad + angle), math.sin(yaw_rad + angle)
            for step in range(2, round(0.5 * SCAN_M / PLACE_M)):
                reach = 2.0 * step * PLACE_M
                there = (place[0] + reach * cos, place[1] + reach * sin)
                if self._is_thing(there):
                    seen.append(there)
                    break
        return tuple(seen)

    def things_beside(self, place: Place) -> tuple[Place, ...]:
        """Return where things are that a way through a place comes too near to."""
        reach = 0.5 * self.chassis.width_m + CLEARANCE_M + PLACE_M
        count = math.floor(reach / (2.0 * PLACE_M))
        offsets = [2.0 * PLACE_M * k for k in range(-count, count + 1)]
        around = ((place[0] + east, place[1] + north) for east in offsets for north in offsets)
        return tuple(there for there in around if self._is_thing(there))

    def _is_thing(self, place: Place) -> bool:
        if self.surroundings is None:
            return False
        up = self.ground_up_m(place)
        balls = ((*place, up + height) for height in SCAN_UP_M)
        return any(self.surroundings.touched(ball, PLACE_M) for ball in balls)
