# SPDX-License-Identifier: Apache-2.0
"""Expected position of a silent vehicle: it is assumed to fly on.

From its last known place it follows the rest of its plan at the speed of the plan, and then flies
home. A vehicle that stands still or is on the ground is assumed to stay.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from rocsafe_geo.position import GeoPosition, distance_m


@dataclass(frozen=True, slots=True, kw_only=True)
class Prediction:
    """Expected position of a vehicle.

    Attributes
    ----------
    position
        Altitude as last known.
    passed
        Number of waypoints that it should have passed since.
    spread_m
        Uncertainty, metres: a fifth of the way flown unseen, and the way of one second.
    """

    position: GeoPosition
    passed: int
    spread_m: float


def predict(
    last: GeoPosition, way: Sequence[GeoPosition], speed_mps: float, silent_s: float
) -> Prediction:
    """Return the expected position `silent_s` after a vehicle was at `last`, on its `way`."""
    left_m = speed_mps * silent_s
    spread_m = 0.2 * left_m + speed_mps
    for passed, (start, end) in enumerate(pairwise([last, *way])):
        leg_m = distance_m(start, end)
        if left_m < leg_m:
            place = _between(start, end, left_m / leg_m, last.altitude_m)
            return Prediction(position=place, passed=passed, spread_m=spread_m)
        left_m -= leg_m
    end = way[-1] if way else last
    place = GeoPosition(end.latitude_deg, end.longitude_deg, last.altitude_m)
    return Prediction(position=place, passed=len(way), spread_m=spread_m)


def _between(a: GeoPosition, b: GeoPosition, share: float, altitude_m: float) -> GeoPosition:
    # Legs are short and do not cross the antimeridian.
    return GeoPosition(
        a.latitude_deg + share * (b.latitude_deg - a.latitude_deg),
        a.longitude_deg + share * (b.longitude_deg - a.longitude_deg),
        altitude_m,
    )
