# SPDX-License-Identifier: Apache-2.0
"""A place at which a photograph is taken."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition, offset


@dataclass(frozen=True, slots=True, kw_only=True)
class Viewpoint:
    """A place at which a photograph is taken.

    `position` is the camera's, its altitude NaN if no home's altitude is known; `yaw_rad` is 0
    for a nose that points east, anticlockwise positive; `footprint` are the corners of the ground
    that the photograph shows, anticlockwise; `sensors` are what the vehicle must carry.
    """

    id: int
    position: GeoPosition
    height_agl_m: float
    yaw_rad: float
    footprint: tuple[GeoPosition, ...]
    sensors: tuple[str, ...] = ()


def viewpoints_over(
    places: Iterable[GeoPosition], camera: PinholeCamera, height_agl_m: float, first_id: int = 0
) -> tuple[Viewpoint, ...]:
    """Return viewpoints over places, numbered on from `first_id`, noses to the north."""
    across, along = camera.footprint_m(height_agl_m)
    corners = [(-across, -along), (across, -along), (across, along), (-across, along)]
    return tuple(
        Viewpoint(
            id=first_id + number,
            position=place,
            height_agl_m=height_agl_m,
            yaw_rad=0.5 * math.pi,
            footprint=tuple(offset(place, 0.5 * east, 0.5 * north) for east, north in corners),
        )
        for number, place in enumerate(places)
    )
