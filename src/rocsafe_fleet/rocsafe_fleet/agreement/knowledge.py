# SPDX-License-Identifier: Apache-2.0
"""What a ledger says of a fleet: who takes work, what is photographed, proposals and claims."""

from collections.abc import Iterable, Iterator, Mapping

from rocsafe_fleet.agreement.fleet_plan import Ring
from rocsafe_fleet.ledger.ledger import Kind, Ledger
from rocsafe_fleet.ledger.records import (
    Claim,
    Epoch,
    Proposal,
    RoundKey,
    claim_of,
    proposal_of,
    ring_of,
    set_of,
)
from rocsafe_fleet.search.search_round import (
    ExtraPlaces,
    SearchRound,
    extra_places,
    search_round_of,
)
from rocsafe_geo.position import GeoPosition


class Knowledge:
    """Reads a ledger. What is long to decode is decoded once for each state of the ledger.

    Parameters
    ----------
    ledger
        What is known.
    count
        Number of vehicles of the survey's plan.
    first_extra
        Above the ids of the viewpoints of the survey.
    """

    def __init__(self, ledger: Ledger, count: int, first_extra: int) -> None:
        self._ledger = ledger
        self._count = count
        self._first_extra = first_extra
        self._rounds: tuple[int, dict[RoundKey, SearchRound]] = (0, {})
        self._decoded: tuple[int, list[tuple[Epoch, Proposal]]] = (0, [])
        self._visited: tuple[int, frozenset[int]] = (0, frozenset())

    @property
    def unable(self) -> Mapping[int, str]:
        """Vehicles that say that they take no more work, and why."""
        texts = {k: self._ledger.newest(k, Kind.ABLE) for k in range(self._count)}
        return {k: text.decode() for k, text in texts.items() if text}

    @property
    def visited(self) -> frozenset[int]:
        """Viewpoints that anybody has photographed."""
        if self._visited[0] != self._ledger.digest:
            sets = [set_of(value) for _, _, value in self._ledger.values(Kind.VISITED)]
            self._visited = self._ledger.digest, frozenset().union(*sets)
        return self._visited[1]

    @property
    def duplicates(self) -> int:
        """Photographs of viewpoints that another vehicle has photographed too."""
        by_vehicle: dict[int, set[int]] = {}
        for (vehicle, _), _, value in self._ledger.values(Kind.VISITED):
            by_vehicle.setdefault(vehicle, set()).update(set_of(value))
        return sum(map(len, by_vehicle.values())) - len(self.visited)

    @property
    def proposals(self) -> list[tuple[Epoch, Proposal]]:
        """All proposals, each with its epoch."""
        if self._decoded[0] != self._ledger.digest:
            found = [(w, proposal_of(v)) for w, _, v in self._ledger.values(Kind.PROPOSAL)]
            known = [((proposal.number, *writer), proposal) for writer, proposal in found]
            self._decoded = self._ledger.digest, known
        return self._decoded[1]

    @property
    def zones(self) -> tuple[tuple[int, int], ...]:
        """Zones to keep out of: the vehicle that names each, and its number there."""
        values = self._ledger.values(Kind.EXCLUSION)
        return tuple(sorted({(writer[0], part) for writer, part, _ in values}))

    def rings(self, proposal: Proposal) -> tuple[Ring, ...] | None:
        """Return the zones of a proposal; None: some are not known here yet."""
        values = self._ledger.values(Kind.EXCLUSION)
        zones = {(writer[0], part): ring_of(value) for writer, part, value in values}
        if any(zone not in zones for zone in proposal.exclusions):
            return None
        return tuple(zones[zone] for zone in proposal.exclusions)

    def claim(self, member: int) -> Claim | None:
        """Return the newest plan that a vehicle says it keeps to."""
        value = self._ledger.newest(member, Kind.CLAIM)
        return None if value is None else claim_of(value)

    @property
    def rounds(self) -> Mapping[RoundKey, SearchRound]:
        """Rounds of the search, of each agent and number the one that its last start chose."""
        if self._rounds[0] != self._ledger.digest:
            written = self._ledger.values(Kind.ROUND)
            latest = {(writer[0], part): (writer, value) for writer, part, value in written}
            found = {
                (*writer, number): search_round_of(number, value)
                for (_, number), (writer, value) in latest.items()
            }
            self._rounds = self._ledger.digest, found
        return self._rounds[1]

    def open_rounds(self) -> tuple[RoundKey, ...]:
        """Return the rounds of which places are left."""
        return tuple(
            key
            for key, one in sorted(self.rounds.items(), key=lambda item: item[0])
            if any(i not in self.visited for i, _ in self._places_of(key, one))
        )

    @property
    def extra_points(self) -> frozenset[int]:
        """Ids of the places of all rounds."""
        return frozenset(
            i for key, one in self.rounds.items() for i, _ in self._places_of(key, one)
        )

    def _places_of(self, key: RoundKey, one: SearchRound) -> Iterator[tuple[int, GeoPosition]]:
        return extra_places(one, key[0], self._first_extra)

    def places(self, keys: Iterable[RoundKey]) -> ExtraPlaces | None:
        """Return the places of rounds; None: some are not known here yet."""
        written = {(*w, part): value for w, part, value in self._ledger.values(Kind.ROUND)}
        if any(key not in written for key in keys):
            return None
        return tuple(
            place
            for key in keys
            for place in self._places_of(key, search_round_of(key[2], written[key]))
        )
