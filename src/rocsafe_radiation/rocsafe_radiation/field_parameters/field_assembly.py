# SPDX-License-Identifier: Apache-2.0
"""From parallel lists of parameters to sources and shields."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import TypeVar

from rocsafe_geo.angle import yaw_of_heading_rad
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_radiation.physics.nuclide import DEFAULT_NUCLIDE
from rocsafe_radiation.physics.shielding import Box, BoxShielding
from rocsafe_radiation.physics.source import RadiationSource, decayed_sigma_usvps
from rocsafe_radiation.physics.source_shape import AreaShape, LineShape, SourceShape, TrackShape

Value = TypeVar('Value')
POINT, LINE, AREA, TRACK = 'point', 'line', 'area', 'track'
SHAPES = (POINT, LINE, AREA, TRACK)


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceLists:
    """Sources, one an index; optional lists may be empty.

    Attributes
    ----------
    names: of all.
    places: where each is, or begins.
    sigmas_usvps: dose rates at 1 m; 0: by activity.
    nuclides, activities_gbq, ages_s: of each; optional.
    shapes: of `SHAPES`; optional.
    corner_counts: how many of `corners` describe each source; optional.
    corners, corner_times_s: of all sources, one after the other; times of tracks only.
    """

    names: tuple[str, ...]
    places: tuple[GeoPosition, ...]
    sigmas_usvps: tuple[float, ...]
    nuclides: tuple[str, ...] = ()
    activities_gbq: tuple[float, ...] = ()
    ages_s: tuple[float, ...] = ()
    shapes: tuple[str, ...] = ()
    corner_counts: tuple[int, ...] = ()
    corners: tuple[GeoPosition, ...] = ()
    corner_times_s: tuple[float, ...] = ()


def sources_of(lists: SourceLists) -> tuple[RadiationSource, ...]:
    """Return the sources described.

    Raises
    ------
    ValueError: naming the source, the value and the limit.
    """
    if sum(lists.corner_counts) != len(lists.corners):
        raise ValueError(
            f'source_corner_counts add up to {sum(lists.corner_counts)}, but there are '
            f'{len(lists.corners)} corners'
        )
    return tuple(_source(lists, index) for index in range(len(lists.names)))


def _source(lists: SourceLists, index: int) -> RadiationSource:
    name = lists.names[index]
    nuclide = entry(lists.nuclides, index, '') or DEFAULT_NUCLIDE
    sigma_usvps = lists.sigmas_usvps[index]
    if sigma_usvps == 0.0 and lists.activities_gbq:
        age_s = entry(lists.ages_s, index, 0.0)
        sigma_usvps = decayed_sigma_usvps(name, nuclide, lists.activities_gbq[index], age_s)
    try:
        shape = _shape(lists, index)
    except ValueError as error:
        raise ValueError(f'source {name}: {error}') from error
    return RadiationSource(
        name=name,
        position=lists.places[index],
        sigma_usvps=sigma_usvps,
        nuclide=nuclide,
        shape=shape,
    )


def _shape(lists: SourceLists, index: int) -> SourceShape | None:
    kind = entry(lists.shapes, index, POINT)
    if kind not in SHAPES:
        raise ValueError(f'shape = {kind!r} must be one of: {", ".join(SHAPES)}')
    ends = [0, *accumulate(lists.corner_counts)]
    own = slice(ends[index], ends[index + 1]) if lists.corner_counts else slice(0, 0)
    corners = lists.corners[own]
    if kind == LINE:
        return LineShape(corners=corners)
    if kind == AREA:
        return AreaShape(corners=corners)
    if kind == TRACK:
        return TrackShape(times_s=lists.corner_times_s[own], stops=corners)
    return None


def places_of(
    names: Sequence[str],
    latitudes: Sequence[float],
    longitudes: Sequence[float],
    altitudes: Sequence[float],
) -> tuple[GeoPosition, ...]:
    """Return positions of parallel lists.

    Raises
    ------
    ValueError: with the name of the wrong one, its value and the limit.
    """
    found = []
    for name, latitude, longitude, altitude in zip(
        names, latitudes, longitudes, altitudes, strict=True
    ):
        try:
            position = GeoPosition(latitude, longitude, altitude)
        except ValueError as error:
            raise ValueError(f'{name}: {error}') from error
        if not math.isfinite(altitude):
            raise ValueError(f'{name}: altitude_m = {altitude} must be finite')
        found.append(position)
    return tuple(found)


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxLists:
    """Boxes that shield, one an index.

    Attributes
    ----------
    materials: of each.
    places: of the middle of each bottom.
    sizes_m: length, width and height of each.
    headings_deg: of each length, clockwise from north.
    walls_m: thickness of the walls, 0: solid; optional.
    """

    materials: tuple[str, ...]
    places: tuple[GeoPosition, ...]
    sizes_m: tuple[tuple[float, float, float], ...]
    headings_deg: tuple[float, ...] = ()
    walls_m: tuple[float, ...] = ()


def shielding_of(lists: BoxLists) -> BoxShielding | None:
    """Return the boxes described, None without any.

    Raises
    ------
    ValueError: naming the box, the value and the limit.
    """
    if not lists.materials:
        return None
    frame = LocalFrame(lists.places[0])
    boxes = []
    for index, material in enumerate(lists.materials):
        east, north, up = frame.enu_of(lists.places[index]).tolist()
        size_m = lists.sizes_m[index]
        heading_deg = entry(lists.headings_deg, index, 0.0)
        try:
            box = Box(
                material=material,
                centre_enu_m=(east, north, up + size_m[2] / 2.0),
                size_m=size_m,
                yaw_rad=yaw_of_heading_rad(math.radians(heading_deg)),
                wall_m=entry(lists.walls_m, index, 0.0),
            )
        except ValueError as error:
            raise ValueError(f'box {index}: {error}') from error
        boxes.append(box)
    return BoxShielding(frame=frame, boxes=tuple(boxes))


def entry(values: tuple[Value, ...], index: int, default: Value) -> Value:
    """Return `values[index]`, or `default` of an empty list."""
    return values[index] if values else default
