# SPDX-License-Identifier: Apache-2.0
"""Compass headings and mathematical yaws."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.angle import heading_of_yaw_rad, wrap_rad, yaw_of_heading_rad

ANGLES = st.floats(-50.0, 50.0)


@pytest.mark.parametrize(
    ('heading_deg', 'yaw_deg'),
    [(0, 90), (90, 0), (180, -90), (270, 180), (45, 45), (315, 135), (225, -135)],
)
def test_known_directions(heading_deg, yaw_deg):
    """North is yaw 90, east is 0, south is -90, west is 180 degrees."""
    assert math.degrees(yaw_of_heading_rad(math.radians(heading_deg))) == pytest.approx(yaw_deg)
    assert math.degrees(heading_of_yaw_rad(math.radians(yaw_deg))) == pytest.approx(heading_deg)


@given(ANGLES)
def test_wrap_keeps_the_direction(angle):
    """The wrapped angle lies in (-pi, pi] and points the same way."""
    wrapped = wrap_rad(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-12)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-12)


@given(ANGLES)
def test_heading_and_yaw_are_inverse(yaw):
    """There and back gives the same direction; headings lie in [0, 2 pi)."""
    heading = heading_of_yaw_rad(yaw)
    assert 0.0 <= heading < math.tau
    assert wrap_rad(yaw_of_heading_rad(heading) - yaw) == pytest.approx(0.0, abs=1e-12)


def test_arrays_stay_arrays():
    """An array is wrapped element by element."""
    np.testing.assert_allclose(wrap_rad(np.array([math.tau, 3 * math.pi])), [0.0, math.pi])
