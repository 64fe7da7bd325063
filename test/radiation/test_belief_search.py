# SPDX-License-Identifier: Apache-2.0
"""The grid of beliefs finds what the likelihood finds, more roughly, behind the same seam."""

import math

import numpy as np
import pytest

from rocsafe_radiation.belief.belief_search import believe, poisson_below
from rocsafe_radiation.errors import TooFewReadingsError
from rocsafe_radiation.localization.localize import LocalizationOptions
from rocsafe_radiation.products.assessment import AssessmentOptions, assess, suggested_waypoints
from rocsafe_radiation.readings.survey import RadiationSurvey

from .simulated_survey import LOSSLESS, survey


def test_two_sources_are_found_within_a_cell_or_two():
    """20 m are enough to send somebody."""
    truth = [(80.0, 90.0, 925.0), (220.0, 210.0, 925.0)]
    found, belief = believe(survey(truth), LOSSLESS)
    assert len(found.sources) == 2
    assert found.method == 'belief-grid'
    for x, y, _ in truth:
        nearest = min(math.dist(s.position_enu_m[:2], (x, y)) for s in found.sources)
        assert nearest < 20.0
    assert belief.probabilities.max() > 0.9
    assert found.order_probabilities[2] > 0.5, 'cells beside the two are no third source'


def test_without_a_source_nothing_is_believed():
    """In 30 surveys, no cell."""
    for seed in range(30):
        found, belief = believe(survey([], seed=seed), LOSSLESS)
        assert found.sources == ()
        assert found.order_probabilities[0] > 0.5
        assert belief.probabilities.max() < 0.9


def test_who_measured_does_not_matter():
    """Two vehicles that merge believe what one would."""
    readings = survey([(150.0, 120.0, 925.0)])
    names = ['rav1' if k % 2 else 'rav2' for k in range(readings.size)]
    _, alone = believe(readings, LOSSLESS)
    _, merged = believe(readings, LOSSLESS, names)
    assert merged.probabilities == pytest.approx(alone.probabilities)


def test_strength_and_place_are_told_like_those_of_the_likelihood():
    """Within a factor of 1.4, with a covariance."""
    found, _ = believe(survey([(150.0, 150.0, 2000.0)]), LOSSLESS)
    (source,) = found.sources
    assert 1400.0 < source.dose_rate_at_1m_usvh < 2800.0
    assert source.ellipse_95()[0] > 5.0
    low, high = source.interval_95_usvh()
    assert high / low > 1.05, 'a place that is not known makes the strength less known'


@pytest.mark.slow
def test_a_picture_is_made_by_either_method():
    """Same products; places to measure next come from either."""
    readings = survey([(150.0, 150.0, 925.0)])
    for method in ('poisson-ml', 'belief-grid'):
        assessment = assess(readings, AssessmentOptions(known=LOSSLESS, method=method))
        assert assessment.found.method == method
        assert (assessment.belief is not None) == (method == 'belief-grid')
        assert assessment.cordons
        assert len(suggested_waypoints(assessment, 3)) == 3
    with pytest.raises(ValueError, match="method = 'guess' must be one of: poisson-ml"):
        AssessmentOptions(method='guess')


@pytest.mark.slow
def test_without_a_source_the_doubtful_ground_is_to_be_measured():
    """As long as a source may be hidden there."""
    full = survey([], seed=1)
    west = full.positions_enu_m[:, 0] < 100.0
    west |= full.positions_enu_m.sum(axis=1) > 620.0
    half = RadiationSurvey(
        positions_enu_m=full.positions_enu_m[west],
        counts=full.counts[west],
        exposures=full.exposures[west],
    )
    assessment = assess(half, AssessmentOptions(known=LOSSLESS))
    assert not assessment.verdict.is_enough
    places = [one.place_m for one in suggested_waypoints(assessment, 6)]
    assert len(places) == 6
    assert min(x for x, _, _ in places) > 80.0


def test_poisson_probabilities_are_near_the_exact_ones():
    """Against sums of the terms."""
    for mean in (0.5, 4.0, 55.0):
        limits = np.arange(0.0, 3.0 * mean + 5.0)
        terms = [math.exp(k * math.log(mean) - mean - math.lgamma(k + 1)) for k in range(300)]
        exact = np.array([sum(terms[: int(limit)]) for limit in limits])
        assert poisson_below(limits, np.full(len(limits), mean)) == pytest.approx(exact, abs=0.006)


def test_too_few_readings_are_told():
    """As by the likelihood."""
    few = RadiationSurvey(
        positions_enu_m=np.zeros((2, 3)), counts=np.ones(2), exposures=np.ones(2)
    )
    with pytest.raises(TooFewReadingsError, match='2 readings at different places'):
        believe(few, LocalizationOptions())


@pytest.mark.parametrize('counts', [0.2, 0.5, 0.8])
def test_a_tube_that_counts_less_than_once_a_reading_sees_no_ghosts(counts):
    """The median of its counts is 0, which is no background: 19 ghosts in 30 surveys."""
    east, north = np.meshgrid(np.arange(-100.0, 101.0, 5.0), np.arange(-50.0, 51.0, 20.0))
    places = np.column_stack([east.ravel(), north.ravel(), np.full(east.size, 25.0)])
    for seed in range(5):
        survey = RadiationSurvey(
            positions_enu_m=places,
            counts=np.random.default_rng(seed).poisson(counts, east.size).astype(float),
            exposures=np.full(east.size, counts / 0.1),
        )
        found, _ = believe(survey, LocalizationOptions(), smallest_usvh=300.0)
        assert not found.sources
        assert 0.05 < found.background_usvh < 0.2
