# SPDX-License-Identifier: Apache-2.0
"""Values of entries: places, sets of viewpoints, proposals, claims."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain

from rocsafe_fleet.ledger.varint import Reader, put_bytes, put_number, put_signed
from rocsafe_geo.position import GeoPosition

_E7 = 10_000_000
_CM = 100
_NO_ALTITUDE = -(2**31)
_DECISECONDS = 10
_LONGEST_GAP = 2
HASH_BYTES = 8
"""Bytes of the hashes of situations and plans."""

Epoch = tuple[int, int, int]
"""Number of an agreement, the coordinator that proposed it and its start; the highest holds."""
FIRST_EPOCH: Epoch = (0, 0, 0)
RoundKey = tuple[int, int, int]
"""Agent that chose a round of the search, its start, and the number of the round from 1."""


def put_set(into: bytearray, members: Iterable[int]) -> None:
    """Append a set of numbers as bits, without the empty bytes around and between them."""
    bits: dict[int, int] = {}
    for member in members:
        bits[member >> 3] = bits.get(member >> 3, 0) | 1 << (member & 7)
    runs: list[tuple[int, bytearray]] = []
    for place in sorted(bits):
        if not runs or place - runs[-1][0] - len(runs[-1][1]) > _LONGEST_GAP:
            runs.append((place, bytearray()))
        first, run = runs[-1]
        run += bytes(place - first - len(run)) + bytes([bits[place]])
    put_number(into, len(runs))
    end = 0
    for first, run in runs:
        put_number(into, first - end)
        put_bytes(into, bytes(run))
        end = first + len(run)


def take_set(reader: Reader) -> frozenset[int]:
    """Return the next set of numbers."""
    members: list[int] = []
    place = 0
    for _ in range(reader.number()):
        place += reader.number()
        for byte in reader.text():
            members += [8 * place + bit for bit in range(8) if byte >> bit & 1]
            place += 1
    return frozenset(members)


def set_bytes(members: Iterable[int]) -> bytes:
    """Return a set of numbers as the value of an entry."""
    into = bytearray()
    put_set(into, members)
    return bytes(into)


def set_of(value: bytes) -> frozenset[int]:
    """Return the set of numbers that is the value of an entry."""
    return take_set(Reader(value))


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Place of a vehicle in 1e-7 degrees and centimetres: all compute with equal numbers.

    Attributes
    ----------
    altitude_cm
        Above the ellipsoid; None: not known.
    used_ds
        Flight time used of its battery, tenths of a second.
    is_aloft
        Whether it is in the air; else it stands at home.
    is_landing
        Whether it comes down at home, and takes no route until it stands.
    """

    latitude_e7: int
    longitude_e7: int
    altitude_cm: int | None
    used_ds: int
    is_aloft: bool
    is_landing: bool = False

    @property
    def position(self) -> GeoPosition:
        """The place in degrees and metres."""
        altitude = float('nan') if self.altitude_cm is None else self.altitude_cm / _CM
        return GeoPosition(self.latitude_e7 / _E7, self.longitude_e7 / _E7, altitude)

    @property
    def used_s(self) -> float:
        """Flight time used of its battery, seconds."""
        return self.used_ds / _DECISECONDS


def place_of(
    position: GeoPosition, used_s: float, *, is_aloft: bool, is_landing: bool = False
) -> Place:
    """Return where a vehicle is, rounded."""
    altitude = position.altitude_m
    return Place(
        latitude_e7=round(position.latitude_deg * _E7),
        longitude_e7=round(position.longitude_deg * _E7),
        altitude_cm=None if altitude != altitude else round(altitude * _CM),
        used_ds=max(0, round(used_s * _DECISECONDS)),
        is_aloft=is_aloft,
        is_landing=is_landing,
    )


def put_place(into: bytearray, place: Place) -> None:
    """Append a place."""
    put_signed(into, place.latitude_e7)
    put_signed(into, place.longitude_e7)
    put_signed(into, _NO_ALTITUDE if place.altitude_cm is None else place.altitude_cm)
    put_number(into, place.used_ds * 4 + place.is_landing * 2 + place.is_aloft)


def take_place(reader: Reader) -> Place:
    """Return the next place."""
    latitude, longitude, altitude = reader.signed(), reader.signed(), reader.signed()
    used = reader.number()
    return Place(
        latitude_e7=latitude,
        longitude_e7=longitude,
        altitude_cm=None if altitude == _NO_ALTITUDE else altitude,
        used_ds=used >> 2,
        is_aloft=bool(used & 1),
        is_landing=bool(used & 2),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Proposal:
    """What a coordinator asks all members to plan from.

    Attributes
    ----------
    number
        Number of the epoch; with the coordinator, who writes it, its name.
    members
        Vehicles that go on, and where they are.
    silent
        Vehicles that were not heard, and may fly on by themselves.
    visited, last
        Ids of viewpoints that are photographed, and that come after all others.
    exclusions
        Writers and numbers of the zones of the ledger that hold.
    rounds
        Those of the search of which places are left.
    """

    number: int
    members: tuple[tuple[int, Place], ...]
    silent: frozenset[int] = frozenset()
    visited: frozenset[int] = frozenset()
    last: frozenset[int] = frozenset()
    exclusions: tuple[tuple[int, int], ...] = ()
    rounds: tuple[RoundKey, ...] = ()

    def encoded(self) -> bytes:
        """Return it as the value of an entry."""
        into = bytearray()
        put_number(into, self.number)
        put_number(into, len(self.members))
        for member, place in self.members:
            put_number(into, member)
            put_place(into, place)
        for numbers in (self.silent, self.visited, self.last):
            put_set(into, numbers)
        put_number(into, len(self.exclusions))
        for writer, number in self.exclusions:
            put_number(into, writer)
            put_number(into, number)
        put_number(into, len(self.rounds))
        for part in chain.from_iterable(self.rounds):
            put_number(into, part)
        return bytes(into)

    @property
    def names(self) -> frozenset[int]:
        """Numbers of the members."""
        return frozenset(member for member, _ in self.members)


def proposal_of(value: bytes) -> Proposal:
    """Return the proposal that is the value of an entry."""
    reader = Reader(value)
    number = reader.number()
    members = tuple((reader.number(), take_place(reader)) for _ in range(reader.number()))
    silent, visited, last = (take_set(reader) for _ in range(3))
    zones = tuple((reader.number(), reader.number()) for _ in range(reader.number()))
    count = reader.number()
    rounds = tuple((reader.number(), reader.number(), reader.number()) for _ in range(count))
    return Proposal(
        number=number,
        members=members,
        silent=silent,
        visited=visited,
        last=last,
        exclusions=zones,
        rounds=rounds,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """The newest epoch that an agent has planned, and the hash of its plan."""

    epoch: Epoch
    plan_hash: bytes

    def encoded(self) -> bytes:
        """Return it as the value of an entry."""
        into = bytearray()
        for part in self.epoch:
            put_number(into, part)
        return bytes(into) + self.plan_hash


def claim_of(value: bytes) -> Claim:
    """Return the claim that is the value of an entry."""
    reader = Reader(value)
    epoch = reader.number(), reader.number(), reader.number()
    return Claim(epoch=epoch, plan_hash=reader.take(HASH_BYTES))


def ring_bytes(ring: Iterable[GeoPosition]) -> bytes:
    """Return the corners of a zone as the value of an entry."""
    into = bytearray()
    for corner in ring:
        put_signed(into, round(corner.latitude_deg * _E7))
        put_signed(into, round(corner.longitude_deg * _E7))
    return bytes(into)


def ring_of(value: bytes) -> tuple[GeoPosition, ...]:
    """Return the corners of the zone that is the value of an entry."""
    reader, corners = Reader(value), []
    while not reader.is_at_end:
        corners.append(GeoPosition(reader.signed() / _E7, reader.signed() / _E7, float('nan')))
    return tuple(corners)
