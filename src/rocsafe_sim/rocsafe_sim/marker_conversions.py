# SPDX-License-Identifier: Apache-2.0
"""Markers of routes and scenes for RViz and Foxglove."""

from collections.abc import Iterator

from geometry_msgs.msg import Point, Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from rocsafe_geo.motion.state import Enu
from rocsafe_ros.conversions import MAP_FRAME, yaw_quaternion
from rocsafe_scene.scenery.scene import Scene, Thing
from rocsafe_sim.flight.route import FlightRoute

_LINE_WIDTH_M = 0.5
_DOT_WIDTH_M = 1.2
_ROUTE_COLOUR = ColorRGBA(r=0.12, g=0.47, b=0.71, a=1.0)
_DOT_COLOUR = ColorRGBA(r=1.0, g=0.5, b=0.05, a=1.0)
_THING_ALPHA = 0.9


def route_markers(route: FlightRoute) -> MarkerArray:
    """Return the planned route as a line from home to home, and a dot for each viewpoint."""
    stops = [waypoint.position_enu for waypoint in route.waypoints]
    line = _marker('route', 0, Marker.LINE_STRIP, _ROUTE_COLOUR)
    line.scale = Vector3(x=_LINE_WIDTH_M, y=0.0, z=0.0)
    line.points = [_point(place) for place in _track(route)]
    dots = _marker('viewpoints', 0, Marker.SPHERE_LIST, _DOT_COLOUR)
    dots.scale = Vector3(x=_DOT_WIDTH_M, y=_DOT_WIDTH_M, z=_DOT_WIDTH_M)
    dots.points = [_point(stop) for stop in stops]
    return MarkerArray(markers=[line, dots])


def _track(route: FlightRoute) -> Iterator[Enu]:
    """Yield the corners of the planned track."""
    yield route.home_enu
    for waypoint in route.waypoints:
        yield from waypoint.approach_enu
        yield waypoint.position_enu
    yield from route.homeward_enu
    yield route.home_enu


def scene_markers(scene: Scene) -> MarkerArray:
    """Return a box with a name for each object of a scene."""
    solid = [thing for thing in scene.things if thing.size_m[2] > 0.0]
    return MarkerArray(markers=[_box(number, thing) for number, thing in enumerate(solid)])


def _box(number: int, thing: Thing) -> Marker:
    red, green, blue = (part / 255.0 for part in thing.colour)
    colour = ColorRGBA(r=red, g=green, b=blue, a=_THING_ALPHA)
    box = _marker(thing.kind, number, Marker.CUBE, colour)
    length, width, height = thing.size_m
    box.scale = Vector3(x=length, y=width, z=height)
    position = (thing.placing.east_m, thing.placing.north_m, 0.5 * height)
    box.pose.position = _point(position)
    box.pose.orientation = yaw_quaternion(thing.placing.yaw_rad)
    box.text = thing.name
    return box


def _marker(namespace: str, number: int, kind: int, colour: ColorRGBA) -> Marker:
    marker = Marker(
        header=Header(frame_id=MAP_FRAME), ns=namespace, id=number, type=kind, color=colour
    )
    marker.action = Marker.ADD
    marker.pose.orientation.w = 1.0
    return marker


def _point(position_enu: Enu) -> Point:
    x, y, z = position_enu
    return Point(x=x, y=y, z=z)
