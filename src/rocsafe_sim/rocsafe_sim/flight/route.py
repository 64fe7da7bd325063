# SPDX-License-Identifier: Apache-2.0
"""Route of a vehicle: viewpoints, bends, landings, exclusions."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise

from rocsafe_geo.detour import Place, Ring, WaysAround, zone_on_way
from rocsafe_geo.limits import require_between, require_not_negative
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.time_units import LONGEST_WAIT_S

# A vehicle this near to its planned way is on it.
ON_WAY_M = 0.01


def require_enu(name: str, position_enu: Enu) -> None:
    """Raise ValueError unless `position_enu` is three finite numbers of metres."""
    if len(position_enu) != 3 or not all(math.isfinite(value) for value in position_enu):
        raise ValueError(f'{name} is {position_enu}: must be three finite numbers of m')


def horizontal_m(a: Enu, b: Enu) -> float:
    """Return the horizontal distance of two points."""
    return math.hypot(b[0] - a[0], b[1] - a[1])


@dataclass(frozen=True, slots=True, kw_only=True)
class RouteWaypoint:
    """A viewpoint to be photographed.

    Attributes
    ----------
    viewpoint_id
        Number within the plan.
    position_enu
        Place of the camera, metres about the mission origin.
    yaw_rad
        Yaw of the vehicle while it photographs, rad, ENU.
    approach_enu
        Bends of the way to it, metres; passed without a photograph.
    """

    viewpoint_id: int
    position_enu: Enu
    yaw_rad: float
    approach_enu: tuple[Enu, ...] = ()

    def __post_init__(self) -> None:
        for bend in self.approach_enu:
            require_enu(f'approach_enu of viewpoint {self.viewpoint_id}', bend)
        require_enu(f'position_enu of viewpoint {self.viewpoint_id}', self.position_enu)
        if not math.isfinite(self.yaw_rad):
            raise ValueError(f'yaw_rad of viewpoint {self.viewpoint_id} is {self.yaw_rad}')


@dataclass(frozen=True, slots=True, kw_only=True)
class BatterySwap:
    """A landing at home to change the battery.

    Attributes
    ----------
    after
        Number of viewpoints photographed before it.
    homeward_enu
        Bends of the way home, metres.
    """

    after: int
    homeward_enu: tuple[Enu, ...] = ()

    def __post_init__(self) -> None:
        for bend in self.homeward_enu:
            require_enu(f'homeward_enu after {self.after} viewpoints', bend)


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightRoute:
    """Viewpoints in flying order, in one flight or more, and where to land.

    Attributes
    ----------
    plan_id
        Identifier of the plan that the route is part of.
    home_enu
        Place of take-off and landing on the ground, metres.
    waypoints
        Viewpoints in order of flight; empty to call a vehicle in the air home.
    homeward_enu
        Bends of the way from the last viewpoint to the landing place, metres.
    exclusions
        Outlines (east, north) of areas that are never flown over, metres.
    clearance_m
        Distance to keep from them, metres.
    delay_s
        Time on the ground before the first take-off, seconds.
    swaps, swap_s
        Landings for a new battery, and the time on the ground of each, seconds.
    landing_enu
        Place on the ground to land at instead of home, metres.
    is_open
        Whether to land below the last viewpoint instead.
    height_m
        Flight height above uneven ground, metres; 0: the route is flown level.
    begins_enu
        Place in the air where it begins; None: at home.
    """

    plan_id: str
    home_enu: Enu
    waypoints: tuple[RouteWaypoint, ...]
    homeward_enu: tuple[Enu, ...] = ()
    exclusions: tuple[Ring, ...] = ()
    clearance_m: float = 0.0
    delay_s: float = 0.0
    swaps: tuple[BatterySwap, ...] = ()
    swap_s: float = 0.0
    landing_enu: Enu | None = None
    is_open: bool = False
    height_m: float = 0.0
    begins_enu: Enu | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        require_enu('home_enu', self.home_enu)
        if self.landing_enu is not None:
            require_enu('landing_enu', self.landing_enu)
        require_between('delay_s', self.delay_s, 0.0, LONGEST_WAIT_S, 's')
        require_between('swap_s', self.swap_s, 0.0, LONGEST_WAIT_S, 's')
        require_not_negative('height_m', self.height_m, 'm')
        cuts = [swap.after for swap in self.swaps]
        if cuts != sorted(cuts) or not all(0 <= cut <= len(self.waypoints) for cut in cuts):
            raise ValueError(f'swaps after {cuts} viewpoints: must rise, up to all of them')
        for bend in self.homeward_enu:
            require_enu('homeward_enu', bend)
        require_not_negative('clearance_m', self.clearance_m, 'm')
        for ring in self.exclusions:
            if len(ring) < 3 or not all(math.isfinite(v) for place in ring for v in place):
                raise ValueError(f'exclusion {ring}: must be three or more finite places')

    @property
    def is_level(self) -> bool:
        """Whether it is flown at one height."""
        return self.height_m == 0.0

    def begin_of(self, number: int) -> int:
        """Return the index of the first viewpoint of flight `number`, from 0."""
        return self.swaps[number - 1].after if number else 0

    def end_of(self, number: int) -> int:
        """Return the index after the last viewpoint of flight `number`."""
        return len(self.waypoints) if self.is_last(number) else self.swaps[number].after

    def is_last(self, number: int) -> bool:
        """Return whether no flight follows flight `number`."""
        return number == len(self.swaps)

    def landing_of(self, number: int) -> Enu | None:
        """Return the landing place of flight `number`; None: below its last viewpoint."""
        if not self.is_last(number):
            return self.home_enu
        return None if self.is_open else self.landing_enu or self.home_enu

    def ground_below(self, place_enu: Enu) -> Enu:
        """Return the ground below a place; over uneven ground that of the nearest viewpoint."""
        if self.is_level or not self.waypoints:
            return (*place_enu[:2], self.home_enu[2])
        near = min(self.waypoints, key=lambda w: horizontal_m(w.position_enu, place_enu))
        return (*place_enu[:2], near.position_enu[2] - self.height_m)

    def refuge(self, here_enu: Enu, number: int) -> Enu:
        """Return the refuge of flight `number`: home or its landing place, whichever is nearer."""
        landing = self.landing_of(number)
        if landing is None and self.waypoints:
            landing = self.ground_below(self.waypoints[-1].position_enu)
        places = (self.home_enu, landing or self.home_enu)
        return min(places, key=lambda place: horizontal_m(place, here_enu))

    def way_to(self, index: int, here_enu: Enu, number: int = 0) -> tuple[Enu, ...]:
        """Return the remaining bends to viewpoint `index`, or to the landing after the last one.

        A vehicle that was stopped continues with the nearest part of the way.
        """
        begin, is_down = self.begin_of(number), index == self.end_of(number)
        start = self.home_enu if number or self.begins_enu is None else self.begins_enu
        before = self.waypoints[index - 1].position_enu if index > begin else start
        if is_down:
            after = self.landing_of(number) or before
            bends = self.homeward_enu if self.is_last(number) else self.swaps[number].homeward_enu
        else:
            after = self.waypoints[index].position_enu
            bends = self.waypoints[index].approach_enu
        corners = (before, *bends, after)
        offsets = [_offset_m(here_enu, a, b) for a, b in pairwise(corners)]
        part = offsets.index(min(offsets))
        ahead = bends[part:]
        # The way from where the route was begun in the air may not be planned.
        is_planned = index > begin or part > 0 or number > 0 or self.begins_enu is None
        if min(offsets) < ON_WAY_M and is_planned:
            return ahead
        return (*self.around(here_enu, ahead[0] if ahead else after), *ahead)

    def fault(self, here_enu: Enu, index: int = 0, number: int = 0) -> str:
        """Return which exclusion lies on what is left of the route; empty if none.

        The vehicle is at `here_enu` on flight `number`, and viewpoint `index` is its next one. The
        rule is `zone_on_way`.
        """
        for flight in range(number, len(self.swaps) + 1):
            begin = index if flight == number else self.begin_of(flight)
            way = self._way_left(here_enu if flight == number else self.home_enu, begin, flight)
            fault = self.crossed(way)
            if fault:
                return fault
        return ''

    def crossed(self, way: Sequence[Enu]) -> str:
        """Return which exclusion lies on a way; empty if none."""
        fault = zone_on_way(self.exclusions, self.clearance_m, [place[:2] for place in way])
        return '' if fault is None else f'exclusion {fault[1]} lies on leg {fault[0]} of the way'

    def _way_left(self, here_enu: Enu, index: int, number: int) -> list[Enu]:
        """Return the corners of what is left of a flight, from where the vehicle is."""
        way, end = [here_enu], self.end_of(number)
        for viewpoint in range(index, end):
            way += self.way_to(viewpoint, way[-1], number)
            way.append(self.waypoints[viewpoint].position_enu)
        way += self.way_to(end, way[-1], number)
        return [*way, self.landing_of(number) or way[-1]]

    def around(self, here_enu: Enu, there_enu: Enu) -> tuple[Enu, ...]:
        """Return the bends of the way around the exclusions between two places."""
        if not self.exclusions:
            return ()
        ways = _ways_around(self.exclusions, self.clearance_m, there_enu[:2])
        return tuple((east, north, here_enu[2]) for east, north in ways.bends(here_enu[:2]))


@lru_cache(maxsize=32)
def _ways_around(zones: tuple[Ring, ...], clearance_m: float, goal: Place) -> WaysAround:
    """Return the ways around exclusions to a goal; cached, as every battery check asks."""
    return WaysAround(zones, clearance_m, goal)


def _offset_m(place: Enu, a: Enu, b: Enu) -> float:
    """Return the horizontal distance of a place from the straight line between two others."""
    east, north = b[0] - a[0], b[1] - a[1]
    square = east * east + north * north
    along = (place[0] - a[0]) * east + (place[1] - a[1]) * north
    share = min(1.0, max(0.0, along / square)) if square else 0.0
    return horizontal_m(place, (a[0] + share * east, a[1] + share * north, 0.0))
