# SPDX-License-Identifier: Apache-2.0
"""What a vehicle is asked to fly."""

import math
from dataclasses import dataclass

Enu = tuple[float, float, float]


def require_enu(name: str, position_enu: Enu) -> None:
    """Raise ValueError unless `position_enu` is three finite numbers of metres."""
    if len(position_enu) != 3 or not all(math.isfinite(value) for value in position_enu):
        raise ValueError(f'{name} is {position_enu}: must be three finite numbers of m')


def horizontal_m(a: Enu, b: Enu) -> float:
    """Return the horizontal distance of two points."""
    return math.hypot(b[0] - a[0], b[1] - a[1])


@dataclass(frozen=True, slots=True, kw_only=True)
class Waypoint:
    """A viewpoint to be photographed.

    Attributes
    ----------
    viewpoint_id : number within the plan.
    position_enu : of the camera, metres about the mission origin.
    yaw_rad : of the vehicle while it photographs, ENU.
    """

    viewpoint_id: int
    position_enu: Enu
    yaw_rad: float

    def __post_init__(self) -> None:
        require_enu(f'position_enu of viewpoint {self.viewpoint_id}', self.position_enu)
        if self.position_enu[2] <= 0.0:
            raise ValueError(
                f'viewpoint {self.viewpoint_id} is {self.position_enu[2]:g} m above the ground: '
                'must be above 0'
            )
        if not math.isfinite(self.yaw_rad):
            raise ValueError(f'yaw_rad of viewpoint {self.viewpoint_id} is {self.yaw_rad}')


@dataclass(frozen=True, slots=True, kw_only=True)
class Route:
    """Viewpoints in flying order, and the home to land at.

    Attributes
    ----------
    plan_id : of the plan that the route is part of.
    home_enu : where to land; up is that of the ground there.
    waypoints : in flying order, at least one.
    """

    plan_id: str
    home_enu: Enu
    waypoints: tuple[Waypoint, ...]

    def __post_init__(self) -> None:
        require_enu('home_enu', self.home_enu)
        if not self.waypoints:
            raise ValueError(f'route of plan {self.plan_id!r} has 0 viewpoints: must have 1')
