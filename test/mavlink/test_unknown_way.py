# SPDX-License-Identifier: Apache-2.0
"""Where it would fly must be known: home set anew in flight, no position, a restart between."""

import pytest
from test.fakes.fake_autopilot import HOME
from test.mavlink.test_flight import plan
from test.mavlink.test_homeward import flying_around, there
from test.mavlink.test_station import Air

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_mavlink.autopilots.ardupilot import RTL
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.drone.vehicle_session import VehicleSession
from rocsafe_mavlink.errors import CommandRefusedError
from rocsafe_mavlink.flight.flight_journal import FlightJournal

HERE = GeoPosition(*HOME)
ORDERS = {
    'resume': lambda commands, now_s: commands.resume(now_s),
    'new route': lambda commands, now_s: commands.replace_route(plan(4), now_s),
    'go to': lambda commands, now_s: commands.go_to(HERE, 30.0, now_s),
}


def flying(journal=None):
    """Return an air whose copter has its first waypoint behind it."""
    air = Air()
    if journal is not None:
        serve(air, journal)
    air.wait(46.0)
    air.fly(count=6)
    air.until(lambda: (air.drones[1].step(air.now_s), air.flight().visited >= 1)[1])
    return air


def serve(air, journal, session=None):
    """Let the copter be served by a new drone, as by a bridge that was started again."""
    before = air.drones[1]
    air.drones[1] = Drone(before.spec, session or before.session, journal)
    air.station.add(air.drones[1])


def set_home(air, rise_m=0.0, north_m=0.0):
    """Set its home anew, as every ground station can, and let that be heard."""
    copter = air.copters[1]
    copter.home_msl_m += rise_m
    copter.home = (copter.home[0] + north_m / 111_195.0, copter.home[1])
    air.wait(2.0)


def is_refused(air, order):
    """Return why an order is refused; empty if it is not."""
    try:
        ORDERS[order](air.drones[1].commands, air.now_s)
    except CommandRefusedError as refusal:
        return str(refusal)
    return ''


@pytest.mark.slow
@pytest.mark.parametrize('order', ORDERS)
def test_no_height_is_flown_above_a_home_that_was_set_higher(order):
    """A route at 30 m would be flown at 55 m; it is told, set back it is taken again."""
    air = flying()
    set_home(air, rise_m=25.0)
    assert is_refused(air, order).startswith('its home was set 25 m higher in flight')
    seen = air.drones[1].status(air.now_s)
    assert seen.advice == 'hold'
    assert 'home moved 0.0 m and 25.0 m in height in flight' in seen.text
    set_home(air, rise_m=-25.0)
    assert is_refused(air, order) == ''
    assert air.drones[1].status(air.now_s).advice == ''


def test_flight_with_another_home_is_ended_by_order():
    """Hold, return and land need no height."""
    air = flying()
    set_home(air, rise_m=-40.0)
    commands = air.drones[1].commands
    commands.hold(air.now_s)
    air.until(lambda: commands.outcome(commands.count) == '', 20.0)
    commands.return_home(air.now_s)
    air.until(lambda: air.copters[1].mode == RTL, 20.0)


def test_home_that_was_set_elsewhere_is_told():
    """Its return leads there; heights are as they were."""
    air = flying()
    set_home(air, north_m=50.0)
    assert 'home moved 50.0 m and 0.0 m in height' in air.drones[1].status(air.now_s).text
    assert is_refused(air, 'go to') == ''


def test_bridge_that_was_started_again_knows_the_home_of_the_begin(tmp_path):
    """It was set anew while no bridge was there."""
    path = tmp_path / 'flight.json'
    air = flying(FlightJournal(path))
    session = VehicleSession.of((1, 1), (255, 190))
    set_home(air, rise_m=25.0)
    serve(air, FlightJournal(path), session)
    air.until(lambda: (air.drones[1].step(air.now_s), session.is_flying)[1], 60.0)
    air.until(lambda: 'is still being read' not in is_refused(air, 'go to'), 60.0)
    assert is_refused(air, 'go to').startswith('its home was set 25 m higher in flight')


@pytest.mark.slow
@pytest.mark.parametrize(
    ('lost', 'words'),
    [
        ('GLOBAL_POSITION_INT', 'no position comes'),
        ('GPS_RAW_INT', "the receiver's time stands still"),
    ],
)
def test_no_way_past_an_exclusion_is_judged_from_where_it_was(lost, words):
    """Heartbeats come, positions do not: only what needs no place is taken."""
    air = flying_around()
    copter, commands = air.copters[1], air.drones[1].commands
    step = copter.step
    copter.step = lambda now_s: [said for said in step(now_s) if said.name != lost]
    air.wait(5.0)
    free = there((60.0, 140.0), (60.0, 40.0), (0.0, 40.0))
    for order in (
        lambda: commands.resume(air.now_s),
        lambda: commands.replace_route(free, air.now_s),
        lambda: commands.go_to(offset(HERE, 60.0, 150.0), 30.0, air.now_s),
    ):
        with pytest.raises(CommandRefusedError, match=f'where it is cannot be told: {words}'):
            order()
    commands.hold(air.now_s)
    copter.step = step
    air.until(lambda: commands.outcome(commands.count) == '', 20.0)
    commands.replace_route(free, air.now_s)
