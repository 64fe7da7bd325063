# SPDX-License-Identifier: Apache-2.0
"""A mission that loses a vehicle in the air: the others photograph what it has not."""

import json
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from .conftest import Flight

pytestmark = pytest.mark.system

SCENARIO = Path(__file__).with_name('loss.yaml')
Launch = Callable[..., Flight]


@pytest.fixture
def launch(rocsafe: Path, ros_domain_id: int, tmp_path: Path) -> Iterator[Launch]:
    """Give a function that starts the mission; end what still flies after the test."""
    flights = []

    def start(*options: str) -> Flight:
        folder = tmp_path / 'flight'
        flights.append(Flight(rocsafe, ros_domain_id, folder, *options, scenario=SCENARIO))
        return flights[-1]

    yield start
    for flight in flights:
        if flight.process.poll() is None:
            os.killpg(flight.process.pid, signal.SIGKILL)
            flight.process.wait()


def test_battery_fails_and_the_others_take_over(launch: Launch) -> None:
    """Every viewpoint is photographed, the mission is complete, and tells who was lost."""
    flight = launch()
    assert flight.end() == 0, flight.output
    assert 'the battery failed' in flight.output
    assert 'the others take over' in flight.output
    plan = json.loads(flight.run.plan.read_text())
    planned = {view['id'] for route in plan['routes'] for view in route['viewpoints']}
    manifest = (flight.run.images / 'manifest.jsonl').read_text().splitlines()
    seen = [json.loads(line)['viewpoint_id'] for line in manifest]
    assert set(seen) == planned
    assert len(seen) == len(planned)
    assert list(flight.info()['lost_vehicles']) == ['rav2']
    (rest,) = flight.run.path.glob('further-*/plan.json')
    names = [route['vehicle'] for route in json.loads(rest.read_text())['routes']]
    assert names == ['rav1', 'rav3']
    assert flight.living() == []
