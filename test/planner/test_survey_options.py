# SPDX-License-Identifier: Apache-2.0
"""Values of a request: known spacings, limits, names, one default each."""

import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_planner.coverage.viewpoint_grid import GRIDS as GRID_MAKERS
from rocsafe_planner.plan import survey_options
from rocsafe_planner.plan.objective import OBJECTIVE_UNITS, OBJECTIVE_VALUES
from rocsafe_planner.plan.survey_options import (
    GRIDS,
    METHODS,
    OBJECTIVES,
    AirspaceOptions,
    CoverageOptions,
    Effort,
    SeparationOptions,
    spacing_m,
)
from rocsafe_planner.routing.methods import METHODS as METHOD_FUNCTIONS
from rocsafe_scenario.blocks.mission import SurveyBlock


@pytest.mark.parametrize(('fov_deg', 'expected_m'), [(60.0, 24.634), (90.0, 42.667)])
def test_spacing_is_that_of_the_paper(fov_deg, expected_m):
    """Smyth et al. 2018: 32 m high, overlap 0.2."""
    across, _ = PinholeCamera(math.radians(fov_deg), 640, 480).footprint_m(32.0)
    assert spacing_m(across, 0.2, 'iou') == pytest.approx(expected_m, abs=5e-4)


@given(st.floats(0.1, 1e3), st.floats(0.0, 0.99))
def test_spacing_keeps_what_its_rule_promises(footprint_m, overlap):
    """Of two photographs in a row, the shared part of all ground, or of one photograph."""
    iou = spacing_m(footprint_m, overlap, 'iou')
    linear = spacing_m(footprint_m, overlap, 'linear')
    assert (footprint_m - iou) / (footprint_m + iou) == pytest.approx(overlap, abs=1e-9)
    assert (footprint_m - linear) / footprint_m == pytest.approx(overlap, abs=1e-9)
    assert 0.0 < iou <= linear <= footprint_m * (1.0 + 1e-12)


def test_names_are_those_of_what_carries_them_out():
    """Every name that a request may give has a function."""
    assert set(METHODS) == set(METHOD_FUNCTIONS)
    assert set(GRIDS) == set(GRID_MAKERS)
    assert set(OBJECTIVES) == set(OBJECTIVE_VALUES) == set(OBJECTIVE_UNITS)


def test_scenario_has_the_same_defaults():
    """A scenario that leaves a key out asks for what a request that leaves it out asks for."""
    block = SurveyBlock(height_agl_m=32.0)
    assert block.coverage() == CoverageOptions(height_agl_m=32.0)
    assert block.airspace.options() == AirspaceOptions()
    assert SeparationOptions(**block.separation.model_dump()) == SeparationOptions()
    assert Effort(**block.effort.model_dump(exclude={'method'})) == Effort()


@pytest.mark.parametrize(
    ('kind', 'values', 'message'),
    [
        ('CoverageOptions', {'height_agl_m': 9.0, 'front_overlap_fraction': 1.0}, 'front_overlap'),
        ('AirspaceOptions', {'clearance_m': -1.0}, 'clearance_m is -1 m: must be 0 to 1000'),
        ('AirspaceOptions', {'terrain_clearance_m': 0.0}, 'terrain_clearance_m is 0 m'),
        ('AirspaceOptions', {'max_height_agl_m': 0.0}, 'max_height_agl_m is 0 m'),
        ('AirspaceOptions', {'wind_mps': (math.nan, 0.0)}, 'wind_mps is nan'),
        ('SeparationOptions', {'distance_m': -1.0}, 'separation distance_m is -1 m'),
        ('SeparationOptions', {'by': 'luck'}, 'must be one of delay, layers'),
        ('Effort', {'objective': 'luck'}, "objective is 'luck'"),
        ('Effort', {'proposals': -1}, 'proposals is -1'),
    ],
)
def test_limits_are_named(kind, values, message):
    """Argument, value and limit."""
    with pytest.raises(ValueError, match=message):
        getattr(survey_options, kind)(**values)


def test_whole_numbers_are_as_good_as_decimal_ones():
    """The same request has the same identity however its numbers are written."""
    assert dataclasses.asdict(CoverageOptions(height_agl_m=32)) == dataclasses.asdict(
        CoverageOptions(height_agl_m=32.0)
    )
    assert isinstance(AirspaceOptions(clearance_m=2).clearance_m, float)
