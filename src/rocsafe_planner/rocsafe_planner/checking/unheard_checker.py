# SPDX-License-Identifier: Apache-2.0
"""Check that routes keep away from the possible places of unheard vehicles."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import shapely

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_planner.checking.checked_track import frame_of, motion_of, terrain_shift_m
from rocsafe_planner.checking.flight_checker import ABSOLUTE_M, Fault
from rocsafe_planner.plan.plan import Route, SurveyPlan
from rocsafe_planner.plan.survey_options import UnheardVehicle

_SAMPLE_S = 0.2
# A vehicle that moves no farther in a sample climbs or descends.
_STANDS_M = 1e-3


def unheard_faults(plan: SurveyPlan) -> Iterator[Fault]:
    """Yield routes that are near such a vehicle although the plan does not say so."""
    frame = frame_of(plan)
    for route in plan.routes:
        if route.vehicle.name in plan.near_unheard:
            continue
        for one in plan.request.continuation.unheard:
            if any(_comes_near(plan, route, k, one, frame) for k in range(len(route.sorties))):
                yield f'{route.vehicle.name}: comes near to where {one.name} may be, not stated'


def _comes_near(
    plan: SurveyPlan, route: Route, number: int, one: UnheardVehicle, frame: LocalFrame
) -> bool:
    motion = motion_of(plan, route, number, frame)
    times = _SAMPLE_S * np.arange(int(motion.duration_s / _SAMPLE_S) + 1, dtype=np.float64)
    places = motion.positions(times)
    heights, climbs = _heights_m(plan, places, frame), _stands(places)
    separation_m = plan.request.separation.distance_m
    home = frame.plane_of((one.home,))[0]
    corners = [home, *frame.plane_of(one.places), home]
    reach = shapely.union_all(
        [shapely.convex_hull(shapely.multipoints([home, a, b])) for a, b in pairwise(corners)]
    )
    points, least = shapely.points(places[:, :2]), separation_m - ABSOLUTE_M
    # Over terrain the height of legs follows the ground; their layer is checked by itself.
    may_meet = climbs if plan.request.terrain is not None else np.ones_like(climbs)
    is_level = np.abs(heights - one.flight_height_m) < separation_m - ABSOLUTE_M
    is_below = heights < one.flight_height_m + separation_m - ABSOLUTE_M
    meets = may_meet & is_level & (shapely.distance(points, reach) < least)
    crosses = is_below & (np.hypot(*(places[:, :2] - home).T) < least)
    return bool((meets | crosses).any())


def _stands(places: FloatArray) -> BoolArray:
    moved = np.hypot(*np.diff(places[:, :2], axis=0, prepend=places[:1, :2]).T)
    stands: BoolArray = moved < _STANDS_M
    return stands


def _heights_m(plan: SurveyPlan, places: FloatArray, frame: LocalFrame) -> FloatArray:
    """Return heights above the ground."""
    terrain = plan.request.terrain
    if terrain is None:
        return places[:, 2]
    latitudes, longitudes, _ = frame.to_geodetic(places).T
    heights: FloatArray = places[:, 2] - terrain.altitudes_m(latitudes, longitudes)
    return heights - terrain_shift_m(plan)
