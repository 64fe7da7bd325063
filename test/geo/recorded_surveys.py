# SPDX-License-Identifier: Apache-2.0
"""Surveys that ArduCopter flew in its own simulator, and what it reported of them.

Ten waypoints without stops: five lanes to the north and south, links to the east, from a place
20 m south and 20 m west of the first, where it had climbed to 50 m. The time is from the first
waypoint reached to the last. ArduCopter 4.7.0-dev, quad `+`, defaults unless said. The wind at
60 m was said to be 5 and 8 m/s; ArduPilot's simulator reduces it below by the square root of the
height (SIM_WIND_T), which leaves 0.913 of it at 50 m.
"""

import math
from dataclasses import dataclass

from rocsafe_geo.motion.autopilot import ARDUCOPTER, Autopilot
from rocsafe_geo.motion.performance import Performance
from rocsafe_geo.motion.route_motion import RouteMotion
from rocsafe_geo.motion.state import Enu

HEIGHT_M = 50.0
WIND_SHARE = math.sqrt(HEIGHT_M / 60.0)
START_OFF_M = 20.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Recorded:
    """One survey: what was set, and how long it took."""

    name: str
    speed_mps: float = 10.0
    lane_m: float = 200.0
    link_m: float = 40.0
    autopilot: Autopilot = ARDUCOPTER
    wind_mps: tuple[float, float] = (0.0, 0.0)
    recorded_s: float

    @property
    def tolerance(self) -> float:
        """By which part the model may be off."""
        return 0.02 if self.wind_mps == (0.0, 0.0) else 0.05

    def performance(self) -> Performance:
        """Return the vehicle in its air."""
        return Performance(
            cruise_speed_mps=self.speed_mps,
            acceleration_mps2=2.5,
            climb_rate_mps=2.5,
            descent_rate_mps=1.5,
            autopilot=self.autopilot,
            wind_mps=self.wind_mps,
        )

    def waypoints(self) -> list[Enu]:
        """Return the ten waypoints, in metres about where it took off."""
        east = START_OFF_M
        places = []
        for lane in range(5):
            ends = (START_OFF_M, START_OFF_M + self.lane_m)
            places += [
                (east, north, HEIGHT_M) for north in (ends if lane % 2 == 0 else ends[::-1])
            ]
            east += self.link_m
        return places

    def motion(self) -> RouteMotion:
        """Return the flight from over the start to the last waypoint, where it stops."""
        flyer, here = self.performance(), (0.0, 0.0, HEIGHT_M)
        ways, places = [], self.waypoints()
        for place in places:
            ways.append(flyer.way(here, place, is_passed=place != places[-1]))
            here = place
        return RouteMotion((0.0, 0.0, HEIGHT_M), ways, flyer.corner_radius_m)

    def model_s(self) -> float:
        """Return the time that the model says."""
        arrivals = self.motion().arrivals_s
        return arrivals[-1] - arrivals[0]


RECORDED = (
    Recorded(name='5 m/s', speed_mps=5.0, recorded_s=238.4),
    Recorded(name='10 m/s', recorded_s=143.2),
    Recorded(name='10 m/s, repeated', recorded_s=143.3),
    Recorded(name='10 m/s, 100 x 20 m', lane_m=100.0, link_m=20.0, recorded_s=84.1),
    Recorded(
        name='10 m/s, radius 5 m', autopilot=Autopilot(waypoint_radius_m=5.0), recorded_s=132.9
    ),
    Recorded(name='10 m/s, jerk 5 m/s^3', autopilot=Autopilot(jerk_mps3=5.0), recorded_s=136.4),
    Recorded(name='15 m/s asked', speed_mps=15.0, recorded_s=144.2),
    Recorded(name='wind 5 m/s from east', wind_mps=(-5.0 * WIND_SHARE, 0.0), recorded_s=149.6),
    Recorded(name='wind 8 m/s from north', wind_mps=(0.0, -8.0 * WIND_SHARE), recorded_s=280.4),
)
