# SPDX-License-Identifier: Apache-2.0
"""Annotations of instances whose box, area, outline and runs are known."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pycocotools import mask as coco

from rocsafe_dataset.labels.annotations import annotate, large_enough
from rocsafe_scene.mesh.classes import class_number
from rocsafe_scene.scene.environment import FIRST_OBJECT_NUMBER

HEIGHT, WIDTH = 24, 32
NUMBER = FIRST_OBJECT_NUMBER + 3


def frame(*parts, number=NUMBER):
    """Return a rendering in which an instance fills rectangles (rows, columns)."""
    numbers = np.zeros((HEIGHT, WIDTH), np.uint32)
    for rows, columns in parts:
        numbers[rows, columns] = number
    return SimpleNamespace(numbers=numbers)


def annotation(shown, share=0.5):
    """Return the one annotation of a rendering."""
    thing = SimpleNamespace(number=NUMBER, name='car', label='car')
    (found,) = annotate(shown, {NUMBER: thing}, {NUMBER: share})
    return found


@given(st.integers(0, HEIGHT - 2), st.integers(0, WIDTH - 2), st.integers(1, 9), st.integers(1, 9))
def test_a_rectangle_has_its_box_area_and_outline(top, left, height, width):
    """In pixels, and as shares of the image; it is cut if it reaches a border."""
    bottom, right = min(top + height, HEIGHT), min(left + width, WIDTH)
    found = annotation(frame((slice(top, bottom), slice(left, right))))
    assert found.box == (left, top, right - left, bottom - top)
    assert found.area == (right - left) * (bottom - top)
    assert found.is_cut == (top == 0 or left == 0 or bottom == HEIGHT or right == WIDTH)
    ring = np.array(found.polygon).reshape(-1, 2) * (WIDTH, HEIGHT)
    assert ring.min(axis=0) == pytest.approx([left, top], abs=0.25)
    assert ring.max(axis=0) == pytest.approx([right, bottom], abs=0.25)


def test_runs_are_read_by_pycocotools():
    """The mask comes back, also of an instance in two parts."""
    shown = frame((slice(2, 6), slice(3, 9)), (slice(10, 20), slice(20, 32)))
    found = annotation(shown)
    decoded = coco.decode({'size': [HEIGHT, WIDTH], 'counts': found.runs})
    assert (decoded == (shown.numbers == NUMBER)).all()
    assert found.area == 4 * 6 + 10 * 12
    assert found.box == (3, 2, 29, 18)
    assert found.is_cut
    assert found.category == class_number('car')


def test_small_instances_sky_and_ground_are_left_out():
    """Numbers below that of the first object are no instances, however large."""
    shown = frame((slice(0, 2), slice(0, 4)))
    shown.numbers[5, 5] = NUMBER + 1
    assert large_enough(shown, 8) == [NUMBER]
    assert large_enough(shown, 9) == []
    assert large_enough(shown, 1) == [NUMBER, NUMBER + 1]
    assert large_enough(frame((slice(0, 9), slice(0, 9)), number=1), 1) == []
