# SPDX-License-Identifier: Apache-2.0
"""Missions whose vehicles have agents: they go on when the orchestrator is gone."""

import json
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from rocsafe_orchestrator.products.photographs import read_photographs

from .conftest import DEADLINE_S, Flight

pytestmark = pytest.mark.system

SCENARIO = Path(__file__).with_name('agents.yaml')
Fly = Callable[..., Flight]


def planned(flight: Flight) -> set[int]:
    """Return the viewpoints of the survey."""
    plan = json.loads(flight.run.plan.read_text())
    return {view['id'] for route in plan['routes'] for view in route['viewpoints']}


def photographed(flight: Flight) -> set[int]:
    """Return the viewpoints of the photographs that are stored."""
    return {shot.viewpoint_id for shot in read_photographs(flight.run.images)}


def test_mission_goes_on_without_its_orchestrator(fly: Fly) -> None:
    """It is killed in the flight, with one vehicle: the others photograph all, then all ends.

    The end of the orchestrator's process ends no other: the agents fly what is left, and when all
    have landed every process ends by itself.
    """
    flight = fly('--speed', '12')
    flight.wait_for_images(2)
    assert photographed(flight) < planned(flight)
    vehicle = flight.pid_of('rav3')
    flight.process.send_signal(signal.SIGKILL)
    flight.process.wait()
    os.kill(vehicle, signal.SIGKILL)
    end = time.monotonic() + DEADLINE_S
    while flight.living() and time.monotonic() < end:
        time.sleep(0.1)
    log = flight.run.log_of('agents').read_text()
    assert photographed(flight) == planned(flight), log
    assert flight.living() == [], log
    assert 'simulated time goes on without' in log


@pytest.mark.all
def test_agents_take_over_from_a_lost_vehicle(fly: Fly) -> None:
    """With an orchestrator, too: it only watches, and the mission is complete."""
    flight = fly('--speed', '12')
    flight.wait_for_images(2)
    while 'the agents of the others take over' not in flight.output:
        assert flight.process.poll() is None, flight.output
        pid = flight.pid_of('rav3')
        if pid in flight.living():
            os.kill(pid, signal.SIGKILL)
        time.sleep(0.05)
    assert flight.end() == 0, flight.output
    assert photographed(flight) == planned(flight)
