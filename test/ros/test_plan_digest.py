# SPDX-License-Identifier: Apache-2.0
"""Hashes by which a person confirms what real vehicles fly."""

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.serialization import deserialize_message, serialize_message

from rocsafe_interfaces.msg import GeoPoint, Route, Viewpoint
from rocsafe_ros.plan_digest import plan_digest, route_digest


def route(**fields: object) -> Route:
    """Return a route with one viewpoint."""
    place = GeoPoint(latitude=47.1, longitude=8.2, altitude=float('nan'))
    return Route(vehicle='rav1', viewpoints=[Viewpoint(id=3, position=place)], **fields)


def test_route_has_the_same_hash_on_the_wire() -> None:
    """Who sends it and who receives it compute the same."""
    sent = route(length_m=0.1 + 0.2)
    heard = deserialize_message(serialize_message(sent), Route)
    assert route_digest('p', heard) == route_digest('p', sent)


def test_any_change_changes_the_hash() -> None:
    """Plan, viewpoint, position in its last digit, order."""
    moved = route()
    moved.viewpoints[0].position.latitude += 1e-14
    other = route()
    other.viewpoints.append(Viewpoint(id=4))
    hashes = {
        route_digest('p', route()),
        route_digest('q', route()),
        route_digest('p', moved),
        route_digest('p', other),
        plan_digest('p', [route(), other]),
        plan_digest('p', [other, route()]),
    }
    assert len(hashes) == 6
