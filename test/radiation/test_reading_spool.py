# SPDX-License-Identifier: Apache-2.0
"""Readings kept in a file come back, but for the one that a crash cut off."""

import math

import pytest

from rocsafe_geo.position import GeoPosition
from rocsafe_hazard.row_spool import SpoolError
from rocsafe_radiation.readings.reading_log import FlightReading, ReadingLog
from rocsafe_radiation.readings.reading_spool import FILE_NAME, ReadingSpool
from rocsafe_radiation.readings.readings_file import read_readings


def reading(number, **changes):
    """Return the reading of second `number`."""
    values = {
        'vehicle': 'rav1',
        'time_ns': 1_748_772_000_000_000_000 + number * 1_000_000_000 + 1,
        'latitude_deg': 53.28 + 1e-5 * number,
        'longitude_deg': -9.06,
        'altitude_m': 98.0,
        'dose_rate_usvh': 0.1 / 3.0,
        'dose_rate_std_usvh': 0.01,
        'counts': 55.0,
        'live_time_s': 1.0,
        'window_s': 1.0,
        'model': 'air',
        **changes,
    }
    return FlightReading(**values)


def test_readings_come_back_as_they_were(tmp_path):
    """Every digit, from two processes one after the other."""
    kept = [reading(k, is_saturated=k == 2) for k in range(6)]
    for part in (kept[:3], kept[3:]):
        spool = ReadingSpool(str(tmp_path))
        for one in part:
            spool.keep(one)
    assert list(ReadingSpool(str(tmp_path)).restored()) == kept


def test_a_row_cut_off_is_left_out_and_does_not_spoil_the_next(tmp_path):
    """As after kill -9 in the middle of a write."""
    spool = ReadingSpool(str(tmp_path))
    for k in range(3):
        spool.keep(reading(k))
    path = tmp_path / FILE_NAME
    path.write_bytes(path.read_bytes()[:-20])
    again = ReadingSpool(str(tmp_path))
    assert list(again.restored()) == [reading(0), reading(1)]
    again.keep(reading(3))
    assert list(ReadingSpool(str(tmp_path)).restored()) == [reading(0), reading(1), reading(3)]


def test_anyone_can_localise_from_the_file(tmp_path):
    """It is a table like any other."""
    spool = ReadingSpool(str(tmp_path))
    for k in range(4):
        spool.keep(reading(k, latitude_deg=math.nan if k == 1 else 53.28))
    table = read_readings(tmp_path / FILE_NAME)
    assert len(table.observations) == 3
    assert table.models == {'air'}


def test_without_a_directory_nothing_is_kept():
    """In memory alone."""
    spool = ReadingSpool('')
    spool.keep(reading(1))
    assert list(spool.restored()) == []


def test_a_directory_that_cannot_be_written_is_told(tmp_path):
    """In one line."""
    blocked = tmp_path / 'file'
    blocked.write_text('')
    with pytest.raises(SpoolError, match='cannot be written'):
        ReadingSpool(str(blocked)).keep(reading(1))


def test_a_log_takes_what_is_of_use_and_each_once():
    """No place, no value, out of range, saturated, again: left out."""
    log = ReadingLog(GeoPosition(53.28, -9.06, 66.0))
    assert log.add(reading(1))
    for useless in (
        reading(1),
        reading(2, latitude_deg=math.nan),
        reading(3, latitude_deg=95.0),
        reading(4, dose_rate_usvh=math.nan),
        reading(5, dose_rate_usvh=-1.0),
        reading(6, is_saturated=True),
    ):
        assert not log.add(useless)
    assert len(log) == 1
    assert log.vehicles == ('rav1',)


def test_a_detector_that_dies_in_flight_proves_nothing_from_then_on():
    """Its counts are left out, and the survey says so; if none lives, all are kept."""
    log = ReadingLog(GeoPosition(53.28, -9.06, 66.0))
    dead = {'counts': 0.0, 'dose_rate_usvh': 0.0}
    for number in range(20):
        log.add(reading(number, **(dead if number >= 10 else {})))
    survey = log.survey()
    assert survey.size == 10
    assert survey.counts.min() == 55.0
    assert '10 readings are of a dead detector' in survey.caveats[0]
    log = ReadingLog(GeoPosition(53.28, -9.06, 66.0))
    for number in range(20):
        log.add(reading(number, **dead))
    assert log.survey().size == 20
