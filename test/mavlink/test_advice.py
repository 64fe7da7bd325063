# SPDX-License-Identifier: Apache-2.0
"""Other aircraft, a fence changed in the air, wind: told at once, with the order that answers."""

import math
from dataclasses import replace

import pytest
from test.fakes.fake_autopilot import AUTO, HOME, LAND, RTL
from test.mavlink.test_flight import plan
from test.mavlink.test_station import ready_air

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_mavlink.autopilots.ardupilot import COPTER
from rocsafe_mavlink.autopilots.parameters import ParameterReader
from rocsafe_mavlink.autopilots.px4 import MULTICOPTER
from rocsafe_mavlink.checks.check import CheckVerdict
from rocsafe_mavlink.checks.preflight import route_checks
from rocsafe_mavlink.checks.setting_checks import setting_checks
from rocsafe_mavlink.checks.wind_checks import wind_checks
from rocsafe_mavlink.drone_options import DroneOptions
from rocsafe_mavlink.knowledge.reducer import reduce
from rocsafe_mavlink.knowledge.telemetry import Motion, VehicleTelemetry, Wind
from rocsafe_mavlink.knowledge.traffic import encounter
from rocsafe_mavlink.plan.flight_limits import FlightLimits, VehicleSettings
from rocsafe_mavlink.plan.flight_plan import FlightWaypoint
from rocsafe_mavlink.wire.dialect import Message
from rocsafe_mavlink.wire.plausibility import fault_of

HERE = GeoPosition(*HOME)
STILL = Motion(
    position=HERE,
    altitude_msl_m=520.0,
    height_above_home_m=32.0,
    velocity_enu_mps=(0.0, 0.0, 0.0),
    yaw_rad=0.0,
    boot_s=1.0,
    heard_s=100.0,
)


def adsb(east_m, north_m, *, above_m=0.0, speed_mps=50.0, course_deg=0.0, flags=31, **fields):
    """Return what an aircraft beside home says."""
    place = offset(HERE, east_m, north_m)
    said = {
        'ICAO_address': 0x3C1234,
        'callsign': 'DHX12',
        'lat': round(place.latitude_deg * 1e7),
        'lon': round(place.longitude_deg * 1e7),
        'altitude': round((520.0 + above_m) * 1000),
        'altitude_type': 1,
        'heading': round(course_deg * 100),
        'hor_velocity': round(speed_mps * 100),
        'ver_velocity': 0,
        'tslc': 0,
        'flags': flags,
    }
    return Message('ADSB_VEHICLE', {**said, **fields}, 1, 1)


def met(message, motion=STILL, now_s=100.0):
    """Return the aircraft as seen from a vehicle."""
    vehicle, _ = reduce(VehicleTelemetry(system=1, component=1), message, 100.0)
    (aircraft,) = vehicle.traffic
    return encounter(aircraft, motion, now_s)


@pytest.mark.parametrize(
    ('message', 'is_close'),
    [
        (adsb(0.0, 3000.0, course_deg=180.0), True),
        (adsb(0.0, 3000.0, course_deg=0.0), False),
        (adsb(0.0, 5000.0, course_deg=180.0), False),
        (adsb(1000.0, 3000.0, course_deg=180.0), False),
        (adsb(500.0, 3000.0, course_deg=180.0), True),
        (adsb(0.0, 400.0, course_deg=0.0), True),
        (adsb(0.0, 3000.0, course_deg=180.0, above_m=100.0), False),
        (adsb(0.0, 3000.0, course_deg=180.0, above_m=100.0, altitude_type=0), True),
        (adsb(0.0, 3000.0, course_deg=180.0, above_m=100.0, ver_velocity=-300), True),
        (adsb(0.0, 3000.0, course_deg=180.0, above_m=900.0, flags=29), True),
        (adsb(0.0, 3000.0, flags=27), False),
    ],
    ids=[
        *('comes', 'goes', 'too far for a minute', 'passes at 1000 m', 'passes at 500 m'),
        *('near and going', 'higher', 'higher by its pressure', 'higher and sinking'),
        *('of unknown height', 'of unknown course'),
    ],
)
def test_aircraft_is_close_by_its_nearest_point(message, is_close):
    """Level and in height, within a minute; what is not told counts against it."""
    assert met(message).is_close is is_close


def test_nearest_point_of_two_that_cross():
    """The nearest point is that of the relative motion."""
    ours = replace(STILL, velocity_enu_mps=(0.0, 10.0, 0.0))
    seen = met(adsb(1000.0, 1000.0, speed_mps=20.0, course_deg=270.0), ours)
    # Relative (-20, -10) m/s from (1000, 1000): nearest after 30000 / 500 s.
    assert seen.closest_in_s == pytest.approx(60.0, abs=0.2)
    assert seen.closest_m == pytest.approx(math.hypot(-200.0, 400.0), abs=3.0)


def test_old_word_is_carried_on():
    """An aircraft that was heard 10 s ago at 50 m/s is 500 m further."""
    assert met(adsb(0.0, 3000.0, course_deg=180.0, tslc=10)).distance_m == pytest.approx(
        2500, 1e-2
    )


def test_aircraft_at_no_place_is_dropped():
    """A place that cannot be is no message; one without a place is no aircraft."""
    assert fault_of(adsb(0.0, 0.0, lat=10**9)) == 'lat'
    vehicle = VehicleTelemetry(system=1, component=1)
    assert reduce(vehicle, adsb(0.0, 0.0, flags=30), 1.0)[0].traffic == ()


def flying(**limits):
    """Return an air with a copter on its route."""
    return ready_air(6, FlightLimits(**limits))


def status(air):
    """Return the status of the copter."""
    return air.drones[1].status(air.now_s)


@pytest.mark.slow
def test_aircraft_that_comes_is_told_and_a_hold_offered():
    """Nothing is commanded; it is forgotten when it is not heard any more."""
    air = flying()
    before = list(air.copters[1].commands)
    air.copters[1]._say('ADSB_VEHICLE', **adsb(0.0, 900.0, course_deg=180.0).fields)
    air.wait(0.3)
    assert status(air).advice == 'hold'
    assert 'aircraft DHX12 at' in status(air).text
    assert [number for number in air.copters[1].commands if number != 511] == [
        number for number in before if number != 511
    ]
    air.wait(20.0)
    assert status(air).advice == ''


def test_fence_changed_in_the_air_is_seen_and_a_hold_offered():
    """Another station draws it tighter than the route."""
    air = flying()
    assert status(air).advice == ''
    corners = [offset(HERE, *corner) for corner in ((-20, -20), (20, -20), (20, 110), (-20, 110))]
    air.copters[1].missions.stored[1] = [
        replace(
            air.copters[1].missions.stored[0][2],
            command=5001,
            frame=0,
            parameters=(4.0, 0.0, 0.0, 0.0),
            x_e7=round(corner.latitude_deg * 1e7),
            y_e7=round(corner.longitude_deg * 1e7),
            z_m=0.0,
        )
        for corner in corners
    ]
    air.until(lambda: status(air).advice == 'hold', 35.0)
    assert 'its fence was changed: 4 of 6 waypoints outside: hold is offered' in status(air).text
    assert air.copters[1].mode == AUTO


def blow(air, speed_mps):
    """Let the copter estimate a wind."""
    air.copters[1]._say('WIND', speed=speed_mps, direction=10.0)
    air.step()


@pytest.mark.slow
@pytest.mark.parametrize(('returns', 'mode'), [(False, AUTO), (True, RTL)])
def test_wind_over_its_limit_is_told_or_answered(returns, mode):
    """By the option of the drone a return is offered, or ordered."""
    air = flying(max_wind_mps=11.0, max_gust_mps=12.0, returns_in_wind=returns)
    blow(air, 7.0)
    assert status(air).advice == ''
    air.wait(1.0)
    blow(air, 13.0)
    assert status(air).advice == 'return_home'
    assert 'gusts of 13.0 m/s: at most 12 m/s allowed' in status(air).text
    for _ in range(30):
        air.drones[1].step(air.now_s)
        air.step()
    assert air.copters[1].mode == mode


@pytest.mark.parametrize(('order', 'mode'), [('land', LAND), ('return_home', RTL)])
@pytest.mark.parametrize('is_obeyed', [True, False])
def test_wind_countermands_no_order_to_come_down(order, mode, is_obeyed):
    """Whom a person told to land does not climb again to fly home, nor is that offered."""
    air = flying(max_wind_mps=11.0, max_gust_mps=12.0, returns_in_wind=True)
    commands, copter = air.drones[1].commands, air.copters[1]
    getattr(commands, order)(air.now_s)
    count, on_command = commands.count, copter._on_command
    if is_obeyed:
        air.until(lambda: copter.mode == mode)
    else:
        copter._on_command = lambda _message: None
    for second in range(5):
        blow(air, 13.0 + second)
        air.drones[1].step(air.now_s)
        air.wait(1.0)
    copter._on_command = on_command
    assert commands.count == count
    assert (status(air).advice == '') is is_obeyed


@pytest.mark.parametrize(
    ('speeds', 'limits', 'verdict'),
    [
        ((), {'max_wind_mps': 8.0}, CheckVerdict.WARN),
        ((5.0, 6.0), {'max_wind_mps': 8.0}, CheckVerdict.PASS),
        ((9.0, 9.0), {'max_wind_mps': 8.0}, CheckVerdict.FAIL),
        ((5.0, 12.5), {'max_wind_mps': 9.0, 'max_gust_mps': 12.0}, CheckVerdict.FAIL),
        ((5.0, 12.5), {'max_wind_mps': 9.0}, CheckVerdict.PASS),
    ],
)
def test_wind_is_judged_before_a_flight(speeds, limits, verdict):
    """The mean and the gust of the last minute; what is not told is warned of."""
    wind = Wind()
    for second, speed in enumerate(speeds):
        wind = wind.after(speed, 2.0 * second)
    (check,) = wind_checks(wind, FlightLimits(**limits), 10.0)
    assert check.verdict is verdict
    assert wind_checks(wind, FlightLimits(), 10.0) == []
    assert math.isnan(wind.mean_mps(200.0))


def test_height_above_the_ground_is_bounded():
    """On a hill the height above home may be more; where the ground is not known it may not."""
    air = ready_air()

    def verdict(height_m, height_agl_m):
        place = plan(1).waypoints[0].position
        way = FlightWaypoint(position=place, height_m=height_m, height_agl_m=height_agl_m)
        flown = replace(plan(1), waypoints=(way,))
        checks = route_checks(
            air.vehicle(), flown, FlightLimits(), air.drones[1].session.readout.settings
        )
        return next(check.verdict for check in checks if check.name == 'heights')

    assert verdict(150.0, 60.0) is CheckVerdict.PASS
    assert verdict(60.0, 130.0) is CheckVerdict.FAIL
    assert verdict(130.0, None) is CheckVerdict.FAIL
    assert verdict(119.0, None) is CheckVerdict.PASS


@pytest.mark.parametrize(
    ('kind', 'found', 'verdict'),
    [
        (MULTICOPTER.name, {'GF_ACTION': 0.0}, CheckVerdict.WARN),
        (MULTICOPTER.name, {'GF_ACTION': 1.0}, CheckVerdict.WARN),
        (MULTICOPTER.name, {'GF_ACTION': 2.0}, CheckVerdict.PASS),
        (MULTICOPTER.name, {'GF_ACTION': 3.0}, CheckVerdict.PASS),
        (MULTICOPTER.name, {'GF_ACTION': 4.0}, CheckVerdict.FAIL),
        (MULTICOPTER.name, {'GF_ACTION': 5.0}, CheckVerdict.PASS),
        (COPTER.name, {'FENCE_ACTION': 0.0}, CheckVerdict.WARN),
        (COPTER.name, {'FENCE_ACTION': 1.0}, CheckVerdict.PASS),
    ],
)
def test_action_at_the_fence_is_judged_by_its_value(kind, found, verdict):
    """One that only reports is warned of; one that stops the motors forbids a flight."""
    reader = ParameterReader(kind=kind, target=(1, 1), found=found, asks=99)
    known = VehicleSettings(parameters=reader, station=255)
    checks = setting_checks(known, FlightLimits())
    (check,) = [check for check in checks if check.name == 'action at the fence']
    assert check.verdict is verdict


def test_option_that_is_none_is_refused():
    """By one line that names what there is."""
    with pytest.raises(ValueError, match="on_wind is 'land': must be one of warn, return"):
        DroneOptions(name='rav1', link='udp://127.0.0.1:14550', on_wind='land')
