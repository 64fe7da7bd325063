# SPDX-License-Identifier: Apache-2.0
"""How a ground vehicle with tracks takes corners, and how long a drive takes it.

It turns in place at sharp corners and drives through the others, so that its speed along a drive
follows from the corners, its acceleration, and the speed limits of the lines between them.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from rocsafe_geo.angle import wrap_rad
from rocsafe_geo.limits import require_positive

Place = tuple[float, float]
# Kept between the sides of a vehicle and what a map shows, by routes.
ROUTE_MARGIN_M = 0.3


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundMotion:
    """What limits changes of speed and direction. Defaults are those of a robot of 50 kg.

    Attributes
    ----------
    acceleration_mps2
        For speeding up and for braking.
    turn_rate_radps
        In place, and at most on the way.
    pivot_rad
        Corners that are sharper are turned in place.
    """

    acceleration_mps2: float = 0.5
    turn_rate_radps: float = 0.8
    pivot_rad: float = math.radians(20.0)

    def __post_init__(self) -> None:
        require_positive('acceleration_mps2', self.acceleration_mps2, 'm/s^2')
        require_positive('turn_rate_radps', self.turn_rate_radps, 'rad/s')
        require_positive('pivot_rad', self.pivot_rad, 'rad')

    def pivot_s(self, turn_rad: float) -> float:
        """Return the time of a turn in place; 0 if the corner is driven through."""
        sharp = abs(turn_rad) > self.pivot_rad
        return abs(turn_rad) / self.turn_rate_radps if sharp else 0.0

    def line_s(self, length_m: float, limit_mps: float, begin_mps: float, end_mps: float) -> float:
        """Return the time of a line between two speeds, with full acceleration up to its limit."""
        a = self.acceleration_mps2
        # Speed at which braking must begin if the limit is not reached before.
        peak = min(limit_mps, math.sqrt(a * length_m + 0.5 * (begin_mps**2 + end_mps**2)))
        peak = max(peak, begin_mps, end_mps)
        ramps = (2.0 * peak**2 - begin_mps**2 - end_mps**2) / (2.0 * a)
        cruise = max(0.0, length_m - ramps) / peak if peak > 0.0 else 0.0
        return (2.0 * peak - begin_mps - end_mps) / a + cruise

    def corner_speeds_mps(
        self, places: Sequence[Place], limits_mps: Sequence[float], stands: Sequence[bool]
    ) -> list[float]:
        """Return the greatest speed at each of n places of a drive.

        Parameters
        ----------
        places
            East and north, m, in driving order.
        limits_mps
            Of the line that leads to each place; the first is not used.
        stands
            Whether the vehicle stands at a place; it does at both ends.
        """
        turns = turns_rad(places)
        speeds = [0.0] * len(places)
        for k in range(1, len(places) - 1):
            if not stands[k] and abs(turns[k]) <= self.pivot_rad:
                speeds[k] = min(limits_mps[k], limits_mps[k + 1])
        lengths = [math.dist(a, b) for a, b in pairwise(places)]
        for k, length in enumerate(lengths):
            speeds[k + 1] = min(speeds[k + 1], self._reached_mps(speeds[k], length))
        for k in reversed(range(len(lengths))):
            speeds[k] = min(speeds[k], self._reached_mps(speeds[k + 1], lengths[k]))
        return speeds

    def durations_s(
        self,
        places: Sequence[Place],
        limits_mps: Sequence[float],
        looks_rad: Sequence[float | None],
    ) -> list[float]:
        """Return the time of the line to each place, the turn in place before it included.

        Parameters as of `corner_speeds_mps`, but `looks_rad` says where the vehicle looks while it
        stands at a place; None: it does not stand. The first time is 0, and so is the first turn.
        """
        stands = [look is not None for look in looks_rad]
        speeds, turns = self.corner_speeds_mps(places, limits_mps, stands), turns_rad(places)
        times = [0.0]
        for k, (a, b) in enumerate(pairwise(places)):
            look, turn = looks_rad[k], turns[k]
            if look is not None:
                turn = float(wrap_rad(math.atan2(b[1] - a[1], b[0] - a[0]) - look))
            line = self.line_s(math.dist(a, b), limits_mps[k + 1], speeds[k], speeds[k + 1])
            times.append(line + self.pivot_s(turn))
        return times

    def _reached_mps(self, speed_mps: float, length_m: float) -> float:
        return math.sqrt(speed_mps**2 + 2.0 * self.acceleration_mps2 * length_m)


def turns_rad(places: Sequence[Place]) -> list[float]:
    """Return by how much the direction changes at each place; 0 at both ends."""
    yaws = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in pairwise(places)]
    turns = [float(wrap_rad(after - before)) for before, after in pairwise(yaws)]
    return [0.0, *turns, 0.0][: len(places)] if places else []
