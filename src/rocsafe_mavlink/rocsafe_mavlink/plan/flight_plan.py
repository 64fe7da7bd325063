# SPDX-License-Identifier: Apache-2.0
"""A route to fly, and the mission with which an autopilot flies it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise

from rocsafe_geo.limits import require_between, require_not_negative, require_positive
from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.autopilots.autopilot import Autopilot
from rocsafe_mavlink.plan.lanes import lanes
from rocsafe_mavlink.protocols.mission_item import GLOBAL, MISSION_FRAME, MissionItem
from rocsafe_mavlink.wire.authority import (
    CONDITION_YAW,
    DO_CHANGE_SPEED,
    DO_DIGICAM_CONTROL,
    DO_SET_CAM_TRIGG_DIST,
)
from rocsafe_mavlink.wire.units import e7_of_deg

WAYPOINT, RETURN_TO_LAUNCH, TAKEOFF = 16, 20, 22
GROUND_SPEED = 1.0
SHOOT = 1
LARGEST_HOLD_S = 3600.0


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightWaypoint:
    """A place to fly to.

    Attributes
    ----------
    position
        Latitude and longitude; the altitude is not used.
    height_m
        Height above home, positive; 0 on a drive.
    hold_s
        Time to stay there.
    heading_deg
        Heading there, clockwise from north.
    height_agl_m
        Height above the ground there; None: not known, taken to be that above home.
    is_bend
        Whether the way only bends there: nothing is photographed or counted.
    speed_mps
        Speed over ground on the way to it; None: that of the plan.
    """

    position: GeoPosition
    height_m: float
    hold_s: float = 0.0
    heading_deg: float = 0.0
    height_agl_m: float | None = None
    is_bend: bool = False
    speed_mps: float | None = None

    def __post_init__(self) -> None:
        require_not_negative('height_m', self.height_m)
        if self.speed_mps is not None:
            require_positive('speed_mps', self.speed_mps, 'm/s')
        require_between('hold_s', self.hold_s, 0.0, LARGEST_HOLD_S)
        require_between('heading_deg', self.heading_deg, 0.0, 360.0)
        if self.height_agl_m is not None:
            require_positive('height_agl_m', self.height_agl_m, 'm')

    @property
    def height_above_ground_m(self) -> float:
        """Height above the ground as far as it is known, else above home."""
        return self.height_m if self.height_agl_m is None else self.height_agl_m


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightPlan:
    """What is to be flown: take-off, the waypoints in order, return, landing.

    Attributes
    ----------
    waypoints
        At least one; only bends where the vehicle is called home.
    speed_mps
        Speed over ground.
    takes_photographs
        Whether the autopilot triggers its camera at each waypoint.
    home
        Take-off place in the plan; None: wherever the vehicle stands.
    trigger_distance_m
        Distance between camera triggers along straight lanes, instead of one at each waypoint.
        There is none between lanes, and one at each waypoint that lies on no lane. 0: no such
        triggers.
    exclusions
        Outlines that the vehicle does not fly over, on its way home neither.
    clearance_m
        Distance to keep from them.
    is_drive
        Whether a ground vehicle drives it: no take-off, no return, no landing.
    """

    waypoints: tuple[FlightWaypoint, ...]
    speed_mps: float
    takes_photographs: bool = False
    home: GeoPosition | None = None
    trigger_distance_m: float = 0.0
    exclusions: tuple[tuple[GeoPosition, ...], ...] = ()
    clearance_m: float = 0.0
    is_drive: bool = False

    def __post_init__(self) -> None:
        if not self.waypoints:
            raise ValueError('a flight plan must have at least one waypoint')
        for waypoint in () if self.is_drive else self.waypoints:
            require_positive('height_m', waypoint.height_m, 'm')
        require_positive('speed_mps', self.speed_mps, 'm/s')
        require_not_negative('trigger_distance_m', self.trigger_distance_m, 'm')
        require_not_negative('clearance_m', self.clearance_m, 'm')

    @property
    def stops(self) -> tuple[FlightWaypoint, ...]:
        """Waypoints that count: all but the bends."""
        return tuple(waypoint for waypoint in self.waypoints if not waypoint.is_bend)


@dataclass(frozen=True, slots=True, kw_only=True)
class Mission:
    """A flight plan as items of an autopilot.

    Attributes
    ----------
    items
        As they lie on it.
    first_item
        Number of the first item after the take-off, at which a vehicle in the air begins.
    waypoint_items
        Number of the item of each waypoint that counts, ascending.
    """

    items: tuple[MissionItem, ...]
    first_item: int
    waypoint_items: tuple[int, ...]

    @property
    def first_place(self) -> int:
        """Number of the item of its first place after the take-off."""
        ahead = range(self.first_item, len(self.items))
        return next((n for n in ahead if self.items[n].command == WAYPOINT), self.first_item)

    def visited(self, reached_item: int) -> int:
        """Return how many waypoints have been passed once item `reached_item` is reached."""
        return sum(number <= reached_item for number in self.waypoint_items)


def mission_of(plan: FlightPlan, autopilot: Autopilot) -> Mission:
    """Return the mission of `plan` for an autopilot, with home in front where it wants it.

    Raises
    ------
    ValueError
        If a ground vehicle is to fly, or another to drive.
    """
    if plan.is_drive != autopilot.drives:
        wanted = 'drive_route' if autopilot.drives else 'fly_route'
        raise ValueError(f'{autopilot.name}: must get its routes by {wanted}')
    if plan.is_drive:
        return _driven(plan)
    items = [MissionItem(command=WAYPOINT, frame=GLOBAL)] if autopilot.has_home_item else []
    items.append(_takeoff(plan.waypoints[0], autopilot))
    first_item = len(items)
    items.append(_speed(plan.speed_mps))
    numbers: list[int] = []
    turns = _turns(plan.waypoints, autopilot)
    for waypoint, turn, shutter in zip(plan.waypoints, turns, _shutters(plan), strict=True):
        items += turn
        if not waypoint.is_bend:
            numbers.append(len(items))
        items += [_item_of(waypoint, autopilot), *shutter]
    items.append(MissionItem(command=RETURN_TO_LAUNCH, frame=MISSION_FRAME))
    return Mission(items=tuple(items), first_item=first_item, waypoint_items=tuple(numbers))


def _driven(plan: FlightPlan) -> Mission:
    """Return the mission of a ground vehicle: its way with speeds, stands and photographs.

    It ends where the way does: a return of its own would be straight, through what stands there.
    """
    items = [MissionItem(command=WAYPOINT, frame=GLOBAL)]
    numbers: list[int] = []
    speed_mps = 0.0
    shot = MissionItem(command=DO_DIGICAM_CONTROL, frame=MISSION_FRAME, x_e7=SHOOT)
    for waypoint in plan.waypoints:
        wanted_mps = waypoint.speed_mps or plan.speed_mps
        if wanted_mps != speed_mps:
            items.append(_speed(wanted_mps))
            speed_mps = wanted_mps
        if not waypoint.is_bend:
            numbers.append(len(items))
        items.append(_item_at(waypoint, 0.0))
        items += [shot] if plan.takes_photographs and not waypoint.is_bend else []
    return Mission(items=tuple(items), first_item=1, waypoint_items=tuple(numbers))


def _speed(speed_mps: float) -> MissionItem:
    return MissionItem(
        command=DO_CHANGE_SPEED,
        frame=MISSION_FRAME,
        parameters=(GROUND_SPEED, speed_mps, 0.0, 0.0),
    )


def _shutters(plan: FlightPlan) -> list[list[MissionItem]]:
    """Return the camera items after each waypoint."""
    shot = MissionItem(command=DO_DIGICAM_CONTROL, frame=MISSION_FRAME, x_e7=SHOOT)
    is_wanted = plan.takes_photographs or plan.trigger_distance_m > 0.0
    shutters = [[shot] if is_wanted and not way.is_bend else [] for way in plan.waypoints]
    if plan.trigger_distance_m:
        for first, last in _lanes_of(plan):
            shutters[first] = [_trigger(plan.trigger_distance_m, 1.0)]
            shutters[first + 1 : last] = [[] for _ in range(first + 1, last)]
            shutters[last] = [_trigger(0.0, 0.0)]
    return shutters


def _lanes_of(plan: FlightPlan) -> list[tuple[int, int]]:
    """Return the first and last number of the waypoints of each lane; bends lie on none."""
    found: list[tuple[int, int]] = []
    start = 0
    for is_bend, stretch in groupby(plan.waypoints, key=lambda waypoint: waypoint.is_bend):
        places = [waypoint.position for waypoint in stretch]
        if not is_bend:
            found += [(start + first, start + last) for first, last in lanes(places)]
        start += len(places)
    return found


def _trigger(distance_m: float, at_once: float) -> MissionItem:
    return MissionItem(
        command=DO_SET_CAM_TRIGG_DIST,
        frame=MISSION_FRAME,
        parameters=(distance_m, 0.0, at_once, 0.0),
    )


def _turns(waypoints: Sequence[FlightWaypoint], autopilot: Autopilot) -> list[list[MissionItem]]:
    """Return the heading item before each waypoint, where the heading changes."""
    headings_deg = [waypoint.heading_deg for waypoint in waypoints]
    is_told = not autopilot.turns_at_waypoints
    return [
        [_turn(after)] if is_told and (number == 0 or after != before) else []
        for number, (before, after) in enumerate(pairwise([0.0, *headings_deg]))
    ]


def _turn(heading_deg: float) -> MissionItem:
    return MissionItem(
        command=CONDITION_YAW, frame=MISSION_FRAME, parameters=(heading_deg, 0.0, 0.0, 0.0)
    )


def _takeoff(first: FlightWaypoint, autopilot: Autopilot) -> MissionItem:
    """Return the climb to the height of the first waypoint, straight up."""
    if autopilot.flies_to_takeoff:
        return replace(_item_of(first, autopilot), command=TAKEOFF)
    return MissionItem(command=TAKEOFF, z_m=first.height_m)


def _item_of(waypoint: FlightWaypoint, autopilot: Autopilot) -> MissionItem:
    return _item_at(waypoint, waypoint.heading_deg if autopilot.turns_at_waypoints else 0.0)


def _item_at(waypoint: FlightWaypoint, heading_deg: float) -> MissionItem:
    return MissionItem(
        command=WAYPOINT,
        x_e7=e7_of_deg(waypoint.position.latitude_deg),
        y_e7=e7_of_deg(waypoint.position.longitude_deg),
        z_m=waypoint.height_m,
        parameters=(waypoint.hold_s, 0.0, 0.0, heading_deg),
    )
