# SPDX-License-Identifier: Apache-2.0
"""What a vehicle is asked to fly."""

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

from rocsafe_geo.detour import Place, Ring, WaysAround
from rocsafe_geo.limits import require_not_negative

Enu = tuple[float, float, float]

# A vehicle this near to its planned way is on it, and needs no way around exclusions to it.
ON_WAY_M = 0.01


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
    approach_enu : where the way to it bends, metres; flown over without a photograph.
    """

    viewpoint_id: int
    position_enu: Enu
    yaw_rad: float
    approach_enu: tuple[Enu, ...] = ()

    def __post_init__(self) -> None:
        for bend in self.approach_enu:
            require_enu(f'approach_enu of viewpoint {self.viewpoint_id}', bend)
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
    homeward_enu : where the way from the last one home bends, metres.
    exclusions : outlines (east, north) that are not flown over, by who gives up the route either.
    clearance_m : distance to keep from them.
    """

    plan_id: str
    home_enu: Enu
    waypoints: tuple[Waypoint, ...]
    homeward_enu: tuple[Enu, ...] = ()
    exclusions: tuple[Ring, ...] = ()
    clearance_m: float = 0.0

    def __post_init__(self) -> None:
        require_enu('home_enu', self.home_enu)
        for bend in self.homeward_enu:
            require_enu('homeward_enu', bend)
        require_not_negative('clearance_m', self.clearance_m, 'm')
        for ring in self.exclusions:
            if len(ring) < 3 or not all(math.isfinite(v) for place in ring for v in place):
                raise ValueError(f'exclusion {ring}: must be three or more finite places')
        if not self.waypoints:
            raise ValueError(f'route of plan {self.plan_id!r} has 0 viewpoints: must have 1')

    def way_to(self, index: int, here_enu: Enu) -> tuple[Enu, ...]:
        """Return the bends still ahead on the way to viewpoint `index`, or home after the last.

        A vehicle that was stopped on its way goes on with the part of it that it is nearest to.
        """
        is_home = index == len(self.waypoints)
        before = self.waypoints[index - 1].position_enu if index else self.home_enu
        after = self.home_enu if is_home else self.waypoints[index].position_enu
        bends = self.homeward_enu if is_home else self.waypoints[index].approach_enu
        corners = (before, *bends, after)
        offsets = [_offset_m(here_enu, a, b) for a, b in pairwise(corners)]
        ahead = bends[offsets.index(min(offsets)) :]
        if min(offsets) < ON_WAY_M:
            return ahead
        return (*self.around(here_enu, ahead[0] if ahead else after), *ahead)

    def around(self, here_enu: Enu, there_enu: Enu) -> tuple[Enu, ...]:
        """Return where the way between any two places bends around the exclusions."""
        if not self.exclusions:
            return ()
        ways = _ways_around(self.exclusions, self.clearance_m, there_enu[:2])
        return tuple((east, north, here_enu[2]) for east, north in ways.bends(here_enu[:2]))


@lru_cache(maxsize=32)
def _ways_around(zones: tuple[Ring, ...], clearance_m: float, goal: Place) -> WaysAround:
    """Return the ways to a goal: looked for at every check of the battery, found once."""
    return WaysAround(zones, clearance_m, goal)


def _offset_m(place: Enu, a: Enu, b: Enu) -> float:
    """Return the horizontal distance of a place from the straight line between two others."""
    east, north = b[0] - a[0], b[1] - a[1]
    square = east * east + north * north
    along = (place[0] - a[0]) * east + (place[1] - a[1]) * north
    share = min(1.0, max(0.0, along / square)) if square else 0.0
    return horizontal_m(place, (a[0] + share * east, a[1] + share * north, 0.0))
