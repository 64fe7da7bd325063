# SPDX-License-Identifier: Apache-2.0
"""Size of a survey: spacing, area and number of viewpoints, before it is planned."""

import math

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_scenario.camera_blocks import CameraBlock
from rocsafe_scenario.scenario_blocks import SurveyBlock


def spacing_m(survey: SurveyBlock, camera: CameraBlock) -> tuple[float, float]:
    """Return the distances between neighbouring viewpoints across and along, metres.

    Smyth et al. (2018), section IV: with footprint F = 2 h tan(fov / 2) and overlap y the rule
    ``iou`` gives F (1 - y) / (1 + y), surveyors' rule ``linear`` F (1 - y). Across is the side of
    the image's width, along that of its height.
    """
    half_angle = math.radians(camera.horizontal_fov_deg) / 2.0
    overlap = survey.overlap_fraction
    front = survey.front_overlap_fraction
    width = 2.0 * survey.height_agl_m * math.tan(half_angle)
    height = width * camera.image_height_px / camera.image_width_px
    along = overlap if front is None else front
    return width * _part(overlap, survey), height * _part(along, survey)


def _part(overlap: float, survey: SurveyBlock) -> float:
    """Return the spacing as a fraction of the footprint."""
    return (1.0 - overlap) / (1.0 + overlap if survey.spacing_rule == 'iou' else 1.0)


def area_m2(area: SurveyArea) -> float:
    """Return the ground inside `area`, less its holes, square metres."""
    centroid = area.centroid()
    on_ellipsoid = GeoPosition(
        latitude_deg=centroid.latitude_deg, longitude_deg=centroid.longitude_deg, altitude_m=0.0
    )
    return float(area.polygon(LocalFrame(on_ellipsoid)).area)


def fewest_viewpoints(area: SurveyArea, survey: SurveyBlock, camera: CameraBlock) -> int:
    """Return a lower bound of the number of viewpoints of a grid that covers `area`.

    A plan has more, because tiles that touch the boundary count too: by about half the length of
    the boundary over the spacing.
    """
    return math.ceil(area_m2(area) / math.prod(spacing_m(survey, camera)))
