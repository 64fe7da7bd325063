# SPDX-License-Identifier: Apache-2.0
"""Real vehicles take off only by a plan that a person has confirmed."""

from types import SimpleNamespace

import pytest

from rocsafe_orchestrator.mission_commands.confirmation import CONFIRM_S, Confirmation


class Desk:
    """A plan that waits, a terminal and what was said there."""

    def __init__(self, *, confirmed=(), is_there=True):
        self.unconfirmed, self.answer = 'a1b2', ''
        self.outcome, self.said = '', []
        terminal = SimpleNamespace(is_there=is_there, typed=lambda: self.answer)
        display = SimpleNamespace(say=self.said.append)
        self.confirmation = Confirmation(self, terminal, display, frozenset(confirmed))

    def confirm(self):
        """Note that the plan is flown."""
        self.unconfirmed, self.outcome = '', 'flown'

    def reject(self, text):
        """Note why it is not."""
        self.unconfirmed, self.outcome = '', text


def test_plan_named_on_the_command_line_is_flown_at_once():
    """Nobody is asked, with a terminal or without."""
    desk = Desk(confirmed=['a1b2'], is_there=False)
    assert desk.confirmation.watch(5.0) == 'a1b2'
    assert (desk.outcome, desk.said) == ('flown', [])
    assert desk.confirmation.watch(6.0) == '', 'told once'


def test_another_hash_does_not_confirm_it():
    """Without a terminal the plan is refused, and the text names what to type."""
    desk = Desk(confirmed=['ffff'], is_there=False)
    assert desk.confirmation.watch(5.0) == ''
    assert '--confirm a1b2' in desk.outcome


@pytest.mark.parametrize('answer', ['', 'n', 'yes please'])
def test_only_y_confirms_it_and_in_time(answer):
    """What was typed before the question counts for nothing."""
    desk = Desk()
    desk.answer = 'y'
    assert desk.confirmation.watch(5.0) == ''
    assert 'a1b2' in desk.said[0]
    desk.answer = answer
    assert desk.confirmation.watch(5.0 + CONFIRM_S) == desk.outcome == ''
    desk.confirmation.watch(5.1 + CONFIRM_S)
    assert 'was not confirmed' in desk.outcome


def test_y_confirms_it():
    """The hash is returned, for the record of the run."""
    desk = Desk()
    desk.confirmation.watch(5.0)
    desk.answer = 'y'
    assert desk.confirmation.watch(9.0) == 'a1b2'
    assert desk.outcome == 'flown'
