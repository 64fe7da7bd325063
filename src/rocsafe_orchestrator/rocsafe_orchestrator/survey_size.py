# SPDX-License-Identifier: Apache-2.0
"""How large a survey is, before the planner is asked."""

import math

from rocsafe_geo.area import SurveyArea
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_orchestrator.scenario_blocks import CameraBlock, SurveyBlock


def spacing_m(survey: SurveyBlock, camera: CameraBlock) -> float:
    """Return the distance between neighbouring viewpoints, metres.

    Smyth et al. (2018), section IV: with footprint F = 2 h tan(fov / 2) and overlap y the rule
    ``iou`` gives F (1 - y) / (1 + y), surveyors' rule ``linear`` F (1 - y).
    """
    half_angle = math.radians(camera.horizontal_fov_deg) / 2.0
    footprint = 2.0 * survey.height_agl_m * math.tan(half_angle)
    overlap = survey.overlap_fraction
    if survey.spacing_rule == 'iou':
        return footprint * (1.0 - overlap) / (1.0 + overlap)
    return footprint * (1.0 - overlap)


def area_m2(area: SurveyArea) -> float:
    """Return the ground inside `area`, less its holes, square metres."""
    centroid = area.centroid()
    on_ellipsoid = GeoPosition(
        latitude_deg=centroid.latitude_deg, longitude_deg=centroid.longitude_deg, altitude_m=0.0
    )
    return float(area.polygon(LocalFrame(on_ellipsoid)).area)


def fewest_viewpoints(area: SurveyArea, survey: SurveyBlock, camera: CameraBlock) -> int:
    """Return a number of viewpoints below which no grid covers `area`.

    Tiles that touch the boundary are flown too, so that the plan has more: by about half the
    boundary's length over the spacing.
    """
    return math.ceil(area_m2(area) / spacing_m(survey, camera) ** 2)
