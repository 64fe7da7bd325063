# SPDX-License-Identifier: Apache-2.0
"""A vehicle whose clock is late is found by how its fixes are off along its way."""

import numpy as np
import pytest

from rocsafe_geo.pinhole import rotation_enu_from_optical
from rocsafe_mapping.alignment.adjustment.clock_lag import lags_s, without_lag
from rocsafe_mapping.alignment.model.photo import Photo, Pose
from rocsafe_mapping.alignment_options import ClockOptions
from rocsafe_mapping.photographs.shot import Intrinsics

CAMERA = Intrinsics(
    width_px=640, height_px=480, fx_px=554.0, fy_px=554.0, cx_px=319.5, cy_px=239.5
)
LEVEL = rotation_enu_from_optical(0.0)
SPEED_MPS, STEP_M, FIX_STD_M = 8.0, 16.0, 1.5


def flown(lag_s, vehicle='rav1', *, strips=4, seed=1, forth_only=False):
    """Return photographs of strips flown to and fro, and where their cameras truly were."""
    rng = np.random.default_rng(seed)
    photos, poses = {}, {}
    for number in range(6 * strips):
        strip, step = divmod(number, 6)
        forth = 1.0 if strip % 2 == 0 or forth_only else -1.0
        centre = np.array([forth * STEP_M * (step - 2.5), 18.0 * strip, 32.0])
        told = centre + lag_s * np.array([forth * SPEED_MPS, 0.0, 0.0])
        told[:2] += rng.normal(0.0, FIX_STD_M, 2)
        name = f'{vehicle}-{number:05d}'
        poses[name] = Pose(centre=centre, rotation=LEVEL)
        photos[name] = Photo(
            name=name, vehicle=vehicle, lens='a', camera=CAMERA, focal_std_share=0.0,
            prior=Pose(centre=told, rotation=LEVEL), horizontal_std_m=FIX_STD_M,
            vertical_std_m=0.5, tilt_std_rad=0.03, yaw_std_rad=0.02,
            time_ns=int(number * 1e9 * STEP_M / SPEED_MPS),
        )  # fmt: skip
    return photos, poses


@pytest.mark.parametrize('lag_s', [1.0, -0.8])
@pytest.mark.parametrize('seed', range(5))
def test_a_late_clock_is_found(lag_s, seed):
    """Within a fifth of a second, its own vehicle only; its fixes are brought back."""
    late, late_poses = flown(lag_s, 'rav2', seed=seed)
    right, right_poses = flown(0.0, 'rav1', seed=seed + 100)
    photos, poses = {**late, **right}, {**late_poses, **right_poses}
    found = lags_s(photos, poses, ClockOptions())
    assert found == {'rav2': pytest.approx(lag_s, abs=0.2)}
    moved = without_lag(photos, found, ClockOptions())
    assert all(moved[name] is photo for name, photo in right.items())
    straight = [name for number, name in enumerate(late) if number % 6 not in (0, 5)]
    before, after = (
        np.mean([np.linalg.norm((p[n].prior.centre - poses[n].centre)[:2]) for n in straight])
        for p in (photos, moved)
    )
    assert after < 0.5 * before


def test_where_the_way_bends_a_late_fix_is_worth_less():
    """At the ends of strips the velocity is not known well."""
    photos, poses = flown(1.0)
    moved = without_lag(photos, lags_s(photos, poses, ClockOptions()), ClockOptions())
    assert moved['rav1-00002'].horizontal_std_m == pytest.approx(FIX_STD_M, rel=0.5)
    assert moved['rav1-00005'].horizontal_std_m > 2.0 * FIX_STD_M


@pytest.mark.parametrize('seed', range(5))
def test_a_right_clock_is_left_alone(seed):
    """Noise of fixes is no lag."""
    assert lags_s(*flown(0.0, seed=seed), ClockOptions()) == {}


def test_fixes_that_are_off_alike_are_no_lag():
    """One way only: nothing tells a lag from a map that lies elsewhere."""
    assert lags_s(*flown(1.0, forth_only=True), ClockOptions()) == {}


def test_photographs_of_one_time_have_no_velocity():
    """Nothing is known of a vehicle whose photographs tell no time, nor of two photographs."""
    photos, poses = flown(1.0)
    few = dict(list(photos.items())[:2])
    assert lags_s(few, poses, ClockOptions()) == {}
    assert without_lag(few, {}, ClockOptions()) == few
