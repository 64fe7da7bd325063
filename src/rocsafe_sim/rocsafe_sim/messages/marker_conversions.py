# SPDX-License-Identifier: Apache-2.0
"""Markers of routes and scenes for RViz and Foxglove."""

from collections.abc import Iterable, Iterator

from geometry_msgs.msg import Point, Quaternion, Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from rocsafe_geo.motion.state import Enu
from rocsafe_ros.conversions import MAP_FRAME
from rocsafe_scene.flat_ground.scene_box import SceneBox
from rocsafe_scene.mesh.classes import CLASSES
from rocsafe_sim.flight.route import FlightRoute

_LINE_WIDTH_M = 0.5
_DOT_WIDTH_M = 1.2
_ROUTE_COLOUR = ColorRGBA(r=0.12, g=0.47, b=0.71, a=1.0)
_DOT_COLOUR = ColorRGBA(r=1.0, g=0.5, b=0.05, a=1.0)
_BOX_ALPHA = 0.9


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


def scene_markers(boxes: Iterable[SceneBox]) -> MarkerArray:
    """Return a marker for each box, with the name of its object, in the colour of its class."""
    return MarkerArray(markers=[_box(number, box) for number, box in enumerate(boxes)])


def _box(number: int, box: SceneBox) -> Marker:
    red, green, blue = (part / 255.0 for part in CLASSES[box.label].colour)
    colour = ColorRGBA(r=red, g=green, b=blue, a=_BOX_ALPHA)
    marker = _marker(box.label, number, Marker.CUBE, colour)
    length, width, height = box.size_m
    marker.scale = Vector3(x=length, y=width, z=height)
    marker.pose.position = _point(box.position_enu)
    x, y, z, w = box.quaternion
    marker.pose.orientation = Quaternion(x=x, y=y, z=z, w=w)
    marker.text = box.name
    return marker


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
