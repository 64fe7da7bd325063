# SPDX-License-Identifier: Apache-2.0
"""A detector's sensitivity and dark counts are read from what it tells, and not told as dose."""

import numpy as np
import pytest

from rocsafe_radiation.decision.sequential_decision import sequential_evidence
from rocsafe_radiation.detection.detector import DETECTORS, measure
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.localize import LocalizationOptions, localize
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.readings.calibration import calibration_of
from rocsafe_radiation.readings.row_checks import of_other_units
from rocsafe_radiation.readings.survey import LocalReading, survey_of

GM = DETECTORS['gm_sbm20']
LOSSLESS = LocalizationOptions(kernel=Kernel(is_lossy=False))


def readings(kind, rates_usvh, digits=9, has_std=True, window_s=1.0):
    """Return readings of a kind of detector over a square of 200 m, 20 m high."""
    generator = np.random.default_rng(1)
    axis = np.linspace(0.0, 200.0, 21)
    found = []
    for k, rate in enumerate(rates_usvh):
        one = measure(kind, float(rate), window_s, generator)
        found.append(
            LocalReading(
                position_enu_m=(axis[k % 21], axis[k // 21], 20.0),
                dose_rate_usvh=round(one.dose_rate_usvh, digits),
                dose_rate_std_usvh=one.dose_rate_std_usvh if has_std else 0.0,
                counts=float(one.counts),
                live_time_s=one.live_time_s,
            )
        )
    return found


def columns(observations):
    """Return counts, live times and dose rates."""
    rows = [(one.counts, one.live_time_s, one.dose_rate_usvh) for one in observations]
    return tuple(np.array(rows).T)


@pytest.mark.parametrize('digits', [2, 9])
@pytest.mark.parametrize('name', DETECTORS)
def test_the_law_of_each_detector_is_read_from_its_readings(name, digits):
    """With dose rates rounded to 0.01 uSv/h, too."""
    kind = DETECTORS[name]
    rates = np.geomspace(0.1, 5.0, 441)
    found = calibration_of(*columns(readings(kind, rates, digits)))
    wanted = kind.sensitivity_cps_per_usvh
    assert found.sensitivity_cps_per_usvh == pytest.approx(wanted, rel=0.03)
    assert found.dark_rate_cps == pytest.approx(kind.dark_rate_cps, abs=0.01 * wanted)


def test_dose_rates_from_elsewhere_tell_no_dark_counts():
    """They scatter about the counts; the sensitivity is then the ratio of both."""
    generator = np.random.default_rng(2)
    rates = np.linspace(0.1, 0.4, 500)
    counts = generator.poisson(100.0 * rates + 20.0).astype(float)
    found = calibration_of(counts, np.ones(500), rates)
    assert found.dark_rate_cps == 0.0
    assert found.sensitivity_cps_per_usvh == pytest.approx(np.median(counts / rates))


def test_a_few_rows_in_another_unit_change_no_calibration():
    """And are found, though few counts are beyond the dark ones."""
    counts, live_s, rates = columns(readings(GM, np.full(441, 0.3)))
    wrong = np.zeros(441, dtype=bool)
    wrong[np.flatnonzero(rates > 0.0)[::9]] = True
    mixed = np.where(wrong, 1e3 * rates, rates)
    assert calibration_of(counts, live_s, mixed).dark_rate_cps == pytest.approx(0.2, rel=0.01)
    assert (of_other_units([''] * 441, counts, live_s, mixed) == wrong).all()


def test_one_count_more_than_dark_is_no_other_unit():
    """Its dose rate is almost 0, for one count."""
    counts = np.array([1.0, 2.0, 3.0, 4.0])
    rates = (counts - 0.9999) / 2.5
    assert not of_other_units([''] * 4, counts, np.ones(4), rates).any()


@pytest.mark.parametrize('has_std', [True, False])
def test_counts_of_readings_without_a_dose_rate_are_kept(has_std):
    """As many as the dark counts or fewer: the dose rate told is 0."""
    told = readings(GM, np.full(441, 0.1), has_std=has_std)
    survey = survey_of(told)
    assert survey.counts.tolist() == [one.counts for one in told]
    assert survey.exposures == pytest.approx(2.5, rel=1e-3)
    assert survey.dark_counts == pytest.approx(0.2, rel=1e-3)
    level = survey.net_counts.sum() / survey.exposures.sum()
    assert level == pytest.approx(0.1, abs=0.035)


def test_dose_rates_allow_for_what_live_times_do_not_tell():
    """Lost counts are not a lower dose rate."""
    rates = np.append(np.linspace(0.1, 1.0, 400), [1e3, 2e3])
    counts = 100.0 * rates
    counts[-2:] *= 0.5
    told = [
        LocalReading(position_enu_m=(0, 0, 1), dose_rate_usvh=r, counts=c, live_time_s=1.0)
        for r, c in zip(rates.tolist(), counts.tolist(), strict=True)
    ]
    assert survey_of(told).exposures[[0, -1]] == pytest.approx([100.0, 50.0])


@pytest.mark.slow
def test_dark_counts_are_no_background():
    """A tube with 0.2 counts a second in the dark, at 0.10 uSv/h: 0.165 was stated."""
    survey = survey_of(readings(GM, np.full(441, 0.1), window_s=10.0))
    found = localize(survey, LOSSLESS)
    assert found.background_usvh == pytest.approx(0.1, abs=3.0 * found.background_std_usvh)
    assert found.background_std_usvh < 0.02
    evidence = sequential_evidence(survey, Setting(kernel=LOSSLESS.kernel), 92.0)
    assert evidence.log_ratio_smallest < -5.0


def test_a_dose_rate_of_0_with_a_deviation_counts_as_no_count_of_so_much():
    """Without counts and live time, too."""
    told = LocalReading(position_enu_m=(0, 0, 30), dose_rate_usvh=0.0, dose_rate_std_usvh=0.4)
    survey = survey_of([told] * 9)
    assert survey.counts.tolist() == [0.0] * 9
    assert survey.exposures == pytest.approx(2.5)
