# SPDX-License-Identifier: Apache-2.0
"""A mission that loses vehicles in the air: the others photograph what they have not."""

import json
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from rocsafe_orchestrator.products.photographs import read_photographs

from .conftest import Flight

pytestmark = pytest.mark.system

SCENARIO = Path(__file__).with_name('loss.yaml')
Fly = Callable[..., Flight]


@pytest.mark.all
def test_others_take_over_from_two_that_are_lost(fly: Fly) -> None:
    """One's process keeps dying, the other's battery fails: the last photographs the rest.

    Time does not wait for the one that is gone; the mission is complete and tells who was lost.
    """
    flight = fly('--speed', '12')
    flight.wait_for_images(2)
    while 'the others take over' not in flight.output and flight.process.poll() is None:
        pid = flight.pid_of('rav3')
        if pid in flight.living():
            os.kill(pid, signal.SIGKILL)
        time.sleep(0.05)
    assert flight.end() == 0, flight.output
    assert 'the battery failed' in flight.output
    assert set(flight.info()['lost_vehicles']) == {'rav2', 'rav3'}
    plan = json.loads(flight.run.plan.read_text())
    planned = {view['id'] for route in plan['routes'] for view in route['viewpoints']}
    assert {shot.viewpoint_id for shot in read_photographs(flight.run.images)} == planned
    rests = [json.loads(path.read_text()) for path in flight.run.path.glob('further-*/plan.json')]
    assert ['rav1', 'rav2'] in [[route['vehicle'] for route in rest['routes']] for rest in rests]
    assert flight.living() == []


@pytest.mark.all
def test_vehicle_that_stands_still_is_replaced_and_comes_back(fly: Fly) -> None:
    """Its process stops for a while: the others take over, and it never flies their viewpoints.

    Every viewpoint is photographed once, and the mission is complete.
    """
    flight = fly('--speed', '12')
    flight.wait_for_images(2)
    pid = flight.pid_of('rav3')
    os.kill(pid, signal.SIGSTOP)
    try:
        flight.wait_until(lambda: 'rav3: nothing heard for 15 s; the others' in flight.output)
    finally:
        os.kill(pid, signal.SIGCONT)
    assert flight.end() == 0, flight.output
    plan = json.loads(flight.run.plan.read_text())
    planned = sorted(view['id'] for route in plan['routes'] for view in route['viewpoints'])
    shots = read_photographs(flight.run.images)
    assert sorted(shot.viewpoint_id for shot in shots) == planned
    assert flight.living() == []


@pytest.mark.all
def test_announced_loss_is_the_same_in_every_run(fly: Fly) -> None:
    """From the same seed: the same plan for the rest, readings and photographs, bit by bit."""
    results = []
    for _ in range(2):
        flight = fly()
        assert flight.end() == 0, flight.output
        assert 'rav2: aborted its flight: the battery failed' in flight.output
        (rest,) = flight.run.path.glob('further-*/plan.json')
        readings = flight.run.readings.read_bytes()
        results.append((rest.read_bytes(), readings, sorted(flight.images().items())))
    assert results[0] == results[1]
