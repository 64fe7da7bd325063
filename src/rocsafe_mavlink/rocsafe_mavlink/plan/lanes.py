# SPDX-License-Identifier: Apache-2.0
"""The straight lanes of a route, along which a camera is triggered by distance."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from rocsafe_geo.angle import wrap_rad
from rocsafe_geo.position import GeoPosition

# A larger turn ends a lane: the corners of a survey turn by 90 degrees, its lanes hardly bend.
STRAIGHT_WITHIN_RAD = math.radians(20.0)


def lanes(way: Sequence[GeoPosition]) -> tuple[tuple[int, int], ...]:
    """Return the first and the last number of each run of three or more places in line.

    The place at a corner may end one lane and begin the next. Legs are short against the Earth, so
    directions are computed in a plane.
    """
    found: list[tuple[int, int]] = []
    for corner in _in_line(way):
        if found and found[-1][1] == corner:
            found[-1] = (found[-1][0], corner + 1)
        else:
            found.append((corner - 1, corner + 1))
    return tuple(found)


def _in_line(way: Sequence[GeoPosition]) -> Iterator[int]:
    """Yield the number of each place at which the way goes straight on."""
    directions = [_direction_rad(a, b) for a, b in pairwise(way)]
    for number, (before, after) in enumerate(pairwise(directions), start=1):
        if abs(wrap_rad(after - before)) <= STRAIGHT_WITHIN_RAD:
            yield number


def _direction_rad(a: GeoPosition, b: GeoPosition) -> float:
    north = b.latitude_deg - a.latitude_deg
    east = (b.longitude_deg - a.longitude_deg) * math.cos(math.radians(a.latitude_deg))
    return math.atan2(north, east)
