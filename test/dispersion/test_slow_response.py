# SPDX-License-Identifier: Apache-2.0
"""Sensors that follow slowly are found by how they fall, and undone."""

import numpy as np
import pytest

from rocsafe_dispersion.estimation.gas_survey import GasSurvey, point_survey, usual_noise
from rocsafe_dispersion.estimation.slow_response import without_delay

STD = 1e-4


def shown(response_s: float, step_s: float, seed: int = 1) -> tuple[np.ndarray, GasSurvey]:
    """Return gas that comes in whiffs, and what a sensor shows of it."""
    rng = np.random.default_rng(seed)
    gas = np.where(rng.random(300) < 0.1, rng.exponential(1.0, 300), 0.0)
    values = np.zeros(300)
    for k in range(1, 300):
        kept = np.exp(-step_s / response_s) if response_s else 0.0
        values[k] = kept * values[k - 1] + (1.0 - kept) * gas[k]
    values += rng.normal(0.0, STD, 300)
    survey = point_survey(
        np.column_stack([np.arange(300.0), np.zeros(300), np.full(300, 2.0)]),
        np.tile([4.0, 0.0], (300, 1)),
        values,
        np.full(300, STD),
        step_s * np.arange(300.0),
    )
    return gas, survey


@pytest.mark.parametrize(('response_s', 'step_s'), [(30.0, 10.0), (30.0, 2.0), (10.0, 2.0)])
def test_a_slow_sensor_is_undone(response_s: float, step_s: float):
    """Within its noise, which is larger then, and is told."""
    gas, survey = shown(response_s, step_s)
    fast, responses = without_delay(survey)
    assert responses[0] == pytest.approx(response_s, rel=0.1)
    misses = fast.values_g_m3[1:] - gas[1:]
    assert np.corrcoef(fast.values_g_m3[1:], gas[1:])[0, 1] > 0.98
    assert np.median(np.abs(misses)) < 30.0 * STD
    assert (fast.std_g_m3[1:] > 3.0 * STD).all()


def test_a_fast_sensor_is_left_alone():
    """In whiffs, in a plume that lasts, and in clean air."""
    for seed in range(20):
        _, survey = shown(0.0, 5.0, seed)
        assert without_delay(survey)[1] == {}
    rng = np.random.default_rng(4)
    for values in (rng.gamma(4.0, 0.25, 300), rng.normal(0.0, STD, 300)):
        steady = point_survey(
            survey.places_m[:, 0], survey.wind_towards_mps, values, survey.std_g_m3
        )
        assert without_delay(steady)[1] == {}


@pytest.mark.parametrize(('noise', 'most'), [(0.0, 0), (0.01, 1)])
def test_a_steady_plume_crossed_again_and_again_is_no_slow_sensor(noise: float, most: int):
    """Line after line it falls alike: 4 of these 60 were told as slow, by up to two minutes."""
    told = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        speed, width = rng.uniform(2.0, 8.0), rng.uniform(60.0, 150.0)
        lines = np.arange(20.0, 20.0 + width, rng.uniform(8.0, 25.0))
        corners = np.array(
            [(x, side * width * (-1) ** k / 2.0) for k, x in enumerate(lines) for side in (-1, 1)]
        )
        ways = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
        times = np.arange(0.0, ways[-1] / speed)
        east, north = (np.interp(speed * times, ways, axis) for axis in corners.T)
        across, upwards = rng.uniform(0.1, 0.3) * east**0.9, 0.08 * east**0.9
        gas = np.exp(-((north / across) ** 2 + (3.0 / upwards) ** 2) / 2.0) / (across * upwards)
        values = gas + noise * gas.max() * rng.normal(size=len(gas))
        places = np.column_stack([east, north, np.full(len(gas), 3.0)])
        wind = np.tile([3.0, 0.0], (len(gas), 1))
        std = np.full(len(gas), usual_noise(values))
        told += bool(without_delay(point_survey(places, wind, values, std, times))[1])
    assert told <= most
