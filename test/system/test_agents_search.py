# SPDX-License-Identifier: Apache-2.0
"""Missions whose agents search after the survey: whoever is killed, the rounds are flown."""

import json
import os
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from rocsafe_orchestrator.products.photographs import read_photographs

from .conftest import DEADLINE_S, Flight

pytestmark = pytest.mark.system

SCENARIO = Path(__file__).with_name('agents_search.yaml')
PLACES, ROUNDS = 3, 2
Fly = Callable[..., Flight]


def planned(flight: Flight) -> set[int]:
    """Return the viewpoints of the survey."""
    plan = json.loads(flight.run.plan.read_text())
    return {view['id'] for route in plan['routes'] for view in route['viewpoints']}


def photographed(flight: Flight) -> set[int]:
    """Return the viewpoints of the photographs that are stored."""
    return {shot.viewpoint_id for shot in read_photographs(flight.run.images)}


def agents_log(flight: Flight) -> str:
    """Return what the agents have said so far."""
    path = flight.run.log_of('agents')
    return path.read_text() if path.is_file() else ''


def nearest_m(flight: Flight) -> float:
    """Return how near two vehicles came in the air, by their positions as recorded."""
    return float(json.loads(flight.run.summary.read_text())['nearest']['distance_m'])


def rounds_in(page: str) -> int:
    """Return the rows of the report's table of rounds."""
    table = page.partition('Rounds of the search</h3>')[2].partition('</table>')[0]
    return table.count('<tr') - 1


@pytest.mark.all
def test_agents_fly_the_rounds_of_the_search(complete: Flight) -> None:
    """All places of both rounds are photographed, the report tells them, and nobody is left."""
    assert complete.info()['outcome'] == 'complete'
    further = photographed(complete) - planned(complete)
    assert planned(complete) < photographed(complete)
    assert len(further) == PLACES * ROUNDS
    page = complete.run.report.read_text()
    assert rounds_in(page) == ROUNDS
    # Also who gets a new route while another one lands: 10 m are kept, but for errors of GPS.
    assert nearest_m(complete) > 9.5
    assert complete.living() == []


def test_search_goes_on_without_the_orchestrator_and_a_vehicle(fly: Fly, rocsafe: Path) -> None:
    """It is killed in the survey, a vehicle when the first round begins: the others do the rest.

    The end of the orchestrator's process ends no other: the agents fly the survey and both rounds,
    and when all have landed every process ends by itself. The report can be made then.
    """
    flight = fly('--speed', '12')
    flight.wait_for_images(2)
    assert photographed(flight) < planned(flight)
    vehicle = flight.pid_of('rav1')
    flight.process.send_signal(signal.SIGKILL)
    flight.process.wait()
    wait_until(lambda: 'epoch 1,' in agents_log(flight))
    os.kill(vehicle, signal.SIGKILL)
    wait_until(lambda: not flight.living())
    log = agents_log(flight)
    assert 'simulated time goes on without' in log
    assert planned(flight) <= photographed(flight), log
    assert len(photographed(flight) - planned(flight)) == PLACES * ROUNDS, log
    # What the agents know of the hazard is left on their host, with the readings of the lost one.
    rows = (flight.run.path / 'agents' / 'readings.csv').read_text().splitlines()[1:]
    assert {row.partition(',')[0] for row in rows} == {'rav1', 'rav2', 'rav3'}
    subprocess.run([rocsafe, 'report', flight.run.path], check=True, timeout=DEADLINE_S)
    page = flight.run.report.read_text()
    assert rounds_in(page) == ROUNDS
    assert nearest_m(flight) > 9.5


def wait_until(condition: Callable[[], bool]) -> None:
    """Wait until `condition` holds, with or without an orchestrator."""
    end = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.1)
