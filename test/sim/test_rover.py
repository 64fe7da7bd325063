# SPDX-License-Identifier: Apache-2.0
"""A simulated ground vehicle drives as planned, and comes home in time by its own readings."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from test.sim.drives import SECOND, driven, parts_of, point_field, route_of, rover_of

from rocsafe_geo.motion.ground_motion import GroundMotion
from rocsafe_sim.driving.caution import CautionOptions, Outlook, reason_to_end
from rocsafe_sim.driving.chassis import Chassis
from rocsafe_sim.driving.drive_journal import read_drive, write_drive
from rocsafe_sim.driving.drive_state import DriveMode, DriveOutcome
from rocsafe_sim.driving.readings import ReadingQueue
from rocsafe_sim.driving.rover import Rover
from rocsafe_sim.driving.way_back import Mark, WayBack
from rocsafe_sim.errors import CommandRefusedError, JournalError

LOOP = ((0.0, 0.0), (12.0, 0.0), (25.0, 3.0), (25.0, 15.0), (6.0, 15.0), (0.0, 0.0))
POST = (20.5, 0.5)


class Wall:
    """A wall across the way at 20 m east."""

    def ground_up_m(self, _east_m, _north_m):
        """Return level ground."""
        return 0.0

    def touched(self, place_enu, radius_m):
        """Return whether a ball touches the wall."""
        return 'wall' if abs(place_enu[0] - 20.0) < 0.2 + radius_m else ''


class Post(Wall):
    """A thin post just behind a bend at 20 m east."""

    def touched(self, place_enu, radius_m):
        """Return whether a ball touches the post."""
        return 'post' if math.dist(place_enu[:2], POST) < 0.05 + radius_m else ''


class Tape(Wall):
    """Barrier tape across the way at 20 m east, just above the vehicle."""

    def touched(self, place_enu, radius_m):
        """Return whether a ball touches the tape."""
        return 'tape' if math.dist(place_enu[::2], (20.0, 0.8)) < radius_m else ''


class Hill:
    """Ground that rises to the east."""

    def __init__(self, grade):
        self.grade = grade

    def ground_up_m(self, east_m, _north_m):
        """Return its height."""
        return self.grade * east_m

    def touched(self, _place_enu, _radius_m):
        """Return that nothing stands there."""
        return ''


def test_line_takes_the_time_of_its_ramps_and_its_cruise():
    """At 0.5 m/s^2 up to 1 m/s: 1 m in 2 s, twice, and the rest at 1 m/s."""
    motion = GroundMotion(acceleration_mps2=0.5)
    assert motion.line_s(10.0, 1.0, 0.0, 0.0) == pytest.approx(2.0 + 8.0 + 2.0)
    assert motion.line_s(0.5, 1.0, 0.0, 0.0) == pytest.approx(2.0 * math.sqrt(0.5 / 0.5))
    assert motion.line_s(10.0, 1.0, 1.0, 1.0) == pytest.approx(10.0)


def test_right_angle_is_turned_in_place_and_a_slight_bend_driven_through():
    """Speed 0 at the one, the limit at the other."""
    motion = GroundMotion()
    places = [(0.0, 0.0), (10.0, 0.0), (20.0, 1.0), (20.0, 11.0)]
    speeds = motion.corner_speeds_mps(places, [1.0] * 4, [False] * 4)
    assert speeds == [0.0, 1.0, 0.0, 0.0]


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(8))
def test_drive_takes_the_time_that_was_planned(seed):
    """Within five in a hundred, with slip, drift and an imperfect receiver."""
    rover = rover_of(parts_of(seed, has_detector=False))
    route = route_of(LOOP, dwells={3: 20.0})
    rover.drive(route)
    shots, _ = driven(rover)
    ledger = rover.state.ledger
    took = (ledger.ended_ns - ledger.began_ns) / SECOND
    assert took == pytest.approx(sum(stop.predicted_s for stop in route.stops), rel=0.05)
    assert ledger.outcome is DriveOutcome.COMPLETED
    assert math.dist(rover.state.place, LOOP[-1]) < 0.15
    assert [shot.evidence for shot in shots] == ['e3']
    assert math.dist(shots[0].place, LOOP[3]) < 0.15
    assert ledger.distance_m == pytest.approx(
        sum(math.dist(a, b) for a, b in pairwise(LOOP)), rel=0.05
    )


def test_step_of_the_simulation_does_not_change_a_drive():
    """Nor its photographs."""
    ends = []
    for step_ns in (SECOND // 10, SECOND // 5, SECOND):
        rover = rover_of(parts_of(has_detector=False))
        rover.drive(route_of(LOOP, dwells={3: 5.0}))
        shots, _ = driven(rover, step_ns=step_ns)
        ends.append((rover.state.place, rover.state.ledger.ended_ns, shots))
    assert ends[0] == ends[1] == ends[2]


def test_other_seed_skids_elsewhere():
    """By centimetres."""
    places = []
    for seed in (1, 2):
        rover = rover_of(parts_of(seed, has_detector=False))
        rover.drive(route_of(((0.0, 0.0), (30.0, 0.0))))
        driven(rover)
        places.append(rover.state.place)
    assert places[0] != places[1]
    assert math.dist(*places) < 0.3


def test_dose_that_was_predicted_is_the_dose_that_is_measured():
    """Where the field is as planned, the drive is completed."""
    rate = point_field(12.0, 8.0, 5e3)
    rover = rover_of()
    route = route_of(LOOP, dwells={3: 10.0}, rate=rate, budget=40.0)
    rover.drive(route)
    _, dose = driven(rover, rate)
    predicted = sum(stop.predicted_usv for stop in route.stops)
    assert rover.state.ledger.outcome is DriveOutcome.COMPLETED
    assert rover.state.ledger.dose_usv == pytest.approx(dose, rel=0.02)
    assert rover.state.ledger.dose_usv == pytest.approx(predicted, rel=0.1)
    assert rover.predicted_usv() == pytest.approx(predicted)


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(12))
def test_budget_is_never_exceeded_where_the_field_is_worse_than_planned(seed):
    """It comes home on its own tracks, wherever it has to turn."""
    strength = 2e3 * 1.6**seed
    rate = point_field(29.0, 9.0, strength)
    planned = point_field(29.0, 9.0, 0.7 * strength)
    rover = rover_of(parts_of(seed))
    plain = route_of(LOOP, dwells={3: 30.0}, rate=planned)
    budget = 1.05 * sum(stop.predicted_usv for stop in plain.stops)
    rover.drive(replace(plain, budget_usv=budget))
    _, dose = driven(rover, rate)
    assert rover.state.ledger.outcome is DriveOutcome.TURNED_BACK_DOSE
    assert 0.3 * budget < dose <= budget
    assert math.dist(rover.state.place, LOOP[0]) < 0.5
    assert rover.state.mode is DriveMode.ARRIVED


def test_dose_rate_at_the_wall_turns_it_back_at_once():
    """Long before its budget is used."""
    rate = point_field(40.0, 0.0, 1e5)
    rover = rover_of()
    rover.drive(route_of(((0.0, 0.0), (38.0, 0.0), (0.0, 0.0)), rate=rate, budget=1e6, wall=1e3))
    driven(rover, rate)
    assert rover.state.ledger.outcome is DriveOutcome.TURNED_BACK_DOSE
    assert rover.state.ledger.distance_m == pytest.approx(2.0 * 30.0, abs=3.0)


@pytest.mark.parametrize(('factor', 'text'), [(4.0, 'it took'), (0.2, 'it took')])
def test_readings_outside_of_the_prediction_stop_it(factor, text):
    """It stands, so that its route can be planned anew."""
    planned = point_field(15.0, 9.0, 3e3)
    rover = rover_of()
    route = route_of(LOOP, dwells={3: 10.0}, rate=planned, budget=6.0)
    rover.drive(route)
    driven(rover, lambda place: factor * planned(place))
    assert rover.state.ledger.outcome is DriveOutcome.DOSE_UNEXPECTED
    assert text in rover.state.ledger.text
    assert rover.state.mode is DriveMode.HOLDING


def test_it_stops_before_what_stands_in_its_way():
    """And tells where that is; the route around it is driven from there."""
    rover = rover_of(parts_of(surroundings=Wall(), has_detector=False))
    rover.drive(route_of(((0.0, 0.0), (40.0, 0.0), (0.0, 0.0)), limit_mps=1.5))
    driven(rover)
    ledger = rover.state.ledger
    assert ledger.outcome is DriveOutcome.BLOCKED
    assert 18.5 < rover.state.east_m < 19.45
    assert all(abs(east - 20.0) < 1.0 for east, _ in ledger.blocked)
    assert len(ledger.blocked) > 5
    home = route_of((rover.state.place, (0.0, 0.0)))
    rover.drive(replace(home, route_id='drive-2'))
    driven(rover)
    assert rover.state.ledger.outcome is DriveOutcome.COMPLETED


def test_post_behind_a_bend_is_seen_before_the_bend():
    """The way is looked along, not one place ahead on the present line."""
    rover = rover_of(parts_of(surroundings=Post(), has_detector=False))
    rover.drive(route_of(((0.0, 0.0), (20.0, 0.0), (40.0, 6.0)), limit_mps=1.5))
    driven(rover)
    assert rover.state.ledger.outcome is DriveOutcome.BLOCKED
    assert math.dist(rover.state.place, POST) > 0.5 + 0.5 * Chassis().width_m


def test_tape_above_it_is_driven_below():
    """Its clearance is beside it, not above it."""
    rover = rover_of(parts_of(surroundings=Tape(), has_detector=False))
    rover.drive(route_of(((0.0, 0.0), (40.0, 0.0)), limit_mps=1.5))
    driven(rover)
    assert rover.state.ledger.outcome is DriveOutcome.COMPLETED


def test_slope_takes_charge_and_a_steep_one_time():
    """A route tells its speeds; motors do not reach them where it is steep."""
    ends = []
    for grade in (0.0, 0.1, 0.5):
        surroundings = Hill(grade) if grade else None
        rover = rover_of(parts_of(surroundings=surroundings, has_detector=False))
        rover.drive(route_of(((0.0, 0.0), (40.0, 0.0))))
        driven(rover)
        ends.append((rover.state.charge_j, rover.state.ledger.ended_ns))
    (level_j, level_ns), (gentle_j, gentle_ns), (steep_j, steep_ns) = ends
    assert level_j > gentle_j > steep_j
    assert gentle_ns == level_ns
    assert steep_ns > 1.05 * level_ns


def test_battery_that_gets_low_brings_it_home():
    """With its reserve."""
    chassis = Chassis(endurance_s=60.0)
    rover = rover_of(parts_of(chassis=chassis))
    rover.drive(route_of(((0.0, 0.0), (40.0, 0.0), (0.0, 0.0))))
    driven(rover, lambda _place: 0.1)
    assert rover.state.ledger.outcome is DriveOutcome.BATTERY_LOW
    assert rover.state.charge_j > 0.0
    assert rover.state.mode is DriveMode.ARRIVED


def test_detector_that_falls_silent_brings_it_home():
    """It does not drive on blind."""
    rover = rover_of()
    rover.drive(route_of(((0.0, 0.0), (60.0, 0.0), (0.0, 0.0))))
    driven(rover, None)
    assert rover.state.ledger.outcome is DriveOutcome.TURNED_BACK_DOSE
    assert 'silent' in rover.state.ledger.text
    assert rover.state.ledger.distance_m < 40.0


@pytest.mark.parametrize(('slope', 'text'), [(0.5, 'reads 10.'), (math.inf, 'is saturated')])
def test_concentration_at_the_level_turns_it_back_by_its_own_gas_sensor(slope, text):
    """Though nothing of it was predicted; what is saturated is above any level."""
    rover = rover_of(parts_of(has_detector=False))
    way = route_of(((0.0, 0.0), (38.0, 0.0), (0.0, 0.0)))
    rover.drive(replace(way, turn_back_ppm=10.0))
    most = drive_in_gas(rover, lambda east: 0.0 if east < 1.0 else slope * east)
    assert rover.state.ledger.outcome is DriveOutcome.TURNED_BACK_GAS
    assert f'electrochemical_chlorine {text}' in rover.state.ledger.text
    assert rover.state.mode is DriveMode.ARRIVED
    assert math.dist(rover.state.place, (0.0, 0.0)) < 0.5
    # It brakes at 0.5 m/s2 from 1 m/s, and learns of it a second later.
    assert most < (22.5 if math.isfinite(slope) else 3.5)


def test_gas_below_the_level_or_without_a_level_ends_no_drive():
    """The level is that of the route."""
    for level in (0.0, 20.0):
        rover = rover_of(parts_of(has_detector=False))
        way = route_of(((0.0, 0.0), (38.0, 0.0), (0.0, 0.0)))
        rover.drive(replace(way, turn_back_ppm=level))
        drive_in_gas(rover, lambda east: 0.5 * east)
        assert rover.state.ledger.outcome is DriveOutcome.COMPLETED


def test_gas_sensors_that_fall_silent_bring_it_home_where_it_has_a_level():
    """As a silent detector does."""
    rover = rover_of(parts_of(has_detector=False))
    way = route_of(((0.0, 0.0), (60.0, 0.0), (0.0, 0.0)))
    rover.drive(replace(way, turn_back_ppm=10.0))
    driven(rover, None)
    assert rover.state.ledger.outcome is DriveOutcome.TURNED_BACK_GAS
    assert 'silent' in rover.state.ledger.text


def test_a_gas_sensor_that_tells_no_concentration_is_silent():
    """NaN, as of one that reads in another unit, is no reading: neither low nor saturated."""
    rover = rover_of(parts_of(has_detector=False))
    way = route_of(((0.0, 0.0), (60.0, 0.0), (0.0, 0.0)))
    rover.drive(replace(way, turn_back_ppm=10.0))
    drive_in_gas(rover, lambda east: east * math.nan)
    assert rover.state.ledger.outcome is DriveOutcome.TURNED_BACK_GAS
    assert 'silent' in rover.state.ledger.text


def test_sensor_that_has_not_warmed_up_is_not_waited_for():
    """Once it has given a reading it is, until it is given up."""
    queue = ReadingQueue(1.2, is_awaited=False)
    assert queue.has_all(100 * SECOND)
    queue.add(100 * SECOND, 0.5)
    assert queue.has_all(101 * SECOND)
    assert not queue.has_all(102 * SECOND)
    assert queue.due(102 * SECOND) == [(100 * SECOND, 0.5)]
    queue.give_up()
    assert queue.has_all(102 * SECOND)
    queue.add(102 * SECOND, 0.5)
    assert not queue.has_all(104 * SECOND)
    assert not ReadingQueue(1.2).has_all(2 * SECOND)


def drive_in_gas(rover, ppm):
    """Drive to the end in a concentration by the distance east; return how far east it came."""
    most = 0.0
    while not (rover.is_over and rover.is_idle):
        assert rover.state.time_ns < 1000 * SECOND
        rover.step(rover.state.time_ns + SECOND)
        most = max(most, rover.state.east_m)
        rover.read_gas('electrochemical_chlorine', ppm(rover.state.east_m))
    return most


def test_hold_resume_return_and_cancel():
    """Each only where it has a meaning."""
    rover = rover_of(parts_of(has_detector=False))
    for command in (rover.hold, rover.resume, rover.return_home):
        with pytest.raises(CommandRefusedError):
            command()
    rover.drive(route_of(((0.0, 0.0), (30.0, 0.0), (0.0, 0.0))))
    rover.step(rover.state.time_ns + 10 * SECOND)
    rover.hold()
    rover.step(rover.state.time_ns + 5 * SECOND)
    stands = rover.state.place
    rover.step(rover.state.time_ns + 5 * SECOND)
    assert rover.state.place == stands
    assert rover.is_idle
    rover.resume()
    rover.step(rover.state.time_ns + 5 * SECOND)
    assert rover.state.east_m > stands[0] + 2.0
    rover.return_home()
    driven(rover)
    assert rover.state.ledger.outcome is DriveOutcome.RETURNED_EARLY
    assert math.dist(rover.state.place, (0.0, 0.0)) < 0.3


def test_other_route_is_refused_until_it_replaces():
    """And one that begins elsewhere always."""
    rover = rover_of(parts_of(has_detector=False))
    rover.drive(route_of(((0.0, 0.0), (30.0, 0.0))))
    other = replace(route_of(((0.0, 0.0), (0.0, 20.0))), route_id='drive-2')
    with pytest.raises(CommandRefusedError, match='another route'):
        rover.drive(other)
    rover.drive(other, replaces=True)
    driven(rover)
    assert math.dist(rover.state.place, (0.0, 20.0)) < 0.3
    with pytest.raises(CommandRefusedError, match='from here'):
        rover.drive(route_of(((0.0, 0.0), (30.0, 0.0))))


def test_restarted_process_drives_on_as_if_nothing_had_happened(tmp_path):
    """From its journal."""
    ends = []
    for is_killed in (False, True):
        rover = rover_of(parts_of(has_detector=False))
        rover.drive(route_of(LOOP, dwells={3: 5.0}))
        rover.step(rover.state.time_ns + 20 * SECOND)
        if is_killed:
            write_drive(tmp_path / 'drive.json', rover.state)
            state = read_drive(tmp_path / 'drive.json')
            rover = Rover(parts_of(has_detector=False), state)
        shots, _ = driven(rover)
        ends.append((rover.state.place, rover.state.ledger, [shot.sequence for shot in shots]))
    assert ends[0] == ends[1]


def test_damaged_journal_is_refused(tmp_path):
    """Naming the file."""
    path = tmp_path / 'drive.json'
    assert read_drive(path) is None
    path.write_text('{"format": 1, "time_ns": "now"}')
    with pytest.raises(JournalError, match=r'drive\.json'):
        read_drive(path)


def test_way_back_has_no_loops():
    """A drive around a square comes back over its first corner at once."""
    way = WayBack([Mark(east_m=0.0, north_m=0.0, limit_mps=1.0)])
    around = [(float(k), 0.0) for k in range(1, 11)]
    around += [(10.0, float(k)) for k in range(1, 11)]
    around += [(10.0 - k, 10.0) for k in range(1, 11)]
    for place in around:
        way.note(place, 1.0, 1.0)
        way.measure(1.0)
    assert way.dose_usv == pytest.approx(30.0)
    for k in range(1, 11):
        way.note((0.0, 10.0 - k), 1.0, 1.0)
        way.measure(1.0)
    assert [mark.place for mark in way.homeward] == [(0.0, 0.0)]
    assert way.dose_usv <= 1.0


def outlook(*, dose_usv, predicted_usv, rest_usv, back_usv, is_hotter=False, ratio=0.0):
    """Return what a drive with a budget of 100 uSv has taken, and would take."""
    return Outlook(
        budget_usv=100.0, turn_back_usvh=1e5, dose_usv=dose_usv, rate_usvh=1.0, growth=1.0,
        predicted_usv=predicted_usv, predicted_line_usv=predicted_usv, rest_usv=rest_usv,
        is_rest_hotter=is_hotter, hotter_ratio=ratio, back_usv=back_usv, rest_j=0.0, back_j=0.0,
        charge_j=1e6, is_at_stop=False,
    )  # fmt: skip


def test_what_is_confirmed_of_a_prediction_is_trusted_for_its_rest():
    """Three quarters behind, as predicted: 22 more of 100 are not given up for a doubt of 25 %.

    At the beginning they are, and so they are if more was taken than predicted.
    """
    options = CautionOptions()
    late = outlook(dose_usv=74.0, predicted_usv=74.0, rest_usv=22.0, back_usv=21.0)
    assert reason_to_end(late, options) is None
    early = outlook(dose_usv=0.5, predicted_usv=0.5, rest_usv=85.0, back_usv=80.0)
    assert reason_to_end(early, options)[0] is DriveOutcome.TURNED_BACK_DOSE
    more = outlook(dose_usv=74.0, predicted_usv=60.0, rest_usv=22.0, back_usv=21.0)
    assert reason_to_end(more, options)[0] is DriveOutcome.TURNED_BACK_DOSE


@pytest.mark.parametrize(('ratio', 'goes_on'), [(1.15, True), (1.7, False), (0.0, False)])
def test_hotter_rest_is_doubted_by_what_the_router_stated(ratio, goes_on):
    """45 of 100 taken as predicted, 40 more to come from a hotter place: 47 at most, or 68."""
    half = outlook(
        dose_usv=45.0,
        predicted_usv=45.0,
        rest_usv=40.0,
        back_usv=44.0,
        is_hotter=True,
        ratio=ratio,
    )
    assert (reason_to_end(half, CautionOptions()) is None) is goes_on


@pytest.mark.parametrize(
    ('rate', 'growth', 'goes_on'),
    [(6e4, 1.0, True), (6e4, 1.8, False), (1e5, 0.5, False), (4e4, 9.0, True)],
)
def test_dose_rate_that_will_reach_the_level_turns_it_back(rate, growth, goes_on):
    """Before it is there: it grows by as much again, at most to the double, until it stands."""
    calm = outlook(dose_usv=0.0, predicted_usv=0.0, rest_usv=0.0, back_usv=0.0)
    now = replace(calm, rate_usvh=rate, growth=growth)
    assert (reason_to_end(now, CautionOptions()) is None) is goes_on


def test_first_readings_tell_nothing_of_a_prediction():
    """After a detour the tracks home are long and hot, the planned rest is neither."""
    start = outlook(dose_usv=0.01, predicted_usv=0.0, rest_usv=20.0, back_usv=160.0)
    assert reason_to_end(start, CautionOptions()) is None


def test_way_back_takes_the_dose_that_was_measured_for_it():
    """Over its many marks as fast as over the few stops of the way there."""
    rover = rover_of()
    rover.drive(route_of((*LOOP[:-1], (6.0, 40.0))))
    while rover.state.place[1] < 38.0:
        rover.step(rover.state.time_ns + SECOND // 5)
        rover.read(rover.state.time_ns, 100.0)
    taken, back = rover.state.ledger.dose_usv, rover._way.dose_usv
    rover.return_home()
    driven(rover, lambda _place: 100.0)
    assert rover.state.ledger.dose_usv - taken == pytest.approx(back, rel=0.04)


def test_dose_while_it_waits_for_a_route_counts_in_the_next_drive():
    """It stands where it was stopped, and its budget is for all of its trip."""
    rover = rover_of(parts_of(surroundings=Wall()))
    rover.drive(route_of(((0.0, 0.0), (40.0, 0.0))))
    driven(rover, lambda _place: 100.0)
    assert rover.state.ledger.outcome is DriveOutcome.BLOCKED
    for _ in range(360):
        rover.step(rover.state.time_ns + SECOND)
        rover.read(rover.state.time_ns, 100.0)
    rover.drive(replace(route_of((rover.state.place, (0.0, 0.0))), route_id='drive-2'))
    assert rover.state.ledger.dose_usv == pytest.approx(10.0, rel=0.01)
