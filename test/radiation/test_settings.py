# SPDX-License-Identifier: Apache-2.0
"""What the readings do not say of the background, the fixes and the law makes no source."""

import dataclasses
import math

import numpy as np
import pytest

from rocsafe_radiation.decision.sequential_decision import SequentialEvidence
from rocsafe_radiation.decision.stopping import StoppingRule
from rocsafe_radiation.localization import source_count
from rocsafe_radiation.localization.background_basis import smooth_basis
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.likelihood import Likelihood
from rocsafe_radiation.localization.localize import LocalizationOptions, localize
from rocsafe_radiation.localization.search_options import SearchOptions
from rocsafe_radiation.localization.source_count import search
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.readings.survey import RadiationSurvey

from .simulated_survey import LOSSLESS, survey

pytestmark = pytest.mark.slow

STRONG = (40.0, 55.0, 2000.0)


def uneven(sources, seed, share=0.2, lengths_m=(150.0, 400.0), slope=0.0):
    """Return a survey over ground that varies by `share` in waves of `lengths_m`."""
    flown = survey([])
    generator = np.random.default_rng(seed)
    lengths = generator.uniform(*lengths_m, 12)
    angles, phases = generator.uniform(0.0, 2.0 * np.pi, (2, 12))
    places = flown.positions_enu_m
    turns = places[:, :1] * np.cos(angles) + places[:, 1:2] * np.sin(angles)
    ground = np.cos(2.0 * np.pi * turns / lengths + phases).sum(axis=1) / np.sqrt(6.0)
    rates = 0.1 * np.exp(share * ground + slope * (places[:, 0] - 150.0) / 150.0)
    for x, y, strength in sources:
        squares = (places[:, 0] - x) ** 2 + (places[:, 1] - y) ** 2 + places[:, 2] ** 2
        rates = rates + strength / squares
    return RadiationSurvey(
        positions_enu_m=places,
        counts=generator.poisson(550.0 * rates).astype(float),
        exposures=flown.exposures,
    )


def test_a_strong_source_at_the_edge_is_the_only_one():
    """The random field neither takes its shape nor leaves rests that look like sources."""
    found = localize(uneven([STRONG], 1), LOSSLESS)
    (source,) = found.sources
    assert np.hypot(*(source.position_enu_m[:2] - STRONG[:2])) < 4.0
    assert source.dose_rate_at_1m_usvh == pytest.approx(STRONG[2], rel=0.15)
    assert found.is_structured


def test_hills_of_background_as_wide_as_a_source_shows_are_no_sources():
    """Waves of 60 to 200 m from 32 m above."""
    found = localize(uneven([], 1, lengths_m=(60.0, 200.0)), LOSSLESS)
    assert found.sources == ()
    assert found.is_structured


def test_a_background_as_steep_as_sources_is_rarer_than_three_of_them():
    """Over an even background, where a random field of bumps a height apart fits as well."""
    sources = [(-17.0, -107.0, 200.0), (38.0, 94.0, 160.0), (7.0, -5.0, 600.0)]
    east, north = np.meshgrid(np.linspace(-50.0, 50.0, 21), np.linspace(-115.0, 115.0, 21))
    places = np.column_stack([east.ravel(), north.ravel(), np.full(east.size, 43.0)])
    rates = np.full(east.size, 0.1)
    for x, y, strength in sources:
        rates += strength / ((places - [x, y, 0.0]) ** 2).sum(axis=1)
    counts = np.random.default_rng(3).poisson(1000.0 * rates).astype(float)
    flown = RadiationSurvey(
        positions_enu_m=places, counts=counts, exposures=np.full(east.size, 1000.0)
    )
    found = localize(flown, LOSSLESS)
    assert len(found.sources) == 3
    assert found.order_probabilities[3] > 0.95


@pytest.mark.parametrize('slope', [0.1, 0.4])
def test_a_slope_of_the_background_is_no_source(slope):
    """As steep as 40 % to each side of the middle."""
    assert localize(uneven([], 2, share=0.0, slope=slope), LOSSLESS).sources == ()


@pytest.mark.parametrize('factor', [3.0, 20.0])
def test_a_spike_is_no_source_and_is_told(factor):
    """One reading that its neighbours know nothing of."""
    flown = survey([])
    flown.counts[200] *= factor
    found = localize(flown, LOSSLESS)
    assert found.sources == ()
    assert found.spike_count == 1
    assert any('spikes' in doubt for doubt in found.doubts)


def test_errors_of_the_fixes_upwards_scatter_readings_of_a_source():
    """With 3 m of them there is one source, and its ellipse is wider than without."""
    readings = survey([(140.0, 150.0, 9250.0)])
    noise = np.random.default_rng(5).normal(0.0, 3.0, readings.size)
    places = readings.positions_enu_m + np.outer(noise, [0.0, 0.0, 1.0])
    options = dataclasses.replace(LOSSLESS, position_std_m=3.0)
    (known,) = localize(readings, options).sources
    (source,) = localize(dataclasses.replace(readings, positions_enu_m=places), options).sources
    assert source.ellipse_95()[0] > 1.3 * known.ellipse_95()[0]
    assert math.dist(source.position_enu_m[:2], (140.0, 150.0)) < 2.0


def test_the_evidence_is_the_integral_of_likelihood_and_prior():
    """Of a background alone, by a sum over its level: all else is nearly fixed."""
    flown = survey([])
    likelihood = Likelihood(flown, Setting(kernel=LOSSLESS.kernel), np.empty((flown.size, 0)))
    fit = likelihood.fit(np.array([math.log(0.1), 0.7, 0.0, 0.0]))
    # The height is the same everywhere, its prior integrates to one; so do both sides.
    steps = np.linspace(-0.05, 0.05, 41)
    ways = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
    logs = np.array(
        [likelihood.objective(fit.parameters + np.insert(way, 1, 0.0)) for way in ways]
    )
    priors = 1.5 * math.log(2.0 * math.pi) + math.log(3.0 * 0.3 * 0.3)
    integral = float(np.log(np.exp(logs).sum()) + 3.0 * math.log(steps[1] - steps[0]))
    assert likelihood.evidence(fit) == pytest.approx(integral - priors, abs=0.05)


def test_probabilities_are_sums_over_settings():
    """More than one setting counts, and all of them make the probability."""
    found = search(
        survey([(120.0, 170.0, 925.0)]).merged(4.0, 2500), Setting(position_std_m=1.5), 2
    )
    assert found.order == 1
    assert len(found.found) > 3
    assert found.evidences[1] + 2.0 > found.found[0].evidence
    assert sum(found.probabilities()) == pytest.approx(1.0)


def test_what_the_others_explain_alone_is_no_evidence_for_a_further_source():
    """A fit with one source that ended beside it, as behind steel, is mended by that with two."""
    readings = survey([(80.0, 90.0, 2000.0), (220.0, 200.0, 925.0)]).merged(4.0, 2500)
    known = SearchOptions(are_shades_tried=False, rhos=(0.0,), position_factors=(1.0,))
    setting = Setting(kernel=LOSSLESS.kernel, position_std_m=1.5, search=known)
    settings = source_count._Settings(readings, setting)
    right = search(readings, setting, 2).settings
    index, likelihood, fit = right[2][0].index, right[2][0].likelihood, right[2][0].fit
    parameters = np.delete(fit.parameters, likelihood.source_rows(len(fit.parameters))[1])
    likelihood.sources(parameters)[0, 0] += 40.0
    value = likelihood.objective(parameters)
    beside = dataclasses.replace(
        likelihood.fit(parameters), parameters=parameters, log_likelihood=value
    )
    wrong = (settings._weighed(index, likelihood, beside),)
    mended = settings.without_one(right[2], wrong)
    assert mended[0].evidence > wrong[0].evidence + 100.0
    (source,) = mended[0].likelihood.sources(mended[0].fit.parameters)
    assert math.dist(source[:2], (80.0, 90.0)) < 10.0
    # As they are where nothing is better.
    assert settings.without_one(right[2], right[1]) is right[1]


def test_a_source_that_is_spread_out_is_never_enough_as_several():
    """All were stated within 4 m, as if decided: a line 60 m long, from 32 m above."""
    line = [(120.0 + 2.0 * k, 150.0, 9250.0 / 30.0) for k in range(31)]
    found = localize(survey(line), LOSSLESS)
    sure = SequentialEvidence(log_ratio=9, log_ratio_smallest=9)
    assert len(found.sources) > 1
    assert found.may_be_spread
    assert any('spread out' in doubt for doubt in found.doubts)
    assert 'spread out' in StoppingRule().verdict(found, sure).reason
    apart = localize(survey([(90.0, 150.0, 9250.0), (210.0, 150.0, 9250.0)]), LOSSLESS)
    assert not apart.may_be_spread
    assert 'spread out' not in StoppingRule().verdict(apart, sure).reason


def test_a_misfit_widens_ellipses_is_told_and_is_never_enough():
    """Gains of a fifth from reading to reading, where settings know of none."""
    readings = survey([(140.0, 150.0, 9250.0)])
    gains = np.exp(np.random.default_rng(3).normal(0.0, 0.1, readings.size))
    rough = dataclasses.replace(readings, counts=np.round(readings.counts * gains))
    plain = SearchOptions(rhos=(0.0,), position_factors=(1.0,), outlier_share=1e-12)
    options = dataclasses.replace(LOSSLESS, search=plain, position_std_m=0.0, largest_order=1)
    known, found = localize(readings, options), localize(rough, options)
    assert known.is_understood
    assert found.is_misfit
    assert any('standard deviations' in doubt for doubt in found.doubts)
    assert found.sources[0].ellipse_95()[0] > 1.5 * known.sources[0].ellipse_95()[0]
    verdict = StoppingRule().verdict(found, SequentialEvidence(log_ratio=9, log_ratio_smallest=9))
    assert not verdict.is_enough
    assert 'do not explain' in verdict.reason


@pytest.mark.parametrize('seed', range(2))
def test_a_field_without_air_is_one_source_to_an_estimator_that_knows_of_air(seed):
    """At 150 m air takes a quarter, which thousands of counts do not forgive."""
    options = LocalizationOptions(kernel=Kernel(), source_up_m=0.0, source_up_std_m=0.0)
    truth = (140.0, 150.0, 9250.0)
    (source,) = localize(survey([truth], seed), options).sources
    assert math.dist(source.position_enu_m[:2], truth[:2]) < 1.0


def test_a_plate_beside_a_source_is_found_makes_no_others_and_is_never_enough():
    """Of 1.2 mean free paths, to the north-east, up to a slope of 1.5: the place is right."""
    truth = (140.0, 150.0, 2000.0)
    flown = survey([truth])
    ways = flown.positions_enu_m - [*truth[:2], 0.0]
    to_m, along_m = (ways[:, 0] + ways[:, 1]) / 2**0.5, (ways[:, 1] - ways[:, 0]) / 2**0.5
    distances = np.linalg.norm(ways, axis=1)
    meets = (1.5 * to_m > ways[:, 2]) & (np.abs(along_m) < 4.0 * to_m)
    paths = 1.2 * distances / np.where(meets, to_m, math.inf)
    left = (1.0 + paths) * np.exp(-paths)
    rates = 0.1 + truth[2] * left / distances**2
    counts = np.random.default_rng(1).poisson(550.0 * rates).astype(float)
    found = localize(dataclasses.replace(flown, counts=counts), LOSSLESS)
    (source,) = found.sources
    assert math.dist(source.position_enu_m[:2], truth[:2]) < 1.0
    assert found.is_lopsided
    evidence = SequentialEvidence(log_ratio=99.0, log_ratio_smallest=99.0)
    assert 'beside' in StoppingRule().verdict(found, evidence).reason


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


def test_a_place_that_readings_tell_nothing_of_has_a_covariance():
    """A source far too weak to be seen may be anywhere: the ellipse is the survey."""
    readings = survey([]).merged(4.0, 2500)
    likelihood = Likelihood(
        readings, Setting(source_up_std_m=1.0), smooth_basis(readings.positions_enu_m, 32.0, 2.0)
    )
    parameters = np.zeros(likelihood.head_size + 4)
    parameters[likelihood.head_size :] = 150.0, 150.0, 0.5, -800.0
    information, _ = likelihood.information_and_gradient(
        parameters, likelihood.weights(parameters)
    )
    place = np.linalg.inv(information)[likelihood.head_size, likelihood.head_size]
    assert 50.0 < np.sqrt(place) < 300.0


def test_more_readings_than_a_fit_takes_are_merged_into_larger_cells():
    """None is lost."""
    readings = survey([(120.0, 170.0, 925.0)])
    merged = readings.merged(1.0, 100)
    assert 50 < merged.size <= 100
    assert merged.counts.sum() == readings.counts.sum()


@pytest.mark.parametrize(
    'truths',
    [
        [(17.4, 19.3, 1246.0), (21.1, -71.0, 1018.0)],
        [(-44.0, 19.7, 1272.0), (10.6, 86.3, 284.0), (37.9, -44.0, 1091.0)],
    ],
    ids=['two', 'three'],
)
def test_sources_are_told_from_an_uneven_background_although_one_alone_explains_little(truths):
    """From 36 m above 100 m x 230 m: a source shows as wide as a hill of the background would."""
    generator = np.random.default_rng(1)
    axes = np.meshgrid(np.linspace(-50.0, 50.0, 21), np.linspace(-115.0, 115.0, 21))
    places = np.column_stack([*(axis.ravel() for axis in axes), np.full(441, 36.0)])
    rates = np.full(441, 0.1)
    for east, north, strength in truths:
        rates += strength / ((places - [east, north, 0.0]) ** 2).sum(axis=1)
    flown = RadiationSurvey(
        positions_enu_m=places + generator.normal(0.0, 1.5, places.shape),
        counts=generator.poisson(200.0 * rates).astype(float),
        exposures=np.full(441, 200.0),
    )
    found = localize(flown, dataclasses.replace(LOSSLESS, position_std_m=1.5))
    assert len(found.sources) == len(truths)
    for truth in truths:
        misses = [math.dist(one.position_enu_m[:2], truth[:2]) for one in found.sources]
        assert min(misses) < 6.0
