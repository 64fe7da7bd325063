# SPDX-License-Identifier: Apache-2.0
"""Readings of dose rate in the ledger: sums over a short way, each reading in exactly one.

Counts and times of a place may be added, and for counts of Poisson nothing is lost by it. As each
sum is one entry of one writer, merging ledgers counts no reading twice.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from rocsafe_fleet.ledger.ledger import Kind, Ledger
from rocsafe_fleet.ledger.varint import Reader, put_number, put_signed
from rocsafe_geo.position import GeoPosition, distance_m

WAY_M = 4.0
"""Readings farther than this from the first of a sum begin another."""
MOST_READINGS = 20
HEADER = (
    'vehicle,time_ns,latitude_deg,longitude_deg,altitude_m,dose_rate_usvh,dose_rate_std_usvh,counts,'
    'live_time_s'
)
_E7, _CM, _MICRO, _MS, _DS = 1e7, 100.0, 1e6, 1e3, 10.0
_NS_A_DS = 100_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class DoseReading:
    """A reading, or the sum of several.

    Attributes
    ----------
    dose_rate_usvh, std_usvh
        Mean dose rate and its standard deviation, microsievert per hour.
    counts, live_time_s
        Added up; 0 of a detector that does not count.
    time_s
        Of the first, by the clock of its vehicle, to tenths of a second.
    """

    position: GeoPosition
    dose_rate_usvh: float
    std_usvh: float
    counts: int = 0
    live_time_s: float = 0.0
    time_s: float = 0.0

    @property
    def is_usable(self) -> bool:
        """Whether place and values are numbers that can be sent."""
        here = self.position
        place = (here.latitude_deg, here.longitude_deg, here.altitude_m)
        values = (self.dose_rate_usvh, self.std_usvh, self.live_time_s, self.time_s)
        return all(map(math.isfinite, place)) and all(0.0 <= v < 1e12 for v in values)

    def encoded(self) -> bytes:
        """Return it as the value of an entry."""
        into, here = bytearray(), self.position
        put_signed(into, round(here.latitude_deg * _E7))
        put_signed(into, round(here.longitude_deg * _E7))
        put_signed(into, round(here.altitude_m * _CM))
        put_number(into, round(self.dose_rate_usvh * _MICRO))
        put_number(into, round(self.std_usvh * _MICRO))
        put_number(into, self.counts)
        put_number(into, round(self.live_time_s * _MS))
        put_number(into, round(self.time_s * _DS))
        return bytes(into)


def dose_reading_of(value: bytes) -> DoseReading:
    """Return the reading that is the value of an entry."""
    reader = Reader(value)
    latitude, longitude, altitude = reader.signed(), reader.signed(), reader.signed()
    return DoseReading(
        position=GeoPosition(latitude / _E7, longitude / _E7, altitude / _CM),
        dose_rate_usvh=reader.number() / _MICRO,
        std_usvh=reader.number() / _MICRO,
        counts=reader.number(),
        live_time_s=reader.number() / _MS,
        time_s=reader.number() / _DS,
    )


class ReadingSums:
    """Adds up the readings of one vehicle, and writes the sums into a ledger."""

    def __init__(self, ledger: Ledger) -> None:
        self._ledger = ledger
        self._open: list[DoseReading] = []
        self._written = 0

    def add(self, reading: DoseReading) -> None:
        """Add a reading; one without a place or a value is left out."""
        if not reading.is_usable:
            return
        first = self._open[0] if self._open else reading
        is_far = distance_m(first.position, reading.position) > WAY_M
        if is_far or len(self._open) >= MOST_READINGS:
            self.close()
        self._open.append(reading)

    def close(self) -> None:
        """Write what was added so far."""
        if self._open:
            self._ledger.write(Kind.READING, _sum(self._open).encoded(), self._written)
            self._written += 1
            self._open = []


def _sum(readings: list[DoseReading]) -> DoseReading:
    count = len(readings)
    places = [one.position for one in readings]
    return DoseReading(
        position=GeoPosition(
            sum(place.latitude_deg for place in places) / count,
            sum(place.longitude_deg for place in places) / count,
            sum(place.altitude_m for place in places) / count,
        ),
        dose_rate_usvh=sum(one.dose_rate_usvh for one in readings) / count,
        std_usvh=math.sqrt(sum(one.std_usvh**2 for one in readings)) / count,
        counts=sum(one.counts for one in readings),
        live_time_s=sum(one.live_time_s for one in readings),
        time_s=readings[0].time_s,
    )


def readings_of(ledgers: Iterable[Ledger], names: Sequence[str]) -> list[tuple[str, DoseReading]]:
    """Return the readings that any of some ledgers knows, each once, with the vehicles' names."""
    known = {
        (writer, part): value
        for ledger in ledgers
        for writer, part, value in ledger.values(Kind.READING)
    }
    return [(names[key[0][0]], dose_reading_of(value)) for key, value in sorted(known.items())]


def table_of(readings: Iterable[tuple[str, DoseReading]]) -> str:
    """Return readings of vehicles as a table with commas.

    Columns are those that `rocsafe localize` reads; a detector that does not count has no counts.
    """
    lines = [HEADER]
    for vehicle, one in readings:
        here = one.position
        counted = f'{one.counts},{one.live_time_s:.3f}' if one.live_time_s > 0.0 else ','
        lines.append(
            f'{vehicle},{round(one.time_s * _DS) * _NS_A_DS},{here.latitude_deg:.7f},'
            f'{here.longitude_deg:.7f},{here.altitude_m:.2f},{one.dose_rate_usvh:.6f},'
            f'{one.std_usvh:.6f},{counted}'
        )
    return '\n'.join(lines) + '\n'
