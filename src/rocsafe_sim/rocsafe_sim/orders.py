# SPDX-License-Identifier: Apache-2.0
"""Orders to a vehicle, and the flight that follows from each."""

from dataclasses import dataclass
from enum import Enum

from rocsafe_sim.airframe import Airframe
from rocsafe_sim.route import Route
from rocsafe_sim.segment import Pose
from rocsafe_sim.timeline import (
    Timeline,
    fly_segments,
    hold_segments,
    land_segments,
    return_segments,
)


class OrderKind(Enum):
    """What the vehicle was last told to do."""

    FLY = 'fly'
    HOLD = 'hold'
    RETURN = 'return'
    LAND = 'land'


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """An order, with the state in which it reached the vehicle: its flight follows from these.

    Attributes
    ----------
    kind : what to do.
    start_ns : simulated time.
    start : pose at that time.
    first_index : first viewpoint of the route that is not yet photographed.
    charge_fraction : left in the battery at that time.
    distance_m : flown until that time since power-up.
    """

    kind: OrderKind
    start_ns: int
    start: Pose
    first_index: int
    charge_fraction: float
    distance_m: float


def timeline_of(order: Order, route: Route, airframe: Airframe) -> Timeline:
    """Return what a vehicle flies from `order` on."""
    if order.kind is OrderKind.FLY:
        return Timeline(fly_segments(airframe, order.start, route, order.first_index))
    if order.kind is OrderKind.HOLD:
        return Timeline(hold_segments(airframe, order.start))
    if order.kind is OrderKind.RETURN:
        return Timeline(return_segments(airframe, order.start, route.home_enu))
    return Timeline(land_segments(airframe, order.start, route.home_enu[2]))
