# SPDX-License-Identifier: Apache-2.0
"""The space in which an unheard vehicle may be, besides its layer.

It goes on along its route, or flies straight home from anywhere on it, at its flight height, and
lands at home. So it may be in the column over its home up to its height, and, at its height, over
the triangles of its home and each leg. Others may not come nearer than the separation: they climb
and descend through its height elsewhere, and do not fly below it through its column.
"""

from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from rocsafe_geo.arrays import FloatArray
from rocsafe_planner.flights.flight_track import FlightTrack
from rocsafe_planner.flights.separation import TOLERANCE_M
from rocsafe_planner.site.survey_site import SurveySite

# Places that are nearer than this are one above the other.
_SAME_M = 1e-3


class UnheardSpace:
    """Column and reach of one vehicle.

    Parameters
    ----------
    home_en, places_en : (2,), (n, 2)
        Where it lands, and the corners of its route; east, north, metres.
    height_m
        Height of its flight above the ground.
    separation_m
        How far others keep away.
    """

    def __init__(
        self, home_en: FloatArray, places_en: FloatArray, height_m: float, separation_m: float
    ) -> None:
        self._home = shapely.Point(home_en)
        corners = [home_en, *places_en, home_en]
        legs = [shapely.MultiPoint([home_en, a, b]).convex_hull for a, b in pairwise(corners)]
        self._reach: BaseGeometry = shapely.union_all(legs)
        self._height, self._separation = height_m, separation_m

    def keeps_away(self, track: FlightTrack, height_m: float) -> bool:
        """Return whether a track whose legs are flown at a height above the ground stays out."""
        return all(self._is_away(np.asarray(way), height_m) for way in track.ways())

    def _is_away(self, way: FloatArray, height_m: float) -> bool:
        least = self._separation - TOLERANCE_M
        high_m = self._height + self._separation - TOLERANCE_M
        low_m = self._height - self._separation + TOLERANCE_M
        for bottom_m, top_m, line in (_end(way, height_m), _end(way[::-1], height_m)):
            is_through = bottom_m < high_m and top_m > low_m
            if is_through and self._reach.distance(line) < least:
                return False
            if bottom_m < high_m and self._home.distance(line) < least:
                return False
        legs = shapely.LineString(way[:, :2])
        return height_m >= high_m or self._home.distance(legs) >= least


def _end(way: FloatArray, height_m: float) -> tuple[float, float, BaseGeometry]:
    """Return bottom and top above the ground, and place, of the climb at the beginning of a way.

    Who begins in the air may climb along its first leg. Heights follow from that of the legs, so
    that they hold over terrain.
    """
    level = np.hypot(*(way[:, :2] - way[0, :2]).T) < _SAME_M
    count = len(way) if level.all() else int(np.argmin(level))
    line = shapely.Point(way[0, :2]) if count > 1 else shapely.LineString(way[:2, :2])
    other_m = height_m + float(way[0, 2] - way[max(count - 1, 1), 2])
    return min(other_m, height_m), max(other_m, height_m), line


def keeps_away(spaces: list[UnheardSpace], track: FlightTrack, height_m: float) -> bool:
    """Return whether a track stays out of all spaces."""
    return all(space.keeps_away(track, height_m) for space in spaces)


def unheard_spaces(site: SurveySite) -> list[UnheardSpace]:
    """Return the space of each unheard vehicle of a site."""
    return [
        UnheardSpace(
            site.frame.plane_of([one.home])[0],
            site.frame.plane_of(one.places),
            one.flight_height_m,
            site.request.separation.distance_m,
        )
        for one in site.request.continuation.unheard
    ]
