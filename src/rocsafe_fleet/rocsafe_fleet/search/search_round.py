# SPDX-License-Identifier: Apache-2.0
"""A round of the search: the places to measure at after the survey, as the ledger holds them."""

from collections.abc import Iterator
from dataclasses import dataclass

from rocsafe_fleet.ledger.varint import Reader, put_bytes, put_signed
from rocsafe_geo.position import GeoPosition

MOST_ROUNDS = 20
MOST_PLACES = 100
MOST_REASON_BYTES = 120
_E7 = 10_000_000

ExtraPlaces = tuple[tuple[int, GeoPosition], ...]
"""Ids of viewpoints that are not of the survey, and where they are."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchRound:
    """Places to measure at, chosen from all readings of the ledger.

    Attributes
    ----------
    number
        From 1.
    places
        On a grid of 1e-7 degrees, without altitudes; empty: no further round is flown.
    reason
        Why these were chosen, or none.
    """

    number: int
    places: tuple[GeoPosition, ...]
    reason: str

    def __post_init__(self) -> None:
        if not 1 <= self.number <= MOST_ROUNDS:
            raise ValueError(f'round {self.number}: must be from 1 to {MOST_ROUNDS}')
        if len(self.places) > MOST_PLACES:
            raise ValueError(f'places = {len(self.places)} of them: at most {MOST_PLACES}')

    def encoded(self) -> bytes:
        """Return it as the value of an entry; each place counts from the one before."""
        into = bytearray()
        reason = self.reason.encode()[:MOST_REASON_BYTES].decode(errors='ignore')
        put_bytes(into, reason.encode())
        latitude = longitude = 0
        for place in self.places:
            now = round(place.latitude_deg * _E7), round(place.longitude_deg * _E7)
            put_signed(into, now[0] - latitude)
            put_signed(into, now[1] - longitude)
            latitude, longitude = now
        return bytes(into)


def search_round_of(number: int, value: bytes) -> SearchRound:
    """Return the round that is the value of an entry."""
    reader = Reader(value)
    reason = reader.text().decode()
    places, latitude, longitude = [], 0, 0
    while not reader.is_at_end:
        latitude += reader.signed()
        longitude += reader.signed()
        places.append(GeoPosition(latitude / _E7, longitude / _E7, 0.0))
    return SearchRound(number=number, places=tuple(places), reason=reason)


def extra_places(
    one: SearchRound, chooser: int, first_id: int
) -> Iterator[tuple[int, GeoPosition]]:
    """Yield ids and places of a round.

    Parameters
    ----------
    chooser
        Number of the agent that chose it: rounds of agents that did not hear each other differ.
    first_id
        Above the ids of the survey.
    """
    begin = first_id + (chooser * MOST_ROUNDS + one.number - 1) * MOST_PLACES
    yield from enumerate(one.places, begin)
