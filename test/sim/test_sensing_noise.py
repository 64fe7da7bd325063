# SPDX-License-Identifier: Apache-2.0
"""Sensor errors: of the stated size, a function of seed, vehicle and time alone."""

import math

import numpy as np
import pytest

from rocsafe_sim.rav.sensing_noise import LARGEST_SWAY_STDS, SensorNoise


def noise(seed: int = 1, vehicle: str = 'rav1') -> SensorNoise:
    """Return noise of round sizes."""
    return SensorNoise(
        seed=seed,
        vehicle=vehicle,
        gps_horizontal_std_m=2.0,
        gps_vertical_std_m=3.0,
        tilt_std_rad=0.01,
        attitude_std_rad=0.002,
    )


def test_gps_error_has_the_stated_size() -> None:
    """Over hours the errors have mean 0 and the stated standard deviations, at knots and between.

    1500 independent values give a mean within 3 sigma / sqrt(1500) = 0.08 sigma.
    """
    for phase_ns in (0, 7_000_000_000, 10_000_000_000):
        errors = np.array(
            [noise().gps_error_m(number * 40_000_000_000 + phase_ns) for number in range(1500)]
        )
        assert errors.std(axis=0) == pytest.approx([2.0, 2.0, 3.0], rel=0.06)
        assert np.abs(errors.mean(axis=0) / [2.0, 2.0, 3.0]).max() < 0.08


def test_gps_error_wanders() -> None:
    """Fixes 0.2 s apart share most of their error; fixes a minute apart share none."""
    start = range(0, 60_000_000_000_000, 97_000_000_000)
    east = np.array(
        [
            [noise().gps_error_m(t + later)[0] for later in (0, 200_000_000, 60_000_000_000)]
            for t in start
        ]
    )
    near, far = np.corrcoef(east.T)[0, 1:]
    assert near == pytest.approx(0.9, abs=0.03)
    assert abs(far) < 0.12


def test_errors_do_not_depend_on_the_order_of_calls() -> None:
    """The same question gets the same answer, whatever was asked before."""
    first = [noise().gps_error_m(t) for t in (5, 10**12, 3 * 10**12)]
    assert [noise().gps_error_m(t) for t in (3 * 10**12, 10**12, 5)] == first[::-1]


def test_seeds_and_vehicles_differ() -> None:
    """Two vehicles, or two seeds, have errors of their own."""
    errors = {noise(seed, name).gps_error_m(10**12) for seed in (1, 2) for name in ('a', 'b')}
    assert len(errors) == 4


def test_sway_has_the_stated_size_and_a_limit() -> None:
    """Roll and pitch spread as stated and never exceed the limit together."""
    sways = np.array([noise().sway_rad(number) for number in range(4000)])
    assert sways.std(axis=0) == pytest.approx([0.01, 0.01], rel=0.05)
    assert np.hypot(*sways.T).max() <= LARGEST_SWAY_STDS * 0.01 * (1.0 + 1e-12)
    assert noise().attitude_error_rad(3) != noise().attitude_error_rad(4)
    assert all(map(math.isfinite, noise().attitude_error_rad(3)))
