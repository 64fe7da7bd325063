# SPDX-License-Identifier: Apache-2.0
"""From one line of readings a source could be on either side, and its ellipse says so."""

import math

import numpy as np
import pytest

from rocsafe_radiation.localization.localize import localize
from rocsafe_radiation.readings.survey import RadiationSurvey

from .simulated_survey import LOSSLESS


def along_lines(offsets_m, source, strength_usvh, *, error_m=0.0, seed=0):
    """Return a survey at 3 m along lines to the north, with 1500 cps per uSv/h.

    Its fixes err by `error_m` in each coordinate.
    """
    steps = np.arange(-60.0, 60.1, 2.0)
    places = np.array([(east, north, 3.0) for east in offsets_m for north in steps])
    squares = ((places - [*source, 0.0]) ** 2).sum(axis=1)
    rates = 0.05 + strength_usvh / squares
    generator = np.random.default_rng(seed)
    counts = generator.poisson(1500.0 * rates).astype(float)
    exposures = np.full(len(places), 1500.0)
    fixes = places + generator.normal(0.0, error_m, places.shape)
    return RadiationSurvey(positions_enu_m=fixes, counts=counts, exposures=exposures)


@pytest.mark.slow
def test_beside_a_single_line_both_sides_are_within_the_ellipse():
    """Nothing tells them apart; north is as sure as ever."""
    (source,) = localize(along_lines([0.0], (6.0, 10.0), 3.0), LOSSLESS).sources
    assert abs(source.position_enu_m[0]) == pytest.approx(6.0, abs=2.5)
    for side in (-6.0, 6.0):
        miss = np.array([side, 10.0]) - source.position_enu_m[:2]
        assert miss @ np.linalg.solve(source.covariance_m2[:2, :2], miss) < 5.991
    assert source.ellipse_95()[1] < 4.0


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(6))
def test_errors_of_the_fixes_tell_no_side(seed):
    """They scatter across the line as if the vehicle had been beside it."""
    survey = along_lines([0.0], (12.0, 10.0), 400.0, error_m=0.8, seed=seed)
    for source in localize(survey, LOSSLESS).sources:
        reach_m = math.sqrt(5.991 * source.covariance_m2[0, 0])
        for side in (-12.0, 12.0):
            assert abs(side - source.position_enu_m[0]) < reach_m


@pytest.mark.slow
def test_a_second_line_tells_the_side_with_errors_too():
    """The straightened line leaves the decision to it."""
    survey = along_lines([0.0, 30.0], (12.0, 10.0), 400.0, error_m=0.8)
    (source,) = localize(survey, LOSSLESS).sources
    assert math.dist(source.position_enu_m[:2], (12.0, 10.0)) < 2.0
    assert source.ellipse_95()[0] < 4.0


@pytest.mark.slow
@pytest.mark.parametrize('side', [-5.0, 5.0])
def test_a_second_line_tells_the_side(side):
    """30 m away, it still sees more of a source between the two."""
    found = localize(along_lines([0.0, 30.0], (side, 10.0), 60.0), LOSSLESS)
    (source,) = found.sources
    assert math.dist(source.position_enu_m[:2], (side, 10.0)) < 1.5
    assert source.ellipse_95()[0] < 4.0
