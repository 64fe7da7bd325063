# SPDX-License-Identifier: Apache-2.0
"""Viewpoints that a request names instead of a grid."""

from collections.abc import Collection, Sequence

import numpy as np
import shapely

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_planner.coverage.sight import sight
from rocsafe_planner.coverage.viewpoint_grid import Coverage
from rocsafe_planner.errors import NoWayError, TooManyViewpointsError
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.viewpoint import Viewpoint
from rocsafe_planner.problem.airspace import Airspace


def given_coverage(
    request: SurveyRequest,
    frame: LocalFrame,
    polygons: Sequence[shapely.Polygon],
    airspace: Airspace | None,
    left_out: Collection[int] = (),
) -> Coverage:
    """Return the viewpoints that a request names, without those in exclusions or `left_out`.

    `polygon` of the result is the number of the viewpoint in the request. Those visited before
    count as seen.

    Raises
    ------
    TooManyViewpointsError, NoWayError
        If there are more than the request allows, or none is left.
    """
    views, limit = request.continuation.viewpoints, request.coverage.max_viewpoints
    if len(views) > limit:
        raise TooManyViewpointsError(
            f'{len(views)} viewpoints are given: max_viewpoints is {limit}'
        )
    centres = frame.plane_of([view.position for view in views])
    kept = np.ones(len(views), dtype=bool) if airspace is None else airspace.holds(centres)
    if not kept.any():
        raise NoWayError('exclusions leave no viewpoint: all of them lie inside')
    kept &= np.array([view.id not in left_out for view in views])
    numbers = np.flatnonzero(kept)
    footprints = footprints_of(frame, [views[number] for number in numbers])
    seen = np.vstack([footprints, footprints_of(frame, request.continuation.visited)])
    return Coverage(
        centres=centres[kept],
        yaw_rad=np.array([views[number].yaw_rad for number in numbers]),
        footprints=footprints,
        polygon=numbers,
        sight=sight(polygons, seen, None if airspace is None else airspace.zones),
    )


def footprints_of(frame: LocalFrame, views: Sequence[Viewpoint]) -> FloatArray:
    """Return the corners (east, north) of what viewpoints show, shape (n, 4, 2)."""
    if not views:
        return np.zeros((0, 4, 2))
    return frame.plane_of([c for view in views for c in view.footprint]).reshape(-1, 4, 2)
