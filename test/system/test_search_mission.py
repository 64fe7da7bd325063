# SPDX-License-Identifier: Apache-2.0
"""Missions that fly again to where readings tell most, and lose none when a node is killed."""

import contextlib
import csv
import itertools
import json
import os
import signal
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.node import Node

from .conftest import Flight

SCENARIO = Path(__file__).with_name('search.yaml')
SOURCE = (53.28025, -9.06065)
PLACES = 4
# The survey takes some 190 s; nothing before its end depends on an estimate.
SURVEY_READINGS = 150
# Photographs, of some more, after which time waits for a node that was killed.
HELD_AT = 6

pytestmark = pytest.mark.system

Waits = Callable[[Flight], contextlib.AbstractContextManager[None]]


def readings(flight: Flight) -> list[dict[str, str]]:
    """Return all readings of a flight in the order of time."""
    with flight.run.readings.open(encoding='utf-8', newline='') as stream:
        return sorted(csv.DictReader(stream), key=lambda row: row['time_ns'])


def test_a_further_round_is_flown_to_where_readings_tell_most(complete: Any) -> None:
    """Planned by the planner, photographed like any other, and read."""
    run = complete.run
    plan = json.loads(run.plan.read_text())
    (further,) = run.path.glob('further-*')
    more = json.loads((further / 'plan.json').read_text())
    counts = [sum(len(route['viewpoints']) for route in p['routes']) for p in (plan, more)]
    assert counts[1] == PLACES
    assert len(complete.images()) == sum(counts)
    assert complete.info()['outcome'] == 'complete'
    assert complete.living() == []


def test_the_source_is_found_where_it_is(complete: Any) -> None:
    """Within 3 m, and the report of it says that more was wanted."""
    found = json.loads((complete.run.path / 'sources.json').read_text())
    (source,) = found['sources']
    north_m = (source['place']['latitude_deg'] - SOURCE[0]) * 111_300.0
    east_m = (source['place']['longitude_deg'] - SOURCE[1]) * 66_600.0
    assert (north_m**2 + east_m**2) ** 0.5 < 3.0


def last_dose(flight: Flight) -> Any:
    """Return what the localizer told last of the dose."""
    from mcap_ros2.reader import read_ros2_messages

    messages = read_ros2_messages(flight.run.recording, ['/rav1/accumulated_dose'])
    return [message.ros_msg for message in messages][-1]


def total_usv(flight: Flight) -> float:
    """Return the dose of all readings, a second each."""
    return sum(float(row['dose_rate_usvh']) for row in readings(flight)) / 3600.0


def test_doses_are_recorded(complete: Any) -> None:
    """The dose that the localizer added up is that of the readings."""
    assert last_dose(complete).dose_usv == pytest.approx(total_usv(complete), rel=0.02)


@pytest.fixture
def disturbed(fly: Callable[..., Flight]) -> Callable[..., Flight]:
    """Give a function that flies the search and kills a node in the air."""

    def disturb(node: str, waits: Waits = contextlib.nullcontext) -> Flight:
        flight = fly('--speed', '20')
        flight.wait_for_images(3)
        with waits(flight):
            os.kill(flight.pid_of(node), signal.SIGKILL)
        assert flight.end() == 0, flight.output
        assert flight.info()['restarts'] == {node: 1}
        return flight

    return disturb


@contextlib.contextmanager
def localizer_comes_back(ros: Any, flight: Flight) -> Iterator[None]:
    """Let time wait in the middle of the survey for the localizer that has been killed.

    However long it takes to begin again, it has heard more than it has not.
    """
    node = Node('ears', context=ros.context)

    def listeners() -> set[bytes]:
        ends = node.get_subscriptions_info_by_topic('/rav1/radiation')
        return {bytes(end.endpoint_gid) for end in ends if end.node_name == 'localizer'}

    flight.wait_until(lambda: bool(listeners()))
    killed = listeners()
    yield
    flight.wait_until(lambda: bool(listeners() - killed) or len(flight.images()) >= HELD_AT)
    world = flight.pid_of('world')
    os.kill(world, signal.SIGSTOP)
    try:
        flight.wait_until(lambda: bool(listeners() - killed))
    finally:
        os.kill(world, signal.SIGCONT)
        node.destroy_node()


@pytest.mark.all
def test_a_field_killed_in_the_air_costs_no_reading(
    complete: Any, disturbed: Callable[..., Flight]
) -> None:
    """Counted windows and all: the readings are those of the flight that nobody disturbed."""
    flight = disturbed('radiation_field')
    # The further round follows from an estimate that may have had one reading less on the ground.
    here, there = (
        {row['time_ns']: row for row in readings(one)[:SURVEY_READINGS]}
        for one in (flight, complete)
    )
    # On the ground either may begin some seconds later: who is found late by the others.
    common = here.keys() & there.keys()
    assert len(common) > 0.9 * SURVEY_READINGS
    assert all(here[time] == there[time] for time in common)
    stamps = [int(row['time_ns']) for row in readings(flight)]
    assert {b - a for a, b in itertools.pairwise(stamps)} == {1_000_000_000}


@pytest.mark.all
def test_a_localizer_killed_in_the_air_forgets_nothing(
    disturbed: Callable[..., Flight], ros: Any
) -> None:
    """It knows what it read before its end, and tells for how long it heard nothing.

    Who comes back after more than fifty readings, as at twenty times real time, misses some.
    """
    flight = disturbed('localizer', partial(localizer_comes_back, ros))
    dose = last_dose(flight)
    known_s = dose.measured_s + dose.unmeasured_s
    assert known_s == pytest.approx(len(readings(flight)), abs=2.0)
    assert dose.measured_s > dose.unmeasured_s
    assert dose.is_lower_limit == (dose.unmeasured_s > 0.0)
    assert dose.dose_usv <= 1.02 * total_usv(flight)
