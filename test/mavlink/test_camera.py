# SPDX-License-Identifier: Apache-2.0
"""Shots from three messages, pictures from a folder, and which belongs to which."""

import csv
import math
import os
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test.fakes.fake_autopilot import FakeCopter
from test.mavlink.telemetry import ready

from rocsafe_geo.evidence.shot_store import ShotStore
from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_mavlink.assembly import open_source
from rocsafe_mavlink.camera.camera_trigger import (
    CAPTURED,
    FEEDBACK,
    TRIGGER,
    CameraTrigger,
    TriggerLog,
)
from rocsafe_mavlink.camera.folder_source import FolderSource
from rocsafe_mavlink.camera.geotagging import GeotagContext, Geotagger
from rocsafe_mavlink.camera.numbering import ShotNumbering
from rocsafe_mavlink.camera.pairing import ImagePairing
from rocsafe_mavlink.camera.picture_journal import SHOT_COLUMNS
from rocsafe_mavlink.camera.source import CameraImage
from rocsafe_mavlink.flight.flight_journal import Assignment
from rocsafe_mavlink.knowledge.reducer import reduce
from rocsafe_mavlink.knowledge.telemetry import Attitude, Gps
from rocsafe_mavlink.plan.flight_plan import FlightPlan, FlightWaypoint
from rocsafe_mavlink.wire.dialect import Message, decode, encode

NOW_S = 1_767_225_600.0


def message(name, **fields):
    """Return a message as it comes off the wire."""
    number, payload = encode(Message(name, fields))
    return decode(number, payload, 1, 1)


def feedback(index, taken_s=NOW_S, **fields):
    """Return an autopilot's report of a shot."""
    place = {'lat': 473977420, 'lng': 85455940, 'alt_msl': 518.0, 'alt_rel': 30.0}
    told = {'time_usec': round(taken_s * 1e6), 'img_idx': index, **place, **fields}
    return message(FEEDBACK, **told)


def position(east_m, boot_s):
    """Return a position message so far east of the place."""
    longitude = 85455940 + round(east_m / 0.0075366)
    return message(
        'GLOBAL_POSITION_INT',
        time_boot_ms=round(boot_s * 1000),
        lat=473977420,
        lon=longitude,
        alt=518000,
        relative_alt=30000,
    )


def picture(unix_s, name='a.jpg', jpeg=b''):
    """Return a picture."""
    return CameraImage(name=name, unix_s=unix_s, jpeg=jpeg)


def shot(index, unix_s):
    """Return a shot."""
    place = GeoPosition(47.397742, 8.545594, 565.0)
    return CameraTrigger(
        index=index, unix_s=unix_s, position=place, height_m=30.0, attitude=None, source=FEEDBACK
    )


def test_three_messages_make_one_kind_of_shot():
    """Index, time, place with its datum, attitude after REP 103."""
    vehicle = replace(ready(), geoid_separation_m=47.0)
    captured = {'time_utc': round(NOW_S * 1e6), 'image_index': 4, 'capture_result': 1}
    place = {'lat': 473977420, 'lon': 85455940, 'alt': 518000, 'relative_alt': 30000}
    found = [
        TriggerLog().take(feedback(4, yaw=90.0, pitch=5.0), vehicle, NOW_S)[0],
        TriggerLog().take(message(CAPTURED, **captured, **place), vehicle, NOW_S)[0],
    ]
    log = TriggerLog()
    log.take(position(0.0, 1.0), reduce(vehicle, position(0.0, 200.0), NOW_S)[0], NOW_S)
    found += log.take(message(TRIGGER, time_usec=round(NOW_S * 1e6), seq=4), vehicle, NOW_S)
    for taken in found:
        assert (taken.index, taken.unix_s) == (4, NOW_S)
        assert taken.position.latitude_deg == pytest.approx(47.397742)
        assert taken.height_m == pytest.approx(30.0)
    assert found[0].position.altitude_m == found[1].position.altitude_m == 565.0
    assert found[0].attitude.yaw_rad == pytest.approx(0.0)
    assert found[0].attitude.pitch_rad == pytest.approx(math.radians(-5.0))


def test_uptime_is_no_time_of_day():
    """A shot whose clock was never set is dated by its arrival."""
    (taken,) = TriggerLog().take(feedback(0, 12.5), ready(), NOW_S)
    assert taken.unix_s == NOW_S


def test_lost_reports_are_filled_in_and_marked():
    """Three lost at 10 m/s: each within 0.3 m of where it was taken."""
    log, vehicle = TriggerLog(), ready()
    for tick in range(50):
        moved = reduce(vehicle, position(1.0 * tick, 200.0 + 0.1 * tick), NOW_S)[0]
        log.take(position(1.0 * tick, 200.0 + 0.1 * tick), moved, NOW_S + 0.1 * tick)
    first = log.take(feedback(0, NOW_S), vehicle, NOW_S)
    rest = log.take(feedback(4, NOW_S + 4.0, lng=85455940 + 5307), vehicle, NOW_S + 4.0)
    assert [taken.index for taken in (*first, *rest)] == [0, 1, 2, 3, 4]
    assert [taken.is_interpolated for taken in rest] == [True, True, True, False]
    for number, taken in enumerate(rest[:3], start=1):
        away_m = distance_m(first[0].position, taken.position)
        assert away_m == pytest.approx(10.0 * number, abs=0.3)


def test_report_that_comes_twice_counts_once():
    """Repeated, late and worse reports are not counted; the better kind wins."""
    log, vehicle = TriggerLog(), ready()
    log.take(position(0.0, 1.0), vehicle, NOW_S)
    assert len(log.take(feedback(0), vehicle, NOW_S)) == 1
    assert log.take(feedback(0), vehicle, NOW_S) == []
    assert log.take(message(TRIGGER, time_usec=1, seq=1), vehicle, NOW_S) == []
    assert len(log.take(feedback(1), vehicle, NOW_S)) == 1
    failed = message(CAPTURED, image_index=2, capture_result=0)
    assert log.take(failed, vehicle, NOW_S) == []


@pytest.mark.slow
@given(
    offset_s=st.floats(-40_000.0, 40_000.0),
    gaps=st.lists(st.floats(1.5, 6.0), min_size=6, max_size=15, unique=True),
    lost=st.integers(1, 4),
)
def test_pictures_find_their_shots(offset_s, gaps, lost):
    """Whatever the difference of the clocks; one picture is missing."""
    times = [NOW_S + sum(gaps[:n]) for n in range(len(gaps))]
    shots = [shot(n, time_s) for n, time_s in enumerate(times)]
    pictures = [
        picture(time_s + offset_s, f'{n}.jpg') for n, time_s in enumerate(times) if n != lost
    ]
    pairs = ImagePairing().add(shots, pictures)
    assert {(pair.trigger.index, pair.image.name) for pair in pairs} == {
        (n, f'{n}.jpg') for n in range(len(gaps)) if n != lost
    }


def test_single_picture_of_another_clock_waits():
    """One pair tells nothing of the difference; guesses are not made."""
    pairing = ImagePairing()
    assert pairing.add([shot(0, NOW_S)], [picture(NOW_S + 3600.0)]) == []
    assert pairing.offset_s is None


def test_two_pictures_by_our_clock_find_the_shots_of_a_slow_autopilot():
    """Its clock falls behind by more between them than a pair may differ; ours tells."""
    pairing, found = ImagePairing(), []
    for number, (taken_s, behind_s) in enumerate([(0.0, 3.0), (40.0, 7.0)]):
        reported_s = NOW_S + taken_s + 0.2
        trigger = replace(shot(number, NOW_S + taken_s - behind_s), reported_s=reported_s)
        found += pairing.add([trigger], [picture(NOW_S + taken_s + 0.1, f'{number}.jpg')])
    assert [(pair.trigger.index, pair.image.name) for pair in found] == [
        (0, '0.jpg'),
        (1, '1.jpg'),
    ]


def test_slow_autopilot_that_comes_near_the_camera_by_chance_is_not_believed():
    """Shot 1 by its clock is where picture 0 is; the reports tell which was taken when."""
    shots = [
        replace(shot(number, NOW_S + 4.0 * number - 3.9), reported_s=NOW_S + 4.0 * number)
        for number in range(2)
    ]
    pairing = ImagePairing()
    pairs = pairing.add(shots[:1], [picture(NOW_S, '0.jpg')])
    pairs += pairing.add(shots[1:], [picture(NOW_S + 4.0, '1.jpg')])
    assert [(pair.trigger.index, pair.image.name) for pair in pairs] == [
        (0, '0.jpg'),
        (1, '1.jpg'),
    ]


def test_reports_tell_when_they_came():
    """By our clock, whatever that of the autopilot is."""
    log, vehicle = TriggerLog(), ready()
    log.take(position(0.0, 1.0), vehicle, NOW_S)
    (trigger,) = log.take(feedback(0), vehicle, NOW_S + 5.0)
    assert trigger.reported_s == NOW_S + 5.0


def test_even_times_between_shots_tell_no_pair_where_one_is_missing():
    """Pictures of a camera of another clock fit one shot further on just as well."""
    shots = [shot(number, NOW_S + 4.0 * number) for number in range(5)]
    pictures = [picture(NOW_S + 4.0 * number + 3600.0) for number in range(1, 5)]
    pairing = ImagePairing()
    assert pairing.add(shots, pictures) == []
    assert pairing.offset_s is None


def test_drifting_clock_is_followed():
    """A second in ten minutes, more than a shot may be off."""
    pairing = ImagePairing()
    for number in range(300):
        taken_s = NOW_S + 2.0 * number
        pairs = pairing.add([shot(number, taken_s)], [picture(taken_s * 1.0 + number / 150.0)])
        assert [pair.trigger.index for pair in pairs] == [number]


def jpeg(value=128, size=(48, 64)):
    """Return a grey image file."""
    pixels = np.full((*size, 3), value, np.uint8)
    return cv2.imencode('.jpg', pixels)[1].tobytes()


def leave(folder, name, taken_s, content=None):
    """Leave a file as a camera does."""
    (folder / name).write_bytes(jpeg() if content is None else content)
    os.utime(folder / name, (taken_s, taken_s))


def test_file_is_taken_once_and_only_whole(tmp_path):
    """A file that grows is not read; what is no JPEG never is."""
    folder = FolderSource(tmp_path)
    leave(tmp_path, 'b.jpg', NOW_S + 1.0)
    leave(tmp_path, 'a.JPG', NOW_S)
    leave(tmp_path, 'half.jpg', NOW_S, jpeg()[:200])
    (tmp_path / 'notes.txt').write_text('x')
    assert folder.take() == []
    assert [taken.name for taken in folder.take()] == ['a.JPG', 'b.jpg']
    assert folder.take() == []


def test_source_that_is_none_is_refused():
    """The name is in the message."""
    assert open_source('', lambda: 0.0) is None
    with pytest.raises(ValueError, match="'/nowhere' is no folder"):
        open_source('/nowhere', lambda: 0.0)


def context():
    """Return what a photograph takes from its vehicle."""
    stops = tuple(
        FlightWaypoint(position=GeoPosition(47.397742 + 0.001 * n, 8.545594, 0.0), height_m=30.0)
        for n in range(3)
    )
    assignment = Assignment(
        plan_id='p',
        plan=FlightPlan(waypoints=stops, speed_mps=5.0, takes_photographs=True),
        viewpoint_ids=(7, 8, 9),
    )
    gps = Gps(fix_type=6, horizontal_std_m=0.3, vertical_std_m=0.5)
    return GeotagContext(vehicle='rav1', assignment=assignment, gps=gps, clock_s=100.0)


def test_photograph_has_all_that_places_it(tmp_path):
    """Viewpoint, time of the mission, size; it outlives the process, and its receipt ends it."""
    (tmp_path / 'in').mkdir()
    numbering = ShotNumbering(tmp_path / 'spool')
    made = Geotagger(numbering, FolderSource(tmp_path / 'in'), tmp_path)
    for number in range(2):
        place = {'lat': 473977420 + 10000 * number}
        made.on_message(feedback(number, NOW_S + number, **place), ready(), NOW_S)
        leave(tmp_path / 'in', f'{number}.jpg', NOW_S + number)
    made.tagged(context(), pytest.fail)
    first, second = made.tagged(context(), pytest.fail)
    assert (first.shot_id, first.viewpoint_id, second.viewpoint_id) == ('rav1-00000', 7, 8)
    assert first.time_ns == round((NOW_S + 100.0) * 1e9)
    assert (first.width_px, first.height_px) == (64, 48)
    again = ShotNumbering(tmp_path / 'spool')
    assert again.next_sequence == 2
    assert again.store.overdue(0.0) == [first, second]
    for photograph in (first, second):
        assert again.store.take_receipt(photograph.shot_id, photograph.sha256)
    later = ShotNumbering(tmp_path / 'spool')
    assert (len(later.store), later.next_sequence) == (0, 2)
    with (tmp_path / 'shots.csv').open(newline='') as file:
        rows = list(csv.DictReader(file))
    assert [row['index'] for row in rows] == ['0', '1']
    assert rows[0]['height_above_home_m'] == '30.000'


def test_number_that_was_not_noted_is_not_given_twice(tmp_path):
    """Killed between the photograph and its count: the photograph tells."""
    numbering, (vehicle, source) = ShotNumbering(tmp_path / 'spool'), (ready(), tmp_path / 'in')
    source.mkdir()
    made = Geotagger(numbering, FolderSource(source), None)
    made.on_message(feedback(0), vehicle, NOW_S)
    leave(source, 'a.jpg', NOW_S)
    made.tagged(context(), pytest.fail)
    made.tagged(context(), pytest.fail)
    (tmp_path / 'spool' / 'next.json').unlink()
    assert ShotNumbering(tmp_path / 'spool').next_sequence == 1


def test_full_spool_is_told_and_flight_goes_on(tmp_path):
    """A picture that cannot be kept is named once; the next one has its number."""
    numbering, refused = ShotNumbering(), []
    numbering.store = ShotStore(most_bytes=len(jpeg()))
    made = Geotagger(numbering, FolderSource(tmp_path), None)
    for number in range(2):
        made.on_message(feedback(number, NOW_S + number), ready(), NOW_S)
        leave(tmp_path, f'{number}.jpg', NOW_S + number)
    made.tagged(context(), refused.append)
    kept = made.tagged(context(), refused.append)
    assert [shot.sequence for shot in kept] == [0]
    assert numbering.next_sequence == 1
    (line,) = refused
    assert line.startswith('rav1: 1.jpg is not sent: spool is full')


EASTWARD = Attitude(roll_rad=0.0, pitch_rad=0.0, yaw_rad=0.0)


class Bridge:
    """A geotagger that can be killed, its camera and vehicle, and the time."""

    def __init__(self, folder, clock_ahead_s=0.0):
        self.folder, self.images = folder, folder / 'in'
        self.images.mkdir()
        self.clock_ahead_s, self.now_s = clock_ahead_s, NOW_S
        self.told, self.shots = [], []
        self.vehicle = ready()
        self.start()

    def start(self):
        """Begin, as after a kill: only what is on disk is known."""
        self.numbering = ShotNumbering(self.folder / 'spool')
        self.made = Geotagger(self.numbering, FolderSource(self.images), self.folder)

    def fly(self, seconds, is_up=True):
        """Let the vehicle fly east at 2 m/s, with a position each 0.2 s."""
        for _ in range(round(seconds * 5)):
            self.now_s += 0.2
            if is_up:
                told = position(2.0 * (self.now_s - NOW_S), self.now_s - NOW_S)
                self.vehicle, _ = reduce(self.vehicle, told, self.now_s - NOW_S)
                self.vehicle = replace(self.vehicle, attitude=EASTWARD)
                self.made.on_message(told, self.vehicle, self.now_s, 'p')
        if is_up:
            self.look()

    def shoot(self, index, is_heard=True, is_left=True):
        """Let the camera take a photograph."""
        if is_heard:
            east = {'lng': 85455940 + round(2.0 * (self.now_s - NOW_S) / 0.0075366)}
            said = feedback(index, self.now_s, yaw=90.0, **east)
            self.made.on_message(said, self.vehicle, self.now_s, 'p')
        if is_left:
            leave(self.images, f'{index}.jpg', self.now_s + self.clock_ahead_s)

    def look(self):
        """Make photographs of what is there."""
        self.shots += self.made.tagged(context(), self.told.append)
        self.shots += self.made.tagged(context(), self.told.append)

    def easts_m(self):
        """Return how far east each photograph is placed."""
        start = GeoPosition(47.397742, 8.545594, 0.0)
        return [round(distance_m(start, shot.position), 0) for shot in self.shots]


def test_trigger_without_its_file_yet_survives_a_kill(tmp_path):
    """The file comes after the restart; those that were made are not made again."""
    bridge = Bridge(tmp_path)
    bridge.fly(1.0)
    bridge.shoot(0)
    bridge.fly(3.0)
    bridge.shoot(1, is_left=False)
    leave_at_s = bridge.now_s
    bridge.start()
    leave(bridge.images, '1.jpg', leave_at_s)
    bridge.fly(4.0)
    assert [shot.sequence for shot in bridge.shots] == [0, 1]
    assert bridge.easts_m() == [2.0, 8.0]
    assert bridge.made.pending == 2
    assert bridge.told == []


@pytest.mark.parametrize('clock_ahead_s', [0.0, -4321.0], ids=['same clock', 'other clock'])
def test_pictures_of_triggers_that_nobody_heard_are_placed_by_time(tmp_path, clock_ahead_s):
    """Two of six while the bridge is down: each within half of the way flown meanwhile."""
    bridge = Bridge(tmp_path, clock_ahead_s)
    for index in range(6):
        is_up = index not in (3, 4)
        if index == 5:
            bridge.start()
        bridge.fly(3.0 + 0.4 * index, is_up)
        bridge.shoot(index, is_heard=is_up)
    bridge.fly(20.0)
    assert [shot.sequence for shot in bridge.shots] == list(range(6))
    assert sorted(bridge.easts_m()) == pytest.approx([6, 13, 20, 29, 38, 48], abs=1.5)
    assert [shot.horizontal_std_m > 5.0 for shot in bridge.shots].count(True) == 2
    assert bridge.made.owed(context().assignment, 6) == 6
    assert bridge.told == []


def test_last_triggers_that_nobody_heard_are_placed_too(tmp_path):
    """No report comes after them; the store must get all that the plan says."""
    bridge = Bridge(tmp_path)
    for index in range(3):
        bridge.fly(3.0 + 0.4 * index, is_up=index == 0)
        bridge.shoot(index, is_heard=index == 0)
    bridge.start()
    bridge.fly(10.0)
    assert len(bridge.shots) == 3
    assert bridge.made.owed(context().assignment, 3) == 3


def test_what_is_missing_is_owed_and_named(tmp_path):
    """A trigger without a file, a file that nothing places: named once, never counted as made."""
    bridge = Bridge(tmp_path)
    bridge.fly(2.0)
    bridge.shoot(0)
    bridge.fly(3.0)
    bridge.shoot(1, is_left=False)
    leave(bridge.images, 'old.jpg', NOW_S - 5000.0)
    for _ in range(10):
        bridge.fly(3.0)
    assert bridge.told == [
        'rav1: 1 without a picture: shot 1',
        'rav1: 1 pictures without a place: old.jpg',
    ]
    flown = context().assignment
    along = replace(flown, plan=replace(flown.plan, trigger_distance_m=10.0))
    # Two were triggered; where each stop has one, the report of the third was lost.
    owed = bridge.made.owed
    assert [owed(flown, 0), owed(flown, 2), owed(flown, 3), owed(along, 3)] == [2, 2, 3, 2]
    assert owed(None, 3) == 0
    assert bridge.made.owed(replace(context().assignment, plan_id='other'), 0) == 0
    assert len(bridge.shots) == 1


def test_picture_is_not_placed_where_the_vehicle_may_have_turned(tmp_path):
    """Flown 200 m while the bridge was down: the place is not guessed."""
    bridge = Bridge(tmp_path)
    bridge.fly(2.0)
    bridge.shoot(0)
    bridge.fly(100.0, is_up=False)
    bridge.shoot(1, is_heard=False)
    bridge.fly(5.0, is_up=False)
    bridge.start()
    bridge.fly(8.0)
    bridge.fly(12.0)
    bridge.look()
    assert len(bridge.shots) == 1
    assert bridge.told == ['rav1: 1 pictures without a place: 1.jpg']


def test_kill_between_the_row_and_its_picture_makes_it_once(tmp_path):
    """The row was written, the photograph not kept: it is made at the next start."""
    bridge = Bridge(tmp_path)
    bridge.fly(2.0)
    bridge.shoot(0)
    bridge.numbering.add = lambda _shot: (_ for _ in ()).throw(OSError('killed here'))
    bridge.look()
    bridge.start()
    bridge.fly(2.0)
    assert [shot.sequence for shot in bridge.shots] == [0]
    bridge.start()
    bridge.fly(2.0)
    assert len(bridge.shots) == 1


def test_journal_of_another_version_is_named(tmp_path):
    """Neither overwritten nor half read."""
    (tmp_path / 'shots.csv').write_text('index,unix_s\n1,2\n')
    with pytest.raises(ValueError, match='has other columns'):
        Geotagger(ShotNumbering(), None, tmp_path)
    (tmp_path / 'shots.csv').write_text(','.join(SHOT_COLUMNS) + '\nx,y\n')
    with pytest.raises(ValueError, match='is damaged'):
        Geotagger(ShotNumbering(), None, tmp_path)


def test_distance_trigger_runs_between_first_and_last_waypoint():
    """The fake copter flies 200 m and photographs every 20 m."""
    copter = FakeCopter()
    copter.trigger_m = 20.0
    for _ in range(200):
        copter._fly_past(1.0)
    assert copter.shot_count == 10
