# SPDX-License-Identifier: Apache-2.0
"""Modes and states of the two families of autopilots."""

import pytest
from test.mavlink.telemetry import after, heartbeat, landed, mission, ready

from rocsafe_mavlink.autopilots.ardupilot import COPTER
from rocsafe_mavlink.autopilots.autopilot import FlightState, Verb
from rocsafe_mavlink.autopilots.px4 import MULTICOPTER, custom_mode
from rocsafe_mavlink.autopilots.registry import autopilot_of
from rocsafe_mavlink.knowledge.telemetry import VehicleTelemetry

NOW_S = 100.0


def flying(mode, *messages):
    """Return a vehicle in the air in a mode."""
    return after(heartbeat(mode, armed=True, status=4), landed(2), *messages, vehicle=ready())


@pytest.mark.parametrize(
    ('vehicle', 'state'),
    [
        (VehicleTelemetry(system=1, component=1), FlightState.UNKNOWN),
        (ready(), FlightState.DISARMED),
        (after(heartbeat(4, armed=True), vehicle=ready()), FlightState.ARMED),
        (after(landed(3), vehicle=flying(3)), FlightState.TAKING_OFF),
        (flying(3, mission(3)), FlightState.FLYING),
        (flying(3, mission(3, 4)), FlightState.HOLDING),
        (flying(5, mission(3, 4)), FlightState.HOLDING),
        (flying(17), FlightState.HOLDING),
        (flying(4), FlightState.FLYING),
        (flying(6), FlightState.RETURNING),
        (flying(21), FlightState.RETURNING),
        (flying(27), FlightState.RETURNING),
        (flying(9), FlightState.LANDING),
        (after(landed(4), vehicle=flying(6)), FlightState.LANDING),
        (flying(99), FlightState.UNKNOWN),
        (after(landed(1), heartbeat(3), vehicle=flying(3)), FlightState.LANDED),
    ],
)
def test_copter_state(vehicle, state):
    """Mode, landed state and mission state together say what it does."""
    assert COPTER.state_of(vehicle, NOW_S) is state


def test_silent_vehicle_is_lost():
    """Whatever it did last."""
    assert COPTER.state_of(flying(3), NOW_S + 10.0) is FlightState.LOST


@pytest.mark.parametrize(
    ('kind', 'verb', 'parameters'),
    [
        (COPTER, Verb.GUIDED, (1, 4, 0)),
        (COPTER, Verb.MISSION, (1, 3, 0)),
        (COPTER, Verb.RETURN, (1, 6, 0)),
        (MULTICOPTER, Verb.MISSION, (1, 4, 4)),
        (MULTICOPTER, Verb.RETURN, (1, 4, 5)),
        (MULTICOPTER, Verb.GUIDED, (1, 6, 0)),
    ],
)
def test_mode_is_asked_for_in_its_own_way(kind, verb, parameters):
    """ArduPilot takes a number, PX4 a main and a sub mode."""
    command = kind.mode_command(verb, (1, 1))
    assert command['command'] == 176
    assert tuple(command[f'param{number}'] for number in (1, 2, 3)) == parameters


def test_unknown_mode_has_no_neighbours_name():
    """A number that nobody named is published as a number."""
    assert COPTER.mode_name(3) == 'AUTO'
    assert COPTER.mode_name(8) == 'UNKNOWN(8)'
    assert MULTICOPTER.mode_name(custom_mode(4, 4)) == 'AUTO.MISSION'


def test_autopilot_is_told_by_its_heartbeat():
    """Two families are known, and of them multicopters."""
    assert autopilot_of(3, 2) is COPTER
    assert autopilot_of(12, 13) is MULTICOPTER
    assert COPTER.is_tested
    assert MULTICOPTER.is_tested
    with pytest.raises(ValueError, match='autopilot = 8 is not known; known are 3'):
        autopilot_of(8, 2)
    with pytest.raises(ValueError, match='vehicle type = 1 is no multicopter'):
        autopilot_of(3, 1)


@pytest.mark.parametrize('kind', [COPTER, MULTICOPTER], ids=lambda kind: kind.name)
def test_every_mode_that_is_used_has_a_name(kind):
    """So that it can be said to people."""
    assert set(kind.modes) == set(Verb)
    assert set(kind.modes.values()) | set(kind.states) <= set(kind.mode_names)
