# SPDX-License-Identifier: Apache-2.0
"""Smoothing of edges: nearer to the exact coverage of pixels, and nothing else changes."""

import numpy as np
import pytest

from rocsafe_scene.engine.drawing_options import SMOOTHING
from rocsafe_scene.engine.smoothing import smoothed

HEIGHT, WIDTH = 60, 90
DARK, BRIGHT = 40.0, 210.0
OVERSAMPLED = 16
UP = np.full((HEIGHT, WIDTH, 3), 255, np.uint8)


def share_below(slope, oversampled):
    """Return the share of each pixel below a line of `slope` through the middle, (h, w)."""
    rows = (np.arange(HEIGHT * oversampled) + 0.5) / oversampled
    columns = (np.arange(WIDTH * oversampled) + 0.5) / oversampled
    is_below = rows[:, None] > 0.5 * HEIGHT + slope * (columns - 0.5 * WIDTH)
    parts = is_below.reshape(HEIGHT, oversampled, WIDTH, oversampled)
    return parts.mean(axis=(1, 3))


def picture(share):
    """Return an image of shares, dark 0 and bright 1, grey."""
    grey = np.rint(DARK + (BRIGHT - DARK) * share).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2)


@pytest.mark.parametrize('slope', [0.08, 0.2, 0.45, -0.3, 0.9, 2.5, -6.0])
def test_a_slanted_edge_comes_nearer_to_the_coverage_of_its_pixels(slope):
    """Against the exact share of each pixel: less than nine tenths of the error of steps."""
    drawn = share_below(slope, 1)
    numbers = (1 + drawn).astype(np.uint32)
    exact = picture(share_below(slope, OVERSAMPLED)).astype(float)
    before = picture(drawn)
    after = smoothed(before, numbers, UP)
    errors = [np.sqrt(np.mean((image - exact) ** 2)) for image in (before, after)]
    assert errors[1] < 0.9 * errors[0]


def test_only_pixels_beside_an_edge_change():
    """Texture within a thing stays as it was drawn."""
    rng = np.random.default_rng(3)
    before = rng.integers(0, 256, (HEIGHT, WIDTH, 3)).astype(np.uint8)
    numbers = np.ones((HEIGHT, WIDTH), np.uint32)
    numbers[:, 50:] = 2
    after = smoothed(before, numbers, UP)
    is_changed = (after != before).any(axis=2)
    assert is_changed[:, 50].any()
    assert not np.delete(is_changed, 50, axis=1).any()


def test_a_fold_within_a_thing_is_an_edge():
    """Where its normal turns by more than the limit, and only there."""
    drawn = share_below(0.2, 1)
    before, numbers = picture(drawn), np.ones((HEIGHT, WIDTH), np.uint32)
    for turn, is_edge in ((SMOOTHING.least_turn, False), (SMOOTHING.least_turn + 1, True)):
        normals = UP.copy()
        normals[..., 2] = np.where(drawn > 0.5, 255, 255 - turn)
        assert (smoothed(before, numbers, normals) != before).any() == is_edge


def test_an_edge_of_little_contrast_is_kept():
    """Up to the limits, absolute for dark and relative for bright pixels."""
    numbers = np.ones((HEIGHT, WIDTH), np.uint32)
    numbers[HEIGHT // 2 :] = 2
    numbers[HEIGHT // 2 + 1 :, 30:] = 1
    for bright, contrast in ((60, SMOOTHING.least_contrast), (250, 35)):
        before = np.full((HEIGHT, WIDTH, 3), bright, np.uint8)
        before[numbers == 2] = bright - int(contrast)
        assert (smoothed(before, numbers, UP) == before).all()


def test_a_picture_without_edges_is_returned_as_it_is():
    """The same array: nothing is copied."""
    before = picture(share_below(0.3, 1))
    assert smoothed(before, np.ones((HEIGHT, WIDTH), np.uint32), UP) is before
