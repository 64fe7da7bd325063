# SPDX-License-Identifier: Apache-2.0
"""The operator's hand on one vehicle: each order begins an errand, or is refused with the reason.

Nothing here is ever called by the suite itself.
"""

from collections.abc import Sequence

from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.drone.station import Station, Target
from rocsafe_mavlink.errors import OrderRefusedError
from rocsafe_mavlink.flight.command_sequence import Errand
from rocsafe_mavlink.flight.fence import Fence, rally_items
from rocsafe_mavlink.flight.operator_commands import Writer, require_reachable
from rocsafe_mavlink.flight.preflight import FlightLimits
from rocsafe_mavlink.knowledge.vehicle import Vehicle
from rocsafe_mavlink.protocols.mission_results import MissionType


class OperatorOrders:
    """Orders to the vehicle `target` of `station`.

    To hold, to return and to land may replace an order under way; others wait for its end.
    Every method raises `OrderRefusedError`, saying why, if the order cannot be given at all; how
    a given one ends is said by `errand`.
    """

    def __init__(self, target: Target, station: Station, limits: FlightLimits) -> None:
        self._target = target
        self._station = station
        self._limits = limits

    @property
    def errand(self) -> Errand | None:
        """The present or last order."""
        return self._station.member(self._target).errand

    @property
    def count(self) -> int:
        """Number of the present or last order."""
        return self._station.member(self._target).errand_count

    def hold(self, now_s: float) -> None:
        """Stand still, within the mission if one is flown."""
        self._in_air(now_s)
        self._begin(lambda desk, vehicle: desk.hold(vehicle), preempts=True)

    def resume(self, now_s: float) -> None:
        """Go on with the mission."""
        self._in_air(now_s)
        member = self._station.member(self._target)
        if not member.is_flying:
            # What an earlier bridge began is picked up by these.
            seen = (member.stored, member.vehicle.home, member.vehicle.landed or None)
            is_read = None not in seen
            reason = 'no route is being flown' if is_read else 'it is still being read'
            raise OrderRefusedError(reason)
        self._begin(lambda desk, vehicle: desk.resume(vehicle))

    def return_home(self, now_s: float) -> None:
        """Give up the route, fly home and land."""
        self._in_air(now_s)
        self._begin(lambda desk, _vehicle: desk.return_home(), preempts=True)

    def land(self, now_s: float) -> None:
        """Give up the route and land where it is."""
        self._in_air(now_s)
        self._begin(lambda desk, _vehicle: desk.land(), preempts=True)

    def change_speed(self, speed_mps: float, now_s: float) -> None:
        """Fly faster or slower from now on."""
        self._in_air(now_s)
        self._begin(lambda desk, _vehicle: desk.change_speed(speed_mps))

    def go_to(self, place: GeoPosition, height_m: float, now_s: float) -> None:
        """Fly to a place, `height_m` above home, and stay there."""
        vehicle = self._in_air(now_s)
        try:
            home = require_reachable(place, height_m, vehicle.home, self._limits)
        except ValueError as error:
            raise OrderRefusedError(str(error)) from error
        self._require_within_fence(place)
        self._begin(lambda desk, _vehicle: desk.go_to(place, height_m, home))

    def push_fence(self, fence: Fence) -> None:
        """Replace the polygons of the fence."""
        self._begin(lambda desk, _vehicle: desk.push_fence(fence))
        # Read again, as it lies there then: until that is done no flight begins.
        self._station.member(self._target).forget_fence()

    def push_rally(self, points: Sequence[GeoPosition], height_m: float) -> None:
        """Replace the rally points."""
        try:
            items = rally_items(points, height_m)
        except ValueError as error:
            raise OrderRefusedError(str(error)) from error
        self._begin(lambda desk, _vehicle: desk.push(MissionType.RALLY, items))

    def _require_within_fence(self, place: GeoPosition) -> None:
        member = self._station.member(self._target)
        if member.fence is None and not member.fence_error:
            raise OrderRefusedError('its fence is still being read')
        if member.fence is not None and not member.fence.holds(place):
            raise OrderRefusedError('the place is outside the fence')

    def _in_air(self, now_s: float) -> Vehicle:
        try:
            return self._station.require_contact(self._target, now_s)
        except ValueError as error:
            raise OrderRefusedError(str(error)) from error

    def _begin(self, write: Writer, *, preempts: bool = False) -> None:
        try:
            self._station.order(self._target, write, preempts=preempts)
        except ValueError as error:
            raise OrderRefusedError(str(error)) from error
