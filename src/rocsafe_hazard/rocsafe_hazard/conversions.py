# SPDX-License-Identifier: Apache-2.0
"""Maps of hazards and places to measure at -> messages."""

from collections.abc import Sequence

import numpy as np
from nav_msgs.msg import OccupancyGrid

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_hazard.next_places import MeasuringPlace, Verdict
from rocsafe_interfaces.srv import SuggestViewpoints
from rocsafe_ros.conversions import point_of_position, stamp_of_ns

MAP_FRAME = 'map'


def grid_message(
    percent: FloatArray, corner_m: tuple[float, float], cell_m: float, time_ns: int
) -> OccupancyGrid:
    """Return values of 0 to 100 at nodes as cells around these, in the frame of the mission.

    Parameters
    ----------
    percent : (rows, columns)
        Values, rows northwards; the first is at `corner_m`, east and north.
    corner_m, cell_m
        Place of the first node and distance of nodes, metres.
    time_ns
        Stamp, nanoseconds.
    """
    rows, columns = percent.shape
    cells = np.clip(np.round(percent), 0, 100).astype(np.int8)
    message = OccupancyGrid(data=cells.ravel().tolist())
    message.header.stamp = stamp_of_ns(time_ns)
    message.header.frame_id = MAP_FRAME
    message.info.resolution = float(cell_m)
    message.info.width, message.info.height = columns, rows
    # The origin of a message is the corner of a cell, a node is its middle.
    message.info.origin.position.x = corner_m[0] - cell_m / 2.0
    message.info.origin.position.y = corner_m[1] - cell_m / 2.0
    message.info.origin.orientation.w = 1.0
    return message


def fill_suggestion(
    response: SuggestViewpoints.Response,
    verdict: Verdict,
    places: Sequence[MeasuringPlace],
    frame: LocalFrame,
) -> SuggestViewpoints.Response:
    """Return `response` with the places to measure at next and the reason."""
    response.status = SuggestViewpoints.Response.OK
    response.is_enough, response.reason = verdict.is_enough, verdict.reason
    response.viewpoints = [point_of_position(frame.position_of(one.place_m)) for one in places]
    response.expected_gain = [one.gain for one in places]
    return response
