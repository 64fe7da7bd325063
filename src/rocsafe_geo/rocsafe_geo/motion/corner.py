# SPDX-License-Identifier: Apache-2.0
"""Corners flown without a stop: the next leg begins before the last one has ended.

The vehicle's motion is the sum of both legs' while they overlap, which rounds the corner. They
overlap as long as possible such that in the middle of the turn the vehicle is within a radius of
the corner and no faster than either leg may be. So ArduCopter 4 flies waypoints without a delay;
the corner counts as reached in the middle. Neither leg is overlapped by more than half of it, nor
while it cruises: the sum's acceleration stays within twice that of a leg.
"""

import math

from rocsafe_geo.motion.leg_table import LegTable

_HALVINGS = 40

Direction = tuple[float, float, float]


def overlap_s(
    table: LegTable, leg: int, directions: tuple[Direction, Direction], radius_m: float
) -> float:
    """Return for how long `leg` and the one after it are flown at once, in seconds.

    Parameters
    ----------
    table : of the legs.
    leg : the first of the two.
    directions : of both, unit vectors.
    radius_m : distance from the corner in the middle of the turn; 0: it stops there.
    """
    if radius_m == 0.0:  # else rounding would decide whether a corner is straight
        return 0.0
    legs = table.legs
    longest = float(min(legs.ramp_s[leg], legs.ramp_s[leg + 1]))
    fastest = float(min(legs.limit_mps[leg], legs.limit_mps[leg + 1])) * (1.0 + 1e-9)
    cosine = sum(a * b for a, b in zip(*directions, strict=True))

    def is_fine(overlap: float) -> bool:
        # braking mirrors speeding up: the first leg is as far from its end as from its start
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
