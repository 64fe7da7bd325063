# SPDX-License-Identifier: Apache-2.0
"""Images of labels and depth show what the truth says."""

import numpy as np

from rocsafe_scene.command_line.label_images import (
    class_picture,
    depth_picture,
    number_picture,
    truth_sheet,
)
from rocsafe_scene.mesh.classes import CLASSES


def test_classes_have_their_colours():
    """Blue, green, red, as OpenCV wants them; a number without a class is black."""
    numbers = np.array([[label.number for label in CLASSES.values()]], np.uint8)
    colours = class_picture(numbers)[0]
    assert [tuple(row[::-1]) for row in colours.tolist()] == [
        label.colour for label in CLASSES.values()
    ]
    assert class_picture(np.array([[255]], np.uint8)).tolist() == [[[0, 0, 0]]]


def test_instances_differ_and_the_sky_is_black():
    """Thousand neighbours in number have a thousand colours, none of them dark."""
    colours = number_picture(np.arange(1001, dtype=np.uint32)[None])[0]
    assert colours[0].tolist() == [0, 0, 0]
    assert len({tuple(row) for row in colours[1:].tolist()}) == 1000
    assert colours[1:].min() >= 96


def test_nearer_is_brighter_and_the_sky_is_as_far_as_the_farthest():
    """By the logarithm: each doubling of the distance is the same step."""
    depth = np.array([[2.0, 4.0, 8.0, 16.0, np.inf]])
    brightness = depth_picture(depth).astype(float).sum(axis=2)[0]
    assert (np.diff(brightness[:4]) < 0.0).all()
    assert brightness[4] == brightness[3]


def test_a_sheet_has_four_images_of_one_size():
    """Classes and instances above depth and normals."""
    size = (6, 8)
    sheet = truth_sheet(
        np.ones(size, np.uint8),
        np.ones(size, np.uint32),
        np.full(size, 5.0),
        np.full((*size, 3), 7, np.uint8),
    )
    assert sheet.shape == (12, 16, 3)
    assert (sheet[6:, 8:] == 7).all()
