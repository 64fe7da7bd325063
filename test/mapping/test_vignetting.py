# SPDX-License-Identifier: Apache-2.0
"""A lens's fall-off is found from overlaps and undone, and none is made up."""

import numpy as np
import pytest

from rocsafe_mapping.drawing.coarse_view import CoarseView
from rocsafe_mapping.drawing.grid import Window
from rocsafe_mapping.drawing.vignetting import FallOff, fall_offs
from rocsafe_mapping.drawing_options import GainOptions, VignettingOptions

SIDE = 60


def views_of(fall_off, rng):
    """Return nine overlapping views of rough ground through a lens, each of other exposure."""
    ground = rng.uniform(70.0, 180.0, (200, 200, 1)).repeat(3, axis=2)
    axis = (np.arange(SIDE) - (SIDE - 1) / 2) / (SIDE / 2)
    squares = ((axis[:, None] ** 2 + axis[None] ** 2) / 2.0).astype(np.float32)
    light = np.exp(fall_off.logs(squares))[..., None]
    views = {}
    for number in range(9):
        row, column = 22 * (number // 3), 25 * (number % 3)
        seen = ground[row : row + SIDE, column : column + SIDE] * light * rng.uniform(0.8, 1.2)
        views[f'{number}'] = CoarseView(
            window=Window(row, column, SIDE, SIDE),
            colours=np.clip(seen, 0, 255).astype(np.uint8),
            scores=np.ones((SIDE, SIDE), np.float32),
            squares=squares,
        )
    return views


def test_fall_off_is_found_whatever_the_ground_and_the_exposure():
    """The corners' 35 % and the middle of the way are found to 2 %."""
    truth = FallOff(-0.25, -0.18)
    views = views_of(truth, np.random.default_rng(1))
    found = fall_offs(views, dict.fromkeys(views, 'lens'), GainOptions(), VignettingOptions())
    places = np.array([0.25, 0.5, 1.0], np.float32)
    assert found['lens'].logs(places) == pytest.approx(truth.logs(places), abs=0.02)
    flat = np.full((1, 3, 3), 100, np.uint8)
    seen = np.rint(flat * np.exp(truth.logs(places))[None, :, None]).astype(np.uint8)
    assert np.abs(found['lens'].undone(seen, places[None]).astype(int) - 100).max() <= 3


def test_no_fall_off_is_made_up():
    """A lens without one, or one seen by too few pairs, is left as it is."""
    views = views_of(FallOff(0.0, 0.0), np.random.default_rng(2))
    lenses = dict.fromkeys(views, 'lens')
    assert fall_offs(views, lenses, GainOptions(), VignettingOptions()) == {}
    few = dict(list(views_of(FallOff(-0.4, 0.0), np.random.default_rng(2)).items())[:2])
    assert fall_offs(few, lenses, GainOptions(), VignettingOptions()) == {}
