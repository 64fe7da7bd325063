# SPDX-License-Identifier: Apache-2.0
"""Size of a survey: spacing, area and number of viewpoints, before it is planned."""

import math

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.plan.survey_options import spacing_m
from rocsafe_scenario.blocks.cameras import CameraBlock
from rocsafe_scenario.blocks.mission import SurveyBlock


def spacings_m(survey: SurveyBlock, camera: CameraBlock) -> tuple[float, float]:
    """Return the distances between neighbouring viewpoints across and along, metres.

    Across is the side of the image's width, along that of its height.
    """
    coverage = survey.coverage()
    width = 2.0 * survey.height_agl_m * math.tan(math.radians(camera.horizontal_fov_deg) / 2.0)
    height = width * camera.image_height_px / camera.image_width_px
    across = spacing_m(width, coverage.overlap_fraction, coverage.spacing_rule)
    return across, spacing_m(height, coverage.front_overlap, coverage.spacing_rule)


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
    return math.ceil(area_m2(area) / math.prod(spacings_m(survey, camera)))
