# SPDX-License-Identifier: Apache-2.0
"""Commands to real vehicles in the air after the operator interrupts, or is gone.

The processes that watch a flight never just end: with a terminal the operator is asked; without
one the run goes on without him, and does what the scenario says. Time is an argument.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import Enum

from rocsafe_orchestrator.mission.status import FlightState

QUESTION = 'real vehicles are in the air: [h]old, [r]eturn and land, [l]eave flying? then Enter'
# Without an answer the flight goes on.
ANSWER_S = 30.0
# Time of the hold before the return, in which the operator can come back.
HOLD_S = 60.0
# A command is repeated after this time to those that do not obey.
REPEAT_S = 5.0
# A hold that was chosen is repeated no longer: later holds are resumed by an operator.
OBEY_S = 30.0
# Vehicles that are not heard are waited for no longer.
LONGEST_S = 1800.0

ON_ROUTE = frozenset({FlightState.TAKING_OFF, FlightState.FLYING})
AIRBORNE = ON_ROUTE | {
    FlightState.HOLDING,
    FlightState.RETURNING,
    FlightState.LANDING,
    FlightState.LOST,
}
TO_CALL_HOME = ON_ROUTE | {FlightState.HOLDING}
COMING_DOWN = frozenset({FlightState.RETURNING, FlightState.LANDING})


class OnOperatorLost(Enum):
    """What vehicles do when the operator is gone."""

    HOLD_THEN_RETURN = 'hold_then_return'
    RETURN = 'return'
    GO_ON = 'go_on'


class Verb(Enum):
    """A command to all vehicles but those that come down already, see `addressees`."""

    HOLD = 'hold'
    RETURN = 'return'


@dataclass(frozen=True, slots=True, kw_only=True)
class OperatorNews:
    """What came from the operator since the last look.

    Attributes
    ----------
    is_interrupted
        Whether a signal came.
    has_terminal
        Whether somebody can be asked.
    answer
        First letter of what was typed; empty: nothing.
    """

    is_interrupted: bool = False
    has_terminal: bool = False
    answer: str = ''


class OperatorWatch:
    """Decides the commands to all vehicles, and when the run may end.

    Parameters
    ----------
    policy
        What they do when the operator is lost.

    Attributes
    ----------
    remarks
        Lines for people; the caller prints and removes them.
    ends
        Whether the run is to end once all have landed: no orders are sent meanwhile.
    """

    def __init__(self, policy: OnOperatorLost) -> None:
        self.remarks: list[str] = []
        self.ends = False
        self._policy = policy
        self._asked_s: float | None = None
        self._aim: Verb | None = None
        self._since_s = 0.0
        self._told_s: float | None = None
        self._returns_s: float | None = None
        self._is_settled = False

    def end_flight(self, now_s: float, states: Collection[FlightState]) -> None:
        """Call home, once, who still flies or holds when the flights are over.

        Nobody else tells them any more. What the operator chose for this flight stands.
        """
        if self._is_settled or not any(state in TO_CALL_HOME for state in states):
            return
        self._is_settled = True
        self.remarks.append('the flight is over: who is still on a route or holds returns')
        self._pursue(Verb.RETURN, now_s)

    def advance(
        self, now_s: float, news: OperatorNews, states: Collection[FlightState]
    ) -> Verb | None:
        """Return the command to all vehicles now; None: no command."""
        if news.is_interrupted and not self.ends:
            self._interrupted(now_s, news)
        self._is_settled |= self.ends
        if self._asked_s is not None:
            self._hear(now_s, news)
        if self._returns_s is not None and now_s >= self._returns_s:
            self._returns_s = None
            self.remarks.append('the operator is gone: the vehicles return')
            self._pursue(Verb.RETURN, now_s)
        return self._command(now_s, states)

    def may_end(self, now_s: float, states: Collection[FlightState]) -> bool:
        """Return whether the run can end without a vehicle in the air that it would leave."""
        is_late = self.ends and now_s - self._since_s > LONGEST_S
        return is_late or not any(state in AIRBORNE for state in states)

    def _interrupted(self, now_s: float, news: OperatorNews) -> None:
        if news.has_terminal:
            self._asked_s = now_s
            self.remarks.append(QUESTION)
        elif self._policy is OnOperatorLost.GO_ON:
            self._asked_s = None
            self.remarks.append('the operator is gone: the flight goes on')
        else:
            self._asked_s, self.ends = None, True
            if self._policy is OnOperatorLost.RETURN:
                self._returns_s = now_s
                return
            self.remarks.append(f'the operator is gone: hold, and return in {HOLD_S:.0f} s')
            self._returns_s = now_s + HOLD_S
            self._pursue(Verb.HOLD, now_s)

    def _hear(self, now_s: float, news: OperatorNews) -> None:
        choices = {'h': 'hold', 'r': 'return and land', 'l': 'the flight goes on'}
        if news.answer in choices:
            self._asked_s = None
            self.remarks.append(choices[news.answer])
            if news.answer == 'h':
                self._is_settled = True
                self._pursue(Verb.HOLD, now_s)
            elif news.answer == 'r':
                self.ends = True
                self._pursue(Verb.RETURN, now_s)
        elif news.answer:
            self.remarks.append(QUESTION)
        elif self._asked_s is not None and now_s - self._asked_s > ANSWER_S:
            self._asked_s = None
            self.remarks.append('no answer: the flight goes on')

    def _pursue(self, aim: Verb, now_s: float) -> None:
        self._aim, self._since_s, self._told_s = aim, now_s, None

    def _command(self, now_s: float, states: Collection[FlightState]) -> Verb | None:
        if self._aim is Verb.HOLD and not self.ends and now_s - self._since_s > OBEY_S:
            self._aim = None
        if self._aim is None or (self._told_s is not None and now_s - self._told_s < REPEAT_S):
            return None
        targets = ON_ROUTE if self._aim is Verb.HOLD else TO_CALL_HOME
        if not any(state in targets for state in states):
            return None
        self._told_s = now_s
        return self._aim


def addressees(states: Mapping[str, FlightState]) -> list[str]:
    """Return the vehicles that are told to hold or return.

    Those that return or land already are left out: they obey an order, or have a reason of their
    own that is not known here.
    """
    return [name for name, state in states.items() if state not in COMING_DOWN]
