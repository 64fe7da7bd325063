# SPDX-License-Identifier: Apache-2.0
"""Errors of fixes that last for a while neither hide where a source is nor make another one."""

import dataclasses
import math

import numpy as np
import pytest

from rocsafe_radiation.localization.background_basis import smooth_basis
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.likelihood import Likelihood
from rocsafe_radiation.localization.localize import localize
from rocsafe_radiation.readings.survey import LocalReading, survey_of

from .simulated_survey import LOSSLESS

FIX_STD_M = 1.5
# Of an error a second later: it lasts for 20 s.
ALIKE = 0.95


def flown(seed, source=(10.0, -20.0, 20_000.0)):
    """Return the survey of one drone, 32 m up, 5 m/s, a reading a second."""
    rng = np.random.default_rng(seed)
    lines = [np.arange(-50.0, 51.0, 5.0)[:: 1 - 2 * (k % 2)] for k in range(6)]
    places = [(x, 20.0 * k - 50.0, 32.0) for k, line in enumerate(lines) for x in line]
    error_m, readings = rng.normal(0.0, FIX_STD_M, 3), []
    for second, place in enumerate(np.array(places)):
        error_m = ALIKE * error_m + math.sqrt(1.0 - ALIKE**2) * rng.normal(0.0, FIX_STD_M, 3)
        square = float(((place - (*source[:2], 0.0)) ** 2).sum())
        rate = rng.poisson(100.0 * (0.1 + source[2] / square)) / 100.0
        readings.append(
            LocalReading(
                position_enu_m=tuple((place + error_m).tolist()), dose_rate_usvh=rate,
                counts=100.0 * rate, live_time_s=1.0, vehicle='rav1', time_s=float(second),
            )
        )  # fmt: skip
    return survey_of(readings, 100.0)


def is_right(found, source=(10.0, -20.0)):
    """Return whether one source is found, and lies in its ellipse of 99 %."""
    if len(found.sources) != 1:
        return False
    miss = found.sources[0].position_enu_m[:2] - source
    return miss @ np.linalg.solve(found.sources[0].covariance_m2[:2, :2], miss) < 9.21


def test_legs_are_of_one_vehicle_and_of_several_lengths():
    """20, 80 and 320 s; each leg has a number of its own."""
    readings = [
        LocalReading(position_enu_m=(0.0, 0.0, 9.0), dose_rate_usvh=1.0, vehicle=v, time_s=t)
        for v, t in [('a', 5.0), ('a', 15.0), ('a', 26.0), ('b', 15.0), ('a', 90.0)]
    ]
    legs = survey_of(readings).flight.legs
    assert legs.tolist() == [[0, 4, 7], [0, 4, 7], [1, 4, 7], [3, 6, 8], [2, 5, 7]]
    for time_s in (math.nan, 1e300):
        unknown = dataclasses.replace(readings[1], time_s=time_s)
        assert survey_of([readings[0], unknown]).flight is None


def test_many_readings_keep_their_places_before_their_legs():
    """Of an area flown over again and again, cells are not made larger for the sake of legs."""
    survey = flown(1)
    plain = dataclasses.replace(survey, flight=None)
    assert survey.merged(1.0, 1000).flight is not None
    most = plain.merged(1.0, 1000).size - 1
    assert survey.merged(1.0, most).flight is None
    assert survey.merged(1.0, most).size == plain.merged(1.0, most).size


def test_derivatives_to_errors_of_legs():
    """Expected counts change as the slopes say."""
    survey = flown(1)
    setting = Setting(drift_std_m=FIX_STD_M, source_up_std_m=1.0)
    likelihood = Likelihood(survey, setting, smooth_basis(survey.positions_enu_m, 32.0, 2.0))
    rng = np.random.default_rng(2)
    parameters = rng.normal(0.0, 0.5, likelihood.head_size + likelihood.source_size)
    parameters[-4:] = (12.0, -15.0, 0.5, math.log(20_000.0))
    slopes, _ = likelihood.slopes(parameters)
    for column in range(likelihood.background_size, len(parameters)):
        step = np.zeros(len(parameters))
        step[column] = 1e-5
        ahead, back = (likelihood.expected(parameters + s * step) for s in (1.0, -1.0))
        assert slopes[:, column] == pytest.approx((ahead - back) / 2e-5, rel=1e-4, abs=1e-4)


@pytest.mark.slow
def test_lasting_errors_of_fixes_are_in_the_ellipse():
    """Taken as independent, they make it far too small."""
    surveys = [flown(seed) for seed in range(8)]
    assert sum(is_right(localize(survey, LOSSLESS)) for survey in surveys) >= 7
    without = [dataclasses.replace(survey, flight=None) for survey in surveys]
    assert sum(is_right(localize(survey, LOSSLESS)) for survey in without) <= 5
