# SPDX-License-Identifier: Apache-2.0
"""The ledger: what the agents of a fleet know together, merged in any order.

It is a delta-state CRDT (Almeida, Shoker, Baquero 2018, doi:10.1016/j.jpdc.2017.08.003). Each
entry has one writer, which numbers its writes; of two values of an entry the one with the higher
version holds. A map whose values only grow in a total order is a semilattice, so merging is
commutative, associative and idempotent. A version vector says up to which write of each writer a
ledger is complete; deltas carry what a vector lacks. An agent that starts again is another writer,
so that it takes back what it wrote before like anything else.
"""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import IntEnum

Writer = tuple[int, int]
"""Number of an agent, and its incarnation: later starts have higher ones."""
Vector = Mapping[Writer, int]
"""Number of the write of each writer up to which all its entries are known."""
ENTRY_BYTES = 8
"""Most bytes that an entry takes in a packet besides its value."""
DELTA_BYTES = 16
"""Most bytes that a delta takes besides its entries."""
_TURN_VERSIONS = 8


class Kind(IntEnum):
    """What an entry tells; the comment says what `part` distinguishes."""

    VISITED = 1
    ABLE = 2
    PROPOSAL = 3
    CLAIM = 4
    EXCLUSION = 5  # number
    READING = 8  # number
    ROUND = 9  # number


Key = tuple[Writer, int, int]
"""Writer, kind and part of an entry."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """One value of one entry."""

    key: Key
    version: int
    value: bytes

    @property
    def order(self) -> tuple[int, bytes]:
        """The greater of two values of an entry holds; the bytes decide if a writer erred."""
        return self.version, self.value

    @property
    def digest(self) -> int:
        """64 bits of a hash of all of it."""
        text = repr((self.key, self.version, self.value)).encode()
        return int.from_bytes(hashlib.blake2b(text, digest_size=8).digest(), 'big')


@dataclass(frozen=True, slots=True, kw_only=True)
class Delta:
    """All entries of one writer with versions after `base`, up to `upto`; some later ones, too."""

    writer: Writer
    base: int
    upto: int
    entries: tuple[Entry, ...]


class Ledger:
    """The knowledge of one agent.

    Parameters
    ----------
    writer
        The agent, and its incarnation.

    Attributes
    ----------
    vector
        Of its entries.
    latest
        Number of the newest write that is known of each writer: what was lost before it, and whose
        writer is gone, may never come.
    digest
        64 bits that are equal for equal entries.
    """

    def __init__(self, writer: Writer) -> None:
        self.writer = writer
        self.vector: dict[Writer, int] = {}
        self.latest: dict[Writer, int] = {}
        self.digest = 0
        self._entries: dict[Key, Entry] = {}
        self._kinds: dict[int, dict[Key, Entry]] = {kind: {} for kind in Kind}
        self._writers: dict[Writer, dict[Key, Entry]] = {}
        self._newest: dict[tuple[int, int, int], Key] = {}
        self._turn = 0

    @property
    def entries(self) -> frozenset[Entry]:
        """All entries."""
        return frozenset(self._entries.values())

    def write(self, kind: Kind, value: bytes, part: int = 0) -> bool:
        """Write an own entry; return whether it changes anything."""
        key = (self.writer, int(kind), part)
        known = self._entries.get(key)
        if known is not None and known.value == value:
            return False
        version = self.vector.get(self.writer, 0) + 1
        self._take(Entry(key=key, version=version, value=value))
        self.vector[self.writer] = version
        return True

    def newest(self, agent: int, kind: Kind, part: int = 0) -> bytes | None:
        """Return the value that the latest incarnation of an agent wrote, None if none did."""
        key = self._newest.get((agent, int(kind), part))
        return None if key is None else self._entries[key].value

    def values(self, kind: Kind) -> Iterator[tuple[Writer, int, bytes]]:
        """Yield writer, part and value of all entries of a kind, in order."""
        for (writer, _, part), entry in sorted(self._kinds[kind].items(), key=lambda one: one[0]):
            yield writer, part, entry.value

    def merge(self, delta: Delta) -> bool:
        """Take what a delta has; return whether it changes anything.

        After a gap the vector stays, so that the gap is asked for again; what came after it is
        passed on to those who show another digest.
        """
        news = [entry for entry in delta.entries if self._take(entry)]
        if delta.base <= self.vector.get(delta.writer, 0) < delta.upto:
            self.vector[delta.writer] = delta.upto
        return bool(news)

    def join(self, other: 'Ledger') -> None:
        """Take all that another ledger has."""
        for entry in other.entries:
            self._take(entry)
        for writer, version in other.vector.items():
            self.vector[writer] = max(version, self.vector.get(writer, 0))

    def deltas(self, vector: Vector, most_bytes: int) -> list[Delta]:
        """Return what a ledger of that vector lacks, as much as goes into so many bytes.

        Readings come last. What is left out follows when the next vector comes: then another
        writer is the first, and of what came after a gap other entries are.
        """
        behind = [w for w in sorted(self.latest) if self.latest[w] > vector.get(w, 0)]
        first = self._turn % len(behind) if behind else 0
        ranks = {writer: k for k, writer in enumerate(behind[first:] + behind[:first])}
        newer = [
            entry
            for writer in behind
            for entry in self._writers[writer].values()
            if entry.version > vector.get(writer, 0)
        ]
        newer.sort(key=lambda e: (e.key[1] == Kind.READING, ranks[e.key[0]], *self._order(e)))
        chosen: dict[Writer, list[Entry]] = {}
        upto = {writer: self.vector.get(writer, 0) for writer in behind}
        for entry in newer:
            writer = entry.key[0]
            size = ENTRY_BYTES + len(entry.value) + (0 if writer in chosen else DELTA_BYTES)
            if size <= most_bytes:
                most_bytes -= size
                chosen.setdefault(writer, []).append(entry)
            else:
                upto[writer] = min(upto[writer], entry.version - 1)
        self._turn += sum(map(len, chosen.values())) < len(newer)
        return [
            Delta(
                writer=writer,
                base=vector.get(writer, 0),
                upto=upto[writer],
                entries=tuple(sorted(entries, key=lambda entry: entry.version)),
            )
            for writer, entries in chosen.items()
        ]

    def _order(self, entry: Entry) -> tuple[bool, int]:
        """Return in which order the entries of a writer are sent.

        Vectors do not pass a gap that nobody can fill: what came after it takes turns, else only
        the first packet of it would ever be sent.
        """
        writer = entry.key[0]
        if entry.version <= self.vector.get(writer, 0):
            return False, entry.version
        return True, (entry.version - _TURN_VERSIONS * self._turn) % (self.latest[writer] + 1)

    def _take(self, entry: Entry) -> bool:
        known = self._entries.get(entry.key)
        if known is not None and known.order >= entry.order:
            return False
        if known is not None:
            self.digest ^= known.digest
        self.digest ^= entry.digest
        self._entries[entry.key] = entry
        writer = entry.key[0]
        self._kinds.setdefault(entry.key[1], {})[entry.key] = entry
        self._writers.setdefault(writer, {})[entry.key] = entry
        self.latest[writer] = max(entry.version, self.latest.get(writer, 0))
        of_agent = (entry.key[0][0], *entry.key[1:])
        self._newest[of_agent] = max(entry.key, self._newest.get(of_agent, entry.key))
        return True
