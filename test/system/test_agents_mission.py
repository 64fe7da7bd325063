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


@pytest.mark.all
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
    # What the agents know of the hazard is left on their host, with the readings of the lost one.
    rows = (flight.run.path / 'agents' / 'readings.csv').read_text().splitlines()[1:]
    assert {row.partition(',')[0] for row in rows} == {'rav1', 'rav2', 'rav3'}


@pytest.mark.all
def test_mission_without_its_orchestrator_goes_on_after_a_standstill(fly: Fly) -> None:
    """All its processes stand still for longer than DDS remembers them."""
    flight = fly('--speed', '6')
    flight.wait_for_images(2)
    flight.process.send_signal(signal.SIGKILL)
    flight.process.wait()
    agents = flight.run.log_of('agents')
    time.sleep(1.0)
    assert photographed(flight) < planned(flight)
    stopped = flight.living()
    for number in (signal.SIGSTOP, signal.SIGCONT):
        for pid in stopped:
            os.kill(pid, number)
        time.sleep(45.0 if number == signal.SIGSTOP else 0.0)
    end = time.monotonic() + DEADLINE_S
    while flight.living() and time.monotonic() < end:
        time.sleep(0.1)
    assert flight.living() == [], agents.read_text()
    assert photographed(flight) == planned(flight), agents.read_text()


@pytest.mark.all
def test_resumed_mission_is_joined_and_brought_to_its_end(fly: Fly) -> None:
    """The orchestrator is killed in the flight and comes back: no process but it was started anew.

    Every viewpoint is photographed once, nothing that was stored is lost, and map, report and
    recording are those of the whole mission.
    """
    flight = fly('--speed', '6')
    flight.wait_for_images(2)
    run, before = flight.run, flight.living()
    flight.process.send_signal(signal.SIGKILL)
    flight.process.wait()
    stored = flight.images()
    resumed = fly('--resume', run.path, is_new=False)
    assert resumed.end() == 0, resumed.output
    assert f'{len(before)} processes run' in resumed.output
    shots = read_photographs(run.images)
    assert sorted(shot.viewpoint_id for shot in shots) == sorted(planned(flight))
    assert stored.items() <= flight.images().items()
    assert flight.living() == []
    summary = json.loads(run.summary.read_text())
    assert summary['outcome'] == 'complete', summary
    assert run.mosaic.is_file()
    assert '<h2>Agents</h2>' in run.report.read_text()
    assert len(flight.info()['resumed']) == 1
    assert not run.session.exists()


@pytest.mark.all
def test_resumed_after_the_last_landing_the_run_gets_its_map_and_report(fly: Fly) -> None:
    """All processes have ended: nothing flies again, what was recorded is finished."""
    flight = fly('--speed', '12')
    flight.wait_for_images(2)
    flight.process.send_signal(signal.SIGKILL)
    flight.process.wait()
    end = time.monotonic() + DEADLINE_S
    while flight.living() and time.monotonic() < end:
        time.sleep(0.1)
    resumed = fly('--resume', flight.run.path, is_new=False)
    assert resumed.end() == 0, resumed.output
    assert photographed(flight) == planned(flight)
    assert flight.run.mosaic.is_file()
    again = fly('--resume', flight.run.path, is_new=False)
    assert again.end() == 3
    assert 'cannot be resumed: it is over' in again.output


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
    assert flight.run.further_plans, 'the report draws the plan of those who took over'
    assert ' for the rest: ' in flight.run.report.read_text(encoding='utf-8')


@pytest.mark.all
@pytest.mark.parametrize('comes_back', [True, False])
def test_vehicle_that_stands_still_does_not_hang_the_mission(fly: Fly, comes_back: bool) -> None:
    """Its process is stopped until the others go on without it; where it comes back, it holds."""
    flight = fly('--speed', '12')
    flight.wait_for_images(2)
    vehicle = flight.pid_of('rav3')
    os.kill(vehicle, signal.SIGSTOP)
    try:
        flight.wait_until(lambda: 'the agents of the others take over' in flight.output)
        if comes_back:
            os.kill(vehicle, signal.SIGCONT)
        assert flight.end() == 0, flight.output
    finally:
        if vehicle in flight.living():
            os.kill(vehicle, signal.SIGCONT)
    assert photographed(flight) == planned(flight)
    lost = json.loads(flight.run.summary.read_text())['lost_vehicles']
    assert list(lost) == ['rav3']
