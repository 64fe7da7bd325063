# SPDX-License-Identifier: Apache-2.0
"""A PX4 whose bridge was killed while it uploaded is freed every time, whenever another begins."""

import random

import numpy as np
import pytest
from test.fakes.px4_missions import IDLE, Px4Missions
from test.mavlink.hostile_vehicle import KIND, HostileVehicle, modes_of
from test.mavlink.test_flight import plan

from rocsafe_mavlink.autopilots.autopilot import Verb
from rocsafe_mavlink.autopilots.px4 import MULTICOPTER
from rocsafe_mavlink.drone.vehicle_session import VehicleSession
from rocsafe_mavlink.plan.flight_plan import mission_of
from rocsafe_mavlink.protocols.mission_transfer import TransferStage, transfer
from rocsafe_mavlink.wire.dialect import Message

US, TARGET = (255, 190), (1, 1)
STEP_S, LONGEST_S = 0.05, 90.0
ITEMS = mission_of(plan(4), MULTICOPTER).items


class Px4Vehicle(HostileVehicle):
    """A well-behaved vehicle but for the states of its mission protocol."""

    def __init__(self):
        super().__init__(MULTICOPTER, modes_of(MULTICOPTER, Verb), random.Random(1), KIND)
        self.missions = Px4Missions()

    def receive(self, message, now_s):
        """Take a message of the bridge."""
        if message.name.startswith('MISSION'):
            self.said += self.missions.receive(message, US, now_s)
        else:
            super().receive(message, now_s)

    def step(self, now_s):
        """Fly on; return what it said."""
        return self.missions.tick(now_s) + super().step(now_s)


def offered(at_s):
    """Return a vehicle to which a bridge offered 9 items, and was killed."""
    vehicle = Px4Vehicle()
    vehicle.missions.receive(Message('MISSION_COUNT', {'count': 9, 'mission_type': 0}), US, at_s)
    return vehicle


@pytest.mark.parametrize('later_s', np.arange(0.0, 7.0, 0.21).round(2).tolist())
def test_bridge_that_begins_at_any_time_can_upload(later_s):
    """It reads fence and rally points first, as ever; then its upload is taken and verified."""
    vehicle, session = offered(0.0), VehicleSession.of(TARGET, US)
    now_s, until_s = 0.0, later_s + LONGEST_S
    while session.readout.settings.rally is None:
        now_s += STEP_S
        assert now_s < until_s, 'nothing is read'
        for message in vehicle.step(now_s):
            if now_s > later_s:
                session.take(message, now_s)
        session.tick(now_s)
        for message in session.outgoing():
            vehicle.receive(message, now_s)
    assert run(vehicle, now_s).stage is TransferStage.VERIFIED


@pytest.mark.parametrize('items', [1, 9])
def test_stuck_autopilot_is_freed(items):
    """One that a reading left with its flag set refuses every offer, until a reading times out."""
    vehicle = offered(0.0)
    vehicle.missions.receive(Message('MISSION_REQUEST_LIST', {'mission_type': 1}), US, 0.1)
    vehicle.missions.receive(Message('MISSION_ACK', {'type': 0, 'mission_type': 1}), US, 0.2)
    assert vehicle.missions.state == IDLE
    assert vehicle.missions.is_in_progress
    moved = run(vehicle, 0.3, ITEMS[:items])
    assert moved.stage is TransferStage.VERIFIED
    assert moved.tries == 2 if items == 9 else moved.tries >= 2


def test_upload_that_another_took_the_place_of_is_taken_up():
    """A second upload is offered while the PX4 still asks for an item of the first."""
    vehicle = Px4Vehicle()
    first, sent = transfer(ITEMS, TARGET, first_compared=0).begin(0.0)
    for message in sent:
        vehicle.receive(message, 0.0)
    (request,) = [m for m in vehicle.said if m.name == 'MISSION_REQUEST_INT']
    first, sent = first.on_message(request, 0.1)
    for message in sent:
        vehicle.receive(message, 0.1)
    assert run(vehicle, 0.2).stage is TransferStage.VERIFIED


def run(vehicle, now_s, items=ITEMS):
    """Upload; return the transfer at its end."""
    end_s = now_s + LONGEST_S
    moving, sent = transfer(items, TARGET, first_compared=0).begin(now_s)
    while not moving.is_over:
        for message in sent:
            vehicle.receive(message, now_s)
        now_s += STEP_S
        assert now_s < end_s, 'the upload does not end'
        sent = []
        for message in vehicle.step(now_s):
            moving, more = moving.on_message(message, now_s)
            sent += more
        moving, more = moving.on_tick(now_s)
        sent += more
    return moving
