# SPDX-License-Identifier: Apache-2.0
"""Masks written for others: COCO's run lengths and YOLO's polygons."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rocsafe_dataset.outlines import outline
from rocsafe_dataset.rle import length_of_text, mask_of, run_lengths, short_text

MASKS = st.tuples(st.integers(1, 12), st.integers(1, 12)).flatmap(
    lambda shape: arrays(np.bool_, shape)
)


@given(MASKS)
@settings(max_examples=60, deadline=None)
def test_run_lengths_give_the_mask_back(mask):
    """Also through the short text."""
    lengths = run_lengths(mask)
    assert np.array_equal(mask_of(lengths, mask.shape), mask)
    assert length_of_text(short_text(lengths)) == lengths


@given(MASKS)
@settings(max_examples=60, deadline=None)
def test_the_short_text_is_that_of_pycocotools(mask):
    """Letter by letter, and its area with it."""
    coco = pytest.importorskip('pycocotools.mask')
    theirs = coco.encode(np.asfortranarray(mask.astype(np.uint8)))
    assert short_text(run_lengths(mask)).encode() == theirs['counts']
    assert coco.area(theirs) == mask.sum()


@given(st.lists(st.integers(0, 10**6), min_size=1, max_size=9))
def test_long_runs_survive_the_text(lengths):
    """Several groups of five bits, and differences below zero."""
    assert length_of_text(short_text(lengths)) == lengths


@pytest.mark.parametrize('seed', range(6))
def test_one_polygon_covers_all_parts_of_a_mask(seed):
    """Blobs and specks: drawn again, the polygon agrees with the mask."""
    rng = np.random.default_rng(seed)
    mask = np.zeros((80, 100), np.uint8)
    for _ in range(3):
        place = rng.integers(12, 68, 2).tolist()
        cv2.ellipse(mask, place, rng.integers(5, 12, 2).tolist(), seed * 30.0, 0, 360, 1, -1)
    ring = outline(mask.astype(bool))
    assert len(ring) >= 3
    large = np.zeros((800, 1000), np.uint8)
    cv2.fillPoly(large, [np.rint(10.0 * ring).astype(np.int32)], 1)
    again = cv2.resize(large, (100, 80), interpolation=cv2.INTER_AREA) > 0
    both, either = (mask & again).sum(), (mask | again).sum()
    assert both / either > 0.85


def test_a_single_pixel_has_an_outline():
    """About itself, half a pixel to each side."""
    ring = outline(np.ones((1, 1), bool))
    assert len(ring) >= 3
    assert ring.min() >= 0.0
    assert ring.max() <= 1.0
