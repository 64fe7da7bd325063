# SPDX-License-Identifier: Apache-2.0
"""No vehicle takes off while another of the same bridge is in the way."""

import dataclasses

import pytest
from test.fakes.fake_autopilot import HOME
from test.mavlink.test_station import LIMITS, Air

from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.drone.take_off_space import in_the_way
from rocsafe_mavlink.errors import WaitError
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome
from rocsafe_mavlink.knowledge.telemetry import Motion

SEPARATION_M = 10.0
# COMPONENT_ARM_DISARM, and a mode.
ARM, LOITER = 400, 5


def at(north_m, altitude_m):
    """Return where a vehicle is, north of the pad."""
    return Motion(
        position=GeoPosition(HOME[0] + north_m / 111_200.0, HOME[1]),
        altitude_msl_m=altitude_m,
        height_above_home_m=0.0,
        velocity_enu_mps=(0.0, 0.0, 0.0),
        yaw_rad=0.0,
        boot_s=0.0,
        heard_s=0.0,
    )


@pytest.mark.parametrize(
    ('place', 'words'),
    [
        (at(0.0, 100.0), 'rav2 is 0 m away'),
        (at(6.0, 106.0), 'rav2 is 8 m away'),
        (at(0.0, 111.0), ''),
        (at(11.0, 100.0), ''),
        (None, 'rav2 has running motors and tells no position'),
    ],
)
def test_who_is_nearer_than_the_separation_is_in_the_way(place, words):
    """In space, not on the level: who has climbed out of the way is not."""
    found = in_the_way(at(0.0, 100.0), [('rav2', place)], SEPARATION_M, 1.0)
    assert found.startswith(words)
    assert bool(found) == bool(words)
    assert in_the_way(at(0.0, 100.0), [('rav2', place)], 0.0, 1.0) == ''


def test_who_was_not_heard_of_lately_is_told_with_the_age_of_its_place():
    """It may stand there yet."""
    found = in_the_way(at(0.0, 100.0), [('rav2', at(3.0, 100.0))], SEPARATION_M, 90.0)
    assert 'rav2 is 3 m away with running motors, last heard 90 s ago' in found


def two_on_a_pad():
    """Return an air in which two copters stand at one place, ready to fly."""
    air = Air(2, limits=dataclasses.replace(LIMITS, separation_m=SEPARATION_M))
    for drone in air.drones.values():
        drone.others = tuple(air.drones.values())
    air.wait(46.0)
    return air


@pytest.mark.slow
def test_two_that_are_started_together_take_off_one_after_the_other():
    """Both routes are sent; the motors of the second start when the first is high enough."""
    air = two_on_a_pad()
    air.fly(1)
    air.fly(2)
    first, second = air.copters.values()
    air.until(lambda: first.is_armed or second.is_armed)
    if second.is_armed:
        first, second = second, first
    air.until(lambda: second.is_armed, 40.0)
    assert first.height_m >= SEPARATION_M - 1.0
    air.until(lambda: air.flight(1).is_over and air.flight(2).is_over)
    assert {air.flight(system).outcome for system in (1, 2)} == {FlightOutcome.COMPLETED}


@pytest.mark.slow
def test_goal_waits_while_a_pilot_hovers_above():
    """It can be tried again, and flies once the other has landed."""
    air = two_on_a_pad()
    air.copters[1].be_flown(LOITER)
    air.wait(2.0)
    with pytest.raises(WaitError, match='rav1 is 5 m away with running motors'):
        air.fly(2)
    air.copters[1].be_landed()
    air.wait(2.0)
    air.fly(2)
    assert air.flight(2) is not None


@pytest.mark.slow
def test_motors_stay_off_below_a_pilot_who_has_come_meanwhile():
    """After the route was sent; the start fails if he stays."""
    air = two_on_a_pad()
    air.fly(2)
    air.copters[1].be_flown(LOITER)
    air.until(lambda: air.flight(2).is_over)
    assert air.flight(2).outcome is FlightOutcome.REJECTED
    assert ARM not in air.copters[2].commands
