# SPDX-License-Identifier: Apache-2.0
"""Corners passed without a stop: the next leg begins before the last one has ended.

While two legs overlap, the motion of the vehicle is the sum of both, which rounds the corner. The
overlap is as long as possible under two conditions: in the middle of the turn the vehicle is
within a radius of the corner, and it is no faster than either leg may be. ArduCopter 4 flies
waypoints without a delay in this way. The corner counts as reached in the middle of the turn. At
most half of a leg is overlapped, and never its cruise, so that the acceleration of the sum stays
within twice that of a leg.
"""

import math

from rocsafe_geo.motion.leg_table import LegTable

_HALVINGS = 40

Direction = tuple[float, float, float]


def overlap_s(
    table: LegTable, leg: int, directions: tuple[Direction, Direction], radius_m: float
) -> float:
    """Return how long `leg` and the next one overlap, in seconds.

    Parameters
    ----------
    table
        Table of the legs.
    leg
        Number of the first of the two legs.
    directions
        Directions of both, unit vectors.
    radius_m
        Distance from the corner in the middle of the turn, metres; 0: the vehicle stops there.
    """
    if radius_m == 0.0:  # Otherwise rounding would decide whether a corner is straight.
        return 0.0
    legs = table.legs
    longest = float(min(legs.ramp_s[leg], legs.ramp_s[leg + 1]))
    fastest = float(min(legs.limit_mps[leg], legs.limit_mps[leg + 1])) * (1.0 + 1e-9)
    cosine = sum(a * b for a, b in zip(*directions, strict=True))

    def is_fine(overlap: float) -> bool:
        # Braking mirrors acceleration: the first leg is as far from its end as from its start.
        first, speed, _ = table.at(leg, 0.5 * overlap)
        second, next_speed, _ = table.at(leg + 1, 0.5 * overlap)
        off_m = _length_of_sum(first, second, -cosine)
        return off_m <= radius_m and _length_of_sum(speed, next_speed, cosine) <= fastest

    if is_fine(longest):
        return longest
    low, high = 0.0, longest
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_fine(middle) else (low, middle)
    return low


def _length_of_sum(a: float, b: float, cosine: float) -> float:
    """Return the length of the sum of two vectors of lengths a and b at an angle."""
    return math.sqrt(max(0.0, a * a + b * b + 2.0 * a * b * cosine))
