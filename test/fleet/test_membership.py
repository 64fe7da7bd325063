# SPDX-License-Identifier: Apache-2.0
"""Who is heard, and for how long silence is allowed."""

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
