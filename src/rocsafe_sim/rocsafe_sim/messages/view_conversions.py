# SPDX-License-Identifier: Apache-2.0
"""What a live view draws, out of messages in the frame of the mission."""

import math
from collections.abc import Iterator

import numpy as np
from geometry_msgs.msg import Pose
from nav_msgs.msg import Odometry, Path
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from rocsafe_scene.live.live_view import DrawnLine, Sight
from rocsafe_scene.live.overlay import COLOURS, Colour

LINES = (Marker.LINE_STRIP, Marker.LINE_LIST)


def sight_of(name: str, message: Odometry) -> Sight:
    """Return where a vehicle is, and where it looks."""
    pose: Pose = message.pose.pose
    place, turn = pose.position, pose.orientation
    yaw = math.atan2(
        2.0 * (turn.w * turn.z + turn.x * turn.y), 1.0 - 2.0 * (turn.y**2 + turn.z**2)
    )
    return Sight(name=name, place=(place.x, place.y, place.z), yaw_rad=yaw)


def track_of(number: int, message: Path) -> DrawnLine:
    """Return the track of a vehicle in its colour."""
    places = [each.pose.position for each in message.poses]
    rows = np.array([(p.x, p.y, p.z) for p in places], np.float64).reshape(-1, 3)
    return DrawnLine(places=rows, colour=COLOURS[number % len(COLOURS)], width_px=2)


def lines_of(message: MarkerArray) -> list[DrawnLine]:
    """Return the lines among markers; points and texts are not drawn."""
    return [line for marker in message.markers for line in _lines(marker)]


def _lines(marker: Marker) -> Iterator[DrawnLine]:
    if marker.type not in LINES or marker.action != Marker.ADD:
        return
    at = marker.pose.position
    points = [(p.x + at.x, p.y + at.y, p.z + at.z) for p in marker.points]
    pieces = [points]
    if marker.type == Marker.LINE_LIST:
        pieces = [points[k : k + 2] for k in range(0, len(points), 2)]
    for piece in pieces:
        yield DrawnLine(
            places=np.array(piece, np.float64).reshape(-1, 3), colour=_bgr(marker.color)
        )


def _bgr(colour: ColorRGBA) -> Colour:
    blue, green, red = (
        round(255.0 * min(max(one, 0.0), 1.0)) for one in (colour.b, colour.g, colour.r)
    )
    return blue, green, red
