# SPDX-License-Identifier: Apache-2.0
"""Surveys over hills: how soon there is a plan, and how good it is."""

import math
import time

import numpy as np

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.terrain.terrain import Terrain
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.survey_options import CoverageOptions, Effort
from rocsafe_planner.plan.survey_region import SurveyRegion
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.region_plan import CAMERA

_CENTRE = GeoPosition(53.28, -9.06, 0.0)
_HIGH_M, _EAST_M, _NORTH_M = 20.0, 60.0, 40.0
"""Height of the hills, and metres of a radian of their waves."""
_PIXEL_M = 10.0
_HEIGHT_M = 20.0
_VEHICLES = 3
_ENDURANCE_S = 1e5
_SQUARE = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))


def hills(half_m: float) -> Terrain:
    """Return waves of ground about the centre; pixels are north up and as wide as high."""
    count = 2 * math.ceil(half_m / _PIXEL_M)
    metres = _PIXEL_M * (np.arange(count) + 0.5 - count / 2)
    up = _HIGH_M * np.sin(metres[None, :] / _EAST_M) * np.cos(metres[::-1, None] / _NORTH_M)
    north, east = offset(_CENTRE, 0.0, _PIXEL_M), offset(_CENTRE, _PIXEL_M, 0.0)
    high = north.latitude_deg - _CENTRE.latitude_deg
    wide = east.longitude_deg - _CENTRE.longitude_deg
    return Terrain(
        heights_m=up,
        to_column=(1.0 / wide, 0.0, count / 2 - _CENTRE.longitude_deg / wide),
        to_row=(0.0, -1.0 / high, count / 2 + _CENTRE.latitude_deg / high),
        crs='EPSG:4326',
        digest=f'hills {half_m}',
    )


def hilly_request(side_m: float, budget_s: float) -> SurveyRequest:
    """Return the survey of a square by alike vehicles from one corner of it."""
    half = 0.5 * side_m
    corners = tuple(offset(_CENTRE, e * half, n * half) for e, n in _SQUARE)
    home = GeoPosition(corners[0].latitude_deg, corners[0].longitude_deg, math.nan)
    return SurveyRequest(
        regions=(SurveyRegion(area=SurveyArea(corners)),),
        camera=CAMERA,
        vehicles=tuple(
            Vehicle(name=f'rav{k}', home=home, endurance_s=_ENDURANCE_S) for k in range(_VEHICLES)
        ),
        coverage=CoverageOptions(height_agl_m=_HEIGHT_M, max_viewpoints=20_000),
        terrain=hills(half + 100.0),
        effort=Effort(budget_s=budget_s),
    )


def over_hills(side_m: float, budget_s: float) -> tuple[int, float, float]:
    """Return how many viewpoints a square has, seconds to its first plan, and the proven gap."""
    request = hilly_request(side_m, budget_s)
    began = time.perf_counter()
    first: list[float] = []

    def note(makespan_s: float, _bound_s: float) -> bool:
        if not first and not math.isnan(makespan_s):
            first.append(time.perf_counter() - began)
        return True

    plan = plan_survey(request, note)
    viewpoints = sum(len(route.viewpoints) for route in plan.routes)
    return viewpoints, first[0], plan.gap_fraction
