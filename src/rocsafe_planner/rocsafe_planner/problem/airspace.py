# SPDX-License-Identifier: Apache-2.0
"""The plane without the zones that must not be flown over.

Zones are widened by the clearance that legs must keep; the corners at which paths bend lie a
little further out, so that no rounding makes a path touch the zone it follows.
"""

from collections.abc import Sequence

import numpy as np
import shapely

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_planner.errors import TooManyViewpointsError
from rocsafe_planner.problem.detours import MARGIN_M, Detours, Door

MAX_SITES = 5000
"""Most sites: the lengths of detours of all pairs of 5000 sites take 300 MB."""

NOBODY: FloatArray = np.zeros((0, 2))


class Airspace:
    """The plane without the zones that must not be entered.

    Parameters
    ----------
    zones
        Polygons (east, north; metres) that no leg may cross.
    clearance_m
        Distance from them that legs and sites must keep.
    stands : (n, 2)
        Places of vehicles. Ground that zones enclose is closed, too, unless one of them is there.
    """

    def __init__(
        self, zones: list[shapely.Polygon], clearance_m: float, stands: FloatArray = NOBODY
    ) -> None:
        union = self.zones = shapely.union_all(zones)
        self.closed: shapely.Geometry = _filled(_widened(union, clearance_m), stands)
        self.shut: shapely.Geometry = _filled(_widened(union, clearance_m + MARGIN_M), stands)
        """What no viewpoint may lie in; on its edge one may."""
        self._outline = shapely.boundary(self.shut)
        self._corners = _vertices(self.shut)
        self._edges = _edges(self.closed)

    def holds(self, places: FloatArray) -> BoolArray:
        """Return which of the places (n, 2) lie outside all zones, shape (n,)."""
        inside: BoolArray = shapely.intersects_xy(self.closed, places[:, 0], places[:, 1])
        return ~inside

    def exit(self, place: FloatArray) -> FloatArray:
        """Return the place (2,) outside all zones that is nearest to one inside."""
        line = shapely.shortest_line(shapely.Point(place), self._outline)
        nearest: FloatArray = shapely.get_coordinates(line)[-1]
        return nearest

    def detours(
        self,
        sites: FloatArray,
        doors: Sequence['Door'] = (),
        crossed: Sequence[shapely.Polygon] = (),
    ) -> 'Detours':
        """Return the shortest paths among sites (s, 2), all of which may be flown to.

        Parameters
        ----------
        sites
            Places, east and north, metres.
        doors
            Sites from which legs may leave a zone.
        crossed
            Zones that lie across such a zone: legs do not enter them from there either.

        Raises
        ------
        TooManyViewpointsError
            If there are more than `MAX_SITES`.
        NoWayError
            If zones shut off a site from another.
        """
        if len(sites) > MAX_SITES:
            raise TooManyViewpointsError(
                f'{len(sites)} viewpoints and homes are to be joined around exclusions: must be '
                f'at most {MAX_SITES}'
            )
        corners = self._corners[self.holds(self._corners)]
        edges = np.vstack([self._edges, *map(_edges, crossed)])
        return Detours(sites, corners, edges, doors)


def _widened(union: shapely.Geometry, distance_m: float) -> shapely.Geometry:
    return shapely.buffer(union, distance_m, join_style='mitre') if distance_m else union


def _filled(closed: shapely.Geometry, stands: FloatArray) -> shapely.Geometry:
    """Return what is closed, and the yards in it that have no stand."""
    spots = shapely.points(stands)
    parts = []
    for part in shapely.get_parts(closed):
        yards = [shapely.Polygon(ring) for ring in part.interiors]
        kept = [yard.exterior for yard in yards if shapely.intersects(yard, spots).any()]
        parts.append(shapely.Polygon(part.exterior, kept))
    return shapely.union_all(parts)


def _rings(geometry: shapely.Geometry) -> list[FloatArray]:
    polygons = shapely.get_parts(geometry)
    return [shapely.get_coordinates(ring) for ring in shapely.get_rings(polygons)]


def _vertices(geometry: shapely.Geometry) -> FloatArray:
    return np.vstack([ring[:-1] for ring in _rings(geometry)])


def _edges(geometry: shapely.Geometry) -> FloatArray:
    """Return begin and end of each edge, shape (e, 2, 2)."""
    return np.vstack([np.stack([ring[:-1], ring[1:]], axis=1) for ring in _rings(geometry)])
