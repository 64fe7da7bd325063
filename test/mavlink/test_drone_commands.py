# SPDX-License-Identifier: Apache-2.0
"""Orders, parameters, fences and predictions: what is sent, what is refused, what is believed."""

import math
import struct
from dataclasses import replace

import pytest
from pymavlink.dialects.v20 import ardupilotmega as library
from test.fakes.fake_autopilot import HOME
from test.mavlink.telemetry import heartbeat, ready, said
from test.mavlink.test_flight import plan
from test.mavlink.test_station import Air, ready_air

from rocsafe_geo.position import GeoPosition, distance_m, offset
from rocsafe_mavlink.autopilots.ardupilot import AUTO, BRAKE, COPTER, GUIDED, ROVER
from rocsafe_mavlink.autopilots.parameters import Parameter, ParameterReader
from rocsafe_mavlink.autopilots.px4 import MULTICOPTER, OFFBOARD
from rocsafe_mavlink.checks.check import CheckVerdict, failures
from rocsafe_mavlink.checks.preflight import preflight
from rocsafe_mavlink.drone.commands import DroneCommands
from rocsafe_mavlink.errors import CommandRefusedError
from rocsafe_mavlink.flight.flight_journal import FlightJournal
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome
from rocsafe_mavlink.flight.vehicle_commands import VehicleCommands
from rocsafe_mavlink.knowledge.prediction import predict
from rocsafe_mavlink.knowledge.reducer import reduce
from rocsafe_mavlink.knowledge.telemetry import Home, Landed
from rocsafe_mavlink.plan.fence import Circle, Fence, fence_items, fence_of
from rocsafe_mavlink.plan.flight_limits import FlightLimits, VehicleSettings
from rocsafe_mavlink.protocols.mission_item import MissionItem
from rocsafe_mavlink.protocols.onboard_mission import OnboardMission
from rocsafe_mavlink.wire.dialect import Message

TARGET, US = (1, 1), (255, 190)
PLACE = GeoPosition(*HOME)
HOME_OF = Home(latitude_deg=HOME[0], longitude_deg=HOME[1], altitude_msl_m=488.0)
FREE = lambda _vehicle, _now_s: ''  # noqa: E731


def numbers_of(sequence):
    """Return the numbers of the commands of a sequence."""
    return [step.call.command['command'] for step in sequence.steps if hasattr(step, 'call')]


def flying(air, visited=1):
    """Fly until so many waypoints are behind."""
    air.wait(46.0)
    air.fly(count=6)
    air.until(lambda: air.flight().visited >= visited)
    return air.drones[1].commands


def done(air, commands):
    """Let an order come to its end; return its error."""
    air.until(lambda: commands.outcome(commands.count) is not None, 150.0)
    return commands.outcome(commands.count)


def test_hold_within_a_mission_keeps_the_mode():
    """ArduPilot pauses; outside a mission it brakes, since LOITER obeys a stick."""
    made = VehicleCommands(autopilot=COPTER, target=TARGET, us=US)
    on_mission = reduce(ready(), heartbeat(AUTO, armed=True), 100.0)[0]
    assert numbers_of(made.hold(on_mission)) == [193]
    guided = reduce(ready(), heartbeat(GUIDED, armed=True), 100.0)[0]
    (step,) = made.hold(guided).steps
    assert (step.call.command['command'], step.call.command['param2']) == (176, float(BRAKE))
    px4 = VehicleCommands(autopilot=MULTICOPTER, target=TARGET, us=US)
    assert numbers_of(px4.hold(on_mission)) == [176]


@pytest.mark.slow
@pytest.mark.parametrize('visited', [0, 6], ids=['climbing', 'returning'])
def test_what_cannot_pause_brakes(visited):
    """A copter that climbs or returns within its mission refuses to pause; it stands all the same.

    Then it goes on as it was.
    """
    air = Air()
    commands = flying(air, visited)
    air.until(lambda: air.copters[1].height_m > 5.0)
    commands.hold(air.now_s)
    assert done(air, commands) == ''
    assert air.copters[1].mode == BRAKE
    place = air.copters[1].place, air.copters[1].height_m
    air.wait(5.0)
    assert (air.copters[1].place, air.copters[1].height_m) == place
    commands.resume(air.now_s)
    assert done(air, commands) == ''
    assert air.copters[1].mode == AUTO
    air.until(lambda: air.flight().is_over)
    assert (air.flight().outcome, air.flight().visited) == (FlightOutcome.COMPLETED, 6)


def test_go_to_is_written_for_each_autopilot():
    """ArduPilot wants GUIDED first and a height above home, PX4 one command and the sea's."""
    first, second = (
        VehicleCommands(autopilot=COPTER, target=TARGET, us=US)
        .go_to(PLACE, 30.0, HOME_OF, FREE)
        .steps
    )
    assert first.call.command['param2'] == float(GUIDED)
    assert (second.call.command['frame'], second.call.command['z']) == (6, 30.0)
    assert second.call.command['x'] == 473977420
    (only,) = (
        VehicleCommands(autopilot=MULTICOPTER, target=TARGET, us=US)
        .go_to(PLACE, 30.0, HOME_OF, FREE)
        .steps
    )
    assert (only.call.command['frame'], only.call.command['z']) == (5, 518.0)
    assert OFFBOARD not in {only.call.command.fields.get('param2')}


@pytest.mark.slow
@pytest.mark.parametrize('loss', [0.0, 0.2, 0.4])
def test_orders_are_obeyed_over_a_lossy_link(loss):
    """Held, resumed, slowed: an order ends well only if the vehicle shows it."""
    air = Air()
    commands = flying(air)
    air.loss = loss
    commands.hold(air.now_s)
    error = done(air, commands)
    assert not error or loss == 0.4
    if not error:
        # Where every pause was lost it was switched to BRAKE.
        assert air.copters[1].is_paused or air.copters[1].mode == BRAKE
        commands.resume(air.now_s)
        assert not done(air, commands) or loss == 0.4


def test_landing_takes_the_place_of_a_slower_order():
    """What is urgent does not wait; what is not, does."""
    air = Air()
    commands = flying(air)
    commands.change_speed(5.0, air.now_s)
    with pytest.raises(CommandRefusedError, match='speed is under way'):
        commands.resume(air.now_s)
    commands.land(air.now_s)
    assert commands.count == 2
    assert done(air, commands) == ''
    assert air.copters[1].mode == 9


@pytest.mark.slow
@pytest.mark.parametrize('verb', ['hold', 'resume', 'return_home', 'land'])
def test_order_that_is_given_twice_is_one_order(verb):
    """The first is not called off by the second, and nothing is sent twice."""
    once, twice = Air(), Air()
    for air in (once, twice):
        commands = flying(air)
        count = commands.count
        if verb == 'resume':
            commands.hold(air.now_s)
            assert done(air, commands) == ''
            count += 1
        getattr(commands, verb)(air.now_s)
        if air is twice:
            air.wait(0.1)
            getattr(commands, verb)(air.now_s)
        assert commands.count == count + 1
        assert done(air, commands) == ''
    assert twice.copters[1].commands == once.copters[1].commands


def test_refusal_carries_the_words_of_the_autopilot():
    """Paused in a mode that cannot pause."""
    air = Air()
    commands = flying(air)
    air.copters[1].is_paused = False
    commands.resume(air.now_s)
    assert done(air, commands) == ''
    commands.return_home(air.now_s)
    assert done(air, commands) == ''
    commands.resume(air.now_s)
    assert done(air, commands) == ''
    assert air.copters[1].mode == AUTO
    # Not from a return that we did not command.
    air.copters[1].mode = 6
    air.wait(2.0)
    with pytest.raises(CommandRefusedError, match='not ours to command: it is in RTL'):
        commands.resume(air.now_s)


@pytest.mark.slow
@pytest.mark.parametrize('unread', [{'home': None}, {'landed': Landed.UNDEFINED}, {}])
def test_route_is_called_none_only_when_all_is_read_that_tells_of_one(unread):
    """A bridge that was started again finds its flight by mission, home and landed state."""
    air = Air()
    commands = flying(air)
    session = air.drones[1].session
    session.flight, session.readout.mission = None, OnboardMission(items=())
    session.telemetry = replace(session.telemetry, **unread)
    wanted = 'it is still being read' if unread else 'no route is being flown'
    with pytest.raises(CommandRefusedError, match=wanted):
        commands.resume(air.now_s)


def test_nothing_is_ordered_by_the_suite_itself():
    """A flight through failsafes, losses and returns: only what began it was ever sent."""
    air = Air()
    flying(air)
    air.copters[1].lose_battery()
    air.until(lambda: air.flight().is_over)
    sent = [number for number in air.copters[1].commands if number != 511]
    assert sent == [176, 400, 176, 300]


@pytest.mark.parametrize(
    ('names', 'speed'),
    [({'WP_SPD': 8.0}, 'WP_SPD'), ({'WPNAV_SPEED': 800.0}, 'WPNAV_SPEED')],
)
def test_parameters_are_read_in_both_spellings(names, speed):
    """The unit follows from the spelling that answered."""
    reader = ParameterReader(kind=COPTER.name, target=TARGET, found={})
    reader, asked = reader.on_tick(0.0)
    assert {'WP_SPD', 'WPNAV_SPEED'} <= {message['param_id'] for message in asked}
    for name, value in names.items():
        reader = reader.on_message(
            said('PARAM_VALUE', param_id=name, param_value=value, param_type=9)
        )
    assert reader.value(Parameter.CRUISE_SPEED_MPS) == pytest.approx(8.0)
    assert reader.spelling(Parameter.CRUISE_SPEED_MPS) == speed
    assert math.isnan(reader.value(Parameter.ACCELERATION_MPS2))
    _, again = reader.on_tick(2.0)
    assert speed not in {message['param_id'] for message in again}


def test_px4_copies_the_bits_of_integers():
    """A 2 comes as a float that is nearly nothing."""
    (value,) = struct.unpack('<f', struct.pack('<i', 2))
    told = said('PARAM_VALUE', param_id='NAV_DLL_ACT', param_value=value, param_type=6)
    reader = ParameterReader(kind=MULTICOPTER.name, target=TARGET, found={}).on_message(told)
    assert reader.value(Parameter.LINK_LOSS_ACTION) == 2.0


def test_link_loss_that_does_nothing_may_forbid_the_flight():
    """Where the policy says that it must return, and the setting is off or not told."""
    limits = FlightLimits(must_return_on_link_loss=True)
    for found in ({'FS_GCS_ENABLE': 0.0}, {}):
        knowledge = VehicleSettings(
            parameters=ParameterReader(kind=COPTER.name, target=TARGET, found=found)
        )
        checks = preflight(ready(), COPTER, None, limits, 100.0, knowledge)
        verdicts = {check.name: check.verdict for check in checks}
        assert verdicts['link-loss action'] is CheckVerdict.FAIL


@pytest.mark.parametrize(
    ('asks', 'value'), [(1, 'not read yet'), (6, 'FS_GCS_ENABLE not answered')]
)
def test_setting_is_waited_for(asks, value):
    """What was asked for just now is not yet without an answer."""
    reader = ParameterReader(kind=COPTER.name, target=TARGET, found={}, asks=asks)
    checks = preflight(
        ready(), COPTER, None, FlightLimits(), 100.0, VehicleSettings(parameters=reader)
    )
    assert {check.name: check.value for check in checks}['link-loss action'] == value


def test_fence_travels_and_holds():
    """As items and back; a place in an exclusion is outside."""
    ring = tuple(offset(PLACE, *c) for c in ((-50, -50), (50, -50), (50, 50), (-50, 50)))
    hole = tuple(offset(PLACE, *c) for c in ((10, 10), (20, 10), (20, 20)))
    fence = Fence(inclusions=(ring,), exclusions=(hole,))
    back = fence_of(fence_items(fence))
    assert [len(r) for r in (*back.inclusions, *back.exclusions)] == [4, 3]
    assert back.holds(offset(PLACE, -20.0, 0.0))
    assert not back.holds(offset(PLACE, 17.0, 12.0))
    assert not back.holds(offset(PLACE, 60.0, 0.0))
    assert Fence().holds(PLACE)
    with pytest.raises(ValueError, match='3 or more'):
        Fence(inclusions=(ring[:2],))


def ring(half_m):
    """Return the corners of a square about home."""
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    return tuple(offset(PLACE, half_m * east, half_m * north) for east, north in corners)


def test_circles_are_part_of_a_fence():
    """Within one and out of another; a leg may cross a circle though its ends are outside."""
    fence = Fence(
        inner_circles=(Circle(center=PLACE, radius_m=100.0),),
        outer_circles=(Circle(center=offset(PLACE, 0.0, 50.0), radius_m=10.0),),
    )
    assert fence_of(fence_items(fence)) == Fence(
        inner_circles=fence.inner_circles,
        outer_circles=tuple(
            replace(one, center=fence_of(fence_items(fence)).outer_circles[0].center)
            for one in fence.outer_circles
        ),
    )
    assert [item.command for item in fence_items(fence)] == [
        library.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION,
        library.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION,
    ]
    assert fence.holds(offset(PLACE, 99.0, 0.0))
    assert not fence.holds(offset(PLACE, 101.0, 0.0))
    assert not fence.holds(offset(PLACE, 0.0, 41.0))
    ends = [offset(PLACE, east, 45.0) for east in (-40.0, 40.0)]
    assert all(map(fence.holds, ends))
    assert not fence.holds_leg(*ends)


def test_large_polygon_of_the_autopilot_is_read():
    """It has more corners than are sent from here."""
    corners = [
        (math.sin(number / 50 * math.pi), math.cos(number / 50 * math.pi)) for number in range(100)
    ]
    big = Fence(inclusions=(tuple(offset(PLACE, 80 * e, 80 * n) for e, n in corners),))
    with pytest.raises(ValueError, match='at most 80 corners'):
        fence_items(big)
    items = [
        MissionItem(
            command=5001,
            x_e7=round(corner.latitude_deg * 1e7),
            y_e7=round(corner.longitude_deg * 1e7),
            parameters=(100.0, 0.0, 0.0, 0.0),
        )
        for corner in big.inclusions[0]
    ]
    assert fence_of(items).holds(PLACE)
    assert not fence_of(items).holds(offset(PLACE, 90.0, 0.0))
    with pytest.raises(ValueError, match='not the 100 corners'):
        fence_of(items[:99])
    with pytest.raises(ValueError, match='5007'):
        fence_of([MissionItem(command=5007)])


def test_fence_that_cannot_be_read_forbids_the_flight():
    """A bow-tie: what the autopilot makes of it is not known."""
    air = Air()
    tie = [ring(200.0)[number] for number in (0, 2, 1, 3)]
    air.copters[1].missions.stored[1] = [
        MissionItem(
            command=5001,
            frame=0,
            x_e7=round(corner.latitude_deg * 1e7),
            y_e7=round(corner.longitude_deg * 1e7),
            parameters=(4.0, 0.0, 0.0, 0.0),
        )
        for corner in tie
    ]
    air.wait(60.0)
    with pytest.raises(ValueError, match='within fence is cannot be read: a polygon'):
        air.fly()


@pytest.mark.slow
@pytest.mark.parametrize('delay_s', [0.0, 0.1, 0.2, 0.3, 0.5, 5.0])
def test_no_flight_begins_before_the_new_fence_was_read(delay_s):
    """Be the fence that it replaces unread, half read, or known: none is taken for the new one."""
    air = Air()
    air.until(lambda: air.vehicle().autopilot is not None)
    air.copters[1].missions.stored[1] = list(fence_items(Fence(inclusions=(ring(900.0),))))
    air.wait(delay_s)
    commands = air.drones[1].commands
    commands.push_fence(Fence(inclusions=(ring(120.0),)), air.now_s)
    words = []
    while not any('outside' in word for word in words):
        assert air.now_s < 100.0
        air.step()
        words.append(words_of_fence(air))
    assert set(words) == {'not read yet', '1 of 3 waypoints outside'}


def words_of_fence(air):
    """Return what the look at the fence says before a flight of 150 m to the north."""
    checks = air.drones[1].commands.route_checks(plan())
    return next((check.value for check in checks if check.name == 'within fence'), 'not read yet')


def test_route_that_leaves_the_fence_takes_the_place_of_none():
    """Nor does one that is too high or too far away; one that may be flown does."""
    air = Air()
    air.copters[1].missions.stored[1] = list(fence_items(Fence(inclusions=(ring(400.0),))))
    commands = flying(air)
    air.until(lambda: air.drones[1].session.readout.settings.fence is not None)
    for count, word in ((9, 'fence'), (60, 'dist')):
        with pytest.raises(CommandRefusedError, match=word):
            commands.replace_route(plan(count), air.now_s)
    low = DroneCommands(
        air.drones[1].session, FlightLimits(max_height_agl_m=20.0), FlightJournal()
    )
    with pytest.raises(CommandRefusedError, match='heights'):
        low.replace_route(plan(3), air.now_s)
    commands.replace_route(plan(4), air.now_s)
    assert done(air, commands) == ''


def test_silent_vehicle_is_taken_to_fly_on():
    """Along its way, then it stays at its end."""
    way = [offset(PLACE, 0.0, 100.0), offset(PLACE, 100.0, 100.0)]
    early, late = predict(PLACE, way, 10.0, 5.0), predict(PLACE, way, 10.0, 15.0)
    assert distance_m(early.position, offset(PLACE, 0.0, 50.0)) < 0.1
    assert (early.passed, late.passed) == (0, 1)
    assert distance_m(late.position, offset(PLACE, 50.0, 100.0)) < 0.1
    end = predict(PLACE, way, 10.0, 300.0)
    assert distance_m(end.position, way[-1]) < 0.1
    assert end.spread_m > late.spread_m > early.spread_m


def test_orders_that_make_no_sense_are_refused():
    """On the ground, out of contact, out of limits."""
    air = Air()
    commands = air.drones[1].commands
    with pytest.raises(CommandRefusedError, match='not in contact'):
        commands.hold(air.now_s)
    commands = flying(air)
    for place, height_m, word in (
        (offset(PLACE, 0.0, 9000.0), 30.0, 'distance'),
        (PLACE, 4000.0, 'height_m'),
        (PLACE, math.nan, 'height_m'),
    ):
        with pytest.raises(CommandRefusedError, match=word):
            commands.go_to(place, height_m, air.now_s)
    with pytest.raises(CommandRefusedError, match='speed_mps'):
        commands.change_speed(math.inf, air.now_s)
    assert isinstance(air.sent[-1], Message)


@pytest.mark.parametrize(
    ('found', 'failed'),
    [
        ({'FS_GCS_ENABLE': 1.0}, set()),
        ({'FS_GCS_ENABLE': 3.0}, set()),
        ({'FS_GCS_ENABLE': 2.0}, {'link-loss action'}),
        ({'FS_GCS_ENABLE': 5.0}, {'link-loss action'}),
        ({'FS_GCS_ENABLE': 7.0}, {'link-loss action'}),
        ({'FS_GCS_ENABLE': 1.0, 'FS_OPTIONS': 2.0}, {'exceptions from the link-loss action'}),
        ({'FS_GCS_ENABLE': 1.0, 'FS_OPTIONS': 16.0}, set()),
        ({'FS_GCS_ENABLE': 1.0, 'MAV_GCS_SYSID': 254.0}, {'station that may command'}),
        ({'FS_GCS_ENABLE': 1.0, 'MAV_GCS_SYSID': 250.0}, set()),
    ],
)
def test_only_a_return_passes_where_a_return_is_required(found, failed):
    """Landing, braking or going on is no return, nor is one that another station hides."""
    reader = ParameterReader(kind=COPTER.name, target=TARGET, found=found, asks=6)
    known = VehicleSettings(parameters=reader, station=250)
    limits = FlightLimits(must_return_on_link_loss=True)
    checks = preflight(ready(), COPTER, None, limits, 100.0, known)
    assert {check.name for check in checks if check.verdict is CheckVerdict.FAIL} == failed


@pytest.mark.parametrize(
    ('found', 'failed'),
    [
        ({'FS_GCS_ENABLE': 1.0, 'FS_ACTION': 4.0}, set()),
        ({'FS_GCS_ENABLE': 1.0, 'FS_ACTION': 3.0, 'FS_OPTIONS': 1.0}, set()),
        ({'FS_GCS_ENABLE': 0.0, 'FS_ACTION': 4.0}, {'link-loss failsafe'}),
        ({'FS_GCS_ENABLE': 2.0, 'FS_ACTION': 4.0}, {'link-loss failsafe'}),
        # Nothing, straight home through what stands there, a stand, stopped motors.
        ({'FS_GCS_ENABLE': 1.0, 'FS_ACTION': 0.0}, {'link-loss action'}),
        ({'FS_GCS_ENABLE': 1.0, 'FS_ACTION': 1.0}, {'link-loss action'}),
        ({'FS_GCS_ENABLE': 1.0, 'FS_ACTION': 2.0}, {'link-loss action'}),
        ({'FS_GCS_ENABLE': 1.0, 'FS_ACTION': 5.0}, {'link-loss action'}),
    ],
)
def test_rover_returns_by_its_own_numbers(found, failed):
    """Those of a copter mean something else."""
    reader = ParameterReader(kind=ROVER.name, target=TARGET, found=found, asks=6)
    known = VehicleSettings(parameters=reader, station=250)
    limits = FlightLimits(must_return_on_link_loss=True)
    checks = preflight(ready(), ROVER, None, limits, 100.0, known)
    assert {check.name for check in checks if check.verdict is CheckVerdict.FAIL} == failed
    # What a rover does not have is not asked for.
    assert not {'height of the return', 'heading on the way'} & {check.name for check in checks}


@pytest.mark.parametrize(
    ('kind', 'found', 'verdict'),
    [
        (COPTER, {'MIS_RESTART': 1.0}, CheckVerdict.FAIL),
        (ROVER, {'MIS_RESTART': 1.0}, CheckVerdict.FAIL),
        (COPTER, {'MIS_RESTART': 0.0}, CheckVerdict.PASS),
        (COPTER, {}, CheckVerdict.WARN),
        (ROVER, {'MIS_DONE_BEHAVE': 3.0}, CheckVerdict.FAIL),
        (ROVER, {'MIS_DONE_BEHAVE': 1.0}, CheckVerdict.PASS),
        (ROVER, {'SRTL_POINTS': 0.0}, CheckVerdict.FAIL),
        (ROVER, {'SRTL_POINTS': 300.0}, CheckVerdict.PASS),
        (COPTER, {'RTL_ALT_FINAL': 500.0}, CheckVerdict.WARN),
        (COPTER, {'RTL_ALT_FINAL': 0.0}, CheckVerdict.PASS),
        (MULTICOPTER, {'RTL_LAND_DELAY': -1.0}, CheckVerdict.WARN),
        (MULTICOPTER, {'RTL_LAND_DELAY': 0.0}, CheckVerdict.PASS),
    ],
)
def test_settings_that_change_what_an_order_does_are_judged(kind, found, verdict):
    """A mission that begins anew after a hold, a return that never lands, and the like."""
    reader = ParameterReader(kind=kind.name, target=TARGET, found=found, asks=6)
    known = VehicleSettings(parameters=reader, station=250)
    checks = preflight(ready(), kind, None, FlightLimits(), 100.0, known)
    name = next(iter(found), 'MIS_RESTART')
    (check,) = [check for check in checks if check.value.startswith(name)]
    assert check.verdict is verdict


@pytest.mark.parametrize('value', [0.0, 1.0, 3.0, 5.0])
def test_px4_returns_by_one_action_only(value):
    """Holding, landing or stopping the motors is no return."""
    reader = ParameterReader(
        kind=MULTICOPTER.name, target=TARGET, found={'NAV_DLL_ACT': value}, asks=6
    )
    limits = FlightLimits(must_return_on_link_loss=True)
    knowledge = VehicleSettings(parameters=reader)
    checks = preflight(ready(), MULTICOPTER, None, limits, 100.0, knowledge)
    assert {check.name: check.verdict for check in checks}['link-loss action'] is CheckVerdict.FAIL


@pytest.mark.parametrize(
    ('found', 'warned'),
    [
        ({'ARMING_CHECK': 1.0, 'RTL_ALT': 3000.0, 'FS_THR_ENABLE': 1.0}, set()),
        ({'ARMING_SKIPCHK': 0.0, 'RTL_ALT_M': 30.0, 'FS_THR_ENABLE': 1.0}, set()),
        (
            {'ARMING_CHECK': 0.0, 'RTL_ALT': 30000.0, 'FS_THR_ENABLE': 0.0},
            {'checks before arming', 'height of the return', 'radio-loss action'},
        ),
        ({'MAV_GCS_SYSID': 255.0}, {'station that may command'}),
        ({'WP_YAW_BEHAVIOR': 1.0}, {Parameter.YAW_BEHAVIOUR.value}),
    ],
)
def test_settings_that_make_a_failsafe_worse_are_warned_of(found, warned):
    """In both spellings of the names, whose meaning differs."""
    good = {'ARMING_CHECK': 1.0, 'RTL_ALT': 3000.0, 'FS_THR_ENABLE': 1.0}
    told = {'WP_YAW_BEHAVIOR': 0.0, **({} if 'ARMING_SKIPCHK' in found else good), **found}
    known = VehicleSettings(
        parameters=ParameterReader(kind=COPTER.name, target=TARGET, found=told, asks=6),
        station=255,
    )
    checks = preflight(ready(), COPTER, None, FlightLimits(), 100.0, known)
    names = {'checks before arming', 'height of the return', 'radio-loss action'}
    names |= {'station that may command', Parameter.YAW_BEHAVIOUR.value}
    found_bad = {check.name for check in checks if check.verdict is CheckVerdict.WARN}
    assert found_bad & names == warned


def test_fence_that_another_station_changed_is_seen():
    """On the ground it is read again and again; also one that could not be read before."""
    air = ready_air()
    air.copters[1].missions.stored[1] = list(fence_items(Fence(inclusions=(ring(100.0),))))
    air.wait(40.0)
    with pytest.raises(ValueError, match='outside'):
        air.fly()


def test_parameter_that_another_station_changed_is_seen():
    """An autopilot that does not tell it to all is asked again; a return was required."""
    air = Air(limits=FlightLimits(must_return_on_link_loss=True))
    settings = air.copters[1].parameters
    settings.update(FS_GCS_ENABLE=1.0, BATT_FS_LOW_ACT=2.0)
    air.wait(46.0)
    assert failures(air.drones[1].checks(plan(3), air.now_s)) == ''
    settings['FS_GCS_ENABLE'] = 0.0
    air.wait(40.0)
    assert 'FS_GCS_ENABLE' in failures(air.drones[1].checks(plan(3), air.now_s))


def test_fence_is_read_again_at_once_after_an_order_that_broke_its_reading_off():
    """Rally points are pushed while the new fence is being read: a route need not wait for it."""
    air = ready_air()
    drone = air.drones[1]
    drone.commands.push_fence(Fence(inclusions=(ring(100.0),)), air.now_s)
    assert done(air, drone.commands) == ''
    air.until(lambda: drone.session.readout._download is not None, 5.0)
    assert drone.session.readout.settings.fence is None
    drone.commands.push_rally([offset(PLACE, 20.0, 20.0)], 20.0, air.now_s)
    assert done(air, drone.commands) == ''
    air.wait(5.0)
    with pytest.raises(ValueError, match='outside'):
        air.fly()
