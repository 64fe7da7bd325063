# SPDX-License-Identifier: Apache-2.0
"""Presence of a vehicle: silent, lost, returned, apart."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_orchestrator.mission_state.presence import (
    MOST_RETURNS,
    Lease,
    Member,
    Presence,
    Sighting,
)

LEASE = Lease(silent_s=5.0, lost_s=15.0)
HEARD = Sighting()
REPLACED = Member().lost('nothing heard').replaced()
sightings = st.builds(
    Sighting,
    silent_s=st.floats(0.0, 100.0),
    ending=st.sampled_from(['', '', 'the battery failed']),
    taken_by=st.sampled_from(['', '', 'pilot', 'failsafe']),
    is_grounded=st.booleans(),
    is_unheard=st.booleans(),
)
# What a mission does with a member between two looks at it.
steps = st.lists(st.one_of(sightings, st.sampled_from(['replaced', 'merged'])), max_size=40)


@pytest.mark.parametrize(
    ('silent_s', 'presence'),
    [(5.0, Presence.PRESENT), (5.1, Presence.SILENT), (15.1, Presence.LOST)],
)
def test_silence_has_a_lease(silent_s: float, presence: Presence) -> None:
    """A vehicle gets no orders after one limit, and is replaced after the other."""
    assert Member().seen(Sighting(silent_s=silent_s), LEASE).presence is presence


def test_short_silence_changes_nothing() -> None:
    """Who is heard again before others took over flies on."""
    silent = Member().seen(Sighting(silent_s=9.0), LEASE)
    assert silent.seen(HEARD, LEASE) == Member()


def test_announced_loss_is_one_at_once() -> None:
    """Nobody waits for the end of a flight that will not be as planned."""
    seen = Member().seen(Sighting(ending='the battery failed'), LEASE)
    assert (seen.presence, seen.why) == (Presence.LOST, 'the battery failed')


def test_vehicle_that_comes_back_holds_until_it_is_merged() -> None:
    """Heard again after it was replaced, it takes a new route and nothing else."""
    back = REPLACED.seen(HEARD, LEASE)
    assert back.presence is Presence.RETURNED
    assert back.is_replaced
    assert back.merged() == replace(Member(), returns=1)


@pytest.mark.parametrize(
    'sighting',
    [
        Sighting(taken_by='pilot'),
        Sighting(taken_by='failsafe'),
        Sighting(ending='battery low'),
        Sighting(is_grounded=True),
    ],
)
def test_vehicle_that_others_have_gets_no_orders(sighting: Sighting) -> None:
    """Its pilot, a failsafe, or its own early end keeps it apart; on the ground it stays."""
    back = REPLACED.seen(sighting, LEASE)
    assert back.presence is Presence.APART
    assert not back.takes_orders


def test_vehicle_that_its_pilot_gives_back_is_present() -> None:
    """A takeover during which nobody replaced it changes nothing."""
    taken = Member().seen(Sighting(taken_by='pilot'), LEASE)
    assert not taken.takes_orders
    assert taken.seen(HEARD, LEASE).presence is Presence.PRESENT


def test_unreliable_vehicle_gets_no_more_work() -> None:
    """After some returns it stays apart for good."""
    member = Member()
    for _ in range(MOST_RETURNS + 1):
        member = member.seen(Sighting(silent_s=20.0), LEASE).replaced().seen(HEARD, LEASE)
        assert member.presence is not Presence.PRESENT
        member = member if member.is_withdrawn else member.merged()
    assert member.is_withdrawn
    assert member.seen(HEARD, LEASE).presence is Presence.APART


@pytest.mark.slow
@given(steps)
def test_nobody_flies_what_others_took_over(done: list[Sighting | str]) -> None:
    """Whatever happens, a replaced vehicle is never present before it was merged.

    And whoever is silent, in other hands or ends its flight takes no orders.
    """
    member = Member()
    for step in done:
        if step == 'replaced':
            member = member if member.takes_orders else member.replaced()
        elif step == 'merged':
            member = member.merged() if member.takes_orders else member
        elif isinstance(step, Sighting):
            member = member.seen(step, LEASE)
            is_ours = not (step.ending or step.taken_by or step.is_unheard)
            assert not member.takes_orders or (is_ours and step.silent_s <= LEASE.silent_s)
        assert not (member.is_replaced and member.presence is Presence.PRESENT)


def test_lease_that_loses_before_it_is_silent_is_refused() -> None:
    """The order of the limits is checked."""
    with pytest.raises(ValueError, match='lost_s is 5'):
        Lease(silent_s=5.0, lost_s=5.0)
