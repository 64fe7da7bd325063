# SPDX-License-Identifier: Apache-2.0
"""North-east-down and east-north-up."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_airsim.ned import Origin, attitude_ned, heading, swapped, yaw_ned, yaw_of

numbers = st.floats(-1e4, 1e4)
vectors = st.tuples(numbers, numbers, numbers)
yaws = st.floats(-math.pi, math.pi)


@given(vectors, vectors)
def test_places_come_back(place, home):
    """To the rounding of a sum."""
    origin = Origin(home)
    assert origin.to_enu(origin.to_ned(place)) == pytest.approx(place, abs=1e-8)
    assert swapped(swapped(place)) == place


def test_known_directions():
    """East is 90 degrees; up is negative; a level body that faces east has that yaw."""
    assert swapped((1.0, 2.0, 3.0)) == (2.0, 1.0, -3.0)
    assert yaw_ned(0.0) == pytest.approx(math.pi / 2)
    assert yaw_ned(math.pi / 2) == pytest.approx(0.0)
    facing_north = (0.0, 0.0, math.sin(math.pi / 4), math.cos(math.pi / 4))
    x, y, z, w = attitude_ned(facing_north)
    assert abs(w) == pytest.approx(1.0)
    assert (x, y, z) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


@given(yaws)
def test_a_level_body_is_level_in_both(yaw):
    """With the yaw of the other frame."""
    body = (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    found, expected = attitude_ned(body), heading(yaw)
    dot = sum(a * b for a, b in zip(found, expected, strict=True))
    assert abs(dot) == pytest.approx(1.0)
    assert math.cos(yaw_of(body) - yaw) == pytest.approx(1.0)
