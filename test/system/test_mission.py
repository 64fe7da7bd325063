# SPDX-License-Identifier: Apache-2.0
"""Whole missions: `rocsafe run` as a user starts it, with every process of its own."""

import csv
import json
import os
import re
import shutil
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from test.small_file_system import small_file_system

from rocsafe_campaign.flight.pure_mission import run_purely
from rocsafe_scenario.scenario_file import read_scenario

from .conftest import DEADLINE_S

# 9 viewpoints, see small.yaml.
IMAGES = 9
# One of each kind dies in one mission, one after another; the others, alone, in `make test-all`.
KILLED_TOGETHER = ('planner', 'radiation_field', 'rav1', 'world')
KILLED_ALONE = [
    pytest.param((node,), marks=pytest.mark.all)
    for node in (*KILLED_TOGETHER, 'collector', 'localizer', 'mosaic', 'recorder')
]
# Signals of one number that come sooner may count as one.
APART_S = 0.2
# Slow enough to be caught in the air, fast enough for a test.
SPEED = ('--speed', '12')

pytestmark = pytest.mark.system

Fly = Callable[..., Any]


def test_mission_hands_over_everything(complete: Any) -> None:
    """The run directory holds every product, and the summary says that all went well."""
    run = complete.run
    products = (
        run.scenario, run.run_info, run.plan, run.path / 'plan.geojson', run.path / 'plan.kml',
        run.mosaic, run.recording, run.readings, run.summary, run.report,
    )  # fmt: skip
    for product in products:
        assert product.stat().st_size > 0, product
    assert complete.info()['outcome'] == 'complete'
    summary = json.loads(run.summary.read_text())
    assert summary['outcome'] == 'complete'
    assert len(complete.images()) == IMAGES
    assert complete.damaged_images() == set()
    assert 'mission complete' in complete.output
    assert 'Traceback' not in complete.output


def test_one_function_flies_the_same_mission(complete: Any) -> None:
    """The mission of campaigns, without ROS, has the plan and every reading of the processes."""
    alone = run_purely(read_scenario(complete.run.scenario))
    assert json.loads(complete.run.plan.read_text())['plan_id'] == alone.plan.plan_id
    with complete.run.readings.open() as file:
        rows = {(row['vehicle'], int(row['time_ns'])): row for row in csv.DictReader(file)}
    own = {reading.key: reading for reading in alone.readings}
    assert rows.keys() == own.keys()
    for key, row in rows.items():
        # The table rounds places to a tenth of a millimetre, dose rates not at all.
        assert float(row['dose_rate_usvh']) == own[key].dose_rate_usvh
        assert row['latitude_deg'] == f'{own[key].latitude_deg:.9f}'
        assert row['altitude_m'] == f'{own[key].altitude_m:.3f}'


def test_mission_leaves_no_process(complete: Any) -> None:
    """After the end nothing of the run is left, nor was anything restarted."""
    assert complete.living() == []
    assert complete.info()['restarts'] == {}


@pytest.mark.all
def test_speed_changes_nothing(complete: Any, fly: Fly) -> None:
    """Same seed, another speed: the same plan, the same photographs, the same readings."""
    slow = fly('--speed', '30')
    assert slow.end() == 0, slow.output
    assert slow.run.plan.read_bytes() == complete.run.plan.read_bytes()
    assert slow.images() == complete.images()
    assert readings(slow.run.readings) == readings(complete.run.readings)


@pytest.mark.parametrize('nodes', [KILLED_TOGETHER, *KILLED_ALONE], ids='-'.join)
def test_killed_node_comes_back(nodes: tuple[str, ...], complete: Any, fly: Fly) -> None:
    """`kill -9` of any node in the air: it is started again, and the mission is completed."""
    flight = fly(*SPEED)
    for count, node in enumerate(nodes):
        flight.wait_for_images(2 + 2 * count)
        os.kill(flight.pid_of(node), signal.SIGKILL)
    assert flight.end() == 0, flight.output
    assert flight.info()['restarts'] == dict.fromkeys(nodes, 1)
    for node in nodes:
        assert f'{node} was ended by SIGKILL' in flight.output
    assert flight.images() == complete.images()
    assert flight.damaged_images() == set()
    assert flight.living() == []


def test_node_that_keeps_dying_ends_the_mission(fly: Fly) -> None:
    """A node that is killed again and again is given up: a clear line, exit code 1, no hang."""
    flight = fly(*SPEED)
    flight.wait_for_images(2)
    while flight.process.poll() is None:
        pid = flight.pid_of('radiation_field')
        if pid in flight.living():
            os.kill(pid, signal.SIGKILL)
        time.sleep(0.05)
    assert flight.end() == 1, flight.output
    assert 'mission failed: radiation_field was ended by SIGKILL after 5 restarts' in flight.output
    assert flight.damaged_images() == set()
    assert flight.run.mosaic.is_file()
    assert flight.run.report.is_file()


@pytest.mark.all
def test_node_that_hangs_is_named(fly: Fly, tmp_path: Path) -> None:
    """A node that neither works nor ends holds up time: the mission fails and says who."""
    config = tmp_path / 'config.yaml'
    config.write_text('/**/orchestrator:\n  ros__parameters:\n    stall_timeout_s: 8.0\n')
    flight = fly(*SPEED, '--config', str(config))
    flight.wait_for_images(2)
    os.kill(flight.pid_of('rav1'), signal.SIGSTOP)
    assert flight.end() == 1, flight.output
    assert re.search(r'simulated time stands still for \d+ s: waits for rav1', flight.output)
    assert flight.living() == []


@pytest.mark.parametrize(
    ('number', 'code'),
    [
        pytest.param(signal.SIGINT, 130, id='SIGINT'),
        pytest.param(signal.SIGTERM, 143, id='SIGTERM', marks=pytest.mark.all),
    ],
)
def test_interrupted_mission_ends_in_order(
    complete: Any, fly: Fly, number: signal.Signals, code: int
) -> None:
    """Ctrl-C and SIGTERM end every process; what was recorded is handed over.

    Up to there it is the mission that was flown at another speed, from the same seed.
    """
    flight = fly(*SPEED)
    flight.wait_for_images(2)
    flight.process.send_signal(number)
    assert flight.end() == code, flight.output
    assert flight.living() == []
    assert 'Traceback' not in flight.output
    assert 'mission cancelled: interrupted by' in flight.output
    assert flight.info()['outcome'] == 'cancelled'
    assert json.loads(flight.run.summary.read_text())['outcome'] == 'cancelled'
    assert flight.damaged_images() == set()
    assert flight.run.plan.read_bytes() == complete.run.plan.read_bytes()
    assert flight.images().items() <= complete.images().items()
    whole = readings(complete.run.readings)
    assert all(row in whole for row in readings(flight.run.readings))


@pytest.mark.all
def test_third_interrupt_ends_at_once(fly: Fly) -> None:
    """Who asks three times does not wait for products; how to make them is said."""
    flight = fly(*SPEED)
    flight.wait_for_images(1)
    for _ in range(3):
        flight.process.send_signal(signal.SIGINT)
        time.sleep(APART_S)
    assert flight.end() == 130, flight.output
    assert flight.info()['outcome_text'] == 'interrupted by Ctrl-C'
    assert f'no report was made: rocsafe report {flight.run.path}' in flight.output
    assert not flight.run.report.exists()
    assert flight.living() == []


@pytest.mark.parametrize('count', [1, pytest.param(2, marks=pytest.mark.all), 3])
def test_interrupt_while_processes_start_leaves_a_word(fly: Fly, count: int) -> None:
    """Also three at once: none runs, and the run says why; with one or two it has a report."""
    flight = fly(*SPEED)
    flight.wait_until(lambda: 'run directory' in flight.output)
    for _ in range(count):
        flight.process.send_signal(signal.SIGINT)
        time.sleep(APART_S)
    assert flight.end() == 130, flight.output
    assert flight.info()['outcome'] == 'cancelled'
    assert flight.info()['outcome_text'] == 'interrupted by Ctrl-C'
    assert flight.run.report.is_file() is (count < 3)
    assert 'mission cancelled: interrupted by Ctrl-C' in flight.output
    assert flight.living() == []


def test_interrupt_while_mapping_leaves_map_and_report(fly: Fly) -> None:
    """Also a second one: both are written, and the mission is cancelled."""
    flight = fly()
    flight.wait_until(lambda: ' mapping, ' in flight.output)
    flight.process.send_signal(signal.SIGINT)
    flight.wait_until(lambda: 'interrupted by' in flight.output)
    flight.process.send_signal(signal.SIGINT)
    assert flight.end() == 130, flight.output
    assert flight.run.mosaic.is_file()
    assert flight.run.report.is_file()
    assert json.loads(flight.run.summary.read_text())['outcome'] == 'cancelled'
    assert flight.living() == []


@pytest.mark.all
def test_lost_output_ends_no_flight(complete: Any, fly: Fly) -> None:
    """As with `rocsafe run ... | head -1`: the mission is flown to its end."""
    flight = fly(has_reader=False)
    assert flight.end() == 0
    assert flight.info()['outcome'] == 'complete'
    assert flight.images() == complete.images()


def test_full_disk_ends_a_flight_by_name(fly: Fly, tmp_path: Path) -> None:
    """While there is room for map and report; nothing stored is damaged. The next is refused."""
    with small_file_system(tmp_path / 'disk', megabytes=160) as disk:
        flight = fly(*SPEED, runs=disk)
        flight.wait_for_images(2)
        left = shutil.disk_usage(disk).free - 50 * 2**20
        with (disk / 'filler').open('wb') as filler:
            os.posix_fallocate(filler.fileno(), 0, left)
        assert flight.end() == 1, flight.output
        assert re.search(
            r'mission failed: the disk of .* is full: \d+ MiB are free', flight.output
        )
        assert flight.run.report.is_file()
        assert flight.run.mosaic.is_file()
        assert flight.damaged_images() == set()
        refused = fly(runs=disk)
        assert refused.end() == 3
        assert re.search(r'disk of .*: \d+ MiB are free, must be about', refused.output)


def test_killed_orchestrator_leaves_no_orphan(fly: Fly) -> None:
    """Nodes end with the process that started them, however it ended."""
    flight = fly(*SPEED)
    flight.wait_for_images(1)
    flight.process.kill()
    flight.process.wait()
    end = time.monotonic() + DEADLINE_S
    while flight.living():
        assert time.monotonic() < end, 'orphans'
        time.sleep(0.05)


@pytest.mark.all
def test_second_mission_in_a_domain_is_refused(fly: Fly) -> None:
    """Two missions in one ROS domain would fly each other's vehicles."""
    first = fly('--speed', '4')
    first.wait_for_images(1)
    second = fly()
    assert second.end() == 3
    assert 'another mission is running in this ROS domain' in second.output
    assert first.process.poll() is None
    first.process.send_signal(signal.SIGINT)
    assert first.end() == 130


@pytest.mark.all
def test_foreign_clock_and_steps_move_nothing(complete: Any, fly: Fly, intruder: Any) -> None:
    """Another program's /clock, years ahead, and its reports of steps: the same mission."""
    flight = fly(*SPEED)
    flight.wait_for_images(2)
    intruder.disturb()
    assert flight.end() == 0, flight.output
    assert intruder.heard_steps == 0
    assert flight.images() == complete.images()
    assert readings(flight.run.readings) == readings(complete.run.readings)


@pytest.mark.all
def test_foreign_vehicle_of_the_same_name_changes_nothing(
    complete: Any, fly: Fly, intruder: Any
) -> None:
    """It begins in the middle of the mission, and says that it is lost: the same mission."""
    flight = fly(*SPEED)
    flight.wait_for_images(2)
    intruder.pretend('rav1')
    assert flight.end() == 0, flight.output
    assert flight.images() == complete.images()
    assert readings(flight.run.readings) == readings(complete.run.readings)
    assert flight.info()['restarts'] == {}


def test_vehicle_that_somebody_has_is_not_flown(fly: Fly, intruder: Any) -> None:
    """A bridge that serves rav1 is up: nothing is started, and the line says who has it."""
    with intruder.vehicle('rav1'):
        flight = fly()
        assert flight.end() == 3
    assert 'node /rav1/bridge (process' in flight.output
    assert 'already speaks for /rav1/fly_route' in flight.output
    assert not flight.has_begun


def readings(path: Path) -> list[dict[str, str]]:
    """Return the rows of a table of readings."""
    with path.open(encoding='utf-8', newline='') as stream:
        return list(csv.DictReader(line for line in stream if not line.startswith('#')))
