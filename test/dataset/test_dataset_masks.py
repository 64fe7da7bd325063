# SPDX-License-Identifier: Apache-2.0
"""Masks written for others: COCO's run lengths and YOLO's polygons."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rocsafe_dataset.labels.outlines import outline
from rocsafe_dataset.labels.rle import run_lengths, short_text

MASKS = st.tuples(st.integers(1, 12), st.integers(1, 12)).flatmap(
    lambda shape: arrays(np.bool_, shape)
)


@given(MASKS)
@settings(max_examples=60, deadline=None)
def test_runs_alternate_and_add_up_to_the_mask(mask):
    """Odd runs hold the ones; all runs together are as long as the mask."""
    lengths = run_lengths(mask)
    assert sum(lengths) == mask.size
    assert sum(lengths[1::2]) == mask.sum()
    values = np.repeat(np.arange(len(lengths)) % 2 == 1, lengths)
    assert np.array_equal(values.reshape(mask.shape[::-1]).T, mask)


@given(MASKS)
@settings(max_examples=60, deadline=None)
def test_the_short_text_is_that_of_pycocotools(mask):
    """Letter by letter, and its area with it."""
    coco = pytest.importorskip('pycocotools.mask')
    theirs = coco.encode(np.asfortranarray(mask.astype(np.uint8)))
    assert short_text(run_lengths(mask)).encode() == theirs['counts']
    assert coco.area(theirs) == mask.sum()


def test_long_runs_and_shrinking_runs_are_written_as_pycocotools_does():
    """Several groups of five bits, and negative differences."""
    coco = pytest.importorskip('pycocotools.mask')
    mask = np.zeros((700, 700), bool)
    mask[5:, 100:400] = True
    mask[300:310, 500:] = True
    mask[1, 699] = True
    theirs = coco.encode(np.asfortranarray(mask.astype(np.uint8)))
    assert short_text(run_lengths(mask)).encode() == theirs['counts']


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
