# SPDX-License-Identifier: Apache-2.0
"""Packets between agents: a heartbeat, and what the others lack.

A packet is no longer than one frame of the link, so that a loss costs one packet and not all. A
keyed hash (BLAKE2b, 8 bytes) tells damaged packets and those of other fleets.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field

from rocsafe_fleet.errors import PacketError
from rocsafe_fleet.ledger.ledger import Delta, Entry, Vector, Writer
from rocsafe_fleet.ledger.records import Place, put_place, take_place
from rocsafe_fleet.ledger.varint import Reader, put_bytes, put_number

FORMAT = 3
TAG_BYTES = 8
MOST_BYTES = 1200
"""Most bytes of a packet: below the least MTU of IPv6, 1280 bytes, less the headers."""
_DIGEST_BYTES = 8

Beat = tuple[int, int]
"""Incarnation of an agent, and number of its heartbeat in it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Packet:
    """One packet.

    Attributes
    ----------
    sender
        Number of the agent.
    beats
        Newest heartbeat of each agent that the sender knows of, its own included.
    digest
        Of its ledger.
    place
        Where its vehicle is; None: not known.
    vector
        Of its ledger, if it seems to lack something; else empty.
    deltas
        For others.
    """

    sender: int
    beats: Mapping[int, Beat]
    digest: int
    place: Place | None = None
    vector: Vector = field(default_factory=dict)
    deltas: tuple[Delta, ...] = ()


def encode(packet: Packet, key: bytes) -> bytes:
    """Return a packet as bytes, with the hash of the fleet's key of up to 64 bytes."""
    into = bytearray([FORMAT])
    put_number(into, packet.sender)
    _put_beats(into, packet.beats)
    into += packet.digest.to_bytes(_DIGEST_BYTES, 'big')
    into.append(packet.place is not None)
    if packet.place is not None:
        put_place(into, packet.place)
    _put_vector(into, packet.vector)
    for delta in packet.deltas:
        _put_delta(into, delta)
    return bytes(into) + _tag(bytes(into), key)


def decode(data: bytes, key: bytes) -> Packet:
    """Return the packet in some bytes.

    Raises
    ------
    PacketError
        If they are damaged, of another fleet, or of another version of the format.
    """
    body, tag = data[:-TAG_BYTES], data[-TAG_BYTES:]
    if _tag(body, key) != tag:
        raise PacketError('packet is damaged, or of another fleet')
    reader = Reader(body)
    if (version := reader.number()) != FORMAT:
        raise PacketError(f'packet has format {version}: must be {FORMAT}')
    sender, beats = reader.number(), _take_beats(reader)
    digest = int.from_bytes(reader.take(_DIGEST_BYTES), 'big')
    place = take_place(reader) if reader.take(1)[0] else None
    vector = _take_vector(reader)
    deltas = []
    while not reader.is_at_end:
        deltas.append(_take_delta(reader))
    return Packet(
        sender=sender, beats=beats, digest=digest, place=place, vector=vector, deltas=tuple(deltas)
    )


def _tag(body: bytes, key: bytes) -> bytes:
    return hashlib.blake2b(body, digest_size=TAG_BYTES, key=key).digest()


def _put_beats(into: bytearray, beats: Mapping[int, Beat]) -> None:
    put_number(into, len(beats))
    for member, (incarnation, number) in sorted(beats.items()):
        put_number(into, member)
        put_number(into, incarnation)
        put_number(into, number)


def _take_beats(reader: Reader) -> dict[int, Beat]:
    count = reader.number()
    return {reader.number(): (reader.number(), reader.number()) for _ in range(count)}


def _put_vector(into: bytearray, vector: Vector) -> None:
    put_number(into, len(vector))
    for (agent, incarnation), version in sorted(vector.items()):
        put_number(into, agent)
        put_number(into, incarnation)
        put_number(into, version)


def _take_vector(reader: Reader) -> dict[Writer, int]:
    count = reader.number()
    return {(reader.number(), reader.number()): reader.number() for _ in range(count)}


def _put_delta(into: bytearray, delta: Delta) -> None:
    for value in (*delta.writer, delta.base, delta.upto, len(delta.entries)):
        put_number(into, value)
    for entry in delta.entries:
        for value in (*entry.key[1:], entry.version):
            put_number(into, value)
        put_bytes(into, entry.value)


def _take_delta(reader: Reader) -> Delta:
    writer = reader.number(), reader.number()
    base, upto, count = reader.number(), reader.number(), reader.number()
    entries = []
    for _ in range(count):
        key = writer, reader.number(), reader.number()
        version = reader.number()
        entries.append(Entry(key=key, version=version, value=reader.text()))
    return Delta(writer=writer, base=base, upto=upto, entries=tuple(entries))
