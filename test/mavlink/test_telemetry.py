# SPDX-License-Identifier: Apache-2.0
"""What is known of a vehicle follows from its messages alone, in our units."""

import csv
import math
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from test.mavlink.telemetry import (
    EKF_LOST,
    after,
    gps,
    heartbeat,
    landed,
    mission,
    position,
    ready,
    said,
)

from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_mavlink.knowledge.events import EventKind
from rocsafe_mavlink.knowledge.fix import fix_fault, separation_m
from rocsafe_mavlink.knowledge.reducer import reduce
from rocsafe_mavlink.knowledge.telemetry import Battery, Contact, Home, VehicleTelemetry
from rocsafe_mavlink.wire.dialect import Message
from rocsafe_mavlink.wire.units import deg_of_e7, e7_of_deg, yaw_of_centidegrees

NOW_S = 100.0


def kinds(vehicle, message):
    """Return the kinds of the events of a message."""
    return [event.kind for event in reduce(vehicle, message, NOW_S)[1]]


@given(st.integers(-1_800_000_000, 1_800_000_000))
def test_places_survive_both_ways(angle_e7):
    """Integer degrees come back exactly: nothing is cut off."""
    assert e7_of_deg(deg_of_e7(angle_e7)) == angle_e7


def test_units_are_ours():
    """Millimetres, centimetres a second north-east-down and headings become SI and ENU."""
    motion = ready().motion
    assert motion.position.latitude_deg == 47.397742
    assert motion.position.longitude_deg == 8.545594
    assert motion.altitude_msl_m == 488.0
    assert motion.velocity_enu_mps == (-2.0, 1.0, -0.5)
    assert motion.yaw_rad == pytest.approx(0.0)
    assert motion.boot_s == 50.0
    assert ready().battery == Battery(fraction=0.8, voltage_v=12.6, current_a=28.0)
    assert ready().home == Home(latitude_deg=47.397742, longitude_deg=8.545594, altitude_msl_m=488)


def test_unknown_is_nan_and_not_a_number():
    """Each "not known" of the wire is NaN here."""
    assert math.isnan(yaw_of_centidegrees(65535))
    status = {'battery_remaining': -1, 'voltage_battery': 65535, 'current_battery': -1}
    vehicle = after(said('SYS_STATUS', onboard_control_sensors_health=0, **status), gps(h_acc=0))
    assert math.isnan(vehicle.battery.fraction)
    assert math.isnan(vehicle.battery.voltage_v)
    assert math.isnan(vehicle.battery.current_a)
    assert math.isnan(vehicle.gps.horizontal_std_m)


@pytest.mark.parametrize(
    ('measured_m', 'given_m', 'expected_m'),
    [(47.0, math.nan, 47.0), (-34.0, 10.0, -34.0), (0.0, 47.0, 47.0), (200.0, 47.0, 47.0)],
    ids=['Switzerland', 'Ohio, before the parameter', 'equal is unknown', 'nonsense'],
)
def test_altitude_is_above_the_ellipsoid(measured_m, given_m, expected_m):
    """The receiver's own difference comes first, then the parameter."""
    assert separation_m(488.0, 488.0 + measured_m, given_m) == expected_m
    fix = gps(alt_ellipsoid=488000 + round(measured_m * 1000))
    vehicle = after(fix, position(), given_separation_m=given_m)
    assert vehicle.motion.position.altitude_m == 488.0 + expected_m


def test_altitude_is_nan_rather_than_of_another_datum():
    """Without any source the altitude is not known, the place is."""
    assert math.isnan(ready().motion.position.altitude_m)
    assert math.isnan(separation_m(488.0, 0.0, math.nan))


def test_geoid_is_held_in_flight():
    """The vertical track does not step when the receiver changes its mind."""
    vehicle = after(gps(alt_ellipsoid=535000), heartbeat(armed=True))
    vehicle = after(gps(alt_ellipsoid=454000), position(), vehicle=vehicle)
    assert vehicle.motion.position.altitude_m == 535.0


def test_good_fix_is_believed():
    """A ready vehicle has a position."""
    assert fix_fault(ready(), NOW_S) == ''


@pytest.mark.parametrize(
    ('message', 'words'),
    [
        (gps(2_000_000, fix_type=1), 'no fix'),
        (said('EKF_STATUS_REPORT', flags=EKF_LOST), 'does not use'),
        (position(50.1, lat=0, lon=0), 'zero of the map'),
        (position(50.1, lat=473977420 + 10_000), 'jumped'),
    ],
    ids=['receiver', 'estimate', 'before the first fix', 'jump of 111 m'],
)
def test_fix_is_lost_by_the_first_sign(message, words):
    """Positions keep coming; they are not believed."""
    assert words in fix_fault(after(message, vehicle=ready()), NOW_S)


def test_fix_is_lost_when_time_stands_still():
    """A receiver that repeats itself for a second, or silence, is no position."""
    vehicle = after(gps(), position(51.2), vehicle=ready(), now_s=NOW_S + 1.2)
    assert 'time stands still' in fix_fault(vehicle, NOW_S + 1.2)
    assert 'no position comes' in fix_fault(ready(), NOW_S + 1.2)
    assert 'no position comes' in fix_fault(VehicleTelemetry(system=1, component=1), NOW_S)
    assert 'not been heard of' in fix_fault(replace(ready(), ekf_flags=None), NOW_S)


def test_late_message_changes_nothing():
    """A position that was overtaken on the way is not taken for a newer one."""
    vehicle = ready()
    assert after(position(49.9, lat=0), vehicle=vehicle) == vehicle


@pytest.mark.parametrize('message', [heartbeat(0, status=1), position(3.0)], ids=['boot', 'time'])
def test_reboot_is_noticed_and_forgets(message):
    """After a new start nothing is known but what is said again."""
    vehicle, events = reduce(ready(), message, NOW_S)
    assert EventKind.REBOOTED in {event.kind for event in events}
    assert vehicle.home is None
    assert vehicle.ekf_flags is None


def test_other_senders_change_nothing():
    """Neither another vehicle nor another component on the same link."""
    vehicle = ready()
    for system, component in ((2, 1), (1, 154)):
        other = Message('HEARTBEAT', heartbeat(9, armed=True).fields, system, component)
        assert reduce(vehicle, other, NOW_S) == (vehicle, [])


def test_station_on_the_same_address_is_no_autopilot():
    """A heartbeat of what is no autopilot keeps nothing alive."""
    station = said('HEARTBEAT', type=6, autopilot=8, base_mode=0, custom_mode=0, system_status=4)
    assert after(station).contact(NOW_S) is Contact.NONE


@pytest.mark.parametrize(
    ('silence_s', 'contact'), [(2.9, Contact.FRESH), (3.0, Contact.STALE), (10.0, Contact.LOST)]
)
def test_silence_is_told(silence_s, contact):
    """Three seconds make it stale, ten lost; only heartbeats count."""
    vehicle = after(position(60.0), vehicle=ready(), now_s=NOW_S + 2.0)
    assert vehicle.contact(NOW_S + silence_s) is contact


def test_events_tell_what_changed():
    """One event a change, in the vehicle's own words where it has some."""
    assert kinds(VehicleTelemetry(system=1, component=1), heartbeat(0, status=0)) == [
        EventKind.FOUND,
    ]
    assert kinds(ready(), heartbeat(3, armed=True)) == [EventKind.ARMED, EventKind.MODE]
    assert kinds(ready(), heartbeat(status=5)) == [EventKind.STATUS]
    assert kinds(ready(), landed(2)) == [EventKind.LANDED]
    assert kinds(ready(), said('MISSION_ITEM_REACHED', seq=3)) == [EventKind.REACHED]
    assert kinds(ready(), said('FENCE_STATUS', breach_status=1)) == [EventKind.FENCE]
    assert kinds(ready(), heartbeat()) == []
    _, (event,) = reduce(ready(), said('STATUSTEXT', text='Arm: no', severity=3), NOW_S)
    assert (event.kind, event.text, event.severity) == (EventKind.TEXT, 'Arm: no', 3)


def test_reached_items_never_go_back_in_a_flight():
    """They begin anew when it is armed again."""
    vehicle = after(heartbeat(3, armed=True), vehicle=ready())
    for number in (2, 5, 3):
        vehicle = after(said('MISSION_ITEM_REACHED', seq=number), mission(3), vehicle=vehicle)
    assert (vehicle.mission.reached, vehicle.mission.current) == (5, 3)
    vehicle = after(heartbeat(), heartbeat(4, armed=True), vehicle=vehicle)
    assert vehicle.mission.reached == -1


def test_recorded_flight_is_followed():
    """The recorded survey's positions arrive without a jump, and at the same places."""
    path = Path(__file__).with_name('survey_track.csv')
    vehicle = ready()
    start_s = 100.0
    with path.open() as file:
        for row in csv.DictReader(file):
            sent = position(
                start_s + float(row['t_s']),
                lat=round(float(row['lat_deg']) * 1e7),
                lon=round(float(row['lon_deg']) * 1e7),
                alt=round(float(row['alt_amsl_m']) * 1000),
                vx=round(float(row['vn_mps']) * 100),
                vy=round(float(row['ve_mps']) * 100),
            )
            vehicle = after(sent, vehicle=vehicle)
            place = GeoPosition(float(row['lat_deg']), float(row['lon_deg']))
            assert distance_m(vehicle.motion.position, place) < 0.01
    assert vehicle.jumped_s == -math.inf
    assert vehicle.motion.altitude_msl_m == pytest.approx(float(row['alt_amsl_m']))
