# SPDX-License-Identifier: Apache-2.0
"""The topic `drawings`: what clients draw into the scene, and the traces of vehicles."""

from collections.abc import Callable, Sequence
from threading import Lock

from geometry_msgs.msg import Point
from rclpy.node import Node
from visualization_msgs.msg import Marker, MarkerArray

from rocsafe_airsim.conversions import marker_of, text_marker_of
from rocsafe_airsim.ned import Vector
from rocsafe_ros.interfaces import topics

MOST_DRAWINGS = 500
# A trace keeps its newest points.
MOST_POINTS = 5000
LEAST_STEP_M = 0.2


class Drawings:
    """Publishes drawings; those beyond the most are forgotten, the oldest first.

    Parameters
    ----------
    node
        Node that publishes.
    """

    def __init__(self, node: Node) -> None:
        self._publisher = topics.create_publisher(node, topics.DRAWINGS)
        self._drawings: dict[int, Marker] = {}
        self._traces: dict[str, Marker] = {}
        self._drawn = 0
        # Clients draw from the thread of the server, traces grow in that of ROS.
        self._lock = Lock()

    def draw(
        self,
        lines: Sequence[Sequence[Vector]],
        rgba: Sequence[float],
        size_m: float,
        *,
        kind: str,
        duration_s: float,
    ) -> None:
        """Show points or lines, in the frame of the mission."""
        with self._lock:
            number = self._next()
            self._keep(marker_of(number, lines, rgba, size_m, kind), duration_s)
            self._publish()

    def write(
        self,
        texts: Sequence[tuple[str, Vector]],
        rgba: Sequence[float],
        size_m: float,
        duration_s: float,
    ) -> None:
        """Show texts at places, in the frame of the mission."""
        with self._lock:
            for text, place in texts:
                marker = text_marker_of(self._next(), text, place, rgba, size_m)
                self._keep(marker, duration_s)
            self._publish()

    def trace(self, vehicle: str, rgba: Sequence[float], size_m: float) -> None:
        """Show where a vehicle flies from now on; what it has flown keeps its colour."""
        with self._lock:
            marker = marker_of(self._next(), [], rgba, size_m, 'lines')
            marker.type = Marker.LINE_STRIP
            self._keep(marker, 0.0)
            self._traces[vehicle] = marker

    def follow(self, place_of: Callable[[str], Vector]) -> None:
        """Lengthen the traces to where the vehicles are."""
        with self._lock:
            grown = [_lengthened(each, place_of(name)) for name, each in self._traces.items()]
            if any(grown):
                self._publish()

    def clear(self) -> None:
        """Remove all drawings; traces begin anew."""
        with self._lock:
            self._drawings.clear()
            for marker in self._traces.values():
                marker.points = []
                self._drawings[marker.id] = marker
            self._publisher.publish(MarkerArray(markers=[Marker(action=Marker.DELETEALL)]))

    def _next(self) -> int:
        self._drawn += 1
        return self._drawn

    def _keep(self, marker: Marker, duration_s: float) -> None:
        marker.lifetime.sec = int(duration_s)
        marker.lifetime.nanosec = int(duration_s % 1.0 * 1e9)
        self._drawings[marker.id] = marker
        while len(self._drawings) > MOST_DRAWINGS:
            del self._drawings[next(iter(self._drawings))]

    def _publish(self) -> None:
        shown = [each for each in self._drawings.values() if each.points or each.text]
        self._publisher.publish(MarkerArray(markers=shown))


def _lengthened(marker: Marker, place: Vector) -> bool:
    x, y, z = place
    points = marker.points
    if (
        points
        and abs(points[-1].x - x) + abs(points[-1].y - y) + abs(points[-1].z - z) < LEAST_STEP_M
    ):
        return False
    points.append(Point(x=x, y=y, z=z))
    del points[:-MOST_POINTS]
    return True
