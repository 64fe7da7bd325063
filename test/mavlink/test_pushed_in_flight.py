# SPDX-License-Identifier: Apache-2.0
"""Fence and rally points that are given in flight: none that the flight could not keep."""

from dataclasses import replace

import pytest
from test.mavlink.test_homeward import HOME_PLACE, flying_around
from test.mavlink.test_station import ready_air
from test.mavlink.test_unknown_way import flying

from rocsafe_geo.position import offset
from rocsafe_mavlink.autopilots.ardupilot import BRAKE
from rocsafe_mavlink.errors import CommandRefusedError
from rocsafe_mavlink.plan.fence import Fence, rally_items

# Behind the square of `around`, as seen from its last legs.
BEHIND = offset(HOME_PLACE, -60.0, 100.0)


def field(north_m, south_m=-50.0):
    """Return a field about home that ends so far north."""
    corners = ((-90.0, south_m), (90.0, south_m), (90.0, north_m), (-90.0, north_m))
    return tuple(offset(HOME_PLACE, *corner) for corner in corners)


@pytest.mark.slow
@pytest.mark.parametrize(
    ('fence', 'words'),
    [
        (Fence(inclusions=(field(20.0),)), 'the vehicle would be outside the fence at once'),
        (Fence(inclusions=(field(160.0),)), 'waypoints outside'),
        (Fence(exclusions=(field(260.0, 240.0),)), 'waypoints outside'),
    ],
)
def test_fence_that_the_flight_would_leave_is_refused_in_the_air(fence, words):
    """It would break the flight off at once, or later; on the ground the pre-flight judges it."""
    air = flying()
    commands, count = air.drones[1].commands, air.drones[1].commands.count
    with pytest.raises(CommandRefusedError, match=words):
        commands.push_fence(fence, air.now_s)
    assert commands.count == count
    commands.push_fence(Fence(inclusions=(field(400.0),)), air.now_s)
    air.until(lambda: commands.outcome(commands.count) is not None, 60.0)
    assert commands.outcome(commands.count) == ''


def test_any_fence_is_taken_on_the_ground():
    """No flight begins that it does not hold."""
    air = ready_air()
    air.drones[1].commands.push_fence(Fence(inclusions=(field(20.0),)), air.now_s)


def flying_with_two_ways_home():
    """Return an air whose copter may give up anywhere: a rally point lies at each end."""
    ends = (offset(HOME_PLACE, 30.0, 160.0), offset(HOME_PLACE, 60.0, 60.0))
    air = flying_around()
    air.copters[1].mode, air.copters[1].parameters['OA_TYPE'] = BRAKE, 0.0
    readout = air.drones[1].session.readout
    found = {**readout.settings.parameters.found, 'OA_TYPE': 0.0, 'RALLY_INCL_HOME': 0.0}
    readout.settings = replace(
        readout.settings, parameters=replace(readout.settings.parameters, found=found)
    )
    write_rally(air, ends)
    assert air.drones[1].status(air.now_s).advice == ''
    return air


def write_rally(air, places):
    """Let another station write rally points, and wait until they were read."""
    air.copters[1].missions.stored[2] = list(rally_items(places, 30.0))
    air.wait(40.0)


@pytest.mark.slow
def test_rally_points_behind_an_exclusion_are_refused_in_the_air():
    """Who gives up flies straight to the nearest."""
    air = flying_with_two_ways_home()
    commands = air.drones[1].commands
    with pytest.raises(CommandRefusedError, match='way home is exclusion 1 lies between leg'):
        commands.push_rally([BEHIND], 30.0, air.now_s)


@pytest.mark.slow
def test_rally_points_that_another_station_moves_are_told_with_a_hold():
    """Nothing is commanded by itself."""
    air = flying_with_two_ways_home()
    write_rally(air, [BEHIND])
    status = air.drones[1].status(air.now_s)
    assert status.advice == 'hold'
    assert 'its rally points or its fence were changed' in status.text
    assert 'exclusion 1 lies between leg' in status.text
    assert air.copters[1].mode == BRAKE
