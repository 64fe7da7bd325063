# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C and closed terminals during a flight of real vehicles."""

import os
import pty
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_orchestrator.mission.status import FlightState, VehicleStatus
from rocsafe_orchestrator.mission_commands.mission_loop import (
    AFTER_FLIGHT,
    LONGEST_SILENCE_S,
    MissionLoop,
)
from rocsafe_orchestrator.mission_commands.progress import SteadyDisplay
from rocsafe_orchestrator.mission_commands.terminal import Terminal
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.watches.operator_watch import (
    AIRBORNE,
    ANSWER_S,
    HOLD_S,
    LONGEST_S,
    OBEY_S,
    QUESTION,
    REPEAT_S,
    OnOperatorLost,
    OperatorNews,
    OperatorWatch,
    Verb,
)

FLYING, HOLDING, RETURNING, LANDED = (
    FlightState.FLYING,
    FlightState.HOLDING,
    FlightState.RETURNING,
    FlightState.LANDED,
)
NOTHING = OperatorNews(has_terminal=True)
CTRL_C = OperatorNews(is_interrupted=True, has_terminal=True)
GONE = OperatorNews(is_interrupted=True)


def watch(policy: OnOperatorLost = OnOperatorLost.HOLD_THEN_RETURN) -> OperatorWatch:
    """Return a watch of a flight."""
    return OperatorWatch(policy)


def typed(letter: str) -> OperatorNews:
    """Return what comes when somebody types a line."""
    return OperatorNews(has_terminal=True, answer=letter)


def test_nothing_is_told_without_cause() -> None:
    """A flight that nobody interrupts is left alone."""
    one = watch()
    assert one.advance(0.0, NOTHING, [FLYING]) is None
    assert not one.may_end(0.0, [FLYING, LANDED])
    assert one.may_end(0.0, [LANDED, FlightState.DISARMED])
    assert one.remarks == []


def test_terminal_is_asked_and_obeyed() -> None:
    """Ctrl-C asks; the answer is told to all, and repeated until they obey."""
    one = watch()
    assert one.advance(0.0, CTRL_C, [FLYING]) is None
    assert one.remarks == [QUESTION]
    assert one.advance(1.0, typed('x'), [FLYING]) is None
    assert one.remarks == [QUESTION, QUESTION]
    assert one.advance(2.0, typed('h'), [FLYING, HOLDING]) is Verb.HOLD
    assert one.advance(3.0, NOTHING, [FLYING, HOLDING]) is None
    assert one.advance(2.0 + REPEAT_S, NOTHING, [FLYING, HOLDING]) is Verb.HOLD
    assert one.advance(2.0 + 2 * REPEAT_S, NOTHING, [HOLDING, HOLDING]) is None
    assert not one.ends
    # Resumed later: the hold of then is over.
    assert one.advance(3.0 + OBEY_S, NOTHING, [FLYING]) is None


def test_return_ends_the_run_after_the_landing() -> None:
    """No order is sent any more, and the run ends when the last one is down."""
    one = watch()
    one.advance(0.0, CTRL_C, [FLYING])
    assert one.advance(1.0, typed('r'), [FLYING, HOLDING]) is Verb.RETURN
    assert one.ends
    assert one.advance(10.0, NOTHING, [RETURNING, RETURNING]) is None
    assert not one.may_end(10.0, [RETURNING, LANDED])
    assert one.may_end(20.0, [LANDED, LANDED])


def test_answer_that_comes_with_another_ctrl_c_counts() -> None:
    """Both may come between two looks."""
    one = watch()
    one.advance(0.0, CTRL_C, [FLYING])
    both = OperatorNews(is_interrupted=True, has_terminal=True, answer='r')
    assert one.advance(1.0, both, [FLYING]) is Verb.RETURN


@pytest.mark.parametrize('letter', ['l', ''])
def test_flight_goes_on(letter: str) -> None:
    """Told so, or without an answer."""
    one = watch()
    one.advance(0.0, CTRL_C, [FLYING])
    assert one.advance(ANSWER_S + 1.0, typed(letter), [FLYING]) is None
    assert 'the flight goes on' in one.remarks[-1]
    assert not one.ends
    assert one.advance(ANSWER_S + 2.0, typed('r'), [FLYING]) is None


def test_without_a_terminal_they_hold_and_then_return() -> None:
    """The default: time for somebody to take over, then home."""
    one = watch()
    assert one.advance(0.0, GONE, [FLYING]) is Verb.HOLD
    assert one.ends
    assert one.advance(HOLD_S - 1.0, OperatorNews(), [HOLDING]) is None
    assert one.advance(HOLD_S, OperatorNews(), [HOLDING]) is Verb.RETURN
    assert one.advance(HOLD_S + REPEAT_S, OperatorNews(), [HOLDING]) is Verb.RETURN
    # More signals change nothing.
    assert one.advance(HOLD_S + REPEAT_S + 1.0, GONE, [RETURNING]) is None
    assert one.may_end(HOLD_S + 100.0, [LANDED])


class Told:
    """Keeps what vehicles are told."""

    def __init__(self) -> None:
        self.plans = self.drives = None
        self.led_by_others = frozenset({'rav5'})
        self.orders: list[tuple[Verb, list[str]]] = []

    def command_fleet(self, verb: Verb, vehicles: list[str]) -> None:
        """Keep an order."""
        self.orders.append((verb, vehicles))


def test_who_returns_or_lands_already_is_not_told_to_hold_or_return() -> None:
    """Not who returns or lands already: it would stop over people, or climb again.

    Nor who is led by somebody else.
    """
    states = {'rav1': FLYING, 'rav2': RETURNING, 'rav3': FlightState.LANDING, 'rav4': HOLDING}
    states['rav5'] = FLYING
    seen = [SimpleNamespace(name=name, state=state) for name, state in states.items()]
    told = Told()
    parts: Any = SimpleNamespace(
        node=SimpleNamespace(requests=told),
        terminal=SimpleNamespace(is_there=False, typed=lambda: ''),
        interrupt=SimpleNamespace(count=1, first=signal.SIGHUP, withdraw=lambda: None),
        monitor=SimpleNamespace(vehicles=seen),
        operator=watch(),
        mission=SimpleNamespace(phase=Phase.FLYING),
        display=SimpleNamespace(say=lambda _text: None),
        table=(),
    )
    loop = MissionLoop(parts, 1.0, 0.0)
    loop._tell = lambda _decisions: None  # type: ignore[method-assign]
    for now_s in (0.0, REPEAT_S, HOLD_S):
        loop._watch_operator(now_s)
        parts.interrupt.count = 0
    assert [verb for verb, _names in told.orders] == [Verb.HOLD, Verb.HOLD, Verb.RETURN]
    assert {tuple(names) for _verb, names in told.orders} == {('rav1', 'rav4')}


@pytest.mark.parametrize(
    ('phase', 'told'),
    [
        (Phase.FLYING, []),
        (Phase.COLLECTING, []),
        *((phase, [(Verb.RETURN, ['rav1'])]) for phase in sorted(AFTER_FLIGHT)),
    ],
)
def test_who_is_in_the_air_after_the_flights_is_called_home(
    phase: Phase, told: list[tuple[Verb, list[str]]]
) -> None:
    """A mission that failed sends nothing more: it would hold until its battery's failsafe.

    Not a simulated one, whose time may stand still for good, nor who is led by somebody else.
    """
    seen = [SimpleNamespace(name=name, state=HOLDING) for name in ('rav1', 'rav2', 'rav5')]
    requests = Told()
    parts: Any = SimpleNamespace(
        node=SimpleNamespace(requests=requests),
        terminal=SimpleNamespace(is_there=True, typed=lambda: ''),
        interrupt=SimpleNamespace(count=0, first=None),
        monitor=SimpleNamespace(vehicles=seen),
        operator=watch(),
        mission=SimpleNamespace(phase=phase),
        display=SimpleNamespace(say=lambda _text: None),
        real=frozenset({'rav1', 'rav5'}),
        table=(),
    )
    loop = MissionLoop(parts, 1.0, 0.0)
    loop._tell = lambda _decisions: None  # type: ignore[method-assign]
    assert loop._watch_operator(0.0)
    assert requests.orders == told
    loop._watch_operator(REPEAT_S)
    assert requests.orders == told * 2


def test_what_the_operator_chose_stands_after_the_flights() -> None:
    """A hold that was asked for is not turned into a return; a return is told once."""
    one = watch()
    one.advance(0.0, CTRL_C, [FLYING])
    assert one.advance(1.0, typed('h'), [FLYING]) is Verb.HOLD
    one.end_flight(2.0, [HOLDING])
    assert one.advance(2.0 + REPEAT_S, NOTHING, [HOLDING]) is None
    other = watch()
    other.end_flight(0.0, [RETURNING, LANDED])
    assert other.advance(0.0, NOTHING, [RETURNING, LANDED]) is None
    gone = watch()
    assert gone.advance(0.0, GONE, [FLYING]) is Verb.HOLD
    gone.end_flight(1.0, [HOLDING])
    assert gone.advance(1.0 + REPEAT_S, OperatorNews(), [HOLDING]) is None
    assert gone.advance(HOLD_S, OperatorNews(), [HOLDING]) is Verb.RETURN


@pytest.mark.parametrize(
    ('phase', 'state', 'heard_ago_s', 'waits'),
    [
        (Phase.REPORTING, FLYING, 1.0, True),
        (Phase.REPORTING, LANDED, 1.0, False),
        (Phase.REPORTING, FLYING, LONGEST_SILENCE_S, False),
        (Phase.MAPPING, FLYING, 1.0, False),
    ],
)
def test_no_report_begins_with_a_real_vehicle_in_the_air(
    phase: Phase, state: FlightState, heard_ago_s: float, waits: bool
) -> None:
    """Whatever ended the flight: the report begins with the end of the bridge."""
    seen = [VehicleStatus(name='rav1', state=state), VehicleStatus(name='rav2', state=FLYING)]
    said: list[str] = []
    parts: Any = SimpleNamespace(
        node=SimpleNamespace(requests=Told()),
        monitor=SimpleNamespace(vehicles=seen, heard_ago_s=lambda _name, _now_s: heard_ago_s),
        mission=SimpleNamespace(phase=phase),
        display=SimpleNamespace(say=said.append),
        real=frozenset({'rav1'}),
        table=(),
    )
    loop = MissionLoop(parts, 1.0, 0.0)
    loop._tell = lambda _decisions: None  # type: ignore[method-assign]
    assert loop._waits_for_landing(100.0) is waits
    assert loop._waits_for_landing(100.0 + LONGEST_S) is False
    assert said == ['rav1: in the air, the report waits for its landing'] * waits


def test_who_lands_is_not_called_home_by_a_dose() -> None:
    """It was told to land, or is at home."""
    for state, may in ((FLYING, True), (FlightState.WAITING, True), (FlightState.LANDING, False)):
        assert VehicleStatus(name='rav1', state=state).may_turn_back is may


def test_other_policies() -> None:
    """Return at once, or let them finish."""
    one = watch(OnOperatorLost.RETURN)
    assert one.advance(0.0, GONE, [FLYING]) is Verb.RETURN
    other = watch(OnOperatorLost.GO_ON)
    assert other.advance(0.0, GONE, [FLYING]) is None
    assert not other.ends


def test_closed_terminal_while_asking_is_a_lost_operator() -> None:
    """A question that nobody can answer any more is not waited for."""
    one = watch()
    one.advance(0.0, CTRL_C, [FLYING])
    assert one.advance(1.0, GONE, [FLYING]) is Verb.HOLD


def test_lost_vehicle_is_not_waited_for_without_end() -> None:
    """A run ends even if a vehicle is never heard again."""
    one = watch(OnOperatorLost.RETURN)
    one.advance(0.0, GONE, [FlightState.LOST])
    assert not one.may_end(LONGEST_S, [FlightState.LOST])
    assert one.may_end(LONGEST_S + 1.0, [FlightState.LOST])


news = st.builds(
    OperatorNews,
    is_interrupted=st.booleans(),
    has_terminal=st.booleans(),
    answer=st.sampled_from(['', 'h', 'r', 'l', '?']),
)
states = st.lists(st.sampled_from(list(FlightState)), min_size=1, max_size=4)


@given(st.lists(st.tuples(news, states), max_size=40), st.sampled_from(OnOperatorLost))
def test_whatever_comes_nobody_is_left_alone(
    events: list[tuple[OperatorNews, list[FlightState]]], policy: OnOperatorLost
) -> None:
    """The run never ends with a vehicle in the air, and once it ends it calls home for good."""
    one = watch(policy)
    was_ending, has_returned = False, False
    for second, (what, now) in enumerate(events):
        verb = one.advance(float(second), what, now)
        assert not one.may_end(float(second), [*now, FLYING])
        assert one.ends or not was_ending
        assert not (has_returned and verb is Verb.HOLD and was_ending)
        was_ending, has_returned = one.ends, has_returned or (one.ends and verb is Verb.RETURN)
        if verb is not None:
            assert any(state in AIRBORNE for state in now)


@contextmanager
def own_terminal() -> Iterator[int]:
    """Give the far end of a terminal that is our input and output."""
    far, near = pty.openpty()
    kept = [os.dup(number) for number in (0, 1, 2)]
    for number in (0, 1, 2):
        os.dup2(near, number)
    try:
        yield far
    finally:
        for number, old in enumerate(kept):
            os.dup2(old, number)
            os.close(old)
        os.close(near)
        os.close(far)


def test_terminal_is_read_without_waiting(tmp_path: Path) -> None:
    """The first letter of a line counts; after its end nobody is there."""
    with own_terminal() as far:
        terminal = Terminal(tmp_path / 'terminal.log')
        assert terminal.is_there
        assert terminal.typed() == ''
        os.write(far, b'Hold\n')
        assert terminal.typed() == 'h'
        terminal.close()
        assert not terminal.is_there
        os.write(1, b'printed later\n')
    assert (tmp_path / 'terminal.log').read_text() == 'printed later\n'


def test_lost_output_ends_nothing() -> None:
    """What cannot be shown is told once to who can do something about it."""
    lost = []

    class Broken:
        def __enter__(self) -> 'Broken':
            raise OSError

        def __exit__(self, *_: object) -> None:
            raise OSError

        def show(self, _status: object) -> None:
            raise OSError

        def say(self, _text: str) -> None:
            raise BrokenPipeError

    with SteadyDisplay(Broken(), lambda: lost.append(1)) as display:
        display.say('text')
    assert len(lost) == 3
