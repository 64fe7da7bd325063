# SPDX-License-Identifier: Apache-2.0
"""Readings in the ledger: each counts once, whoever tells it and in whatever order."""

import math

import pytest

from rocsafe_fleet.conversions import dose_reading_of_message
from rocsafe_fleet.ledger.ledger import Delta, Kind, Ledger
from rocsafe_fleet.ledger.readings import (
    DoseReading,
    ReadingSums,
    dose_reading_of,
    readings_of,
    table_of,
)
from rocsafe_geo.position import GeoPosition, offset
from rocsafe_interfaces.msg import GeoPoint, RadiationReading
from rocsafe_radiation.readings.readings_file import read_readings

HOME = GeoPosition(53.28, -9.06, 42.0)
NAMES = ['rav1', 'rav2', 'rav3']


def reading(east_m: float, counts: int) -> DoseReading:
    """Return a reading of one second."""
    return DoseReading(
        position=offset(HOME, east_m, 0.0),
        dose_rate_usvh=0.1 * counts,
        std_usvh=0.1 * math.sqrt(counts),
        counts=counts,
        live_time_s=1.0,
        time_s=1000.0 + east_m,
    )


def flown(agent: int, start: int, easts_m: list[float], counts: int) -> Ledger:
    """Return the ledger of an agent whose vehicle read so many counts at some places."""
    ledger = Ledger((agent, start))
    sums = ReadingSums(ledger)
    for east_m in easts_m:
        sums.add(reading(east_m, counts))
    sums.close()
    return ledger


def known(ledger: Ledger) -> list[DoseReading]:
    """Return the readings of a ledger."""
    return [dose_reading_of(value) for _, _, value in ledger.values(Kind.READING)]


def test_readings_are_added_up_over_a_short_way():
    """Counts and times are added, places and dose rates averaged; a far one begins another sum."""
    near, far = known(flown(0, 1, [0.0, 1.0, 2.0, 30.0], 9))
    assert (near.counts, near.live_time_s, near.dose_rate_usvh) == (27, 3.0, pytest.approx(0.9))
    assert near.std_usvh == pytest.approx(0.3 / math.sqrt(3.0), abs=1e-6)
    assert near.position.longitude_deg == pytest.approx(
        offset(HOME, 1.0, 0.0).longitude_deg, abs=2e-7
    )
    assert (far.counts, far.position.altitude_m) == (9, pytest.approx(42.0, abs=0.01))


def test_merged_readings_count_once(tmp_path):
    """In any order and however often they come; those of an earlier start stay."""
    parts = [flown(0, 1, [0.0, 20.0], 3), flown(0, 2, [40.0], 5), flown(1, 1, [60.0, 61.0], 7)]
    one, other = Ledger((2, 1)), Ledger((2, 2))
    for ledger in (*parts, parts[0]):
        one.join(ledger)
    for ledger in reversed(parts):
        for delta in ledger.deltas({}, 1000):
            other.merge(delta)
    assert sum(each.counts for each in known(one)) == 2 * 3 + 5 + 2 * 7
    table = table_of(readings_of([one, other, parts[0]], NAMES))
    assert table == table_of(readings_of([other], NAMES))
    path = tmp_path / 'readings.csv'
    path.write_text(table)
    read = read_readings(path)
    assert [round(each.counts) for each in read.observations] == [3, 3, 5, 14]
    assert not read.dropped


def test_plans_go_before_readings():
    """An agent that is heard again is told first what it needs in order to agree."""
    ledger = flown(0, 1, [20.0 * k for k in range(200)], 3)
    ledger.write(Kind.PROPOSAL, b'proposal')
    other, packets = Ledger((1, 1)), 0
    while other.digest != ledger.digest:
        for delta in ledger.deltas(other.vector, 1000):
            other.merge(delta)
        packets += 1
        assert other.newest(0, Kind.PROPOSAL) == b'proposal'
    assert packets < 15
    assert other.vector == ledger.vector


def test_what_came_after_a_gap_is_spread_though_it_fills_several_packets():
    """The writer is gone, and what it wrote before the gap is lost: the rest is not."""
    whole = flown(0, 1, [20.0 * k for k in range(120)], 3)
    known = Ledger((1, 1))
    for entry in whole.entries:
        if entry.version <= 5 or entry.version > 20:
            base = entry.version - 1
            delta = Delta(writer=(0, 1), base=base, upto=base + 1, entries=(entry,))
            known.merge(delta)
    other, packets = Ledger((2, 1)), 0
    while other.digest != known.digest and packets < 60:
        for delta in known.deltas(other.vector, 1000):
            other.merge(delta)
        packets += 1
    assert other.entries == known.entries
    assert packets < 40


def test_readings_without_a_place_or_an_upper_limit_are_left_out():
    """What only says that there is more is no sum's part."""
    here = GeoPoint(latitude=53.28, longitude=-9.06, altitude=42.0)
    message = RadiationReading(dose_rate_usvh=0.2, live_time_s=math.nan, position=here)
    found = dose_reading_of_message(message)
    assert found is not None
    assert (found.dose_rate_usvh, found.counts, found.live_time_s) == (0.2, 0, 0.0)
    message.saturated = True
    assert dose_reading_of_message(message) is None
    nowhere = GeoPoint(latitude=math.nan, longitude=math.nan, altitude=math.nan)
    assert dose_reading_of_message(RadiationReading(position=nowhere)) is None
