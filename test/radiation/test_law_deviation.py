# SPDX-License-Identifier: Apache-2.0
"""A law that differs from the one assumed makes no further sources and shifts none far."""

import dataclasses
import math

import numpy as np
import pytest

from rocsafe_radiation.localization import source_count as order_search
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.law_deviation import LawDeviation
from rocsafe_radiation.localization.likelihood import Likelihood
from rocsafe_radiation.localization.localize import LocalizationOptions, localize
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.physics.photons import AIR
from rocsafe_radiation.physics.shielding import Box
from rocsafe_radiation.physics.transmission import shielded_transmission

from .simulated_survey import LOSSLESS, survey

STRONG = (140.0, 150.0, 9250.0)


@pytest.mark.parametrize('has_shield', [False, True])
def test_the_gradient_is_that_of_the_objective_with_a_law_in_doubt(has_shield):
    """Against difference quotients, tilt, shades and all."""
    readings = survey([STRONG])
    basis = np.random.default_rng(1).uniform(size=(readings.size, 2))
    setting = Setting(
        background_std=0.3, source_up_std_m=1.0, tilt_std=0.4, shade=0.3, has_shield=has_shield
    )
    likelihood = Likelihood(readings, setting, basis)
    head = [math.log(0.12), 0.5, 0.1, -0.2, 0.3, *[1.5, -0.8, 0.2, -0.4, 0.3] * has_shield]
    place = np.array([*head, 133.0, 158.0, 0.3, math.log(2500.0)])
    _, gradient = likelihood.information_and_gradient(place)
    for index, step in enumerate(np.diag(np.full(len(place), 1e-4))):
        slope = (likelihood.objective(place + step) - likelihood.objective(place - step)) / 2e-4
        assert gradient[index] == pytest.approx(slope, rel=1e-3, abs=0.05)


@pytest.mark.parametrize('tilt_std', [0.0, 0.4])
def test_slopes_of_a_shield_are_those_of_its_factors(tilt_std):
    """By its numbers and by the place of the source, against difference quotients."""
    law = LawDeviation(height_m=32.0, tilt_std=tilt_std, has_shield=True)
    random = np.random.default_rng(0)
    offsets = np.concatenate([random.uniform(-90, 90, (2, 2, 9)), np.full((2, 1, 9), 31.0)], 1)
    numbers = np.array([0.3, 1.6, -0.9, 0.2, -0.3, -0.4])[6 - law.stds.size :]
    features, slopes = law.features(numbers, offsets), law.slopes(numbers, offsets)
    for index, step in enumerate(np.diag(np.full(numbers.size, 1e-6))):
        ratio = law.factors(numbers + step, offsets) / law.factors(numbers - step, offsets)
        assert features[index] == pytest.approx(np.log(ratio) / 2e-6, rel=1e-4, abs=1e-6)
    for axis, step in enumerate(np.eye(3)[:, None, :, None] * 1e-5):
        ratio = law.factors(numbers, offsets - step) / law.factors(numbers, offsets + step)
        assert slopes[:, axis] == pytest.approx(np.log(ratio) / 2e-5, rel=1e-4, abs=1e-6)


def test_a_wall_takes_from_readings_behind_it_and_not_from_those_above():
    """Nothing on the open side and right above, most of rays that roof and wall slant for."""
    law = LawDeviation(height_m=32.0, has_shield=True)
    east = np.array([-100.0, 0.0, 40.0, 200.0])
    offsets = np.stack([east, np.zeros(4), np.full(4, 32.0)])[None]
    open_side, above, even, flat = law.factors(np.array([3.0, 0.0, 1.0, 0.0, 0.0]), offsets)[0]
    assert open_side == pytest.approx(1.0, abs=1e-3)
    assert above == pytest.approx(1.0, abs=1e-3)
    assert flat < even < math.exp(-1.0)


def test_a_misfit_widens_ellipses_and_is_told(monkeypatch):
    """What no setting explains is told, and makes places less sure by its variance."""
    readings = survey([STRONG])
    gains = np.exp(np.random.default_rng(3).normal(0.0, 0.1, readings.size))
    rough = dataclasses.replace(readings, counts=np.round(readings.counts * gains))
    # One source and Poisson counts, whatever the readings say.
    monkeypatch.setattr(
        'rocsafe_radiation.localization.localize.search',
        lambda *given: order_search.search(given[0], given[1], 1),
    )
    monkeypatch.setattr(order_search, 'NUISANCES', order_search.NUISANCES[:1])
    monkeypatch.setattr(order_search, 'SHADES', ())
    monkeypatch.setattr(order_search, 'ROUGH_WALLS', ())
    monkeypatch.setattr(order_search, 'FIRST_WALLS', ())
    known, found = localize(readings, LOSSLESS), localize(rough, LOSSLESS)
    assert known.doubts == ()
    assert found.dispersion > 3.0
    assert any('standard deviations' in doubt for doubt in found.doubts)
    assert found.sources[0].ellipse_95()[0] > 2.0 * known.sources[0].ellipse_95()[0]


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
    found = localize(dataclasses.replace(flown, counts=counts), options)
    (source,) = found.sources
    miss = source.position_enu_m[:2] - STRONG[:2]
    assert math.hypot(*miss) < 1.0
    assert miss @ np.linalg.solve(source.covariance_m2[:2, :2], miss) < 12.0
    assert source.dose_rate_at_1m_usvh == pytest.approx(STRONG[2], rel=0.15)
    assert found.is_shielded


def test_the_shadow_of_an_empty_tank_car_is_that_of_the_law():
    """Walls of 10 mm of iron, a metre beside the source, turned by 40 degrees: within 0.5 m."""
    flown = survey([STRONG])
    car = Box(material='iron', centre_enu_m=(0.0, 4.0, 2.5), size_m=(15.0, 3.0, 3.0), wall_m=0.01)
    turn = math.radians(40.0)
    turned = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    rays = flown.positions_enu_m - [*STRONG[:2], 0.0]
    squares, beside = (rays**2).sum(axis=1), rays.copy()
    beside[:, :2] = rays[:, :2] @ turned.T
    source = np.array([[0.0, 1.5, 0.5]])
    iron = car.lengths_m(source, source + beside)[0]
    left = shielded_transmission('Cs-137', {AIR: np.sqrt(squares) - iron, 'iron': iron})
    counts = np.round(550.0 * (0.1 + STRONG[2] * left / squares))
    place = [STRONG[0] + 4.0, STRONG[1] - 4.0, 0.0, math.log(STRONG[2])]
    parameters = np.array([math.log(0.1), 0.7, *3.0 * turned[1], 0.0, 0.0, 0.0, *place])
    for sharpness in (6.0, 40.0):
        setting = Setting(has_shield=True, edge_sharpness=sharpness)
        seen = dataclasses.replace(flown, counts=counts)
        likelihood = Likelihood(seen, setting, np.empty((flown.size, 0)))
        fit = likelihood.fit(parameters)
        parameters = fit.parameters
    assert math.dist(fit.parameters[-4:-2], STRONG[:2]) < 0.5
    assert math.exp(fit.parameters[-1]) == pytest.approx(STRONG[2], rel=0.02)
    # A source alone leaves a misfit of five hundred standard deviations.
    assert likelihood.dispersion(fit.parameters) < 10.0
