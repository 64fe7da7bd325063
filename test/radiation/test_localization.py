# SPDX-License-Identifier: Apache-2.0
"""Sources are found where they are, as many as there are, and as surely as it is said."""

import dataclasses
import math

import numpy as np
import pytest

from rocsafe_radiation.errors import TooFewReadingsError
from rocsafe_radiation.localization.estimates import SourceEstimate
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.likelihood import Likelihood
from rocsafe_radiation.localization.localize import LocalizationOptions, localize
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.readings.spectral_window import background_shape
from rocsafe_radiation.readings.survey import LocalReading, RadiationSurvey, survey_of

from .simulated_survey import HEIGHT_M, LOSSLESS, survey

CAESIUM_10_GBQ = 925.0


def errors_m(found, sources):
    """Return the distance from each true source to the nearest found."""
    places = np.array([source.position_enu_m[:2] for source in found.sources])
    return [np.hypot(*(places - source[:2]).T).min() for source in np.array(sources)]


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(3))
def test_no_source_is_found_where_none_is(seed):
    """Background alone, and its level."""
    found = localize(survey([], seed), LOSSLESS)
    assert found.sources == ()
    assert found.order_probabilities[0] > 0.9
    assert found.background_usvh == pytest.approx(0.1, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(3))
def test_one_source_is_found_within_its_ellipse(seed):
    """10 GBq from 32 m: within 5 sigma, as strong as it is, certainly one."""
    truth = (120.0, 170.0, CAESIUM_10_GBQ)
    found = localize(survey([truth], seed), LOSSLESS)
    (source,) = found.sources
    miss = source.position_enu_m[:2] - truth[:2]
    assert miss @ np.linalg.solve(source.covariance_m2[:2, :2], miss) < 25.0
    assert abs(math.log(source.dose_rate_at_1m_usvh / truth[2])) < 5.0 * source.log_std
    assert found.order_probabilities[1] > 0.9
    assert source.detection_llr > 100.0


@pytest.mark.slow
def test_three_sources_are_told_apart():
    """One strong, two weaker ones 58 m and more away."""
    truth = [(200.0, 60.0, 3000.0), (100.0, 170.0, 900.0), (160.0, 230.0, 600.0)]
    found = localize(survey(truth), LOSSLESS)
    assert len(found.sources) == 3
    assert max(errors_m(found, truth)) < 6.0


@pytest.mark.slow
def test_position_noise_makes_no_further_sources():
    """3 m of noise about a strong source scatter counts far beyond Poisson."""
    truth = [(140.0, 150.0, 9250.0)]
    found = localize(survey(truth, position_noise_m=3.0), LOSSLESS)
    assert len(found.sources) == 1
    assert errors_m(found, truth)[0] < 4.0


@pytest.mark.slow
def test_a_height_unknown_by_a_metre_is_fitted():
    """The strength goes with the height: with its prior, both come near the truth."""
    readings = survey([(140.0, 150.0, 9250.0)])
    lifted = RadiationSurvey(
        positions_enu_m=readings.positions_enu_m + np.array([0.0, 0.0, 1.5]),
        counts=readings.counts,
        exposures=readings.exposures,
    )
    options = LocalizationOptions(kernel=Kernel(is_lossy=False), source_up_std_m=1.0)
    (source,) = localize(lifted, options).sources
    assert source.position_enu_m[2] == pytest.approx(1.5, abs=1.0)
    assert source.covariance_m2[2, 2] < 1.0


def test_the_gradient_is_that_of_the_objective():
    """Against difference quotients, background and all."""
    readings = survey([(140.0, 150.0, 3000.0)])
    readings.positions_enu_m[::3, 2] += 5.0
    basis = np.random.default_rng(1).uniform(size=(readings.size, 2))
    setting = Setting(
        kernel=Kernel(), background_std=0.3, rho=0.05, source_up_std_m=1.0, position_std_m=1.5,
        has_shades=True,
    )  # fmt: skip
    likelihood = Likelihood(readings, setting, basis)
    head = [math.log(0.12), 0.5, 0.2, -0.1, 0.1, -0.2]
    shade = [0.9, -0.7, 0.9, -0.3]
    place = np.array([*head, 133.0, 158.0, 0.3, math.log(2500.0), *shade])
    weights = likelihood.weights(place)
    _, gradient = likelihood.information_and_gradient(place, weights)
    for index, step in enumerate(np.diag(np.full(len(place), 1e-4))):
        rise = likelihood.objective(place + step, weights)
        slope = (rise - likelihood.objective(place - step, weights)) / 2e-4
        assert gradient[index] == pytest.approx(slope, rel=1e-3, abs=0.05)


@pytest.mark.slow
def test_the_same_readings_in_another_order_give_the_same():
    """Nothing depends on the order, nor is anything random."""
    readings = survey([(120.0, 170.0, CAESIUM_10_GBQ)])
    turned = RadiationSurvey(
        positions_enu_m=readings.positions_enu_m[::-1],
        counts=readings.counts[::-1],
        exposures=readings.exposures[::-1],
    )
    first, second = localize(readings, LOSSLESS), localize(turned, LOSSLESS)
    assert first.sources[0].position_enu_m == pytest.approx(second.sources[0].position_enu_m)


def test_an_ellipse_points_along_its_long_axis():
    """Of a covariance with 9 m^2 along north-east and 1 m^2 across."""
    turn = np.array([[1.0, -1.0], [1.0, 1.0]]) / math.sqrt(2.0)
    covariance = np.zeros((4, 4))
    covariance[:2, :2] = turn @ np.diag([9.0, 1.0]) @ turn.T
    source = SourceEstimate(
        position_enu_m=np.zeros(3),
        joint_covariance=covariance,
        dose_rate_at_1m_usvh=1.0,
        detection_llr=9.0,
    )
    long_m, short_m, angle = source.ellipse_95()
    assert (long_m, short_m) == pytest.approx((3 * 2.4477, 2.4477), rel=1e-3)
    assert math.tan(angle) == pytest.approx(1.0)


def test_too_few_readings_are_refused():
    """Also many at one place."""
    reading = LocalReading(position_enu_m=(0.0, 0.0, HEIGHT_M), dose_rate_usvh=0.1)
    with pytest.raises(TooFewReadingsError, match='1 readings at different places'):
        localize(survey_of([reading] * 50))
    with pytest.raises(TooFewReadingsError, match='at least 8'):
        localize(survey_of([reading] * 3))


def test_counts_win_over_dose_rates():
    """Exposure is counts over dose rate, or sensitivity times live time."""
    counted = LocalReading(
        position_enu_m=(0, 0, 32), dose_rate_usvh=0.2, counts=110, live_time_s=1.0
    )
    assert survey_of([counted]).exposures == pytest.approx([550.0])
    assert survey_of([counted], 600.0).exposures == pytest.approx([600.0])
    stated = LocalReading(position_enu_m=(0, 0, 32), dose_rate_usvh=0.2, dose_rate_std_usvh=0.02)
    assert survey_of([stated]).counts == pytest.approx([100.0])


def test_merging_keeps_counts_and_exposures():
    """And the mean place."""
    merged = survey([(120.0, 170.0, 925.0)]).merged(40.0, 2500)
    whole = survey([(120.0, 170.0, 925.0)])
    assert merged.counts.sum() == whole.counts.sum()
    assert merged.exposures.sum() == pytest.approx(whole.exposures.sum())
    assert merged.size < whole.size / 5


@pytest.mark.slow
def test_a_spectral_window_foretells_an_uneven_background():
    """A hot spot of ground, counted in the window above the lines too, is no source."""
    flown = survey([(150.0, 150.0, 300.0)], background_usvh=0.1)
    even = localize(flown, LOSSLESS)
    assert len(even.sources) == 1
    reference = np.random.default_rng(3).poisson(4.0 * flown.counts).astype(float)
    shape = background_shape(flown.positions_enu_m, reference)
    foretold = dataclasses.replace(flown, background_shape=shape)
    assert localize(foretold, LOSSLESS).sources == ()


@pytest.mark.slow
def test_a_source_that_the_window_above_does_not_see_is_found():
    """Its photons have too little energy for it."""
    flown = survey([(150.0, 150.0, 300.0)], background_usvh=0.1)
    reference = np.random.default_rng(3).poisson(220.0, flown.size).astype(float)
    shape = background_shape(flown.positions_enu_m, reference)
    (source,) = localize(dataclasses.replace(flown, background_shape=shape), LOSSLESS).sources
    assert math.dist(source.position_enu_m[:2], (150.0, 150.0)) < 20.0


def test_a_window_without_a_count_is_refused():
    """It foretells nothing."""
    with pytest.raises(ValueError, match='at least one count'):
        background_shape(survey([]).positions_enu_m, np.zeros(441))


@pytest.mark.slow
def test_take_off_and_landing_make_no_source():
    """Near the ground, its radiation is stronger: 0.1 uSv/h that falls by e in 120 m."""
    flown = survey([(140.0, 150.0, 1850.0)])
    generator = np.random.default_rng(2)
    ups = np.tile(np.arange(1.0, 32.0, 1.0), 12)
    climb = np.stack([np.full(ups.size, -60.0), np.full(ups.size, 20.0), ups], axis=1)
    squares = ((climb - [140.0, 150.0, 0.0]) ** 2).sum(axis=1)
    rates = 0.07 * np.exp((32.0 - ups) / 120.0) + 0.03 + 1850.0 / squares
    readings = RadiationSurvey(
        positions_enu_m=np.vstack([flown.positions_enu_m, climb]),
        counts=np.append(flown.counts, generator.poisson(550.0 * rates)),
        exposures=np.full(flown.size + ups.size, 550.0),
    )
    (source,) = localize(readings, LOSSLESS).sources
    assert math.dist(source.position_enu_m[:2], (140.0, 150.0)) < 3.0
