# SPDX-License-Identifier: Apache-2.0
"""The picture of a mission: what is old never looks new, and an order names what was seen."""

import json
import math
import struct
from io import BytesIO

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from rocsafe_console.picture import track as track_module
from rocsafe_console.picture.alarms import ERROR, MOST_KEPT, WARN, Alarms
from rocsafe_console.picture.coordinates import coordinates_of, position_of_ecef, zone_of
from rocsafe_console.picture.estimates import BatteryDrain, Trend, way_home_s
from rocsafe_console.picture.frame_bytes import (
    HEAD,
    OLD_DOSE,
    OLD_PLACE,
    VEHICLE,
    VehicleFrame,
    frame_of,
)
from rocsafe_console.picture.freshness import MissionClock
from rocsafe_console.picture.gas import GasNow
from rocsafe_console.picture.map_image import DOSE, Grid, corners_of, png_of
from rocsafe_console.picture.picture import MissionNow, Picture, Reading
from rocsafe_console.picture.sections import Sections, message_of
from rocsafe_console.picture.track import MOST_POINTS, Track
from rocsafe_console.picture.vehicle import Holder, VehicleReport
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition, ecef_m

FLYING, HOLDING, LANDED, LOST = 4, 5, 8, 9
WALL_S = 1.8e9


def report(
    name: str = 'rav1', state: int = FLYING, stamp_s: float = 10.0, **more
) -> VehicleReport:
    """Return the state of a vehicle."""
    return VehicleReport(name=name, state=state, stamp_s=stamp_s, **more)


def mission(stamp_s: float, name: str = 'm1', phase: int = 2) -> MissionNow:
    """Return the state of a mission."""
    return MissionNow(mission_id=name, phase=phase, stamp_s=stamp_s)


def flown() -> Picture:
    """Return a picture whose mission's clock has been heard from 0 to 10 s, at 1 s a second."""
    picture = Picture()
    for second in range(11):
        picture.on_mission(mission(float(second)), WALL_S + second)
    return picture


def test_a_message_kept_for_late_subscribers_is_old():
    """A stamp from before the first word of the mission's clock is never taken for alive."""
    picture = flown()
    picture.on_report(report(stamp_s=-5.0), WALL_S + 10.0)
    assert picture.vehicles['rav1'].frame(WALL_S + 10.0).age_s == math.inf
    picture.on_report(report(stamp_s=10.0), WALL_S + 10.0)
    assert picture.vehicles['rav1'].frame(WALL_S + 10.5).age_s == pytest.approx(0.5)


def test_an_age_is_that_of_the_stamp_and_not_of_its_arrival():
    """A message that is delayed by 6 s is 6 s old when it arrives."""
    picture = flown()
    picture.on_report(report(stamp_s=4.0), WALL_S + 10.0)
    assert picture.vehicles['rav1'].frame(WALL_S + 10.0).age_s == pytest.approx(6.0)


def test_without_a_clock_nothing_is_live():
    """No word of the mission yet: whatever arrives may have been kept."""
    picture = Picture()
    picture.on_report(report(), WALL_S)
    assert picture.vehicles['rav1'].frame(WALL_S).age_s == math.inf


@pytest.mark.slow
@given(st.lists(st.tuples(st.floats(0, 1e3), st.floats(0, 1e3)), max_size=30), st.floats(0, 2e3))
def test_a_stamp_is_never_younger_than_its_arrival(marks, stamp_s):
    """Whatever the clock did, the time found is not after the time of arrival."""
    clock, wall_s = MissionClock(), 0.0
    for stamp, passed in marks:
        wall_s += passed
        clock.mark(stamp, wall_s)
    assert clock.wall_of(stamp_s, wall_s) <= wall_s


def test_what_was_kept_for_late_subscribers_is_old_until_the_clock_is_seen_to_run():
    """After a restart the first word of the mission may be of any age."""
    picture = Picture()
    picture.on_mission(mission(10.0), WALL_S)
    for stamp_s in (9.0, 10.0, 11.0):
        picture.on_report(report(stamp_s=stamp_s), WALL_S)
        assert picture.frames(WALL_S)[0].age_s == math.inf
    # Several states of the mission may have been kept, and come one after the other.
    for number in range(1, 8):
        picture.on_mission(mission(10.0 + 0.5 * number), WALL_S + 0.1 * number)
        picture.on_report(report(stamp_s=14.0), WALL_S + 0.1 * number)
    assert picture.frames(WALL_S + 0.7)[0].age_s == math.inf
    picture.on_mission(mission(14.5), WALL_S + 1.0)
    picture.on_report(report(stamp_s=13.0), WALL_S + 1.0)
    assert picture.frames(WALL_S + 1.0)[0].age_s == math.inf
    picture.on_report(report(stamp_s=14.6), WALL_S + 1.1)
    assert picture.frames(WALL_S + 1.1)[0].age_s == 0.0


def test_a_place_or_a_dose_may_be_old_alone():
    """A vehicle that is heard may have lost its receiver or its detector."""
    picture = flown()
    picture.on_report(report(), WALL_S + 10.0)
    vehicle = picture.vehicles['rav1']
    assert vehicle.frame(WALL_S + 10.0).flags == OLD_PLACE | OLD_DOSE
    picture.on_fix('rav1', (53.0, -9.0, 60.0), 10.5, WALL_S + 10.5)
    picture.on_dose('rav1', 3.0, 10.5, WALL_S + 10.5, is_lower_limit=False)
    picture.on_reading(
        Reading(vehicle='rav1', stamp_s=10.5, dose_rate_usvh=7.0, std_usvh=0.1,
                latitude_deg=53.0, longitude_deg=-9.0, detector='nai'),
        WALL_S + 10.5,
    )  # fmt: skip
    frame = vehicle.frame(WALL_S + 13.0)
    assert (frame.flags, frame.dose_rate_usvh) == (0, 7.0)
    picture.on_report(report(stamp_s=14.0), WALL_S + 14.0)
    frame = vehicle.frame(WALL_S + 14.0)
    assert (frame.age_s, frame.flags) == (0.0, OLD_PLACE)
    assert math.isnan(frame.dose_rate_usvh)
    # What it flies after its detector has fallen silent has no dose rate.
    picture.on_fix('rav1', (53.001, -9.0, 60.0), 21.0, WALL_S + 21.0)
    assert vehicle.frame(WALL_S + 21.0).flags == OLD_DOSE
    assert math.isnan(vehicle.track.points[-1][2])
    # What DDS has kept is as old as its stamp.
    picture.on_dose('rav1', 3.0, 5.0, WALL_S + 22.0, is_lower_limit=False)
    assert vehicle.frame(WALL_S + 22.0).flags & OLD_DOSE


def test_a_state_of_the_mission_that_was_kept_is_none_of_now():
    """Coverage and phase would look live for three seconds after a restart."""
    picture = Picture()
    picture.on_mission(mission(10.0), WALL_S)
    assert picture.mission_heard_s == -math.inf
    picture.on_mission(mission(10.5), WALL_S + 1.0)
    assert picture.mission_heard_s == WALL_S + 1.0


def test_the_worst_gas_reading_is_kept_by_its_unit():
    """Noise below the limit of detection is no reading; ppm and mg/m3 are two lists."""
    picture = flown()
    plain = {'vehicle': 'rav1', 'std': 1.0, 'sensor': 'pid', 'calibration_gas': 'isobutylene',
             'latitude_deg': 53.0, 'longitude_deg': -9.0}  # fmt: skip
    for stamp_s, value, unit, is_below in (
        (1.0, 9.0, 'ppm', True), (2.0, 5.0, 'ppm', False), (3.0, 4.0, 'ppm', False),
        (4.0, 70.0, 'mg/m³', False), (5.0, math.nan, 'ppm', False),
    ):  # fmt: skip
        reading = GasNow(stamp_s=stamp_s, value=value, unit=unit, is_below_limit=is_below, **plain)
        picture.on_gas(reading, WALL_S + stamp_s)
    mass, volume = picture.gas.to_plain()
    assert (mass['unit'], mass['worst']['value']) == ('mg/m³', 70.0)
    assert (volume['worst']['value'], volume['newest']['value']) == (5.0, 4.0)
    assert volume['worst']['forms']['mgrs']


def test_the_revision_rises_with_state_and_holder_only():
    """An order is refused if the vehicle is no longer what the operator saw."""
    picture = flown()
    picture.on_report(report(), WALL_S)
    first = picture.vehicles['rav1'].revision
    picture.on_report(report(battery_fraction=0.5, stamp_s=11.0), WALL_S)
    picture.on_fix('rav1', (53.0, -9.0, 60.0), 11.0, WALL_S)
    assert picture.vehicles['rav1'].revision == first
    picture.on_report(report(state=HOLDING), WALL_S)
    picture.on_holder('rav1', Holder(holder='a', lease='x/1', epoch=1), WALL_S)
    assert picture.vehicles['rav1'].revision == first + 2


def test_another_mission_begins_from_nothing_and_old_orders_do_not_fit_it():
    """Its sections are told as null; revisions of the same name are higher."""
    picture = flown()
    picture.on_report(report(), WALL_S)
    picture.sections.put('plan', {'plan_id': 'p'})
    seen = picture.vehicles['rav1'].revision
    change = picture.sections.newest
    after = picture.next_one()
    assert not after.vehicles
    assert after.sections.after(change)['plan'] == 'null'
    after.on_report(report(), WALL_S)
    assert after.vehicles['rav1'].revision > seen


def test_a_lost_vehicle_is_one_alarm_until_somebody_has_seen_it():
    """It is told once, and again after it was seen and has happened again."""
    picture = flown()
    picture.on_report(report(), WALL_S)
    for state in (LOST, FLYING, LOST):
        picture.on_report(report(state=state), WALL_S)
    assert [alarm['severity'] for alarm in picture.alarms.to_plain()] == [ERROR]
    picture.acknowledge(1, 'anna', WALL_S + 1.0)
    for state in (FLYING, LOST):
        picture.on_report(report(state=state), WALL_S)
    assert len(picture.alarms) == 2
    assert picture.acknowledge(1, 'bert', WALL_S + 9.0).seen_by == 'anna'


def test_alarms_that_nobody_has_seen_are_forgotten_last():
    """A flood of alarms that are seen drops none that is not."""
    alarms = Alarms()
    alarms.raise_one(0.0, ERROR, 'rav1', 'first')
    for number in range(2 * MOST_KEPT):
        alarm = alarms.raise_one(0.0, WARN, '', f'{number}')
        alarms.acknowledge(alarm.number, 'anna', 1.0)
    assert len(alarms) == MOST_KEPT
    assert alarms.to_plain()[0]['text'] == 'first'
    with pytest.raises(ValueError, match='there is none'):
        alarms.acknowledge(10**6, 'anna', 1.0)


def test_no_number_of_an_alarm_comes_twice():
    """Whoever presses *Seen* as another mission begins acknowledges nothing else."""
    picture = flown()
    numbers = [picture.alarm(WALL_S, ERROR, '', text).number for text in 'abc']
    after = picture.next_one()
    numbers.append(after.alarm(WALL_S, ERROR, '', 'd').number)
    numbers.append(Picture(first_revision=numbers[-1]).alarm(WALL_S, ERROR, '', 'e').number)
    assert sorted(set(numbers)) == numbers
    with pytest.raises(ValueError, match='there is none'):
        after.acknowledge(numbers[0], 'anna', WALL_S)


def test_the_worst_reading_stays_and_the_newest_follows():
    """Both with vehicle and place; the worst is of the whole mission."""
    picture = flown()
    picture.on_report(report(), WALL_S)
    for stamp_s, rate in ((11.0, 5.0), (12.0, 80.0), (13.0, 2.0)):
        reading = Reading(
            vehicle='rav1', stamp_s=stamp_s, dose_rate_usvh=rate, std_usvh=0.0,
            latitude_deg=53.0, longitude_deg=-9.0, detector='ideal',
        )  # fmt: skip
        picture.on_reading(reading, WALL_S + stamp_s)
    picture.refresh()
    dose = picture.sections.value('dose')
    assert (dose['worst']['dose_rate_usvh'], dose['newest']['dose_rate_usvh']) == (80.0, 2.0)


@pytest.mark.slow
@given(
    st.integers(0, 999), st.integers(0, 11), st.floats(-90, 90), st.floats(-180, 180),
    st.floats(-500, 3000) | st.just(math.nan), st.floats(0, 1) | st.just(math.nan),
    st.floats(0, 6000) | st.just(math.inf),
)  # fmt: skip
def test_a_frame_tells_what_was_packed(number, state, latitude, longitude, height, battery, age):
    """To the step of each field; what is unknown stays unknown."""
    packed = VehicleFrame(
        number=number, state=state, latitude_deg=latitude, longitude_deg=longitude,
        height_m=height, battery_fraction=battery, age_s=age,
    ).pack()  # fmt: skip
    got = VEHICLE.unpack(packed)
    assert got[:2] == (number, state)
    assert got[3] * 1e-7 == pytest.approx(latitude, abs=6e-8)
    assert got[4] * 1e-7 == pytest.approx(longitude, abs=6e-8)
    if math.isnan(height):
        assert got[5] == 0x7FFF
    else:
        assert got[5] * 0.1 == pytest.approx(height, abs=0.051)
    assert (got[7] == 0xFF) if math.isnan(battery) else abs(got[7] - 100 * battery) <= 0.51
    assert (got[9] == 0xFFFF) if math.isinf(age) else abs(got[9] - 10 * age) <= 0.51


def test_the_size_of_a_frame_is_that_which_the_page_reads():
    """static/link.js has the same numbers: 24 bytes each."""
    assert (HEAD.size, VEHICLE.size) == (24, 24)
    data = frame_of([VehicleFrame(number=7, state=4).pack()], 5, 2.0, math.nan)
    assert len(data) == 48
    assert data[:2] == b'P\x01'
    assert struct.unpack_from('<HI', data, 2) == (1, 5)
    with pytest.raises(ValueError, match='number = 70000'):
        VehicleFrame(number=70000, state=4)


def test_sections_are_sent_only_after_they_change():
    """A page gets what changed after what it has; NaN is null."""
    sections = Sections()
    assert sections.put('a', {'x': math.nan})
    assert not sections.put('a', {'x': math.inf})
    before = sections.newest
    sections.put('b', 1)
    assert sections.after(before) == {'b': '1'}
    told = json.loads(message_of(sections.after(0), 'hello'))
    assert told == {'kind': 'hello', 'sections': {'a': {'x': None}, 'b': 1}}


# From mgrs.js 2.1 of proj4js, which is written apart from this.
MGRS = [
    (21.309433, -157.916861, '4QFJ1234056779'),
    (0.0, 0.0, '31NAA6602100000'),
    (38.8895, -77.0353, '18SUJ2347806483'),
    (-33.8568, 151.2153, '56HLH3490052288'),
    (60.0, 5.0, '32VKM7697958157'),
    (53.28, -9.0633, '29UMV9577903420'),
    (78.2, 15.6, '33XWG1369680760'),
    (-54.8, -68.3, '19FEV4500027239'),
    (35.0, 179.99, '60SYD7288577129'),
]


@pytest.mark.parametrize(('latitude', 'longitude', 'text'), MGRS)
def test_mgrs_of_known_places(latitude, longitude, text):
    """Both hemispheres, the exceptions of the grid, and near the 180th meridian."""
    assert coordinates_of(latitude, longitude).mgrs.replace(' ', '') == text


def test_zones_of_norway_and_svalbard():
    """The exceptions of the grid."""
    assert [zone_of(60.0, 4.0), zone_of(78.0, 8.0), zone_of(78.0, 10.0), zone_of(78.0, 40.0)] == [
        32, 31, 33, 37,
    ]  # fmt: skip


def test_seconds_of_an_angle_are_never_sixty():
    """What rounds to 60 seconds is a minute more."""
    forms = coordinates_of(53.9999999, -9.0)
    assert forms.dms == '54°00\u203200.00\u2033N 9°00\u203200.00\u2033W'
    assert forms.decimal == '54.000000, -9.000000'
    assert coordinates_of(89.0, 0.0).mgrs == ''
    with pytest.raises(ValueError, match='latitude 91'):
        coordinates_of(91.0, 0.0)


def test_the_origin_of_the_map_comes_back_from_the_frames():
    """Earth-centred coordinates and back."""
    x, y, z = ecef_m(53.28, -9.06, 40.0)[0]
    place = position_of_ecef(x, y, z)
    assert (place.latitude_deg, place.longitude_deg) == pytest.approx((53.28, -9.06), abs=1e-9)
    assert place.altitude_m == pytest.approx(40.0, abs=1e-4)


def test_the_picture_of_the_dose_map_is_north_up_and_lies_where_its_cells_lie():
    """One hot cell in the north-west of two rows and three columns."""
    grid = Grid(cells=[0, 0, 0, 100, 0, -1], columns=3, corner_m=(0.0, 0.0), cell_m=10.0)
    picture = Image.open(BytesIO(png_of(grid, DOSE)))
    assert picture.size == (3, 2)
    assert picture.getpixel((0, 0))[3] > 0
    assert [picture.getpixel((x, 1))[3] for x in range(3)] == [0, 0, 0]
    assert '#' + bytes(picture.getpixel((0, 0))[:3]).hex() == DOSE.stops()[-1][1]
    frame = LocalFrame(GeoPosition(53.0, -9.0, 0.0))
    south_west, north_east = corners_of(grid, frame)
    east, north, _ = frame.to_enu(*(north_east[0], north_east[1], 0.0))[0]
    assert south_west == pytest.approx((53.0, -9.0))
    assert (east, north) == pytest.approx((30.0, 20.0), abs=1e-3)
    with pytest.raises(ValueError, match='full rows'):
        Grid(cells=[1, 2, 3], columns=2, corner_m=(0.0, 0.0), cell_m=1.0)


def test_a_track_is_thinned_but_keeps_its_peak():
    """The highest dose rate is never lost, and the size has a limit."""
    track = Track()
    for step in range(3 * MOST_POINTS):
        track.note(53.0 + step * 2e-5, -9.0, 500.0 if step == 3001 else 1.0)
    assert len(track.points) <= MOST_POINTS + 1
    assert max(point[2] for point in track.points) == 500.0


def test_a_track_is_encoded_once_for_all_pages(monkeypatch):
    """Also when it was thinned meanwhile; 300 tracks for each page held up all others."""
    encoded = []
    text_of = track_module._text_of
    monkeypatch.setattr(track_module, '_text_of', lambda p: encoded.append(p) or text_of(p))
    track = Track()
    for step in range(MOST_POINTS + 10):
        track.note(53.0 + step * 2e-5, -9.0, math.nan if step % 2 else 0.25)
        if step % 100 == 0 or step > MOST_POINTS - 2:
            told = json.loads(track.text)
            assert told == json.loads(track.text)
            assert told == [[round(p[0], 7), p[1], None if p[2] != p[2] else p[2]]
                            for p in track.points]  # fmt: skip
    assert len(encoded) == MOST_POINTS + len(track.points)


def test_what_is_left_to_fly_is_the_time_left():
    """A hold of eight minutes left "0 s" of a survey of eight, with 77 per cent to be flown."""
    picture = flown()
    north = [[53.0 + 0.001 * step, -9.0] for step in range(5)]
    route = {
        'home': north[0], 'line': [*north, north[0]], 'duration_s': 400.0,
        'viewpoints': [[*place, 0.0] for place in north[1:]],
    }  # fmt: skip
    picture.on_plan({'plan_id': 'p1', 'routes': {'rav1': route, 'rav2': route}})

    def left_s(**rav1: object) -> float:
        picture.on_report(report(plan_id='p1', **rav1), WALL_S + 11)
        picture.refresh()
        return picture.sections.value('progress')['left_s']

    assert left_s(latitude_deg=53.0, longitude_deg=-9.0) == pytest.approx(400.0)
    left_s(viewpoint_count=4, viewpoints_visited=1)
    progress = picture.sections.value('progress')
    # A mission without cameras had no coverage.
    assert (progress['visited'], progress['viewpoints']) == (1, 4)
    # Halfway between the second and third of four viewpoints, 5.5 of 8 legs are left.
    picture.on_fix('rav1', (53.0025, -9.0, 50.0), 10.0, WALL_S + 10)
    held_s = left_s(viewpoints_visited=2, state=HOLDING)
    assert held_s == pytest.approx(400.0 * 5.5 / 8.0, rel=1e-3)
    for second in range(12, 500):
        picture.on_mission(mission(float(second)), WALL_S + second)
    assert left_s(viewpoints_visited=2, state=HOLDING) == held_s
    # The rest of a lost vehicle is in the next plan, and one that waits has all before it.
    assert left_s(state=LOST) == 0.0
    picture.on_report(report('rav2', state=1), WALL_S + 11)
    assert left_s(state=LOST) == pytest.approx(400.0)
    picture.on_report(report('rav2', plan_id='p2'), WALL_S + 11)
    assert left_s(state=LANDED) == 0.0


def test_what_people_order_is_among_the_decisions():
    """The page told what the orchestrator had decided, and not what its people had."""
    picture = flown()
    picture.on_order('anna', 'hold', {'rav1': 'done', 'rav2': 'silent'})
    (told,) = picture.sections.value('decisions')
    assert (told['by'], told['verb'], told['outcomes']['rav2']) == ('anna', 'hold', 'silent')
    assert not picture.alarms.to_plain()


def test_estimates_of_a_vehicle():
    """A battery that loses a tenth in 100 s lasts 800 s more at 80 per cent."""
    drain = BatteryDrain()
    for time_s, fraction in ((0.0, 0.9), (50.0, 0.85), (100.0, 0.8)):
        drain.note(time_s, fraction)
    assert drain.left_s == pytest.approx(800.0)
    drain.note(101.0, 1.0)
    assert math.isnan(drain.left_s)
    assert way_home_s(600.0, 10.0) == 60.0
    trend = Trend()
    for time_s in range(30):
        trend.note(float(time_s), 1.0 + time_s)
    assert trend.word == 'rising'
