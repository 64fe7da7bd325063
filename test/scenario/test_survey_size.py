# SPDX-License-Identifier: Apache-2.0
"""Spacing and area of a survey have the published values."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyproj import Geod

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_scenario.blocks.cameras import CameraBlock
from rocsafe_scenario.blocks.mission import SurveyBlock
from rocsafe_scenario.survey_size import area_m2, fewest_viewpoints, spacings_m


def survey(**keys: Any) -> SurveyBlock:
    """Return a survey at 32 m with an overlap of 0.2."""
    return SurveyBlock(**{'height_agl_m': 32.0, 'overlap_fraction': 0.2, **keys})


def square_camera(fov_deg: float) -> CameraBlock:
    """Return a camera with a square image."""
    return CameraBlock(horizontal_fov_deg=fov_deg, image_width_px=480, image_height_px=480)


def rectangle(south: float, west: float, height_deg: float, width_deg: float) -> SurveyArea:
    """Return a rectangle in degrees."""
    corners = [(south, west), (south, west + width_deg),
               (south + height_deg, west + width_deg), (south + height_deg, west)]  # fmt: skip
    return SurveyArea(boundary=tuple(GeoPosition(lat, lon, 0.0) for lat, lon in corners))


@pytest.mark.parametrize(('fov_deg', 'spacing'), [(60.0, 24.634), (90.0, 42.667)])
def test_spacing_is_that_of_the_paper(fov_deg: float, spacing: float) -> None:
    """Smyth et al. (2018), section IV, at 32 m with an overlap of 0.2."""
    expected = pytest.approx((spacing, spacing), abs=1e-3)
    assert spacings_m(survey(spacing_rule='iou'), square_camera(fov_deg)) == expected


def test_linear_spacing_leaves_out_the_overlap() -> None:
    """A footprint of 64 m with an overlap of 0.2, along the flight of 0.5."""
    rule = survey(spacing_rule='linear', front_overlap_fraction=0.5)
    assert spacings_m(rule, square_camera(90.0)) == pytest.approx((51.2, 32.0))


@given(st.floats(0.0, 0.94), st.floats(0.005, 0.01))
def test_more_overlap_is_a_closer_spacing(overlap: float, more: float) -> None:
    """By both rules; and ``iou`` is never wider than ``linear``."""
    camera = square_camera(60.0)
    wide = {}
    for rule in ('iou', 'linear'):
        wide[rule], closer = (
            spacings_m(survey(spacing_rule=rule, overlap_fraction=value), camera)[0]
            for value in (overlap, overlap + more)
        )
        assert closer < wide[rule]
    assert wide['iou'] <= wide['linear']


@given(st.floats(-60.0, 60.0), st.floats(-170.0, 170.0))
def test_area_agrees_with_that_on_the_ellipsoid(south: float, west: float) -> None:
    """The flat frame errs by less than 0.1 % on a field of some hundred metres."""
    field = rectangle(south, west, 0.002, 0.003)
    expected, _ = Geod(ellps='WGS84').polygon_area_perimeter(
        [corner.longitude_deg for corner in field.boundary],
        [corner.latitude_deg for corner in field.boundary],
    )
    assert area_m2(field) == pytest.approx(abs(expected), rel=1e-3)


def test_fewest_viewpoints_fill_the_area() -> None:
    """One fewer would not."""
    field, camera = rectangle(53.28, -9.06, 0.001, 0.002), square_camera(60.0)
    count = fewest_viewpoints(field, survey(), camera)
    cell_m2 = math.prod(spacings_m(survey(), camera))
    assert (count - 1) * cell_m2 < area_m2(field) <= count * cell_m2
