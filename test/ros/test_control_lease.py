# SPDX-License-Identifier: Apache-2.0
"""The control lease: one holder at a time, and words for everybody else."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from rocsafe_ros.lease.control_lease import (
    DEFAULT_S,
    Lease,
    LeaseKeeper,
    LeaseRefusedError,
    server_of,
)

ASKED = Lease(server='', holder='anna', mission='m1', duration_s=10.0)
OTHER = Lease(server='', holder='bert', duration_s=10.0)


def keeper(now_s: float = 100.0) -> LeaseKeeper:
    """Return the keeper of a vehicle that nobody leads."""
    return LeaseKeeper('rav1', Lease(server='s1'), now_s)


def test_order_needs_the_lease() -> None:
    """Without it, or with another, an order is refused and the refusal says who leads."""
    kept = keeper()
    with pytest.raises(LeaseRefusedError, match='nobody leads rav1; take the lease first'):
        kept.require('', 100.0)
    kept.take(ASKED, 100.0)
    kept.require('s1/1', 109.9)
    for number in ('', 's1/0', 's1/2', 's2/1', '1'):
        with pytest.raises(
            LeaseRefusedError,
            match='rav1 is led by anna, mission m1 for 8 s more; take the lease first',
        ):
            kept.require(number, 102.0)


def test_ended_lease_is_no_lease() -> None:
    """After its time an order is refused; its holder may renew it until another has taken it."""
    kept = keeper()
    kept.take(ASKED, 100.0)
    with pytest.raises(LeaseRefusedError, match='the lease of anna, mission m1 has ended'):
        kept.require('s1/1', 110.0)
    kept.renew('s1/1', 5.0, 200.0)
    kept.require('s1/1', 204.0)
    kept.take(OTHER, 206.0)
    for refused in (lambda: kept.renew('s1/1', 5.0, 206.0), lambda: kept.require('s1/1', 206.0)):
        with pytest.raises(LeaseRefusedError, match='rav1 is led by bert for 10 s more'):
            refused()


def test_lease_is_taken_over_only_on_purpose() -> None:
    """Another holder is refused; a takeover is told, and stops the orders of the first."""
    kept = keeper()
    kept.take(ASKED, 100.0)
    with pytest.raises(LeaseRefusedError, match='wait, or take it over'):
        kept.take(OTHER, 101.0)
    kept.take(OTHER, 101.0, takes_over=True)
    assert kept.text == 'led by bert, taken over from anna, mission m1'
    with pytest.raises(LeaseRefusedError, match='led by bert'):
        kept.require('s1/1', 101.0)
    kept.require('s1/2', 101.0)


def test_same_holder_gets_the_same_lease() -> None:
    """An answer that was lost, or a process that was started again, costs no lease."""
    kept = keeper()
    kept.take(ASKED, 100.0)
    kept.take(ASKED, 105.0)
    kept.require('s1/1', 114.0)


def test_restart_gives_the_lease_its_full_time_again() -> None:
    """A process that continues from its journal serves the same holder."""
    kept = keeper()
    kept.take(ASKED, 100.0)
    again = LeaseKeeper('rav1', kept.lease, 7.0)
    again.require('s1/1', 16.9)
    assert not again.is_valid(17.0)


def test_void_lease_must_be_taken_again() -> None:
    """After a pilot has taken the vehicle nothing renews the lease, and even its holder asks."""
    kept = keeper()
    kept.take(ASKED, 100.0)
    kept.revoke('switched to LOITER by its pilot')
    words = (
        'the lease of anna, mission m1 is void: switched to LOITER by its pilot; take the lease'
    )
    for refused in (lambda: kept.renew('s1/1', 5.0, 101.0), lambda: kept.require('s1/1', 101.0)):
        with pytest.raises(LeaseRefusedError, match=words):
            refused()
    kept.take(ASKED, 101.0)
    kept.require('s1/2', 101.0)


def test_released_lease_is_free() -> None:
    """Given back it serves nobody; only its holder gives it back."""
    kept = keeper()
    kept.take(ASKED, 100.0)
    with pytest.raises(LeaseRefusedError):
        kept.release('s1/7', 100.0)
    kept.release('s1/1', 100.0)
    with pytest.raises(LeaseRefusedError, match='nobody leads rav1'):
        kept.require('s1/1', 100.0)
    kept.take(OTHER, 100.0)


@pytest.mark.parametrize(
    ('fields', 'words'),
    [
        ({'holder': ' '}, 'holder is empty'),
        ({'holder': 'a' * 129}, 'holder must be printable, with up to 128'),
        ({'mission': 'a\nb'}, 'mission must be printable'),
        ({'duration_s': -1.0}, 'duration_s is -1: must be within 0 and 3600 s'),
        ({'duration_s': 3601.0}, 'must be within 0 and 3600 s'),
        ({'duration_s': math.nan}, 'duration_s is nan'),
    ],
)
def test_bad_requests_change_nothing(fields: dict[str, Any], words: str) -> None:
    """A name or a time out of its limits is refused by name."""
    kept = keeper()
    before = kept.lease
    asked = Lease(**{'server': '', 'holder': 'anna', **fields})
    with pytest.raises(ValueError, match=words):
        kept.take(asked, 100.0)
    assert kept.lease == before


def test_default_duration() -> None:
    """0 stands for the default."""
    kept = keeper()
    kept.take(Lease(server='', holder='anna', duration_s=0.0), 100.0)
    assert kept.expires_s == 100.0 + DEFAULT_S


@pytest.mark.slow
@given(st.text(max_size=8), st.text(max_size=8))
def test_servers_of_different_missions_differ(one: str, other: str) -> None:
    """Two nodes of one vehicle's name differ unless they are of one mission."""
    assert (server_of('rav1', one) == server_of('rav1', other)) == (one == other)
    assert server_of('rav1', one) != server_of('rav2', one)


class Hands(RuleBasedStateMachine):
    """Three who take, renew and give back as they like: never do two of them lead."""

    def __init__(self) -> None:
        super().__init__()
        self.now_s = 0.0
        self.kept = keeper(0.0)
        self.had: list[tuple[str, str]] = []

    @rule(seconds=st.sampled_from([0.0, 1.0, 9.0, 40.0]))
    def wait(self, seconds: float) -> None:
        """Let time pass."""
        self.now_s += seconds

    @rule(holder=st.sampled_from('abc'), takes_over=st.booleans())
    def take(self, holder: str, takes_over: bool) -> None:
        """Ask for it."""
        led_by, was_led = self.kept.lease.holder, self.kept.is_valid(self.now_s)
        asked = Lease(server='', holder=holder, duration_s=10.0)
        try:
            self.kept.take(asked, self.now_s, takes_over=takes_over)
        except LeaseRefusedError:
            assert was_led
            assert led_by != holder
            assert not takes_over
        else:
            self.had.append((holder, self.kept.lease.number))

    @precondition(lambda self: self.had)
    @rule(data=st.data())
    def renew(self, data: st.DataObject) -> None:
        """Renew any lease that was ever granted."""
        _, number = data.draw(st.sampled_from(self.had))
        try:
            self.kept.renew(number, 10.0, self.now_s)
        except LeaseRefusedError:
            assert number != self.kept.lease.number or self.kept.lease.void

    @rule()
    def revoke(self) -> None:
        """Let a pilot take the vehicle."""
        self.kept.revoke('the pilot has it')

    @rule()
    def restart(self) -> None:
        """Continue from the journal."""
        self.kept = LeaseKeeper('rav1', self.kept.lease, self.now_s)

    @invariant()
    def one_hand(self) -> None:
        """Of all numbers ever granted only those of the present holder are obeyed."""
        obeyed = set()
        for holder, number in self.had:
            try:
                self.kept.require(number, self.now_s)
            except LeaseRefusedError:
                continue
            obeyed.add(holder)
        assert obeyed <= {self.kept.lease.holder}
        assert bool(obeyed) == self.kept.is_valid(self.now_s)


TestHands = Hands.TestCase
