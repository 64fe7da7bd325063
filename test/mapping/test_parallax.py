# SPDX-License-Identifier: Apache-2.0
"""Matches that stand off the ground's plane are known by where they lie."""

import numpy as np

from rocsafe_mapping.alignment.matching.parallax import off_plane, transformed
from rocsafe_mapping.alignment_options import ParallaxOptions

# The second camera is 200 pixels further east.
SHIFT = np.array([[1.0, 0.0, -200.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
MIDDLE = np.array([400.0, 300.0])


def matches(count, offs):
    """Return random points of the first photograph, and the second's with `offs` added."""
    first = np.random.default_rng(1).uniform((200.0, 0.0), (800.0, 600.0), (count, 2))
    return first, transformed(SHIFT, first) + offs


def test_points_moved_along_the_baseline_stand_up():
    """Matches beside their place along the way of the camera are points off the plane."""
    offs = np.zeros((40, 2))
    offs[::2, 0] = 12.0
    assert off_plane(SHIFT, *matches(40, offs), MIDDLE, ParallaxOptions())[::2].all()


def test_points_of_the_plane_do_not():
    """Matches at their place are not off the plane, whatever others do."""
    offs = np.zeros((40, 2))
    offs[::2, 0] = 12.0
    assert not off_plane(SHIFT, *matches(40, offs), MIDDLE, ParallaxOptions())[1::2].any()


def test_points_moved_across_it_are_errors():
    """Nothing on the ground moves across the baseline."""
    assert not off_plane(
        SHIFT, *matches(40, np.array([0.0, 12.0])), MIDDLE, ParallaxOptions()
    ).any()


def test_points_moved_everywhere_are_chance():
    """Wrong matches lie in all directions: those along the baseline are no better."""
    offs = np.random.default_rng(2).uniform(-25.0, 25.0, (300, 2))
    assert not off_plane(SHIFT, *matches(300, offs), MIDDLE, ParallaxOptions()).any()


def test_without_a_baseline_nothing_stands_up():
    """Two photographs from one place show no parallax."""
    first = np.full((20, 2), 100.0)
    assert not off_plane(
        np.eye(3), first, first + np.array([12.0, 0.0]), MIDDLE, ParallaxOptions()
    ).any()
