# SPDX-License-Identifier: Apache-2.0
"""A law that differs from the one assumed makes no further sources and shifts none far."""

import dataclasses
import math

import numpy as np
import pytest

from rocsafe_radiation.kernel import Kernel
from rocsafe_radiation.likelihood import Likelihood, Setting
from rocsafe_radiation.localization import LocalizationOptions, localize

from .simulated_survey import survey

STRONG = (140.0, 150.0, 9250.0)


def test_the_gradient_is_that_of_the_objective_with_a_law_in_doubt():
    """Against difference quotients, tilt, shades and all."""
    readings = survey([STRONG])
    basis = np.random.default_rng(1).uniform(size=(readings.size, 2))
    setting = Setting(background_std=0.3, source_up_std_m=1.0, tilt_std=0.4, shade=0.3)
    likelihood = Likelihood(readings, setting, basis)
    head = [math.log(0.12), 0.5, 0.1, -0.2, 0.3]
    place = np.array([*head, 133.0, 158.0, 0.3, math.log(2500.0)])
    _, gradient = likelihood.information_and_gradient(place)
    for index, step in enumerate(np.diag(np.full(len(place), 1e-4))):
        slope = (likelihood.objective(place + step) - likelihood.objective(place - step)) / 2e-4
        assert gradient[index] == pytest.approx(slope, rel=1e-3, abs=0.05)


@pytest.mark.parametrize('seed', range(2))
def test_a_field_without_air_is_one_source_to_an_estimator_that_knows_of_air(seed):
    """At 150 m air takes a quarter, which thousands of counts do not forgive."""
    options = LocalizationOptions(kernel=Kernel(), source_up_m=0.0, source_up_std_m=0.0)
    (source,) = localize(survey([STRONG], seed), options).sources
    assert math.dist(source.position_enu_m[:2], STRONG[:2]) < 1.0


def test_numbers_of_a_law_stay_those_of_a_source():
    """However much they would explain: three standard deviations at most."""
    readings = survey([STRONG])
    likelihood = Likelihood(readings, Setting(tilt_std=0.4), np.empty((readings.size, 0)))
    start = np.array([math.log(0.1), 0.7, 30.0, 140.0, 150.0, 0.0, math.log(9250.0)])
    assert abs(likelihood.fit(start).parameters[2]) <= 1.2


def test_a_train_beside_a_source_neither_shifts_it_far_nor_makes_others():
    """All readings to the north-east see three tenths of it, none knows."""
    options = LocalizationOptions(kernel=Kernel(), source_up_m=0.0, source_up_std_m=0.0)
    flown = survey([STRONG])
    places = flown.positions_enu_m[:, :2] - STRONG[:2]
    is_behind = places.sum(axis=1) > 12.0
    squares = (places**2).sum(axis=1) + 32.0**2
    rates = 0.1 + STRONG[2] * options.kernel.values(squares) * np.where(is_behind, 0.3, 1.0)
    counts = np.random.default_rng(1).poisson(550.0 * rates).astype(float)
    (source,) = localize(dataclasses.replace(flown, counts=counts), options).sources
    assert math.dist(source.position_enu_m[:2], STRONG[:2]) < 6.0
    assert source.dose_rate_at_1m_usvh == pytest.approx(STRONG[2], rel=0.15)
