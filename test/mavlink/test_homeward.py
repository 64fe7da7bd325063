# SPDX-License-Identifier: Apache-2.0
"""Exclusions hold for the way home, too: of a vehicle that gives up, and of one that is called."""

from dataclasses import replace

import pytest
from shapely.geometry import Point, Polygon
from test.fakes.fake_autopilot import HOME
from test.mavlink.test_station import Air, ready_air

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_mavlink.autopilots.ardupilot import AUTO, BRAKE, COPTER, GUIDED, RTL
from rocsafe_mavlink.autopilots.parameters import ParameterReader
from rocsafe_mavlink.autopilots.px4 import MULTICOPTER
from rocsafe_mavlink.checks.check import CheckVerdict
from rocsafe_mavlink.checks.preflight import route_checks
from rocsafe_mavlink.checks.way_checks import exclusion_checks, start_of
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.errors import CommandRefusedError
from rocsafe_mavlink.flight.flight_journal import Assignment
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome
from rocsafe_mavlink.knowledge.telemetry import Home, VehicleTelemetry
from rocsafe_mavlink.plan.fence import Fence
from rocsafe_mavlink.plan.flight_limits import FlightLimits, VehicleSettings
from rocsafe_mavlink.plan.flight_plan import FlightPlan, FlightWaypoint
from rocsafe_mavlink.plan.homeward import ReturnPlaces, return_fault, way_fault

HOME_PLACE = GeoPosition(*HOME)
# A square of 40 m, 80 to 120 m north of home.
CORNERS = ((-20, 80), (20, 80), (20, 120), (-20, 120))
SQUARE = tuple(offset(HOME_PLACE, *corner) for corner in CORNERS)
ENDS = (offset(HOME_PLACE, 30.0, 160.0), offset(HOME_PLACE, 60.0, 60.0))


def around(*, clearance_m=5.0, exclusions=(SQUARE,)):
    """Return a plan that flies around the square to a place behind it, and back the same way."""
    east = [(60, 60), (60, 140)]
    way = [*east, (0, 150), *reversed(east)]
    return FlightPlan(
        waypoints=tuple(
            FlightWaypoint(
                position=offset(HOME_PLACE, *place), height_m=30.0, is_bend=place in east
            )
            for place in way
        ),
        speed_mps=10.0,
        exclusions=exclusions,
        clearance_m=clearance_m,
    )


def places(**options):
    """Return the places of the return of a vehicle at home."""
    return ReturnPlaces(home=HOME_PLACE, **options)


def test_exclusion_between_a_leg_and_home_is_named():
    """The legs are free of it; the straight way home from the third is not."""
    assert return_fault(around(), places()) == (
        'exclusion 1 lies between leg 3 and the place of its return'
    )
    beside = tuple(offset(HOME_PLACE, *corner) for corner in ((200, 100), (210, 100), (205, 120)))
    assert return_fault(around(exclusions=(beside,)), places()) == ''


@pytest.mark.parametrize(
    ('options', 'is_free'),
    [
        ({}, False),
        ({'rally': (offset(HOME_PLACE, 0.0, 160.0),), 'includes_home': False}, False),
        ({'rally': ENDS}, True),
        ({'rally': ENDS, 'limit_m': 40.0}, False),
    ],
    ids=['none', 'one behind', 'one at each end', 'both too far'],
)
def test_rally_points_make_the_way_free(options, is_free):
    """The autopilot flies to the nearest; beyond its limit it flies home."""
    assert (return_fault(around(), places(**options)) == '') is is_free


@pytest.mark.parametrize(
    ('kind', 'found', 'fence', 'verdict'),
    [
        (COPTER.name, {}, Fence(), CheckVerdict.FAIL),
        (COPTER.name, {'OA_TYPE': 2.0}, Fence(), CheckVerdict.FAIL),
        (
            COPTER.name,
            {'OA_TYPE': 2.0, 'FENCE_ENABLE': 1.0, 'FENCE_TYPE': 4.0},
            Fence(exclusions=(SQUARE,)),
            CheckVerdict.PASS,
        ),
        (
            COPTER.name,
            {'OA_TYPE': 2.0, 'FENCE_ENABLE': 1.0, 'FENCE_TYPE': 3.0},
            Fence(exclusions=(SQUARE,)),
            CheckVerdict.FAIL,
        ),
        (
            COPTER.name,
            {'OA_TYPE': 1.0, 'FENCE_ENABLE': 1.0, 'FENCE_TYPE': 4.0},
            Fence(exclusions=(SQUARE,)),
            CheckVerdict.FAIL,
        ),
        (MULTICOPTER.name, {'RTL_TYPE': 2.0}, Fence(), CheckVerdict.PASS),
        (MULTICOPTER.name, {'RTL_TYPE': 0.0}, Fence(), CheckVerdict.FAIL),
    ],
)
def test_autopilot_that_returns_around_exclusions_passes(kind, found, fence, verdict):
    """ArduCopter by its path planner and its fence, PX4 back along its mission; no others."""
    reader = ParameterReader(kind=kind, target=(1, 1), found=found, asks=99)
    vehicle = VehicleTelemetry(
        system=1,
        component=1,
        home=Home(latitude_deg=HOME[0], longitude_deg=HOME[1], altitude_msl_m=0.0),
    )
    known = VehicleSettings(parameters=reader, fence=fence, rally=())
    checks = route_checks(vehicle, around(), FlightLimits(), known)
    (check,) = [check for check in checks if check.name == 'way home']
    assert check.verdict is verdict


def flying_around(journal=None):
    """Return an air whose copter is behind the square; the check is left out."""
    air = Air()
    if journal is not None:
        air.drones[1] = Drone(air.drones[1].spec, air.drones[1].session, journal)
        air.station.add(air.drones[1])
    air.copters[1].parameters |= {'OA_TYPE': 2.0, 'FENCE_ENABLE': 1.0, 'FENCE_TYPE': 4.0}
    air.wait(46.0)
    commands = air.drones[1].commands
    commands.push_fence(Fence(exclusions=(SQUARE,)), air.now_s)
    air.until(lambda: commands.outcome(commands.count) is not None, 60.0)
    air.wait(60.0)
    air.drones[1].fly(Assignment(plan_id='around', plan=around(), viewpoint_ids=(0,)), air.now_s)
    air.until(lambda: air.copters[1].place[1] > 142.0)
    return air


@pytest.mark.slow
def test_return_to_a_home_that_was_set_into_an_exclusion_is_refused():
    """By another station, in flight: no way leads there; it may land, or go elsewhere."""
    air = flying_around()
    copter, commands = air.copters[1], air.drones[1].commands
    copter.home = (HOME_PLACE.latitude_deg + 100.0 / 111_195.0, HOME_PLACE.longitude_deg)
    air.wait(2.0)
    with pytest.raises(CommandRefusedError, match='its home lies in exclusion 1'):
        commands.return_home(air.now_s)
    commands.land(air.now_s)


@pytest.mark.slow
def test_straight_return_is_not_repeated_from_where_it_would_cross():
    """The order is lost on the link while it flies on: from behind the square it is no more so."""
    air = flying_around()
    copter, commands = air.copters[1], air.drones[1].commands
    copter.mode, copter.place = BRAKE, (60.0, 60.0)
    air.wait(2.0)
    copter._on_command = lambda _message: None
    commands.return_home(air.now_s)
    air.wait(0.5)
    assert len(air.drones[1].session.sequence.steps) == 1
    copter.place = (0.0, 150.0)
    before = len(air.sent)
    air.until(lambda: commands.outcome(commands.count) is not None, 30.0)
    assert 'an exclusion lies on the straight way by now' in commands.outcome(commands.count)
    assert [m for m in air.sent[before:] if m.fields.get('command') == 176] == []


@pytest.mark.slow
def test_commanded_return_flies_around():
    """A straight one would cross the square; nothing is left behind, and the flight has ended."""
    air = flying_around()
    commands, copter = air.drones[1].commands, air.copters[1]
    commands.return_home(air.now_s)
    zone = Polygon(CORNERS)
    track = []

    def is_over():
        track.append(copter.place)
        if commands.outcome(commands.count) == '':
            air.drones[1].gave_up()
        return air.flight().is_over

    air.until(is_over)
    assert commands.outcome(commands.count) == ''
    assert min(zone.distance(Point(place)) for place in track) > 4.0
    assert air.flight().outcome is FlightOutcome.ABORTED_BY_OPERATOR
    assert not copter.is_armed
    assert {BRAKE, AUTO} <= {int(m['param2']) for m in air.sent if m.fields.get('command') == 176}


def test_free_return_is_straight():
    """From before the square the vehicle is switched to its own return."""
    air = ready_air()
    air.fly(count=3)
    air.until(lambda: air.flight().visited >= 1)
    air.drones[1].commands.return_home(air.now_s)
    air.until(lambda: air.copters[1].mode == RTL, 5.0)


@pytest.mark.slow
def test_place_behind_an_exclusion_is_refused():
    """Go-to flies straight."""
    air = flying_around()
    with pytest.raises(CommandRefusedError, match='exclusion 1 lies on the way'):
        air.drones[1].commands.go_to(offset(HOME_PLACE, 0.0, 40.0), 30.0, air.now_s)


@pytest.mark.slow
def test_go_to_is_not_sent_from_where_it_would_cross():
    """It was free when it was ordered; the vehicle flies on before it is sent."""
    air = flying_around()
    copter, commands = air.copters[1], air.drones[1].commands
    copter.mode, copter.place = BRAKE, (60.0, 60.0)
    air.wait(2.0)
    commands.go_to(offset(HOME_PLACE, 0.0, 40.0), 30.0, air.now_s)
    air.until(lambda: copter.mode == GUIDED, 10.0)
    copter.place = (0.0, 150.0)
    before = len(air.sent)
    air.until(lambda: commands.outcome(commands.count) is not None, 30.0)
    assert commands.outcome(commands.count).startswith('go to: ')
    assert not any(m.fields.get('command') == 192 for m in air.sent[before:])


@pytest.mark.slow
@pytest.mark.parametrize('sign', ['text', 'status'])
def test_no_way_around_is_sent_after_a_failsafe(sign):
    """It would be a mission: the vehicle may be told to hold or land. Nor does one go on then."""
    air = flying_around()
    copter, commands = air.copters[1], air.drones[1].commands
    copter.mode = BRAKE
    air.wait(2.0)
    commands.return_home(air.now_s)
    air.wait(1.5)
    if sign == 'text':
        copter._text(2, 'Battery Failsafe')
    else:
        copter.status = 5
    air.wait(8.0)
    assert 'withdrawn' in commands.outcome(commands.count)
    with pytest.raises(CommandRefusedError, match='no way around exclusions is sent any more'):
        commands.return_home(air.now_s)
    commands.hold(air.now_s)
    commands.land(air.now_s)


def test_route_is_refused_where_a_failsafe_would_cross_an_exclusion():
    """Before take-off, with the leg and the exclusion."""
    air = Air()
    air.wait(60.0)
    with pytest.raises(ValueError, match='way home is exclusion 1 lies between leg 3 and'):
        air.drones[1].fly(
            Assignment(plan_id='around', plan=around(), viewpoint_ids=(0,)), air.now_s
        )


def there(*waypoints):
    """Return a plan to places (east, north) about home, clear of the square but for its begin."""
    return FlightPlan(
        waypoints=tuple(
            FlightWaypoint(position=offset(HOME_PLACE, *place), height_m=30.0)
            for place in waypoints
        ),
        speed_mps=10.0,
        exclusions=(SQUARE,),
        clearance_m=5.0,
    )


@pytest.mark.slow
def test_way_to_the_first_waypoint_of_a_new_route_is_checked_from_where_it_is():
    """From home this route is free of the square; behind it the vehicle must fly around first."""
    air = flying_around()
    vehicle, commands = air.drones[1].vehicle, air.drones[1].commands
    route = there((0.0, 40.0))
    home = HOME_PLACE
    assert way_fault(route, [home, *(w.position for w in route.waypoints), home]) == ''
    with pytest.raises(CommandRefusedError, match='way is exclusion 1 lies on leg 1'):
        commands.replace_route(route, air.now_s)
    assert not air.drones[1].session.is_commanded
    lost = replace(vehicle, motion=None)
    (check,) = exclusion_checks(route, start_of(lost, home), home)
    assert check.verdict is CheckVerdict.FAIL
    commands.replace_route(there((60.0, 140.0), (60.0, 40.0), (0.0, 40.0)), air.now_s)


@pytest.mark.slow
def test_way_is_checked_again_when_the_new_route_lies_on_the_vehicle():
    """A gust has carried it behind the square during the upload: it is not started."""
    air = flying_around()
    commands, copter = air.drones[1].commands, air.copters[1]
    commands.replace_route(there((60.0, 140.0), (60.0, 40.0)), air.now_s)
    air.until(lambda: copter.mode == BRAKE, 30.0)
    copter.place = (-60.0, 90.0)
    air.until(lambda: commands.outcome(commands.count) is not None, 60.0)
    assert 'exclusion 1 lies on leg 1' in commands.outcome(commands.count)
    assert copter.mode == BRAKE


@pytest.mark.slow
def test_resumed_route_is_not_flown_across_an_exclusion():
    """Held and carried behind the square it is not resumed; brought back it is."""
    air = Air()
    air.copters[1].parameters |= {'OA_TYPE': 2.0, 'FENCE_ENABLE': 1.0, 'FENCE_TYPE': 4.0}
    air.wait(46.0)
    commands, copter = air.drones[1].commands, air.copters[1]
    commands.push_fence(Fence(exclusions=(SQUARE,)), air.now_s)
    air.until(lambda: commands.outcome(commands.count) is not None, 60.0)
    air.wait(60.0)
    plan = there((60.0, 60.0), (60.0, 140.0), (60.0, 60.0))
    air.drones[1].fly(Assignment(plan_id='beside', plan=plan, viewpoint_ids=(0, 1, 2)), air.now_s)
    air.until(lambda: air.flight().visited == 1 and copter.place[1] > 80.0)
    commands.hold(air.now_s)
    air.until(lambda: commands.outcome(commands.count) is not None, 60.0)
    before = copter.place
    copter.place = (-60.0, 90.0)
    air.wait(3.0)
    with pytest.raises(CommandRefusedError, match='exclusion 1 lies on the way'):
        commands.resume(air.now_s)
    copter.place = before
    air.wait(3.0)
    commands.resume(air.now_s)
    air.until(lambda: commands.outcome(commands.count) is not None, 60.0)
    assert commands.outcome(commands.count) == ''
