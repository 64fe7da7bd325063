# SPDX-License-Identifier: Apache-2.0
"""Pairs are complete, in order, and each comes once."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_ros.pairing import StampPairing


def test_a_pair_is_complete_with_its_second_half():
    """Whichever half comes first."""
    pairing = StampPairing()
    assert pairing.add_left(1, 'a') is None
    assert pairing.add_right(1, 'A') == ('a', 'A')
    assert pairing.add_right(2, 'B') is None
    assert pairing.add_left(2, 'b') == ('b', 'B')


@pytest.mark.slow
@given(data=st.data(), count=st.integers(1, 30))
def test_any_delay_between_the_streams_gives_each_pair_once_in_order(data, count):
    """Two ordered streams, merged in any way."""
    pairing = StampPairing()
    left, right, pairs = 0, 0, []
    while left < count or right < count:
        take_left = right == count or (left < count and data.draw(st.booleans()))
        if take_left:
            pairs.append(pairing.add_left(left, left))
            left += 1
        else:
            pairs.append(pairing.add_right(right, right))
            right += 1
    assert [pair for pair in pairs if pair] == [(number, number) for number in range(count)]
    assert (pairing.waiting, pairing.lost) == (0, 0)


def test_a_stamp_that_comes_again_gives_no_second_pair():
    """A world or vehicle that restarts says some things twice."""
    pairing = StampPairing()
    pairing.add_left(5, 'a')
    pairing.add_right(5, 'A')
    assert pairing.add_left(5, 'a') is None
    assert pairing.add_right(5, 'A') is None
    assert pairing.add_left(4, 'z') is None
    assert pairing.waiting == 0


def test_a_half_said_twice_still_makes_one_pair():
    """The vehicle died between its two halves and said the first again."""
    pairing = StampPairing()
    pairing.add_right(5, 'A')
    pairing.add_right(5, 'A')
    assert pairing.add_left(5, 'a') == ('a', 'A')
    assert pairing.waiting == 0


def test_a_lost_half_is_given_up_and_counted():
    """A later pair proves that the missing half will not come."""
    pairing = StampPairing()
    pairing.add_left(1, 'a')
    pairing.add_left(2, 'b')
    assert pairing.add_right(2, 'B') == ('b', 'B')
    assert (pairing.lost, pairing.waiting) == (1, 0)


def test_memory_is_bounded():
    """A stream whose partner never speaks keeps only the newest values."""
    pairing = StampPairing(capacity=3)
    for number in range(10):
        pairing.add_left(number, number)
    assert (pairing.waiting, pairing.lost) == (3, 7)
    assert pairing.add_right(9, 9) == (9, 9)


def test_a_capacity_below_one_is_refused():
    """Nothing could ever be paired."""
    with pytest.raises(ValueError, match='capacity = 0'):
        StampPairing(capacity=0)
