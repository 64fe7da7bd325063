# SPDX-License-Identifier: Apache-2.0
"""A flight is checked, sent, flown and ended by name, against the fake copter."""

import math
from dataclasses import replace

import pytest
from test.mavlink.sky import TARGET, US, Sky
from test.mavlink.telemetry import after, heartbeat, ready

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_mavlink.autopilots.ardupilot import AUTO, COPTER, RTL
from rocsafe_mavlink.autopilots.parameters import ParameterReader
from rocsafe_mavlink.autopilots.px4 import MULTICOPTER
from rocsafe_mavlink.checks.check import CheckVerdict, failures
from rocsafe_mavlink.checks.preflight import preflight
from rocsafe_mavlink.flight.flight import FlightStage, adopted, fly
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome, failsafe_of
from rocsafe_mavlink.flight.flight_signs import home_moved
from rocsafe_mavlink.flight.vehicle_commands import VehicleCommands
from rocsafe_mavlink.knowledge.telemetry import Battery
from rocsafe_mavlink.plan.fence import Fence
from rocsafe_mavlink.plan.flight_limits import FlightLimits, VehicleSettings
from rocsafe_mavlink.plan.flight_plan import FlightPlan, FlightWaypoint, mission_of

HOME = GeoPosition(47.397742, 8.545594)
NOW_S = 100.0
COMMANDS = VehicleCommands(autopilot=COPTER, target=TARGET, us=US)
UNFENCED = VehicleSettings(fence=Fence())


def plan(count=3, **options):
    """Return a plan of waypoints 50 m apart to the north."""
    waypoints = tuple(
        FlightWaypoint(position=offset(HOME, 0.0, 50.0 * (number + 1)), height_m=30.0)
        for number in range(count)
    )
    return FlightPlan(waypoints=waypoints, speed_mps=10.0, **options)


class Trip:
    """A sky with one flight in it."""

    def __init__(self, flown, **options):
        self.sky = Sky(**options)
        self.sky.ask_for_rates()
        self.sky.run(lambda: self.sky.copter.up_s > 45.0)
        self.flight, sent = fly(flown, COMMANDS, self.sky.vehicle, self.sky.now_s)
        self.sky.give(sent)
        self.visits = [0]

    def step(self):
        """Let a tenth of a second pass."""
        for message in self.sky.step():
            self.flight, sent = self.flight.on_message(message, self.sky.now_s)
            self.sky.give(sent)
        self.flight, sent = self.flight.on_tick(self.sky.vehicle, self.sky.now_s)
        self.sky.give(sent)
        self.visits.append(self.flight.visited)

    def until(self, condition, limit_s=400.0):
        """Step until `condition` holds."""
        end_s = self.sky.now_s + limit_s
        while not condition():
            assert self.sky.now_s < end_s, self.flight
            self.step()

    def fly_on(self, visited=1):
        """Step until so many waypoints are behind."""
        self.until(lambda: self.flight.visited >= visited)

    def end(self, limit_s=400.0):
        """Step until the flight is over; return it."""
        self.until(lambda: self.flight.is_over, limit_s)
        return self.flight


def test_whole_flight_is_completed():
    """Every waypoint, counted up one by one, and only the commands it takes."""
    trip = Trip(plan(takes_photographs=True))
    ended = trip.end()
    assert (ended.outcome, ended.reason, ended.visited) == (FlightOutcome.COMPLETED, '', 3)
    assert trip.visits == sorted(trip.visits)
    assert set(trip.visits) == {0, 1, 2, 3}
    assert [number for number in trip.sky.copter.commands if number != 511] == [176, 400, 176, 300]


def test_lost_reached_events_are_made_up_for():
    """Progress follows the current item when no item is ever reported reached."""
    trip = Trip(plan())
    say = trip.sky.copter._say

    def say_less(name, **fields):
        if name != 'MISSION_ITEM_REACHED':
            say(name, **fields)

    trip.sky.copter._say = say_less
    assert trip.end().outcome is FlightOutcome.COMPLETED


@pytest.mark.slow
@pytest.mark.parametrize(
    ('fault', 'outcome'),
    [
        (lambda copter: copter.lose_battery(), FlightOutcome.FAILSAFE_BATTERY),
        (lambda copter: copter.breach_fence(), FlightOutcome.FAILSAFE_FENCE),
        (lambda copter: setattr(copter, 'has_gps', False), FlightOutcome.FAILSAFE_GPS),
        (lambda copter: copter.lose_remote(), FlightOutcome.FAILSAFE_OTHER),
    ],
    ids=['battery', 'fence', 'receiver', 'remote control'],
)
def test_failsafe_ends_by_its_name(fault, outcome):
    """The autopilot's words say why, and nothing is sent against it."""
    trip = Trip(plan(12))
    trip.fly_on()
    sent = list(trip.sky.copter.commands)
    fault(trip.sky.copter)
    ended = trip.end()
    assert ended.outcome is outcome
    assert failsafe_of(ended.reason) is outcome
    assert 0 < ended.visited < 12
    assert trip.sky.copter.commands == sent


def test_lost_link_is_not_resumed():
    """The copter returned while nobody listened; that it is heard again sends nothing."""
    trip = Trip(plan(12), fs_gcs_enable=True)
    trip.fly_on()
    sent = list(trip.sky.copter.commands)
    trip.sky.is_station_alive = False
    trip.until(lambda: trip.sky.vehicle.custom_mode == RTL)
    trip.sky.is_station_alive = True
    assert trip.end().outcome is FlightOutcome.FAILSAFE_LINK
    assert trip.sky.copter.commands == sent


def test_silence_in_flight_is_waited_out():
    """Twenty seconds without a word: progress is taken from the vehicle, not from memory."""
    trip = Trip(plan(4))
    trip.fly_on()
    trip.sky.copter.is_silent = True
    until_s = trip.sky.now_s + 20.0
    trip.until(lambda: trip.sky.now_s > until_s)
    assert trip.flight.visited == 1
    trip.sky.copter.is_silent = False
    assert trip.end().outcome is FlightOutcome.COMPLETED


@pytest.mark.slow
def test_silence_for_ever_is_lost():
    """After ten minutes the flight ends as lost, with what was known."""
    trip = Trip(plan(4))
    trip.fly_on(2)
    trip.sky.copter.is_silent = True
    ended = trip.end(700.0)
    assert (ended.outcome, ended.visited) == (FlightOutcome.LOST, 2)
    assert 'nothing heard for 600 s' in ended.reason


def test_return_by_order_is_aborted():
    """Who ordered it is told; the waypoints behind are kept."""
    trip = Trip(plan(12))
    trip.fly_on(2)
    trip.sky.copter.mode = RTL
    trip.flight = trip.flight.stopped()
    ended = trip.end()
    assert (ended.outcome, ended.visited) == (FlightOutcome.ABORTED_BY_OPERATOR, 2)


def test_refused_arming_is_rejected_in_its_own_words():
    """Nothing is left armed."""
    trip = Trip(plan())
    trip.sky.copter.has_gps = False
    ended = trip.end()
    assert ended.outcome is FlightOutcome.REJECTED
    assert 'Arm: Need Position Estimate' in ended.reason
    assert not trip.sky.copter.is_armed


def test_refused_mission_is_not_armed():
    """An autopilot without room for it says so before any motor turns."""
    trip = Trip(plan(700))
    ended = trip.end()
    assert ended.outcome is FlightOutcome.REJECTED
    assert ended.reason == 'mission not taken: no space for so many items'
    assert 400 not in trip.sky.copter.commands


def test_home_that_moved_at_arming_is_rejected():
    """Heights above home would not be those that were planned: the motors go off again."""
    trip = Trip(plan())
    planned = replace(trip.sky.vehicle.home, altitude_msl_m=480.0)
    elsewhere = replace(trip.sky.vehicle, home=planned)
    trip.flight, sent = fly(plan(), COMMANDS, elsewhere, trip.sky.now_s)
    trip.sky.give(sent)
    ended = trip.end()
    assert ended.outcome is FlightOutcome.REJECTED
    assert 'home moved 0.0 m and 8.0 m in height' in ended.reason
    assert not trip.sky.copter.is_armed
    assert 400 in trip.sky.copter.commands
    assert home_moved(planned, None)


def test_accepted_but_not_shown_is_not_believed():
    """An acknowledgement without a heartbeat that shows it ends on the ground."""
    trip = Trip(plan())
    trip.sky.copter._on_mode = lambda _message: 0
    ended = trip.end()
    assert ended.outcome is FlightOutcome.REJECTED
    assert 'heartbeats do not show it' in ended.reason


@pytest.mark.slow
@pytest.mark.parametrize('number', [176, 400, 300])
def test_lost_answers_are_made_up_for(number):
    """An order that was carried out without an answer is seen in what the vehicle does."""
    trip = Trip(plan())
    say = trip.sky.copter._say

    def say_less(name, **fields):
        if name != 'COMMAND_ACK' or fields['command'] != number:
            say(name, **fields)

    trip.sky.copter._say = say_less
    assert trip.end().outcome is FlightOutcome.COMPLETED


def test_flight_that_cannot_be_called_back_is_watched():
    """The start is refused, yet it flies and cannot be disarmed: it is not called over."""
    trip = Trip(plan(2))
    trip.sky.copter._on_start = lambda _message: 4
    trip.until(lambda: trip.flight.stage is FlightStage.FLYING)
    assert trip.sky.vehicle.is_armed
    ended = trip.end()
    assert (ended.outcome, ended.visited) == (FlightOutcome.COMPLETED, 2)


def stored(sky):
    """Return the mission that lies on the copter."""
    return tuple(sky.copter.missions.stored[0])


def test_started_again_it_finds_its_flight_and_sends_nothing():
    """Killed in the air: the mission read back and the current item tell all."""
    trip = Trip(plan(6))
    trip.fly_on(3)
    sent = list(trip.sky.copter.commands)
    mission = stored(trip.sky)
    trip.flight = adopted(plan(6), COMMANDS, trip.sky.vehicle, mission)
    trip.step()
    assert trip.flight.visited >= 3
    assert trip.end().outcome is FlightOutcome.COMPLETED
    assert trip.sky.copter.commands == sent


def test_other_flights_are_not_taken_over():
    """Neither another mission nor a vehicle that stands."""
    trip = Trip(plan(6))
    trip.fly_on()
    assert adopted(plan(5), COMMANDS, trip.sky.vehicle, stored(trip.sky)) is None
    standing = after(heartbeat(), vehicle=trip.sky.vehicle)
    assert adopted(plan(6), COMMANDS, standing, stored(trip.sky)) is None


def test_armed_vehicle_is_not_sent_off():
    """A flight begins on the ground, from a known home."""
    with pytest.raises(ValueError, match='is armed'):
        fly(plan(), COMMANDS, after(heartbeat(AUTO, armed=True), vehicle=ready()), NOW_S)
    with pytest.raises(ValueError, match='has not told its home'):
        fly(plan(), COMMANDS, replace(ready(), home=None), NOW_S)


@pytest.mark.parametrize(
    ('kind', 'first', 'begins'), [(COPTER, 4, [16, 22, 178, 115]), (MULTICOPTER, 2, [22, 178])]
)
def test_mission_has_home_where_it_is_wanted(kind, first, begins):
    """Take-off, speed, where to look, waypoints with their photographs, return."""
    mission = mission_of(plan(2, takes_photographs=True), kind)
    assert [item.command for item in mission.items] == [*begins, 16, 203, 16, 203, 20]
    assert mission.waypoint_items == (first, first + 2)
    assert [mission.visited(number) for number in (-1, first, first + 1, 99)] == [0, 1, 1, 2]
    item = mission.items[first]
    assert (item.frame, item.y_e7, item.z_m) == (6, 85455940, 30.0)
    # Of no item is the frame one that goes with a place, where it has none.
    assert {i.frame for i in mission.items if i.command in (20, 115, 178, 203)} == {2}


def test_px4_is_told_where_to_go_after_its_climb():
    """It flies to the place of its take-off, wherever that is; an ArduCopter does not."""
    takeoff, _, first, *_ = mission_of(plan(2), MULTICOPTER).items
    assert (takeoff.x_e7, takeoff.y_e7, takeoff.z_m) == (first.x_e7, first.y_e7, first.z_m)
    _, takeoff, *_ = mission_of(plan(2), COPTER).items
    assert (takeoff.x_e7, takeoff.y_e7, takeoff.z_m) == (0, 0, first.z_m)


def test_heading_is_that_of_the_plan():
    """PX4 finds it in each waypoint, an ArduCopter is told when it changes."""
    ways = [
        replace(waypoint, heading_deg=heading)
        for waypoint, heading in zip(plan(4).waypoints, (45.0, 45.0, 225.0, 0.0), strict=True)
    ]
    flown = replace(plan(4), waypoints=tuple(ways))
    px4, copter = mission_of(flown, MULTICOPTER).items, mission_of(flown, COPTER).items
    told = [item.parameters[3] for item in px4 if item.command in (16, 22)]
    assert told == [45.0, 45.0, 45.0, 225.0, 0.0]
    turns = [(n, item.parameters[0]) for n, item in enumerate(copter) if item.command == 115]
    assert turns == [(3, 45.0), (6, 225.0), (8, 0.0)]


ON, OFF, SHOT, PASS = 'on', 'off', 'shot', ''


@pytest.mark.parametrize(
    ('way', 'told'),
    [
        # Two lanes and the leg between them.
        (
            [(0, 0), (0, 20), (0, 40), (0, 60), (30, 60), (30, 40), (30, 20)],
            [ON, PASS, PASS, OFF, ON, PASS, OFF],
        ),
        # A corner ends one lane and begins the next.
        ([(0, 0), (0, 20), (0, 40), (20, 40), (40, 40)], [ON, PASS, ON, PASS, OFF]),
        # No three in line: one photograph at each.
        ([(0, 0), (0, 20), (20, 20), (20, 40)], [SHOT, SHOT, SHOT, SHOT]),
        ([(0, 0)], [SHOT]),
    ],
)
def test_camera_is_triggered_by_distance_along_lanes_only(way, told):
    """On at once after the first waypoint of a lane, off after its last."""
    waypoints = tuple(
        FlightWaypoint(position=offset(HOME, float(east), float(north)), height_m=30.0)
        for east, north in way
    )
    flown = FlightPlan(waypoints=waypoints, speed_mps=10.0, trigger_distance_m=20.0)
    assert shutter_words(flown) == told


def test_bend_is_not_photographed():
    """It ends a lane, though the way goes straight on there."""
    waypoints = [
        FlightWaypoint(
            position=offset(HOME, 0.0, 20.0 * number), height_m=30.0, is_bend=number == 3
        )
        for number in range(7)
    ]
    flown = FlightPlan(waypoints=tuple(waypoints), speed_mps=10.0, trigger_distance_m=20.0)
    assert shutter_words(flown) == [ON, PASS, OFF, PASS, ON, PASS, OFF]


def shutter_words(flown):
    """Return what the camera is told after each waypoint of a mission."""
    told = []
    for item in mission_of(flown, COPTER).items[4:-1]:
        if item.command == 16:
            told.append(PASS)
        elif item.command == 203:
            told[-1] = SHOT
        else:
            assert item.command == 206
            told[-1] = ON if item.parameters == (20.0, 0.0, 1.0, 0.0) else OFF
    return told


def verdicts(vehicle, flown=None, **limits):
    """Return the checks that did not pass."""
    checks = preflight(vehicle, COPTER, flown or plan(), FlightLimits(**limits), NOW_S, UNFENCED)
    return {check.name for check in checks if check.verdict is CheckVerdict.FAIL}, failures(checks)


def fence_check(**known):
    """Return the look at the fence before `plan()`."""
    checks = preflight(ready(), COPTER, plan(), FlightLimits(), NOW_S, VehicleSettings(**known))
    return next(check for check in checks if check.name == 'within fence')


def test_fence_is_read_before_a_flight():
    """Until then the flight waits; one that cannot be read forbids it, with words."""
    unread = fence_check()
    assert (unread.verdict, unread.value, unread.may_pass_soon) == (
        CheckVerdict.FAIL,
        'not read yet',
        True,
    )
    assert fence_check(fence=Fence()).verdict is CheckVerdict.PASS
    silent = fence_check(fence_error='no answer to a count')
    assert (silent.verdict, silent.value) == (
        CheckVerdict.FAIL,
        'cannot be read: no answer to a count',
    )


def test_leg_across_an_exclusion_is_outside():
    """Though both its ends are where a vehicle may be."""
    places = [waypoint.position for waypoint in plan().waypoints]
    near = [offset(places[0], *step) for step in ((-5.0, 9.0), (5.0, 9.0), (5.0, 12.0))]
    check = fence_check(fence=Fence(exclusions=(tuple(near),)))
    assert (check.verdict, check.may_pass_soon) == (CheckVerdict.FAIL, False)
    assert 'legs partly outside' in check.value


@pytest.mark.parametrize(
    ('found', 'failed'),
    [
        ({}, {}),
        ({'FENCE_ALT_MAX': 25.0}, {'height of the fence': 'FENCE_ALT_MAX = 25'}),
        ({'FENCE_RADIUS': 120.0}, {'radius of the fence': 'FENCE_RADIUS = 120'}),
        ({'FENCE_RADIUS': 120.0, 'FENCE_TYPE': 1.0}, {}),
        ({'FENCE_RADIUS': 120.0, 'FENCE_ENABLE': 0.0}, {}),
        ({'FENCE_TYPE': None}, {}),
        ({'FENCE_RADIUS': None}, {}),
    ],
)
def test_fence_of_parameters_is_kept(found, failed):
    """Height and radius about home, as far as they are on; unanswered they are warned of."""
    on = {'FENCE_ENABLE': 1.0, 'FENCE_TYPE': 7.0, 'FENCE_RADIUS': 300.0, 'FENCE_ALT_MAX': 100.0}
    told = {name: value for name, value in {**on, **found}.items() if value is not None}
    reader = ParameterReader(kind=COPTER.name, target=TARGET, found=told, asks=6)
    known = VehicleSettings(fence=Fence(), parameters=reader)
    checks = preflight(ready(), COPTER, plan(), FlightLimits(), NOW_S, known)
    values = {check.name: check.value for check in checks if check.verdict is CheckVerdict.FAIL}
    assert values == failed


def test_ready_vehicle_passes():
    """Only what a simulator does not tell, and what was not read yet, is warned of."""
    checks = preflight(ready(), COPTER, plan(), FlightLimits(), NOW_S, UNFENCED)
    assert {check.name for check in checks if check.verdict is not CheckVerdict.PASS} == {
        'geoid',
        'settings',
    }
    assert failures(checks) == ''


@pytest.mark.parametrize(
    ('changes', 'name'),
    [
        ({'heartbeat_s': NOW_S - 4.0}, 'contact'),
        ({'is_armed': True}, 'motors'),
        ({'ekf_flags': 37}, 'fix'),
        ({'is_prearm_ok': False}, 'self-test'),
        ({'battery': Battery(fraction=0.2)}, 'charge'),
        ({'battery': Battery(fraction=math.nan)}, 'charge'),
        ({'home': None}, 'home'),
    ],
    ids=lambda value: value if isinstance(value, str) else '',
)
def test_unready_vehicle_fails_by_name(changes, name):
    """Each thing that is wrong is named with its value and limit."""
    failed, text = verdicts(replace(ready(), **changes))
    # Too little charge is also too little energy.
    assert failed - {'energy'} == {name}
    assert text.startswith(f'{name} is ')


@pytest.mark.parametrize(
    ('limits', 'text'),
    [
        (
            {'max_height_agl_m': 25.0},
            'heights is 30 to 30 m: must be 5 m above home to 25 m above the ground',
        ),
        ({'furthest_m': 100.0}, 'distance is 150 m from home: must be at most 100 m'),
        (
            {'longest_s': 60.0},
            (
                'duration is 80 s: must be at most 60 s; '
                'energy is 80% charged: must be 143% for this flight, its reserve included'
            ),
        ),
        (
            {'longest_s': 110.0},
            'energy is 80% charged: must be 82% for this flight, its reserve included',
        ),
    ],
)
def test_wild_plan_fails(limits, text):
    """What an autopilot would accept is refused here."""
    assert verdicts(ready(), **limits)[1] == text


@pytest.mark.parametrize(
    ('make', 'words'),
    [
        (lambda: FlightPlan(waypoints=(), speed_mps=5.0), 'at least one waypoint'),
        (lambda: FlightPlan(waypoints=plan().waypoints, speed_mps=math.nan), 'speed_mps is nan'),
        (lambda: FlightWaypoint(position=HOME, height_m=-1.0), 'height_m is -1'),
        (lambda: FlightWaypoint(position=HOME, height_m=9.0, hold_s=math.inf), 'hold_s is inf'),
    ],
)
def test_wrong_plan_is_not_made(make, words):
    """Every number is looked at before anything is sent."""
    with pytest.raises(ValueError, match=words):
        make()


def test_words_of_failsafes():
    """What was cleared is no cause."""
    assert failsafe_of('GCS Failsafe Cleared') is None
    assert failsafe_of('GCS Failsafe') is FlightOutcome.FAILSAFE_LINK
    assert failsafe_of('Mission: 1 Takeoff') is None
    # All that a Rover says.
    for words in ('Battery 1 is low 10.60V used 9 mAh', 'Battery 2 is critical 9.8V used 9 mAh'):
        assert failsafe_of(words) is FlightOutcome.FAILSAFE_BATTERY
    assert failsafe_of('Battery 2 is missing, last: 9.80V used 9 mAh') is None
    for words in (
        'Crash: Going to HOLD',
        # Wherever it stands: some autopilots say who speaks first.
        'Navigation of vehicle one says: Crash: Going to HOLD',
        'Radio Failsafe',
        'Failsafe: Terrain data missing',
        'Some new failsafe: landing',
    ):
        assert failsafe_of(words) is FlightOutcome.FAILSAFE_OTHER
    for words in (
        'PreArm: Radio failsafe on',
        'Arm: Battery failsafe',
        'Failsafe warning triggered',
    ):
        assert failsafe_of(words) is None
