# SPDX-License-Identifier: Apache-2.0
"""Drives of ground vehicles: values of this package <-> messages."""

from typing import Any

from rocsafe_console.orders.order_book import Errand, Order
from rocsafe_console.picture.vehicle import Vehicle
from rocsafe_interfaces.action import PlanGroundRoute
from rocsafe_interfaces.msg import EvidencePoint, GeoPoint, GroundRoute

# Those of a scenario that does not name its own (docs/ground.md).
TURN_BACK_USVH = 100_000.0
ENDURANCE_S = 7200.0
DWELL_S = 10.0


def plan_goal(order: Order, vehicle: Vehicle) -> PlanGroundRoute.Goal:
    """Return the request for a drive from where a vehicle stands to a place, and home.

    Raises
    ------
    ValueError
        If the order has no such place.
    """
    errand = order.target
    if not isinstance(errand, Errand):
        raise ValueError('target: must be a place to drive to')  # noqa: TRY004 - of the operator
    place = GeoPoint(
        latitude=errand.latitude_deg, longitude=errand.longitude_deg, altitude=vehicle.altitude_m
    )
    home = vehicle.home
    return PlanGroundRoute.Goal(
        vehicle=vehicle.name,
        start=GeoPoint(
            latitude=vehicle.latitude_deg,
            longitude=vehicle.longitude_deg,
            altitude=vehicle.altitude_m,
        ),
        end=[GeoPoint(latitude=home[0], longitude=home[1], altitude=home[2])] if home else [],
        evidence=[
            EvidencePoint(
                id=f'{order.user}-{order.request_id[:6]}', kind='mark', position=place,
                priority=1.0, dwell_s=DWELL_S,
            )
        ],
        dose_budget_usv=errand.dose_budget_usv,
        turn_back_usvh=TURN_BACK_USVH,
        endurance_s=ENDURANCE_S,
    )  # fmt: skip


def drive_of(message: GroundRoute) -> dict[str, Any]:
    """Return what the page shows of a drive."""
    return {
        'route_id': message.route_id,
        'vehicle': message.vehicle,
        'line': [[stop.position.latitude, stop.position.longitude] for stop in message.stops],
        'stands': [
            {'id': stop.evidence, 'place': [stop.position.latitude, stop.position.longitude]}
            for stop in message.stops
            if stop.evidence
        ],
        'duration_s': message.duration_s,
        'dose_usv': message.dose_usv,
        'dose_upper_usv': message.dose_upper_usv,
        'dose_budget_usv': message.dose_budget_usv,
        'lower_bound_s': message.lower_bound_s,
        'left_out': list(message.left_out),
    }
