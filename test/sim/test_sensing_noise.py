# SPDX-License-Identifier: Apache-2.0
"""Sensor errors: of the stated size, a function of seed, vehicle and time alone."""

import math

import numpy as np
import pytest

from rocsafe_sim.sensors.sensing_noise import LARGEST_SWAY_STDS, SensorNoise


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


def test_attitude_errors_have_the_stated_size() -> None:
    """About each axis alike, around 0, and independent of each other."""
    errors = np.array([noise().attitude_error_rad(number) for number in range(4000)])
    assert errors.std(axis=0) == pytest.approx([0.002] * 3, rel=0.05)
    assert np.abs(errors.mean(axis=0)).max() < 3.5 * 0.002 / math.sqrt(4000)
    assert np.abs(np.corrcoef(errors.T) - np.eye(3)).max() < 0.06


def test_axes_of_the_receiver_are_independent() -> None:
    """East, north and up share no error, and two vehicles none either."""
    times = range(0, 1500 * 60_000_000_000, 60_000_000_000)
    errors = np.array(
        [noise().gps_error_m(t) + noise(vehicle='rav2').gps_error_m(t) for t in times]
    )
    assert np.abs(np.corrcoef(errors.T) - np.eye(6)).max() < 0.1


@pytest.mark.slow
def test_sway_of_a_stream_is_as_wide_as_at_photographs_and_smooth() -> None:
    """At knots and between, roll and pitch have the stated size; 1 ms changes next to nothing."""
    for phase_ns in (0, 300_000_000):
        sways = np.array([noise().sway_at_rad(k * 2_000_000_000 + phase_ns) for k in range(3000)])
        assert sways.std(axis=0) == pytest.approx([0.01, 0.01], rel=0.06)
    near = [noise().sway_at_rad(7_999_500_000 + shift) for shift in range(0, 1_000_001, 100_000)]
    assert np.abs(np.diff(near, axis=0)).max() < 1e-5


def test_noise_of_a_picture_depends_on_camera_and_time_alone() -> None:
    """Asked twice, the generator gives the same; another camera or time, another."""
    first = noise().picture_rng('camera', 5).standard_normal(3).tolist()
    assert noise().picture_rng('camera', 5).standard_normal(3).tolist() == first
    others = [noise().picture_rng('front', 5), noise().picture_rng('camera', 6)]
    assert all(other.standard_normal(3).tolist() != first for other in others)
