# SPDX-License-Identifier: Apache-2.0
"""Lock-step: time waits for everybody, is repeated, throttled, paused and adopted."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_sim.clock.clockwork import COMPLAIN_S, LISTEN_S, RESEND_S, Clockwork, Pace

START, STEP = 1_000_000_000, 100_000_000
NAMES = ('rav1', 'rav2')


def clockwork(speed: float = 0.0, **options: bool) -> Clockwork:
    """Return a clockwork for two participants that has listened and published its start."""
    pace = Pace(start_ns=START, step_ns=STEP, speed=speed)
    made = Clockwork(pace, NAMES, 0.0, **options)
    assert made.due(0.0) is None
    assert made.due(LISTEN_S) == START
    return made


def answer(made: Clockwork, time_ns: int, *, is_idle: bool = False) -> None:
    """Report `time_ns` done for both."""
    for name in NAMES:
        made.take(name, time_ns, is_idle=is_idle)


def test_time_waits_for_everybody() -> None:
    """The next time comes only when all, strangers and old steps aside, have done this one."""
    made = clockwork()
    made.take('rav1', START, is_idle=False)
    made.take('stranger', START, is_idle=False)
    made.take('rav2', START - STEP, is_idle=False)
    assert made.due(LISTEN_S) is None
    made.take('rav2', START, is_idle=False)
    assert made.due(LISTEN_S) == START + STEP


def test_time_is_published_again() -> None:
    """Without answers the same time comes every RESEND_S."""
    made = clockwork()
    assert made.due(LISTEN_S + 0.9 * RESEND_S) is None
    assert made.due(LISTEN_S + RESEND_S) == START
    assert made.due(LISTEN_S + RESEND_S) is None
    assert made.due(LISTEN_S + 2 * RESEND_S) == START


def test_who_is_waited_for_is_named() -> None:
    """After COMPLAIN_S the missing are named, in spite of repeats; nobody before and after."""
    made = clockwork()
    made.take('rav1', START, is_idle=False)
    wall_s = LISTEN_S
    while wall_s < LISTEN_S + COMPLAIN_S:
        assert made.missing(wall_s) == []
        made.due(wall_s)
        wall_s += 0.3
    assert made.missing(wall_s) == ['rav2']
    made.take('rav2', START, is_idle=False)
    assert made.missing(wall_s) == []


@settings(max_examples=40, deadline=None)
@given(st.floats(2.0, 50.0), st.lists(st.floats(0.0, 0.05), min_size=10, max_size=30))
def test_speed_is_never_exceeded(speed: float, delays: list[float]) -> None:
    """However late single steps are, time never runs faster than asked."""
    made = clockwork(speed)
    wall_s, start_s = LISTEN_S, LISTEN_S
    for number, delay in enumerate(delays):
        answer(made, START + number * STEP)
        wall_s += delay
        while made.due(wall_s) is None:
            wall_s += 0.004
        simulated_s = (made.time_ns - START - STEP) * 1e-9
        assert simulated_s <= (wall_s - start_s) * speed + 1e-6


def test_speed_is_reached() -> None:
    """With prompt participants the wall time is that of the speed, to a tick."""
    made = clockwork(speed=2.0)
    wall_s = LISTEN_S
    for number in range(40):
        answer(made, START + number * STEP)
        while made.due(wall_s) is None:
            wall_s += 0.001
    assert wall_s - LISTEN_S == pytest.approx(40 * 0.1 / 2.0, abs=0.06)


def test_paused_world_goes_on_when_told() -> None:
    """Without autostart no time is published until run; then it can be paused again."""
    pace = Pace(start_ns=START, step_ns=STEP, speed=0.0)
    made = Clockwork(pace, NAMES, 0.0, is_running=False)
    assert made.due(5.0) is None
    made.run(is_running=True)
    assert made.due(5.0) == START
    answer(made, START)
    assert made.due(5.0) == START + STEP
    made.run(is_running=False)
    answer(made, START + STEP)
    assert made.due(6.0) is None


def test_pauses_when_all_have_become_idle() -> None:
    """Idleness before anybody was busy does not count; after it, it pauses."""
    made = clockwork(pauses_when_idle=True)
    answer(made, START, is_idle=True)
    assert made.due(1.0) == START + STEP
    answer(made, START + STEP, is_idle=False)
    assert made.due(1.0) == START + 2 * STEP
    answer(made, START + 2 * STEP, is_idle=True)
    assert made.due(1.0) is None
    assert not made.is_running
    made.take('rav1', START + 2 * STEP, is_idle=False)
    made.run(is_running=True)
    assert made.due(1.0) == START + 3 * STEP


def test_restarted_world_goes_on_where_it_was() -> None:
    """What a participant repeats is adopted before anything is published, and time runs on."""
    pace = Pace(start_ns=START, step_ns=STEP, speed=0.0)
    made = Clockwork(pace, NAMES, 0.0, is_running=False)
    made.take('rav1', START + 500 * STEP, is_idle=False)
    assert made.due(0.01) == START + 500 * STEP
    made.take('rav2', START + 500 * STEP, is_idle=True)
    assert made.due(0.02) == START + 501 * STEP


def test_restarted_world_stays_paused_when_all_are_idle() -> None:
    """After a mission's end nothing runs on."""
    pace = Pace(start_ns=START, step_ns=STEP, speed=0.0)
    made = Clockwork(pace, NAMES, 0.0, is_running=False)
    for name in NAMES:
        made.take(name, START + 500 * STEP, is_idle=True)
    made.due(0.01)
    assert made.due(0.02) is None


def test_time_does_not_wait_for_who_has_left() -> None:
    """A participant that is gone for good is waited for no more, in the same step already."""
    made = clockwork()
    made.take('rav1', START, is_idle=False)
    assert made.due(LISTEN_S) is None
    made.dismiss('rav2')
    assert made.due(LISTEN_S) == START + STEP
    made.take('rav1', START + STEP, is_idle=False)
    made.dismiss('stranger')
    assert made.due(LISTEN_S) == START + 2 * STEP


reports = st.lists(
    st.tuples(st.sampled_from([*NAMES, 'stranger']), st.sampled_from([-1, 0]), st.booleans()),
    max_size=60,
)


@settings(max_examples=100)
@given(reports, st.floats(0.0, 0.3))
def test_no_step_is_left_out_or_begun_too_early(said, pause_s: float) -> None:
    """Whatever arrives late, twice or from strangers, each time follows the one before.

    It is published only once both have answered the last one, and may be repeated.
    """
    made = clockwork()
    wall_s, now_ns, answered = LISTEN_S, START, set()
    for name, steps_ago, is_idle in said:
        made.take(name, now_ns + steps_ago * STEP, is_idle=is_idle)
        if steps_ago == 0 and name in NAMES:
            answered.add(name)
        wall_s += pause_s
        due_ns = made.due(wall_s)
        if due_ns is None:
            assert answered != set(NAMES)
        elif due_ns != now_ns:
            assert answered == set(NAMES)
            assert due_ns == now_ns + STEP
            now_ns, answered = due_ns, set()
        assert made.time_ns == now_ns


def test_participant_that_comes_back_is_waited_for_again() -> None:
    """It had left, and reports the present step: from the next one on time waits for it."""
    made = clockwork()
    made.dismiss('rav2')
    made.take('rav1', START, is_idle=False)
    assert made.due(LISTEN_S) == START + STEP
    made.take('rav2', START, is_idle=False)
    made.take('rav1', START + STEP, is_idle=False)
    assert made.due(LISTEN_S) == START + 2 * STEP
    answer(made, START + 2 * STEP)
    assert made.due(LISTEN_S) == START + 3 * STEP
    made.take('rav1', START + 3 * STEP, is_idle=False)
    assert made.due(LISTEN_S) is None


def test_news_pause_time_once() -> None:
    """What answers to them takes effect at their time; the repeated report pauses nothing."""
    made = clockwork(pauses_on_news=True)
    made.take('rav1', START, is_idle=False, has_news=True)
    made.take('rav2', START, is_idle=False)
    assert made.due(LISTEN_S) is None
    made.run(is_running=True)
    made.take('rav1', START, is_idle=False, has_news=True)
    assert made.due(LISTEN_S) == START + STEP


def test_news_pause_nothing_unless_asked_for() -> None:
    """A world without a mission goes on."""
    made = clockwork()
    made.take('rav1', START, is_idle=False, has_news=True)
    made.take('rav2', START, is_idle=False)
    assert made.due(LISTEN_S) == START + STEP
