# SPDX-License-Identifier: Apache-2.0
"""The region of a survey: a polygon on the WGS84 ellipsoid, with holes."""

import re
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import shapely

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition, distance_m

Ring = tuple[GeoPosition, ...]

MAX_LATITUDE_DEG = 85.0
"""Areas reach no further to a pole: meridians converge too fast for a local plane."""

MAX_EXTENT_M = 500_000.0
"""No corner is further than this from the first one: a local plane would be no map."""

MOST_CORNERS = 10_000
"""Most corners of a ring: grids over one with more take minutes, and nobody draws it by hand."""

MIN_AREA_M2 = 0.01
"""What encloses less is a line or a point."""

MIN_WIDTH_M = 0.1
"""What is narrower in the mean is a line: positions are written with six decimals, 0.1 m."""


@dataclass(frozen=True, slots=True)
class SurveyArea:
    """A polygon with holes; corners in either direction of rotation, altitudes do not count.

    Repeated corners and a closing copy of the first one are dropped. Edges are straight in the
    plane of a local frame.

    Raises
    ------
    ValueError
        If a ring has fewer than three corners or more than `MOST_CORNERS`, crosses itself or the
        antimeridian, comes nearer to a pole than `MAX_LATITUDE_DEG`, is larger than
        `MAX_EXTENT_M`, encloses nothing or is narrower than `MIN_WIDTH_M`; or if a hole reaches
        outside the boundary or overlaps another one.
    """

    boundary: Ring
    holes: tuple[Ring, ...] = ()
    name: str = ''

    def __post_init__(self) -> None:
        object.__setattr__(self, 'boundary', _distinct(self.boundary))
        object.__setattr__(self, 'holes', tuple(_distinct(hole) for hole in self.holes))
        _check_ring('the boundary', self.boundary, self.boundary[:1])
        for number, hole in enumerate(self.holes, start=1):
            _check_ring(f'hole {number}', hole, self.boundary[:1])
        _check_shape(self)

    def polygon(self, frame: LocalFrame) -> shapely.Polygon:
        """Return the area in the plane of `frame`: coordinates (east, north) in metres."""
        return shapely.Polygon(
            frame.plane_of(self.boundary),
            [frame.plane_of(hole) for hole in self.holes],
        )

    def centroid(self) -> GeoPosition:
        """Return the centre of the area, holes left out; its altitude is unknown."""
        frame = _own_frame(self.boundary)
        centre = self.polygon(frame).centroid
        return frame.position_of([centre.x, centre.y, np.nan])


def _distinct(ring: Ring) -> Ring:
    """Return the corners without immediate repetitions, the closing one included."""
    corners: list[GeoPosition] = []
    for corner in ring:
        if not corners or _place(corner) != _place(corners[-1]):
            corners.append(corner)
    if len(corners) > 1 and _place(corners[0]) == _place(corners[-1]):
        corners.pop()
    return tuple(corners)


def _check_ring(what: str, ring: Ring, first_of_area: Ring) -> None:
    """Refuse what cannot be put into a plane."""
    if len(ring) < 3:
        raise ValueError(f'{what} has {len(ring)} distinct corners: must have at least 3')
    if len(ring) > MOST_CORNERS:
        raise ValueError(
            f'{what} has {len(ring)} corners: must have at most {MOST_CORNERS} (simplify it)'
        )
    for corner in ring:
        if abs(corner.latitude_deg) > MAX_LATITUDE_DEG:
            raise ValueError(
                f'{what} has a corner at latitude {corner.latitude_deg:g} deg: must be within '
                f'-{MAX_LATITUDE_DEG:g} to {MAX_LATITUDE_DEG:g} deg (not at a pole)'
            )
    for a, b in zip(ring, first_of_area + ring[:-1], strict=True):
        if abs(a.longitude_deg - b.longitude_deg) > 180.0:
            raise ValueError(
                f'{what} goes from longitude {b.longitude_deg:g} to {a.longitude_deg:g} deg: '
                'must not cross the antimeridian (180 deg): divide the region there'
            )
    extent = max(distance_m(first_of_area[0], corner) for corner in ring)
    if extent > MAX_EXTENT_M:
        raise ValueError(
            f'{what} extends {extent / 1000.0:.0f} km: must be within {MAX_EXTENT_M / 1000.0:.0f} '
            'km of the first corner'
        )


def _check_shape(area: SurveyArea) -> None:
    """Refuse rings that cross themselves, and holes that are not inside."""
    frame = _own_frame(area.boundary)
    outer = _simple_polygon('the boundary', area.boundary, frame)
    holes = [
        _simple_polygon(f'hole {number}', hole, frame)
        for number, hole in enumerate(area.holes, start=1)
    ]
    for number, hole in enumerate(holes, start=1):
        if not outer.covers(hole):
            place = _text(hole.difference(outer).representative_point(), frame)
            raise ValueError(
                f'hole {number} reaches outside the boundary near {place}: must be inside'
            )
    for (i, a), (j, b) in combinations(enumerate(holes, start=1), 2):
        if a.intersection(b).area > 0.0:
            place = _text(a.intersection(b).representative_point(), frame)
            raise ValueError(f'holes {i} and {j} overlap near {place}: must be apart')
    if outer.area - sum(hole.area for hole in holes) < MIN_AREA_M2:
        raise ValueError(
            f'the holes leave less than {MIN_AREA_M2:g} m2 of the area: nothing to survey'
        )


def _simple_polygon(what: str, ring: Ring, frame: LocalFrame) -> shapely.Polygon:
    """Return the polygon of a ring; raise ValueError, naming the place, if it is not simple."""
    polygon = shapely.Polygon(frame.plane_of(ring))
    if polygon.area < MIN_AREA_M2 and polygon.convex_hull.area < MIN_AREA_M2:
        raise ValueError(
            f'{what} encloses {polygon.area:.2g} m2: must enclose at least '
            f'{MIN_AREA_M2:g} m2 (its corners lie on a line)'
        )
    width_m = 2.0 * polygon.area / polygon.length
    if polygon.is_valid and width_m < MIN_WIDTH_M:
        raise ValueError(
            f'{what} is {width_m:.2g} m wide in the mean: must be at least {MIN_WIDTH_M:g} m '
            '(it is a line)'
        )
    if not polygon.is_valid:
        reason = shapely.is_valid_reason(polygon)
        place = re.search(r'\[(\S+) (\S+)\]', reason)
        where = ''
        if place:
            point = shapely.Point(float(place.group(1)), float(place.group(2)))
            where = f' near {_text(point, frame)}'
        raise ValueError(f'{what} crosses or touches itself{where}: must be a simple polygon')
    return polygon


def _own_frame(ring: Ring) -> LocalFrame:
    first = ring[0]
    return LocalFrame(GeoPosition(first.latitude_deg, first.longitude_deg, 0.0))


def _text(point: shapely.Point, frame: LocalFrame) -> str:
    """Return 'latitude, longitude' of a point of the plane."""
    place = frame.position_of([point.x, point.y, np.nan])
    return f'{place.latitude_deg:.6f}, {place.longitude_deg:.6f}'


def _place(corner: GeoPosition) -> tuple[float, float]:
    return corner.latitude_deg, corner.longitude_deg
