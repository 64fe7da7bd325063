# SPDX-License-Identifier: Apache-2.0
"""A disk that fills up or fails ends no flight, and none begins that a restart would not find."""

import shutil

import pytest
from test.mavlink.test_station import Air

from rocsafe_geo.storage.kept_file import KeptFile
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.flight.flight_journal import FlightJournal
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome
from rocsafe_mavlink.flight.late_start import LateStart
from rocsafe_mavlink.wire.timestamp_store import RESERVE_TICKS, TimestampStore


def broken(folder):
    """Let nothing be written below a folder any more, whoever writes."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.write_text('no folder')


def mended(folder):
    """Let it be written to again."""
    folder.unlink()


def ready(folder):
    """Return an air whose copter may fly, with a journal in a folder."""
    air = Air()
    drone = air.drones[1]
    air.drones[1] = Drone(drone.spec, drone.session, FlightJournal(folder / 'flight.json'))
    air.station.add(air.drones[1])
    air.wait(46.0)
    return air


def entry(folder):
    """Return what a bridge that is started again finds."""
    return FlightJournal(folder / 'flight.json').entry


def test_newest_content_is_written_as_soon_as_the_disk_can_be_written_to(tmp_path):
    """And what lay there before is whole until then."""
    folder = tmp_path / 'state'
    kept = KeptFile(folder / 'a')
    kept.require(b'1')
    shutil.move(folder, tmp_path / 'aside')
    broken(folder)
    kept.keep(b'2')
    assert kept.fault.startswith('a cannot be written: ')
    with pytest.raises(OSError, match='exist'):
        kept.require(b'2')
    mended(folder)
    shutil.move(tmp_path / 'aside', folder)
    assert (folder / 'a').read_bytes() == b'1'
    kept.keep(b'3')
    assert (kept.fault, (folder / 'a').read_bytes()) == ('', b'3')


@pytest.mark.slow
def test_flight_goes_on_when_its_journal_cannot_be_written(tmp_path):
    """It is told in the state, orders are taken, and the end is known and written later."""
    folder = tmp_path / 'state'
    air = ready(folder)
    drone = air.drones[1]

    def step():
        drone.step(air.now_s)
        return drone.status(air.now_s)

    air.fly()
    air.until(lambda: step() and air.flight().visited >= 1)
    assert entry(folder).visited == 1
    broken(folder)
    air.until(lambda: 'flight.json cannot be written' in step().text, 60.0)
    drone.commands.hold(air.now_s)
    number = drone.commands.count
    air.until(lambda: step() and drone.commands.outcome(number) is not None, 60.0)
    assert drone.commands.outcome(number) == ''
    drone.commands.resume(air.now_s)
    air.until(lambda: step() and air.flight().outcome is not None)
    assert drone.summary().outcome is FlightOutcome.COMPLETED
    mended(folder)
    air.fly(count=4)
    assert entry(folder).assignment.plan_id == 'p4'
    assert 'cannot be written' not in step().text


def test_no_flight_begins_that_a_restart_would_not_find(tmp_path):
    """Nothing is sent, and the reason is told."""
    folder = tmp_path / 'state'
    air = ready(folder)
    broken(folder)
    air.sent.clear()
    with pytest.raises(ValueError, match='its flight cannot be kept over a restart'):
        air.fly()
    assert air.flight() is None
    assert [m.name for m in air.sent if m.name.startswith('MISSION_COUNT')] == []
    mended(folder)
    air.fly()
    assert air.flight() is not None


def test_delay_that_a_restart_would_not_find_is_refused(tmp_path):
    """It would count again, into the way of others; to withdraw a start is always possible."""
    folder = tmp_path / 'state'
    late = LateStart(folder / 'late_start.json')
    assert late.due_s('route', 0.0, 10.0) == 10.0
    broken(folder)
    with pytest.raises(OSError, match='exist'):
        late.due_s('another', 0.0, 10.0)
    late.forget()
    mended(folder)
    assert late.due_s('route', 5.0, 10.0) == 15.0


def test_signed_link_speaks_on_when_its_time_stamps_cannot_be_written(tmp_path):
    """Stamps rise in memory, and are on disk again within a second of its mending."""
    folder = tmp_path / 'state'
    folder.mkdir()
    path = folder / 'stamps'
    store = TimestampStore(path)
    first = store.next_sent(1000)
    broken(folder)
    later = store.next_sent(1000 + 2 * RESERVE_TICKS)
    store.accept((0, 1, 1), later)
    assert later > first
    assert store.fault.startswith('stamps cannot be written')
    mended(folder)
    last = store.next_sent(later + 2 * RESERVE_TICKS)
    assert store.fault == ''
    assert TimestampStore(path).next_sent(0) > last
