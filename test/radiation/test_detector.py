# SPDX-License-Identifier: Apache-2.0
"""Counts are Poisson, dead time is as in theory, and nothing depends on the order of calls."""

import math
import re
import textwrap
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_radiation.detection import detector
from rocsafe_radiation.detection.counting import Sample, WindowCounter
from rocsafe_radiation.detection.detector import (
    DETECTORS,
    NON_PARALYSABLE,
    PARALYSABLE,
    DetectorModel,
    measure,
    window_generator,
)
from rocsafe_radiation.physics.background import Background

TUBE = DETECTORS['gm_sbm20']
SECOND_NS = 1_000_000_000


def poisson_chi_square(counts, mean):
    """Return the z score (Wilson and Hilferty) of chi^2 of `counts` against Poisson(mean)."""
    low, high = int(mean - 3 * math.sqrt(mean)), int(mean + 3 * math.sqrt(mean))
    logs = [k * math.log(mean) - mean - math.lgamma(k + 1) for k in range(low, high + 1)]
    inner = np.exp(logs)
    expected = np.concatenate([inner, [1.0 - inner.sum()]]) * len(counts)
    observed = np.array([np.count_nonzero(counts == k) for k in range(low, high + 1)])
    observed = np.append(observed, len(counts) - observed.sum())
    chi2, dof = float(((observed - expected) ** 2 / expected).sum()), len(expected) - 1
    spread = 2.0 / (9.0 * dof)
    return ((chi2 / dof) ** (1 / 3) - 1 + spread) / math.sqrt(spread)


@pytest.mark.slow
def test_counts_are_poisson():
    """Chi-square, p > 0.01, over windows each with its own generator."""
    counts = np.array(
        [measure(TUBE, 8.0, 1.0, window_generator(3, 'rav1', i)).counts for i in range(20_000)]
    )
    rate = 8.0 * 2.5 + 0.2
    assert poisson_chi_square(counts, rate / (1 + rate * TUBE.dead_time_s)) < 2.33


@pytest.mark.parametrize('kind', [NON_PARALYSABLE, PARALYSABLE])
def test_dead_time_and_its_correction_are_as_in_theory(kind):
    """At 0.3 of the time dead, within 1 %; the reading finds back to the truth."""
    tau = 1e-4
    detector = DetectorModel(
        name='x', sensitivity_cps_per_usvh=100.0, dead_time_s=tau, dead_time_model=kind
    )
    load = 0.3 / 0.7 if kind == NON_PARALYSABLE else 0.4894
    truth_usvh = load / tau / 100.0
    reading = measure(detector, truth_usvh, 1000.0, np.random.default_rng(1))
    assert reading.counts / 1000.0 * tau == pytest.approx(0.3, rel=0.01)
    assert reading.dose_rate_usvh == pytest.approx(truth_usvh, rel=0.01)


def test_saturation_is_told():
    """Beyond a share of 0.3 dead, and where a paralysable detector folds back."""
    assert not TUBE.is_saturated(0.2 / TUBE.dead_time_s)
    assert TUBE.is_saturated(0.5 / TUBE.dead_time_s)
    assert DETECTORS['nai_2x2'].is_saturated(1e9)


@given(
    rate=st.floats(0, 1e18),
    name=st.sampled_from(sorted(DETECTORS)),
    window=st.floats(1e-3, 3600),
)
def test_readings_are_finite_whatever_the_field(rate, name, window):
    """Up to the surface of the strongest source."""
    reading = measure(DETECTORS[name], rate, window, np.random.default_rng(0))
    assert 0 <= reading.counts < 2**32
    assert math.isfinite(reading.dose_rate_usvh)
    assert reading.dose_rate_usvh >= 0.0
    assert 0.0 < reading.dose_rate_std_usvh < math.inf
    assert 0.0 < reading.live_time_s <= window


def test_a_tube_overresponds_to_soft_photons():
    """An uncompensated tube reads americium two to three times too high."""
    assert 2.0 < TUBE.relative_response('Am-241') < 3.0
    assert TUBE.relative_response('Cs-137') == 1.0


def northward(samples):
    """Return the dose rate at each sample."""
    return np.array([1e4 * sample.place[0] for sample in samples])


def flight(counter, steps):
    """Return the readings of a flight with a sample each 0.2 s.

    The dose rate grows by 0.1 uSv/h each step of 1e-5 degrees to the north.
    """
    samples = (
        Sample(
            time_ns=step * SECOND_NS // 5,
            place=(1e-5 * step, 2.0, 30.0),
            believed=(1e-5 * step, 2.0, 30.0),
        )
        for step in steps
    )
    return [reading for reading in map(counter.add, samples) if reading is not None]


def test_windows_end_at_whole_seconds_at_the_mean_place():
    """Samples 6 to 10 are the second window: their mean is 0.8 uSv/h at sample 8."""
    readings = flight(WindowCounter(DETECTORS['nai_2x2'], 'rav1', 1.0, 7, northward), range(1, 16))
    assert [reading.time_ns for reading in readings] == [2 * SECOND_NS, 3 * SECOND_NS]
    assert readings[0].latitude_deg == pytest.approx(8e-5)
    assert readings[0].measurement.counts == pytest.approx(0.8 * 1500, abs=200)


def test_a_restart_changes_no_later_window():
    """The counter that began in the middle agrees from its first whole window on."""
    whole = flight(WindowCounter(TUBE, 'rav1', 1.0, 7, northward), range(1, 31))
    late = flight(WindowCounter(TUBE, 'rav1', 1.0, 7, northward), range(13, 31))
    assert late == whole[-len(late) :]
    assert len(late) == 3


def test_windows_without_a_sample_at_their_end_are_told_by_the_next():
    """As with fixes that miss the whole second."""
    readings = flight(WindowCounter(TUBE, 'rav1', 1.0, 7, northward), (1, 3, 6, 9, 12))
    assert [reading.time_ns for reading in readings] == [2 * SECOND_NS]


def test_background_has_its_mean_and_its_spread():
    """Over a square kilometre, at the ground."""
    background = Background(terrestrial_usvh=0.1, variation=0.2, length_m=40.0, seed=5)
    grid = np.linspace(0, 1000, 80) / 111_320.0
    latitudes, longitudes = (axis.ravel() for axis in np.meshgrid(grid, grid))
    rates = background.dose_rates_usvh(latitudes, longitudes, np.zeros(latitudes.size))
    assert rates.mean() == pytest.approx(0.1, rel=0.1)
    assert np.log(rates).std() == pytest.approx(0.2, rel=0.3)
    assert (rates > 0).all()


def test_background_falls_with_height_and_the_sky_adds_to_it():
    """120 m up the ground gives 1/e; cosmic rays double in less than 2 km."""
    ground = Background(terrestrial_usvh=0.1)
    high = ground.dose_rates_usvh([0.0], [0.0], [120.0])
    assert high == pytest.approx([0.1 / math.e])
    sky = Background(is_cosmic=True)
    low, up = sky.dose_rates_usvh([0.0, 0.0], [0.0, 0.0], [0.0, 1733.0])
    assert low == pytest.approx(0.033)
    assert up == pytest.approx(0.066, rel=0.01)


def test_example_of_a_new_detector_counts():
    """The one that docs/architecture.md tells to add."""
    text = Path(__file__).resolve().parents[2].joinpath('docs/architecture.md').read_text()
    block = re.search(r'```python\n(    DetectorModel\(.*?)```', text, re.S)[1]
    kind = eval(textwrap.dedent(block), vars(detector))  # noqa: S307 - our own document
    found = measure(kind, 5.0, 1000.0, window_generator(1, 'rav1', 1))
    assert found.dose_rate_usvh == pytest.approx(5.0, rel=0.01)
