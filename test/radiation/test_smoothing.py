# SPDX-License-Identifier: Apache-2.0
"""Ratemeters that smooth, clocks that differ, gains that fall, dose rates of unknown noise."""

import dataclasses
import math

import numpy as np
import pytest

from rocsafe_radiation.localization.localize import LocalizationOptions, localize
from rocsafe_radiation.localization.noise_spectrum import running_mean
from rocsafe_radiation.localization.smoothing import unaveraged, unsmoothed
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.readings.flight import flight_of
from rocsafe_radiation.readings.survey import LocalReading, survey_of

SOURCE = np.array([60.0, 45.0, 0.5])
STRENGTH_USVH, SENSITIVITY_CPS, SPEED_MPS, HEIGHT_M = 2000.0, 550.0, 6.0, 25.0
LOSSLESS = LocalizationOptions(kernel=Kernel(is_lossy=False))


def flown(
    *, smoothing_s=0.0, last=1, late_s=0.0, fall=0.0, sensitivity=SENSITIVITY_CPS, is_dose=False
):
    """Return readings of lines of 130 m flown to and fro, one a second."""
    rng = np.random.default_rng(5)
    corners = np.array([[130.0 * (((k + 1) // 2) % 2), 20.0 * (k // 2)] for k in range(12)])
    ways = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    times = np.arange(0.0, ways[-1] / SPEED_MPS)

    def places(at):
        flat = [np.interp(SPEED_MPS * at, ways, axis) for axis in corners.T]
        return np.column_stack([*flat, np.full(len(at), HEIGHT_M)])

    rates = 0.1 + STRENGTH_USVH / ((places(times) - SOURCE) ** 2).sum(axis=1)
    rates = rates * (1.0 - fall * times / times[-1])
    counts = rng.poisson(sensitivity * rates).astype(float)
    for index in range(1, len(counts) if smoothing_s else 0):
        kept = math.exp(-1.0 / smoothing_s)
        counts[index] = kept * counts[index - 1] + (1.0 - kept) * counts[index]
    counts = np.convolve(
        np.append(np.full(last - 1, counts[0]), counts), np.ones(last) / last, 'valid'
    )
    stated = places(times + late_s) + rng.normal(0.0, 1.0, (len(times), 3))
    return [
        LocalReading(
            position_enu_m=tuple(place),
            dose_rate_usvh=count / sensitivity if is_dose else math.nan,
            counts=0.0 if is_dose else count,
            live_time_s=math.nan if is_dose else 1.0,
            time_s=time,
        )
        for place, count, time in zip(
            stated.tolist(), counts.tolist(), times.tolist(), strict=True
        )
    ]


def is_right(found) -> bool:
    """Return whether there is one source, in its ellipse and its interval."""
    if len(found.sources) != 1:
        return False
    (source,) = found.sources
    way = source.position_enu_m[:2] - SOURCE[:2]
    low, high = source.interval_95_usvh()
    square = way @ np.linalg.solve(source.covariance_m2[:2, :2], way)
    return bool(square < 5.991 and low < STRENGTH_USVH < high)


def test_counts_need_no_correction():
    """Nothing is said of them."""
    found = localize(survey_of(flown(), SENSITIVITY_CPS), LOSSLESS)
    assert is_right(found)
    assert found.smoothing_s == 0.0
    assert found.allowed_for == ()


@pytest.mark.slow
@pytest.mark.parametrize('is_dose', [False, True])
def test_a_running_mean_is_undone(is_dose):
    """It showed a source behind the true one, weaker, and others beside it."""
    readings = flown(smoothing_s=5.0, is_dose=is_dose)
    found = localize(survey_of(readings, 0.0 if is_dose else SENSITIVITY_CPS), LOSSLESS)
    assert 3.5 < found.smoothing_s < 7.0
    assert is_right(found)
    assert any('running means' in doubt for doubt in found.doubts)


@pytest.mark.slow
@pytest.mark.parametrize('is_dose', [False, True])
def test_a_mean_of_the_last_readings_is_undone(is_dose):
    """All of them count alike; it was taken for one that forgets little by little."""
    readings = flown(last=7, is_dose=is_dose)
    found = localize(survey_of(readings, 0.0 if is_dose else SENSITIVITY_CPS), LOSSLESS)
    assert found.smoothing_s == 7.0
    assert is_right(found)


@pytest.mark.parametrize(('kind', 'is_even'), [('smoothing_s', False), ('last', True)])
@pytest.mark.parametrize('readings', [3, 10])
def test_counts_tell_the_running_mean_by_their_noise_alone(kind, is_even, readings):
    """No fit is needed: how much lower it is, and at which frequencies."""
    found = running_mean(survey_of(flown(**{kind: readings}), SENSITIVITY_CPS))
    assert found.is_even is is_even
    assert found.readings == pytest.approx(readings, rel=0.25)


def test_what_was_counted_follows_from_means_of_the_last_readings():
    """But for what each seventh has in common, a small part of their noise; gaps included."""
    means, counted = (survey_of(flown(last=last), SENSITIVITY_CPS) for last in (7, 1))
    undone = unaveraged(means, 7)
    noise = np.sqrt(np.maximum(means.counts, 1.0))
    assert np.std(((undone.counts - counted.counts) / noise)[7:]) < 0.5
    assert np.std(((means.counts - counted.counts) / noise)[7:]) > 0.9
    unknown = dataclasses.replace(means, flight=None)
    assert unaveraged(unknown, 7) is unknown
    assert running_mean(unknown) is None
    shown = flown(last=7)
    late = [dataclasses.replace(one, time_s=one.time_s + 99.0) for one in shown[70:]]
    halves = unaveraged(survey_of([*shown[:70], *late], SENSITIVITY_CPS), 7)
    assert np.std(((halves.counts - counted.counts) / noise)[77:]) < 0.7


@pytest.mark.slow
@pytest.mark.parametrize(('late_s', 'side'), [(1.5, 'after'), (-1.5, 'before')])
def test_a_clock_that_differs_is_found(late_s, side):
    """Lines flown to and fro tell it."""
    known = dataclasses.replace(LOSSLESS, largest_order=1)
    found = localize(survey_of(flown(late_s=late_s), SENSITIVITY_CPS), known)
    assert is_right(found)
    assert any(f's {side} the readings' in one for one in found.allowed_for)


@pytest.mark.slow
def test_a_gain_that_falls_is_found():
    """It is that of the start that the strength is told by."""
    found = localize(survey_of(flown(fall=0.35), SENSITIVITY_CPS), LOSSLESS)
    assert is_right(found)
    assert any('less at the end' in one for one in found.allowed_for)


@pytest.mark.slow
def test_dose_rates_of_few_counts_are_no_sources():
    """Their noise is that of the readings, not that of a large scintillator."""
    survey = survey_of(flown(sensitivity=3.0, is_dose=True))
    assert survey.is_nominal
    found = localize(survey, LOSSLESS)
    assert len(found.sources) == 1
    assert not found.is_misfit


def test_unsmoothing_is_the_inverse():
    """Gaps in the readings and two vehicles included."""
    rng = np.random.default_rng(1)
    times = np.cumsum(rng.uniform(0.5, 3.0, 60))
    counted, shown = rng.uniform(1.0, 9.0, (2, 60)), np.empty((2, 60))
    shown[:, 0] = counted[:, 0]
    for k in range(1, 60):
        kept = math.exp(-(times[k] - times[k - 1]) / 4.0)
        shown[:, k] = kept * shown[:, k - 1] + (1.0 - kept) * counted[:, k]
    readings = [
        LocalReading(
            position_enu_m=(k, 0.0, 9.0), dose_rate_usvh=shown[v, k], vehicle=str(v), time_s=time
        )
        for k, time in enumerate(times.tolist())
        for v in range(2)
    ]
    survey = unsmoothed(survey_of(readings), 4.0)
    assert survey.counts / survey.exposures == pytest.approx(counted.T.ravel())
    unknown = dataclasses.replace(survey, flight=None)
    assert unsmoothed(unknown, 4.0) is unknown


@pytest.mark.filterwarnings('error')
def test_dose_rates_that_are_all_alike_are_no_running_mean():
    """Nor do they end in a division by 0."""
    alike = [dataclasses.replace(one, dose_rate_usvh=0.1) for one in flown(is_dose=True)]
    found = localize(survey_of(alike), dataclasses.replace(LOSSLESS, largest_order=0))
    assert found.smoothing_s == 0.0


def test_as_many_vehicles_as_readings_have_no_flight():
    """Legs were made longer for ever, so that there were fewer of them."""
    names = [str(number) for number in range(99)]
    assert flight_of(names, np.arange(99.0), np.zeros((99, 3))) is None


def test_velocities_are_those_of_each_vehicle():
    """Two that pass each other, and one reading of a third."""
    times = np.repeat(np.arange(20.0), 2)
    places = np.zeros((41, 3))
    places[:40, 0] = times * np.tile([5.0, -3.0], 20)
    flight = flight_of([*['a', 'b'] * 20, 'c'], np.append(times, 7.0), places)
    assert flight.velocities_mps[:40, 0] == pytest.approx(np.tile([5.0, -3.0], 20))
    assert flight.velocities_mps[40] == pytest.approx(0.0)


def test_uneven_ground_is_no_running_mean():
    """Counts scatter from one to the next as counts do, however the ground rises and falls."""
    rng = np.random.default_rng(2)
    readings = flown(sensitivity=3000.0)
    rates = 0.1 + 0.04 * np.sin([one.position_enu_m[0] / 8.0 for one in readings])
    uneven = [
        dataclasses.replace(one, counts=float(count))
        for one, count in zip(readings, rng.poisson(3000.0 * rates), strict=True)
    ]
    known = dataclasses.replace(LOSSLESS, largest_order=0)
    assert localize(survey_of(uneven, 3000.0), known).smoothing_s == 0.0
