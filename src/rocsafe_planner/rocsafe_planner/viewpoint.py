# SPDX-License-Identifier: Apache-2.0
"""A place at which a photograph is taken."""

from dataclasses import dataclass

from rocsafe_geo.position import GeoPosition


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
