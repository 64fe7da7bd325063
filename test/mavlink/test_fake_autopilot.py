# SPDX-License-Identifier: Apache-2.0
"""The fake copter does what was recorded of the real one, as our own machines see it."""

import pytest
from test.mavlink.sky import TARGET, Sky, survey

from rocsafe_mavlink.autopilots.ardupilot import AUTO, COPTER, GUIDED, LAND, RTL
from rocsafe_mavlink.autopilots.autopilot import FlightState, Verb
from rocsafe_mavlink.knowledge.events import EventKind
from rocsafe_mavlink.knowledge.fix import fix_fault
from rocsafe_mavlink.knowledge.telemetry import Contact, MissionPhase
from rocsafe_mavlink.protocols import command_call as commands
from rocsafe_mavlink.protocols.mission_transfer import TransferStage


def ready(**options):
    """Return a copter that could be armed, with a mission."""
    sky = Sky(**options)
    sky.ask_for_rates()
    sky.run(lambda: sky.copter.up_s > 45.0)
    assert not sky.call(COPTER.mode_command(Verb.GUIDED, TARGET)).error
    return sky


def flying(count=3, **options):
    """Return a copter on its way to its first waypoint."""
    sky = ready(**options)
    assert sky.upload(survey(count)).stage is TransferStage.VERIFIED
    for order in (
        commands.arm(TARGET),
        COPTER.mode_command(Verb.MISSION, TARGET),
        commands.start_mission(TARGET),
    ):
        assert sky.call(order).error == ''
    sky.run(lambda: sky.vehicle.mission.current >= 2)
    return sky


def test_it_becomes_ready_in_the_recorded_order():
    """Fix, home, a pre-arm bit that lies, and at last a position that can be used."""
    sky = Sky()
    sky.ask_for_rates()
    order = []
    signs = {
        'fix': lambda: sky.vehicle.gps.fix_type == 6,
        'home': lambda: sky.vehicle.home is not None,
        'bit': lambda: sky.vehicle.is_prearm_ok,
        'position': lambda: sky.vehicle.motion and not fix_fault(sky.vehicle, sky.now_s),
    }
    for name, sign in signs.items():
        sky.run(lambda: bool(sign()))  # noqa: B023 - it is called before the next
        order.append((name, round(sky.now_s)))
    assert order == [('fix', 10), ('home', 20), ('bit', 24), ('position', 42)]


def test_arming_is_refused_with_the_reason():
    """The bit is set, yet GUIDED refuses until the estimate uses the receiver."""
    sky = Sky()
    sky.ask_for_rates()
    sky.run(lambda: sky.vehicle.is_prearm_ok)
    sky.call(COPTER.mode_command(Verb.GUIDED, TARGET))
    assert (
        sky.call(commands.arm(TARGET)).error == 'command 400 failed; Arm: Need Position Estimate'
    )


def test_nominal_flight_ends_on_the_ground():
    """Take-off, every waypoint, home, motors off; the states follow."""
    sky = flying()
    states = set()
    while sky.vehicle.is_armed:
        sky.wait(0.5)
        states.add(COPTER.state_of(sky.vehicle, sky.now_s))
    assert {event.text for event in sky.events if event.kind is EventKind.REACHED} >= {
        '1',
        '2',
        '3',
        '4',
        '5',
    }
    assert FlightState.FLYING in states
    assert COPTER.state_of(sky.vehicle, sky.now_s) is FlightState.LANDED
    assert sky.vehicle.mission.phase is MissionPhase.COMPLETE
    assert sky.texts[-1] == 'Disarming motors'


@pytest.mark.slow
@pytest.mark.parametrize(
    ('order', 'words'),
    [
        (commands.disarm(TARGET), 'command 400 failed'),
        (commands.set_current(TARGET, 99), 'command 224 failed'),
        (commands.command(20, TARGET), 'command 20 not supported'),
        (commands.command(300, TARGET, 1.0), 'command 300 denied'),
        (commands.set_interval(TARGET, 9999, 1.0), 'command 511 denied'),
    ],
)
def test_refusals_in_flight(order, words):
    """As recorded."""
    assert flying().call(order).error == words


def test_mission_without_take_off_does_not_start():
    """It is taken and refused only when it shall begin, the reason in a text."""
    sky = ready()
    assert sky.upload(survey(takeoff=False)).stage is TransferStage.VERIFIED
    assert not sky.call(commands.arm(TARGET)).error
    call = sky.call(COPTER.mode_command(Verb.MISSION, TARGET))
    assert 'Auto: Missing Takeoff Cmd' in call.error
    sky.run(lambda: not sky.vehicle.is_armed, 20.0)


def test_auto_cannot_be_armed():
    """Mode first, then motors, is refused."""
    sky = ready()
    sky.upload(survey())
    assert not sky.call(COPTER.mode_command(Verb.MISSION, TARGET)).error
    assert 'AUTO mode not armable' in sky.call(commands.arm(TARGET)).error


def test_pause_and_resume():
    """It stands still in AUTO, and goes on."""
    sky = flying()
    assert not sky.call(commands.pause(TARGET)).error
    sky.wait(1.0)
    assert COPTER.state_of(sky.vehicle, sky.now_s) is FlightState.HOLDING
    place = sky.copter.place
    sky.wait(3.0)
    assert sky.copter.place == place
    assert not sky.call(commands.resume(TARGET)).error
    sky.wait(1.0)
    assert COPTER.state_of(sky.vehicle, sky.now_s) is FlightState.FLYING


def test_mission_cannot_be_cleared_in_flight():
    """A refused re-plan says that the old mission could not be cleared either."""
    sky = flying()
    assert 'clearing it: refused' in sky.upload([*survey(2), _bad()]).error


def _bad():
    item = survey(1)[2]
    return type(item)(command=999)


@pytest.mark.parametrize(('enabled', 'mode'), [(False, AUTO), (True, RTL)])
def test_lost_station(enabled, mode):
    """By default it flies on; told so it returns, and stays returning when the station is back."""
    sky = flying(12, fs_gcs_enable=enabled)
    sky.is_station_alive = False
    sky.wait(8.0)
    sky.is_station_alive = True
    sky.wait(3.0)
    assert sky.vehicle.custom_mode == mode
    assert ('GCS Failsafe' in sky.texts) == enabled


def test_low_battery_returns():
    """The mode is RTL; a plain AUTO is accepted, so that resuming is for people to decide."""
    sky = flying(12)
    sky.copter.lose_battery()
    sky.wait(1.5)
    assert COPTER.state_of(sky.vehicle, sky.now_s) is FlightState.RETURNING
    assert sky.vehicle.status == 5
    assert not sky.call(COPTER.mode_command(Verb.MISSION, TARGET)).error


def test_lost_receiver_lands():
    """Positions go on and are not believed at once; eight seconds later it lands."""
    sky = flying(12)
    sky.copter.has_gps = False
    sky.wait(0.5)
    assert 'no fix' in fix_fault(sky.vehicle, sky.now_s)
    assert sky.vehicle.custom_mode == AUTO
    sky.wait(9.0)
    assert sky.vehicle.custom_mode == LAND
    assert 'EKF Failsafe: changed to LAND Mode' in sky.texts


def test_breached_fence_returns():
    """Said in a message and in words."""
    sky = flying(12)
    sky.copter.breach_fence()
    sky.wait(1.5)
    assert sky.vehicle.is_fence_breached
    assert sky.vehicle.custom_mode == RTL


def test_silence_is_stale_then_lost_and_back_again():
    """What is known is kept, with its age; the first heartbeat makes it fresh."""
    sky = flying(12)
    sky.copter.is_silent = True
    sky.wait(4.0)
    assert sky.vehicle.contact(sky.now_s) is Contact.STALE
    sky.wait(7.0)
    assert COPTER.state_of(sky.vehicle, sky.now_s) is FlightState.LOST
    sky.copter.is_silent = False
    sky.wait(1.2)
    assert sky.vehicle.contact(sky.now_s) is Contact.FRESH


def test_reboot_takes_rates_and_mission():
    """Only heartbeats come; nothing of before is believed."""
    sky = ready()
    sky.upload(survey())
    sky.copter.reboot()
    sky.wait(5.0)
    assert EventKind.REBOOTED in {event.kind for event in sky.events}
    assert sky.vehicle.motion is None
    assert sky.vehicle.custom_mode != GUIDED
    assert sky.copter.missions.stored[0] == []
