# SPDX-License-Identifier: Apache-2.0
"""Seams keep off what stands up, and show it whole."""

import cv2
import numpy as np
import pytest

from rocsafe_mapping.drawing.coarse_view import CoarseView
from rocsafe_mapping.drawing.grid import Window
from rocsafe_mapping.drawing.object_ownership import keep_objects_whole
from rocsafe_mapping.drawing.seam_cost import seam_cost
from rocsafe_mapping.drawing.seams import owners
from rocsafe_mapping.drawing_options import DrawingOptions, SeamOptions


def view(window: Window, scores: np.ndarray) -> CoarseView:
    """Return a photograph without colours."""
    return CoarseView(
        window=window, colours=np.zeros((1, 1, 3), np.uint8), scores=scores, squares=scores
    )


def ground(width: int = 160) -> np.ndarray:
    """Return ground that does not repeat itself, 80 pixels high."""
    noise = np.random.default_rng(4).uniform(60, 160, (80, width, 3)).astype(np.uint8)
    return cv2.GaussianBlur(noise, (0, 0), 1.5)


def with_thing(picture: np.ndarray, column: int) -> np.ndarray:
    """Return a picture with a bright thing of 14 x 24 pixels."""
    changed = picture.copy()
    changed[28:52, column : column + 14] = (40, 40, 250)
    changed[30:34, column + 2 : column + 12] = 10
    return changed


def test_ground_that_looks_alike_costs_nothing() -> None:
    """A seam through ground that both photographs show alike is free."""
    assert seam_cost(ground(), ground(), SeamOptions()).max() == 0.0


def test_a_thing_costs_where_it_is_in_either_photograph_and_between() -> None:
    """What stands up lies elsewhere in each: all the way from the one place to the other costs."""
    cost = seam_cost(with_thing(ground(), 60), with_thing(ground(), 66), SeamOptions())
    assert cost[32:48, 62:78].min() > 2.5
    assert cost[:, :40].max() < 1.0
    assert cost[:, 100:].max() < 1.0


@pytest.mark.parametrize(('height', 'width'), [(1, 1), (5, 90), (33, 17), (128, 6)])
def test_places_of_any_shape_have_a_cost(height: int, width: int) -> None:
    """Slivers where photographs barely meet are told too."""
    rng = np.random.default_rng(1)
    one, other = rng.integers(0, 255, (2, height, width, 3)).astype(np.uint8)
    assert seam_cost(one, other, SeamOptions()).shape == (height, width)


def two_views(shift: int) -> tuple[dict[str, CoarseView], Window]:
    """Return two photographs, 110 wide, of ground 160 wide with a thing between them."""
    window = Window(0, 0, 80, 160)
    views = {}
    for name, start, column in (('a', 0, 74), ('b', 50, 74 + shift)):
        colours = with_thing(ground(), column)[:, start : start + 110]
        off = np.abs(np.arange(110) - 54.5) / 110
        scores = np.repeat((1.0 - 0.4 * off**2)[np.newaxis], 80, axis=0).astype(np.float32)
        views[name] = CoarseView(
            window=Window(0, start, 80, 110), colours=colours, scores=scores, squares=scores
        )
    return views, window


@pytest.mark.parametrize('shift', [-6, 6])
def test_a_thing_in_the_middle_between_two_photographs_is_shown_by_one(shift: int) -> None:
    """The seam, which would run through its middle, goes round it."""
    views, window = two_views(shift)
    labels = owners(views, ['a', 'b'], window, DrawingOptions())
    low, high = 74 + min(shift, 0), 88 + max(shift, 0)
    assert len(np.unique(labels[28:52, low:high])) == 1
    assert set(np.unique(labels).tolist()) == {0, 1}


def test_a_thing_that_no_detour_avoids_is_given_to_who_shows_it_whole() -> None:
    """One photograph shows it where seams of least cost would still cut it."""
    cost = np.zeros((40, 60), np.float32)
    cost[10:30, 20:40] = 20.0
    labels = np.zeros((40, 60), np.int32)
    labels[:, 30:] = 1
    everything = Window(0, 0, 40, 60)
    short = np.ones((40, 60), np.float32)
    short[:, 35:] = 0.0
    views = [view(everything, short), view(everything, np.ones((40, 60), np.float32))]
    keep_objects_whole(labels, cost, views, everything, DrawingOptions())
    assert np.all(labels[10:30, 20:40] == 1)
    assert np.all(labels[:, :15] == 0)


def test_a_thing_that_nobody_shows_whole_stays_cut() -> None:
    """Nothing changes where it would not become whole."""
    cost = np.zeros((40, 60), np.float32)
    cost[10:30, 20:40] = 20.0
    labels = np.zeros((40, 60), np.int32)
    labels[:, 30:] = 1
    left, right = (np.zeros((40, 60), np.float32) for _ in range(2))
    left[:, :31], right[:, 29:] = 1.0, 1.0
    everything = Window(0, 0, 40, 60)
    before = labels.copy()
    keep_objects_whole(
        labels,
        cost,
        [view(everything, left), view(everything, right)],
        everything,
        DrawingOptions(),
    )
    assert np.array_equal(labels, before)
