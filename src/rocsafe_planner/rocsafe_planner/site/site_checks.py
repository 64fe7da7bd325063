# SPDX-License-Identifier: Apache-2.0
"""Checks of places: near the regions, and in no exclusion."""

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.position import distance_m
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_planner.problem.airspace import Airspace

MAX_HOME_DISTANCE_M = 100_000.0
"""Homes further from the first region's centre than this are a slip of the pen."""


def check_distances(request: SurveyRequest) -> None:
    """Raise ValueError if a region, home, end or vehicle is too far from the first region."""
    centre = request.regions[0].area.centroid()
    places = [(f'region {r.area.name!r}', r.area.centroid()) for r in request.regions[1:]]
    places.extend(
        (f'viewpoint {view.id}', view.position) for view in request.continuation.viewpoints
    )
    for vehicle in request.vehicles:
        places.append((f'{vehicle.name} home', vehicle.home))
        if vehicle.aloft is not None:
            places.append((vehicle.name, vehicle.aloft.position))
        if vehicle.end is not None:
            places.append((f'{vehicle.name} end', vehicle.end))
    for what, place in places:
        distance = distance_m(centre, place)
        if distance > MAX_HOME_DISTANCE_M:
            raise ValueError(
                f'{what} is {distance / 1000.0:.0f} km from the region: must be '
                f'within {MAX_HOME_DISTANCE_M / 1000.0:.0f} km'
            )


def check_stands(
    vehicles: tuple[Vehicle, ...],
    airspace: Airspace,
    places: tuple[FloatArray, FloatArray, FloatArray],
) -> None:
    """Raise ValueError if a start, home or end, (m, 2) each, lies in an exclusion.

    A vehicle in the air may be in one that is new: see `exits`.
    """
    for what, stands in zip(('start', 'home', 'end'), places, strict=True):
        for vehicle, is_free in zip(vehicles, airspace.holds(stands).tolist(), strict=True):
            if not is_free and not (what == 'start' and vehicle.aloft is not None):
                where = 'home' if what == 'start' and vehicle.aloft is None else what
                raise ValueError(
                    f'{vehicle.name} {where} lies in an exclusion, or nearer to it than '
                    'clearance_m: must be outside'
                )


def check_ups(vehicles: tuple[Vehicle, ...], heights_m: FloatArray, clearance_m: float) -> None:
    """Raise ValueError if a vehicle in the air, (m,) or NaN, is deep in the ground.

    A depth less than the clearance may be an error of the terrain or of the position.
    """
    for vehicle, height_m in zip(vehicles, heights_m.tolist(), strict=True):
        if height_m < -clearance_m:
            raise ValueError(
                f'{vehicle.name} is in the air {-height_m:.1f} m below the terrain: must be at '
                f'most terrain_clearance_m, {clearance_m:g} m'
            )


def exits(
    vehicles: tuple[Vehicle, ...], airspace: Airspace, starts: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return where vehicles in the air leave the exclusions that they are in, and from where.

    Returns
    -------
    starts
        (m, 2), those in an exclusion moved to the nearest place outside.
    insides
        (m, 2), where those are that were moved; NaN for the others.
    """
    moved, insides = starts.copy(), np.full(starts.shape, np.nan)
    for k in np.flatnonzero(~airspace.holds(starts)).tolist():
        if vehicles[k].aloft is not None:
            moved[k], insides[k] = airspace.exit(starts[k]), starts[k]
    return moved, insides
