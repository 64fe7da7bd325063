# SPDX-License-Identifier: Apache-2.0
"""Uneven ground feigns no source and hides no strong one."""

import dataclasses

import numpy as np
import pytest

from rocsafe_radiation.localization.credibility import unevenness, weighed
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.hypothesis import is_placed
from rocsafe_radiation.localization.hypothesis_values import first_source_penalty
from rocsafe_radiation.localization.likelihood import Fit, Likelihood
from rocsafe_radiation.localization.localize import localize
from rocsafe_radiation.localization.search_options import SearchOptions
from rocsafe_radiation.localization.source_count import search
from rocsafe_radiation.readings.survey import RadiationSurvey

from .simulated_survey import LOSSLESS, survey

STRONG = (40.0, 55.0, 2000.0)
SETTING = Setting(kernel=LOSSLESS.kernel)


def uneven(sources, seed, share=0.2, lengths_m=(150.0, 400.0)):
    """Return a survey over ground that varies by `share` in waves of `lengths_m`."""
    flown = survey([])
    generator = np.random.default_rng(seed)
    lengths = generator.uniform(*lengths_m, 12)
    angles, phases = generator.uniform(0.0, 2.0 * np.pi, (2, 12))
    places = flown.positions_enu_m
    turns = places[:, :1] * np.cos(angles) + places[:, 1:2] * np.sin(angles)
    ground = np.cos(2.0 * np.pi * turns / lengths + phases).sum(axis=1) / np.sqrt(6.0)
    rates = 0.1 * np.exp(share * ground)
    for x, y, strength in sources:
        squares = (places[:, 0] - x) ** 2 + (places[:, 1] - y) ** 2 + places[:, 2] ** 2
        rates = rates + strength / squares
    return RadiationSurvey(
        positions_enu_m=places,
        counts=generator.poisson(550.0 * rates).astype(float),
        exposures=flown.exposures,
    )


def test_a_strong_source_at_the_edge_is_the_only_one():
    """The smooth background neither takes its shape nor leaves rests that look like sources."""
    found = localize(uneven([STRONG], 1), LOSSLESS)
    assert len(found.sources) == 1
    (source,) = found.sources
    assert np.hypot(*(source.position_enu_m[:2] - STRONG[:2])) < 4.0
    assert source.dose_rate_at_1m_usvh == pytest.approx(STRONG[2], rel=0.1)
    assert found.is_structured


def test_hills_of_background_as_wide_as_a_source_shows_are_no_sources():
    """Waves of 60 to 200 m from 32 m above: the rolling ground explains them, not four sources."""
    found = localize(uneven([], 1, lengths_m=(60.0, 200.0)), LOSSLESS)
    assert found.sources == ()
    assert found.is_structured


def test_a_source_among_such_hills_is_found():
    """20 GBq among hills of a fifth of the background."""
    (source,) = localize(uneven([STRONG], 1, lengths_m=(60.0, 200.0)), LOSSLESS).sources
    assert np.hypot(*(source.position_enu_m[:2] - STRONG[:2])) < 6.0


def test_even_ground_is_seen_as_even():
    """Nothing is weighed there: the probabilities are those of the counts."""
    flown = survey([(100.0, 120.0, 925.0)], seed=1).merged(4.0)
    even = search(flown, SETTING, 2)
    assert unevenness(even, [even]) == 0.0
    assert weighed(even, 0.0) is even


def test_a_weak_source_needs_more_than_the_ground_could_feign():
    """A tenth of the background, on ground that varies by a tenth, is not believed."""
    weak = search(survey([(150.0, 150.0, 40.0)], seed=3, sensitivity=20_000.0), SETTING, 1)
    assert weak.order == 1, 'on even ground, with so many counts, it is there'
    assert weighed(weak, 0.2).order == 0
    assert weighed(weak, 0.01).order == 1
    assert dataclasses.replace(weak, scores=weak.scores).probabilities()[1] > 0.99


def test_a_source_that_could_be_anywhere_is_background():
    """Its 95 % ellipse must be no longer than a quarter of the survey, however narrow it is."""
    readings = survey([])
    likelihood = Likelihood(readings, SETTING, np.empty((readings.size, 0)))
    parameters = np.array([np.log(0.1), 0.7, 400.0, 150.0, 0.0, 9.0])
    placed, lost = (
        Fit(
            parameters=parameters,
            log_likelihood=0.0,
            information=np.diag([1e4, 4.0, std_m**-2.0, 1.0, 1e8, 100.0]),
        )
        for std_m in (20.0, 60.0)
    )
    assert is_placed(likelihood, placed)
    assert not is_placed(likelihood, lost)


@pytest.mark.parametrize(('readings', 'nats'), [(100, 9.908), (441, 12.134), (1558, 14.027)])
def test_a_first_source_needs_more_evidence_among_more_readings(readings, nats):
    """By BIC with three free parameters, 1.5 ln(n), and prior odds of e^-3."""
    flown = RadiationSurvey(
        positions_enu_m=np.tile([0.0, 0.0, 32.0], (readings, 1)),
        counts=np.ones(readings),
        exposures=np.ones(readings),
    )
    likelihood = Likelihood(flown, SETTING, np.empty((readings, 0)))
    assert first_source_penalty(likelihood) == pytest.approx(nats, abs=1e-3)


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        ({'cell_heights': 0.0}, 'cell_heights = 0.0 must be above 0'),
        ({'pitch_heights': float('nan')}, 'pitch_heights = nan must be above 0'),
        ({'tried_candidates': 0}, 'tried_candidates = 0 must be at least 1'),
    ],
)
def test_search_options_out_of_range_are_refused(change, message):
    """With their name, value and limit."""
    with pytest.raises(ValueError, match=message):
        SearchOptions(**change)
