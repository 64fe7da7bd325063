# SPDX-License-Identifier: Apache-2.0
"""Who is heard, and for how long silence is allowed."""

from rocsafe_fleet.membership.identity import START_BITS, Identity
from rocsafe_fleet.membership.membership import Membership, MembershipOptions


def membership(**options: float) -> Membership:
    """Return what agent 0 of three knows at time 0."""
    return Membership(0, 3, 1, 0.0, MembershipOptions(**options))


def test_silence_is_noticed_after_three_heartbeats():
    """Not before, and for each agent by itself."""
    one = membership()
    for second in range(10):
        one.hear({1: (1, second)}, float(second))
        if second < 5:
            one.hear({2: (1, second)}, float(second))
    assert one.live(7.0) == {0, 1, 2}
    assert one.live(7.1) == {0, 1}


def test_an_agent_that_another_hears_is_live():
    """Its newer heartbeats come by way of the other."""
    one = membership()
    for second in range(20):
        one.hear({1: (1, second), 2: (1, second)}, float(second))
    assert one.live(19.0) == {0, 1, 2}


def test_old_news_keep_nobody_alive():
    """Two agents that repeat each other's last heartbeat of a third do not keep it alive."""
    one = membership()
    one.hear({1: (1, 5), 2: (1, 5)}, 0.0)
    for second in range(1, 10):
        one.hear({1: (1, 5 + second), 2: (1, 5)}, float(second))
    assert one.live(9.0) == {0, 1}


def test_a_bad_link_is_given_more_time():
    """Up to its longest usual gap, and no more than the limit."""
    one = membership()
    beats = [5 * k for k in range(10)]
    for number, second in enumerate(beats):
        one.hear({1: (1, number)}, float(second))
    assert 1 in one.live(45.0 + 4.9)
    assert 1 not in one.live(45.0 + 5.1)
    assert membership(longest_s=2.0).limit_s(1) == 3.0


def test_a_restarted_agent_is_heard():
    """Its heartbeats count from 0 again, in a new incarnation."""
    one = membership()
    one.hear({1: (1, 500)}, 0.0)
    one.hear({1: (2, 1)}, 5.0)
    assert 1 in one.live(7.0)
    assert one.beats[1] == (2, 1)


def test_a_start_that_lost_its_count_begins_again_above_the_earlier_one():
    """The others still tell heartbeats of the start before."""
    one = Identity(65, 12.0)
    one.hear((190, 400), (65, 2), 1.0, is_answer=True)
    assert not one.rests(1.0)
    assert one.incarnation > 190


def test_two_agents_of_a_vehicle_that_begin_again_at_once_have_different_numbers():
    """Each keeps the bits that it has drawn: else they would write different entries as one."""
    ones = [Identity((1 << START_BITS) + drawn, 12.0) for drawn in (7, 8)]
    for one in ones:
        one.hear(((5 << START_BITS) + 9, 3), (one.incarnation, 2), 1.0, is_answer=True)
        assert not one.rests(1.0)
        assert one.incarnation > (5 << START_BITS) + 9
    assert ones[0].incarnation != ones[1].incarnation


def test_the_earlier_of_two_agents_of_a_vehicle_rests_while_the_other_is_heard():
    """It goes on, with a higher number, when the other is gone."""
    one = Identity(65, 12.0)
    one.hear((65, 7), (65, 8), 1.0, is_answer=True)
    one.hear((70, 1), (65, 9), 2.0, is_answer=False)
    assert one.rests(2.0)
    one.hear((70, 9), (65, 9), 10.0, is_answer=True)
    assert one.rests(20.0)
    assert not one.rests(22.1)
    assert one.incarnation > 70


def test_own_packets_that_come_back_and_old_ones_change_nothing():
    """Neither an echo nor what an earlier start sent."""
    one = Identity(65, 12.0)
    one.hear((65, 8), (65, 8), 1.0, is_answer=False)
    one.hear((64, 900), (65, 8), 1.0, is_answer=False)
    assert not one.rests(1.0)
    assert one.incarnation == 65
