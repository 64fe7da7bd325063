# SPDX-License-Identifier: Apache-2.0
"""A mission looks who else speaks in its domain before it starts anything."""

import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.action import ActionServer
from rclpy.node import Node

from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import VehicleState
from rocsafe_orchestrator.company_node import LookoutNode, place_of
from rocsafe_orchestrator.process_table.table import process_table
from rocsafe_orchestrator.processes.company import Speaker, needed_names, objections, open_topics
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_ros.domain.mission_identity import MissionIdentity, new_identity
from rocsafe_scenario.scenario_file import read_scenario

DEADLINE_S = 60.0
GIMBAL = 'camera/gimbal/command'
OWN, OTHER = new_identity('own'), new_identity('other-2')


def needed(path: Path) -> frozenset[str]:
    """Return the names that the scenario at `path` needs."""
    scenario = read_scenario(path)
    return needed_names(scenario, process_table(scenario, RunDirectory(Path('run'))))


def test_names_of_every_vehicle_are_needed(small: Callable[..., Path]) -> None:
    """Verbs, states and shots of each, and what the mission shares; not what is everybody's."""
    names = needed(small())
    for name in ('fly_route', 'state', 'camera/shot', 'hold', 'land', 'fix', 'radiation'):
        assert {f'rav1/{name}', f'rav2/{name}'} <= names
    assert {'plan_survey', 'plan', 'shots/receipts', 'mission/state'} <= names
    # Time has names of its own; /clock and /diagnostics are everybody's.
    assert not {'clock', 'sim/step_done', 'world/run', 'diagnostics', 'rav3/state'} & names


def test_detector_of_the_user_may_speak(small: Callable[..., Path]) -> None:
    """With `detector: own` the user's node publishes the readings of a real vehicle."""
    real = {'name': 'rav2', 'link': 'udp:127.0.0.1:14550', 'drone': {'detector': 'own'}}
    names = needed(small({'vehicles[1]': real}))
    assert 'rav2/radiation' not in names
    assert {'rav1/radiation', 'rav2/state'} <= names


def test_others_may_publish_what_programs_and_detectors_of_the_user_do(
    small: Callable[..., Path],
) -> None:
    """To a mission in flight, and nothing else."""
    real = {'name': 'rav2', 'link': 'udp:127.0.0.1:14550', 'drone': {'detector': 'own'}}
    names = set(open_topics(read_scenario(small({'vehicles[1]': real}))))
    own = {'rav2/radiation', 'rav2/accumulated_dose', 'rav2/dose_alarm'}
    programs = {f'{name}/{topic}' for name in ('rav1', 'rav2') for topic in ('cmd_vel', GIMBAL)}
    assert names == own | programs | {'drawings', 'hazard/reports'}


@pytest.mark.parametrize(
    ('speaker', 'words'),
    [
        (Speaker(node='/planner', mission=OWN, names=('plan',)), None),
        (Speaker(node='/rviz'), None),
        (Speaker(node='/planner', mission=OTHER), 'another mission .*other-2, node /planner'),
        (
            Speaker(node='/rav1/a', place='process 7', names=('rav1/hold',)),
            r'node /rav1/a \(process 7\) already speaks for /rav1/hold: ',
        ),
        (Speaker(node='/x', names=('plan', 'rav1/hold')), 'for /plan and 1 more names'),
    ],
)
def test_only_strangers_are_objected_to(speaker: Speaker, words: str | None) -> None:
    """A node of the same mission, or one that only listens, is none."""
    found = objections(OWN, [speaker])
    assert len(found) == (words is not None)
    assert words is None or re.search(words, found[0])


def test_rival_is_named_once() -> None:
    """One line for a mission, however many nodes it has."""
    rivals = [Speaker(node=f'/{name}', mission=OTHER, names=('plan',)) for name in 'abc']
    assert len(objections(OWN, rivals)) == 1


GID = bytes.fromhex('010f78fd656fb22b0000000000000303')


@pytest.mark.parametrize(
    ('gid', 'own', 'place'),
    [
        (GID, bytes.fromhex('010f78ff0102'), 'on another machine'),
        (b'\x01\x02' + GID[2:], GID, ''),
        (b'', GID, ''),
    ],
)
def test_place_of_an_endpoint(gid: bytes, own: bytes, place: str) -> None:
    """By the bytes in which Fast DDS keeps vendor, machine and process; empty for others."""
    assert place_of(gid, own) == place


@pytest.fixture
def lookout(ros: Any) -> Iterator[LookoutNode]:
    """Give a node that looks at the domain of the test."""
    node = LookoutNode('lookout', context=ros.context)
    yield node
    node.destroy_node()


def test_servers_and_publishers_are_seen(ros: Any, lookout: LookoutNode) -> None:
    """An action, a service or a topic of a vehicle: with node, process and names."""
    names = frozenset({'rav1/fly_route', 'rav1/state', 'rav2/state'})
    other = Node('bridge', namespace='/rav1', context=ros.context)
    action = ActionServer(other, FlyRoute, 'fly_route', lambda _goal: FlyRoute.Result())
    other.create_publisher(VehicleState, 'state', 1)

    def seen() -> list[Speaker]:
        return [one for one in lookout.speakers(names) if len(one.names) == 2]

    ros.spin_until(lambda: bool(seen()), DEADLINE_S)
    place = f'process {os.getpid()} on this machine'
    assert seen() == [
        Speaker(node='/rav1/bridge', place=place, names=('rav1/fly_route', 'rav1/state'))
    ]
    action.destroy()
    other.destroy_node()


HOLDER = """
import sys
from rocsafe_orchestrator.company_node import claimed
from rocsafe_orchestrator.errors import SetupError
from rocsafe_ros.domain.mission_identity import MissionIdentity

_, mission, token = sys.argv
with claimed(MissionIdentity(mission=mission, token=token), ['rav1/state']) as claim:
    try:
        claim.require_alone()
        print('alone', flush=True)
    except SetupError as error:
        print(error, flush=True)
    sys.stdin.read()
"""


@contextmanager
def claimant(domain: int, mission: MissionIdentity) -> 'Iterator[subprocess.Popen[str]]':
    """Start a process that claims the domain and tells what it found; end it."""
    environment = {
        **os.environ,
        'PYTHONPATH': os.pathsep.join(filter(None, sys.path)),
        'ROS_DOMAIN_ID': str(domain),
    }
    with subprocess.Popen(
        [sys.executable, '-c', HOLDER, mission.mission, mission.token],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment,
    ) as process:  # fmt: skip
        yield process


def said(process: 'subprocess.Popen[str]') -> str:
    """Return the next line of a process."""
    assert process.stdout is not None
    return process.stdout.readline()


def test_second_mission_is_refused_by_the_name_of_the_first(ros_domain_id: int) -> None:
    """Also on another machine, where no lock is seen; the domain is free afterwards."""
    with claimant(ros_domain_id, OWN) as first:
        assert said(first) == 'alone\n'
        with claimant(ros_domain_id, OTHER) as second:
            assert re.match('another mission is .*own, node /orchestrator_claim_', said(second))
        # A process of the same mission, which goes on with it, may come.
        with claimant(ros_domain_id, OWN) as again:
            assert said(again) == 'alone\n'
    with claimant(ros_domain_id, OTHER) as third:
        assert said(third) == 'alone\n'


def test_of_two_that_begin_at_once_not_both_start(ros_domain_id: int) -> None:
    """Each sees the claim of the other while it looks."""
    with claimant(ros_domain_id, OWN) as first, claimant(ros_domain_id, OTHER) as second:
        assert [said(first), said(second)].count('alone\n') <= 1
