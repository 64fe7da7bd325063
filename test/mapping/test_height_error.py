# SPDX-License-Identifier: Apache-2.0
"""A map over ground that is not level says how far what stands there may be off."""

import math

import numpy as np
import pytest

from rocsafe_geo.pinhole import rotation_enu_from_optical
from rocsafe_mapping.alignment.adjustment.height_error import TieHeights, height_error, leaning_m
from rocsafe_mapping.alignment.block import BY_FEATURES, Placement
from rocsafe_mapping.alignment.model.photo import Photo, Pose
from rocsafe_mapping.alignment.model.surface import Surface, level_grid
from rocsafe_mapping.alignment_options import AlignmentOptions
from rocsafe_mapping.mosaic.map_alignment import Alignment
from rocsafe_mapping.photographs.shot import Intrinsics

HEIGHT_M = 32.0
POSE = Pose(centre=np.array([20.0, 20.0, HEIGHT_M]), rotation=rotation_enu_from_optical(0.0))


def scattered(count: int, low: float, high: float) -> np.ndarray:
    """Return places over a square."""
    return np.random.default_rng(3).uniform(low, high, (count, 2))


def heights(places: np.ndarray, standing: np.ndarray, stds_m: float | np.ndarray = 0.01):
    """Return heights of ties that are known so well."""
    stds_m = np.broadcast_to(stds_m, len(standing))
    return TieHeights(places_m=places, standing_m=standing, stds_m=stds_m)


def test_a_few_wrong_ties_of_low_photographs_do_not_decide() -> None:
    """Eight wrong matches seem to tell heights to 2 cm, 2000 others tell them to 0.3 m."""
    ties, rng = scattered(2000, 0.0, 60.0), np.random.default_rng(4)
    standing, stds_m = rng.normal(0.0, 1.0, 2000), np.full(2000, 0.3)
    standing[:8], stds_m[:8] = -13.0, 0.02
    found = height_error(Surface(), heights(ties, standing, stds_m), AlignmentOptions())
    assert float(found.heights_m.max()) == pytest.approx(1.0, abs=0.4)


@pytest.mark.parametrize('surface', ['level', 'grid'])
def test_photographs_from_one_place_tell_no_heights(surface) -> None:
    """Whoever hovers and photographs, or flies a survey again, does not make the map worse."""
    ties, rng = scattered(400, 0.0, 60.0), np.random.default_rng(2)
    stds_m = np.where(np.arange(400) % 2, 20.0, 0.05)
    known, noise = stds_m < 1.0, rng.normal(0.0, stds_m)
    ground = Surface() if surface == 'level' else level_grid(ties, 3.2, 40_000)
    found, alone = (
        height_error(ground, heights(places, standing, stds), AlignmentOptions()).at(ties)
        for places, standing, stds in (
            (ties, noise, stds_m),
            (ties[known], noise[known], stds_m[known]),
        )
    )
    # The error between ties is that of draws, which are others with more ties.
    assert found.mean() == pytest.approx(alone.mean(), rel=0.05)
    assert found.max() < 0.3


def test_level_ground_is_as_good_as_its_ties() -> None:
    """One figure for all of it: the spread of the ties' heights."""
    found = height_error(
        Surface(),
        heights(scattered(4, 0.0, 9.0), np.array([0.1, -0.1, 0.3, -0.3])),
        AlignmentOptions(),
    )
    assert found.at(np.array([[500.0, 3.0]])) == pytest.approx(math.sqrt(0.05))


def test_ground_without_ties_is_less_certain() -> None:
    """A hole between ties counts with what the ground may do there."""
    ties = scattered(400, 0.0, 60.0)
    ties = ties[np.linalg.norm(ties - 40.0, axis=1) > 15.0]
    standing = np.random.default_rng(1).normal(0.0, 0.05, len(ties))
    error = height_error(
        level_grid(scattered(9, 0.0, 60.0), 3.2, 40_000),
        heights(ties, standing),
        AlignmentOptions(),
    )
    near, hole = error.at(np.array([[8.0, 8.0], [40.0, 40.0]]))
    assert 0.05 < near < 0.25
    assert hole > 4.0 * near


def test_things_that_stand_up_count_where_they_stand() -> None:
    """Ties of roofs make the error larger about them, not elsewhere."""
    ties = scattered(1500, 0.0, 60.0)
    is_roof = np.linalg.norm(ties - 45.0, axis=1) < 6.0
    standing = np.where(is_roof, 3.0, 0.02)
    error = height_error(
        level_grid(ties, 3.2, 40_000), heights(ties, standing), AlignmentOptions()
    )
    roof, meadow = error.at(np.array([[45.0, 45.0], [10.0, 10.0]]))
    assert roof > 2.0
    assert meadow < 1.0


def test_the_error_of_an_unknown_height_is_that_of_a_point_so_high() -> None:
    """What lies z too high is drawn where the ray through it meets the ground."""
    z_m, ground_m = 0.4, np.array([[32.0, 25.0]])
    up = np.array([*ground_m[0], z_m]) - POSE.centre
    met = POSE.centre + up * (-HEIGHT_M / up[2])
    wrong_m = float(np.linalg.norm(met[:2] - ground_m[0]))
    told = leaning_m(Surface(heights_m=np.full((1, 1), z_m)), POSE, ground_m)[0]
    assert told == pytest.approx(wrong_m, rel=0.02)


def test_a_photograph_states_both_its_place_and_what_leans() -> None:
    """The two errors add up as independent ones do, for all of it or where it is asked."""
    camera = Intrinsics(
        width_px=640, height_px=480, fx_px=554.0, fy_px=554.0, cx_px=319.5, cy_px=239.5
    )
    photo = Photo(
        name='a', vehicle='rav1', lens='a', camera=camera, focal_std_share=0.0, prior=POSE,
        horizontal_std_m=1.5, vertical_std_m=0.5, tilt_std_rad=0.03, yaw_std_rad=0.02,
    )  # fmt: skip
    alignment = Alignment(
        photos={'a': photo},
        placements={'a': Placement(pose=POSE, placed_by=BY_FEATURES)},
        errors_m={'a': 0.03},
        held_out_px=np.zeros((0, 2)),
        heights=heights(np.zeros((0, 2)), np.zeros(0)),
        heights_error=Surface(heights_m=np.full((1, 1), 0.2)),
    )
    below, aside = np.array([[20.0, 20.0]]), np.array([[36.0, 20.0]])
    assert alignment.error_m('a', below) == pytest.approx(0.03)
    assert alignment.error_m('a', aside) == pytest.approx(math.hypot(0.03, 0.1))
    width_m, height_m = (side * HEIGHT_M / 554.0 for side in (640, 480))
    usual = 0.2 * math.sqrt((width_m**2 + height_m**2) / 12.0) / HEIGHT_M
    assert alignment.error_m('a') == pytest.approx(math.hypot(0.03, usual), rel=0.02)
