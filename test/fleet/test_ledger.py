# SPDX-License-Identifier: Apache-2.0
"""The ledger: laws of merging, deltas that bring ledgers together, and packets."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_fleet.errors import PacketError
from rocsafe_fleet.ledger.ledger import Kind, Ledger
from rocsafe_fleet.ledger.packet import MOST_BYTES, Packet, decode, encode
from rocsafe_fleet.ledger.records import (
    Claim,
    Proposal,
    claim_of,
    place_of,
    proposal_of,
    ring_bytes,
    ring_of,
    set_bytes,
    set_of,
)
from rocsafe_geo.position import GeoPosition

KEY = b'a key'
AGENTS = 3

Write = tuple[int, int, Kind, int, bytes]
writes = st.lists(
    st.tuples(
        st.integers(0, AGENTS - 1),
        st.integers(1, 2),
        st.sampled_from(Kind),
        st.integers(0, 2),
        st.binary(max_size=6),
    ),
    max_size=30,
)


def histories(steps: list[Write], seen: list[int]) -> list[Ledger]:
    """Return ledgers that each know a part of what several writers wrote."""
    writers = {(a, i): Ledger((a, i)) for a in range(AGENTS) for i in (1, 2)}
    readers = [Ledger((AGENTS + k, 1)) for k in range(3)]
    for step, (agent, incarnation, kind, part, value) in enumerate(steps):
        one = writers[agent, incarnation]
        one.write(kind, value, part)
        if step < len(seen):
            readers[seen[step]].join(one)
    return readers


def joined(*ledgers: Ledger) -> Ledger:
    """Return the union of ledgers, in their order."""
    found = Ledger((99, 1))
    for ledger in ledgers:
        found.join(ledger)
    return found


def content(ledger: Ledger) -> tuple[object, ...]:
    """Return all that a ledger holds."""
    return ledger.entries, dict(ledger.vector), ledger.digest


@pytest.mark.slow
@given(writes, st.lists(st.integers(0, 2), max_size=30))
def test_merging_is_commutative_associative_idempotent(steps, seen):
    """The order of packets, and repetitions of them, change nothing."""
    a, b, c = histories(steps, seen)
    assert content(joined(a, b, c)) == content(joined(c, a, b))
    assert content(joined(joined(a, b), c)) == content(joined(a, joined(b, c)))
    assert content(joined(a, a, b, a)) == content(joined(a, b))


@pytest.mark.slow
@given(writes, st.lists(st.integers(0, 2), max_size=30), st.integers(60, 400))
def test_deltas_bring_ledgers_together(steps, seen, room):
    """However small the packets are: an exchange of vectors and deltas ends with equal ledgers."""
    a, b, _ = histories(steps, seen)
    for _ in range(200):
        before = a.digest, b.digest, dict(a.vector), dict(b.vector)
        for one, other in ((a, b), (b, a)):
            for delta in one.deltas(other.vector, room):
                other.merge(delta)
        if before == (a.digest, b.digest, dict(a.vector), dict(b.vector)):
            break
    assert a.entries == b.entries
    assert a.digest == b.digest


@given(writes)
def test_a_gap_is_asked_for_again(steps):
    """A lost delta leaves the vector where it was, though what came after is kept."""
    source, target = Ledger((0, 1)), Ledger((1, 1))
    lost = 0
    for number, (_, _, kind, part, value) in enumerate(steps):
        before = source.vector.get(source.writer, 0)
        source.write(kind, value, part)
        deltas = source.deltas({source.writer: before}, 500)
        if number % 3:
            for delta in deltas:
                target.merge(delta)
        elif deltas:
            lost += 1
    for delta in source.deltas(target.vector, 10_000):
        target.merge(delta)
    assert target.entries == source.entries
    assert target.vector.get(source.writer, 0) == source.vector.get(source.writer, 0)


def test_what_came_after_a_gap_is_passed_on():
    """Its writer is gone and the gap stays: all come to know the same all the same."""
    gone, one, other = Ledger((0, 1)), Ledger((1, 1)), Ledger((2, 1))
    gone.write(Kind.ABLE, b'')
    first = gone.deltas({}, 500)
    gone.write(Kind.VISITED, set_bytes({1}))
    before = dict(gone.vector)
    gone.write(Kind.PROPOSAL, b'proposal')
    for delta in (*first, *gone.deltas(before, 500)):
        one.merge(delta)
    for delta in first:
        other.merge(delta)
    assert one.vector == other.vector
    for delta in one.deltas(other.vector, 500):
        other.merge(delta)
    assert (other.entries, other.vector) == (one.entries, one.vector)


def test_a_short_packet_promises_no_more_than_its_sender_knows():
    """What the sender heard after a gap does not hide the gap from the receiver."""
    source, one, other = Ledger((0, 1)), Ledger((1, 1)), Ledger((2, 1))
    for part in range(4):
        source.write(Kind.READING, bytes(10), part)
    parts = [source.deltas({source.writer: base}, 50)[0] for base in (0, 2)]
    for delta in parts[1:]:
        one.merge(delta)
    for delta in one.deltas(other.vector, 40):
        other.merge(delta)
    assert other.entries
    assert other.vector.get(source.writer, 0) == 0


def test_an_entry_without_room_does_not_hold_up_the_others():
    """Each time another writer comes first."""
    one = Ledger((9, 1))
    for agent, size in ((0, 500), (1, 10), (2, 10)):
        other = Ledger((agent, 1))
        other.write(Kind.READING, bytes(size))
        one.join(other)
    sent = [delta.writer[0] for _ in range(4) for delta in one.deltas({}, 60)]
    assert set(sent) == {1, 2}


def test_a_restarted_agent_takes_back_what_it_wrote():
    """It is a new writer: nothing that it acknowledged before is lost or written over."""
    before, other, again = Ledger((0, 1)), Ledger((1, 1)), Ledger((0, 2))
    before.write(Kind.VISITED, set_bytes({1, 2}))
    other.join(before)
    again.write(Kind.VISITED, set_bytes({3}))
    for delta in other.deltas(again.vector, 1000):
        again.merge(delta)
    seen = [set_of(value) for _, _, value in again.values(Kind.VISITED)]
    assert seen == [{1, 2}, {3}]
    assert again.newest(0, Kind.VISITED) == set_bytes({3})


@given(st.frozensets(st.integers(0, 3000)))
def test_sets_of_viewpoints_are_bits(numbers):
    """They are read as written, and take no more than a bit for each number of their span."""
    data = set_bytes(numbers)
    assert set_of(data) == numbers
    span = max(numbers, default=0) - min(numbers, default=0)
    assert len(data) <= span / 8 + 6


def test_values_are_read_as_written():
    """Proposals, claims, zones and findings."""
    place = place_of(GeoPosition(53.2801, -9.0601, 74.25), 123.4, is_aloft=True)
    ground = place_of(GeoPosition(-53.0, 179.9), 0.0, is_aloft=False)
    proposal = Proposal(
        number=7,
        members=((0, place), (3, ground)),
        silent=frozenset({1}),
        visited=frozenset({5, 399}),
        last=frozenset({17}),
        exclusions=((2, 1),),
    )
    assert proposal_of(proposal.encoded()) == proposal
    claim = Claim(epoch=(7, 2, 1), plan_hash=b'12345678')
    assert claim_of(claim.encoded()) == claim
    ring = (GeoPosition(53.28, -9.06), GeoPosition(53.29, -9.06), GeoPosition(53.28, -9.05))
    assert [(p.latitude_deg, p.longitude_deg) for p in ring_of(ring_bytes(ring))] == [
        (p.latitude_deg, p.longitude_deg) for p in ring
    ]


def full_packet() -> Packet:
    """Return a packet with all that it can have."""
    ledger = Ledger((1, 1))
    ledger.write(Kind.VISITED, set_bytes(range(0, 400, 2)))
    return Packet(
        sender=1,
        beats=dict.fromkeys(range(10), (1, 4000)),
        digest=ledger.digest,
        place=place_of(GeoPosition(53.28, -9.06, 40.0), 900.0, is_aloft=True),
        vector=dict(ledger.vector),
        deltas=tuple(ledger.deltas({}, 1000)),
    )


def test_packets_are_read_as_written_and_fit():
    """One of ten vehicles with 400 viewpoints is far below one frame."""
    packet = full_packet()
    data = encode(packet, KEY)
    assert decode(data, KEY) == packet
    assert len(data) < 200 < MOST_BYTES


@given(st.integers(0, 10_000), st.integers(1, 255))
def test_damaged_packets_are_refused(place, change):
    """Any changed byte, a part of a packet, and another fleet's key."""
    data = bytearray(encode(full_packet(), KEY))
    data[place % len(data)] ^= change
    with pytest.raises(PacketError):
        decode(bytes(data), KEY)
    with pytest.raises(PacketError):
        decode(bytes(data[: place % len(data)]), KEY)


def test_packets_of_another_fleet_are_refused():
    """Two fleets in one radio do not mix."""
    with pytest.raises(PacketError, match='another fleet'):
        decode(encode(full_packet(), KEY), b'another key')
