# SPDX-License-Identifier: Apache-2.0
"""Processes of a mission hear their own names from each other only."""

import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rocsafe_ros.domain import mission_partition
from rocsafe_ros.domain.mission_partition import keep_to_mission
from rocsafe_ros.domain.network import HEARTBEATS, PROFILES, RANGE, TRANSPORTS, bind_interfaces

DEADLINE_S = 60.0
OPEN = ('open',)
# Says its name on two topics, serves and asks two services, and prints whom it has heard.
NODE = """
import sys
NAME = sys.argv.pop()
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger
from rocsafe_ros.process.run import run

class Subject(Node):
    def __init__(self, **options):
        super().__init__('subject_' + NAME, **options)
        self.heard = set()
        self.said = [self.create_publisher(String, name, 10) for name in ('rav1/fix', 'open')]
        for name in ('rav1/fix', 'open'):
            self.create_subscription(String, name, lambda m, n=name: self.note(n, m.data), 10)
        self.askers = []
        for name in ('rav1/hold', 'free'):
            self.create_service(Trigger, name, self.answer)
            self.askers.append((name, self.create_client(Trigger, name)))
        self.create_timer(0.1, self.speak)

    def answer(self, request, response):
        response.message = NAME
        return response

    def speak(self):
        for publisher in self.said:
            publisher.publish(String(data=NAME))
        for name, client in self.askers:
            client.call_async(Trigger.Request()).add_done_callback(
                lambda future, name=name: self.note(name, future.result().message))

    def note(self, name, who):
        if (name, who) not in self.heard:
            self.heard.add((name, who))
            print(name, who, flush=True)

sys.exit(run(Subject))
"""


def profiles(path: Path) -> dict[tuple[str, str], str]:
    """Return the partitions of each profile, by its element and name."""
    root = ET.fromstring(path.read_text(encoding='utf-8'))  # noqa: S314
    space = '{http://www.eprosima.com}'
    return {
        (one.tag.removeprefix(space), one.attrib['profile_name']): one.find(
            f'.//{space}value'
        ).text
        for kind in ('data_writer', 'data_reader')
        for one in root.iter(f'{space}{kind}')
        if one.find(f'.//{space}value') is not None
    }


def test_all_is_closed_but_what_others_may_publish(tmp_path: Path) -> None:
    """Requests are taken from everybody, and asked of the mission only."""
    environment: dict[str, str] = {}
    assert keep_to_mission(environment, tmp_path, 'a1', ['rav1/cmd_vel'])
    found = profiles(Path(environment[PROFILES[0]]))
    opened = {
        f'/{name}' for name in ('rosout', 'parameter_events', 'diagnostics', 'tf', 'tf_static')
    }
    assert found == {
        ('data_writer', 'mission_writer'): ';a1',
        ('data_reader', 'mission_reader'): 'a1',
        ('data_reader', 'service'): ';a1',
        ('data_writer', 'client'): 'a1',
        **dict.fromkeys(
            (('data_reader', name) for name in (*opened, '/rav1/cmd_vel', 'ros_discovery_info')),
            ';a1',
        ),
    }


def test_interfaces_stay_bound_and_a_mission_started_by_another_has_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The profile of the interfaces is added to, and names of the mission before are dropped."""
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    environment = {RANGE: 'LOCALHOST', 'ROCSAFE_PEERS': '127.0.0.1'}
    bind_interfaces(environment)
    for token in ('a1', 'b2'):
        (tmp_path / token).mkdir()
        keep_to_mission(environment, tmp_path / token, token, OPEN)
        bind_interfaces(environment)
    path = Path(environment[PROFILES[0]])
    text = path.read_text(encoding='utf-8')
    assert path.parent.name == 'b2'
    assert '<address>127.0.0.1</address>' in text
    assert text.count(HEARTBEATS) == 3
    assert set(profiles(path).values()) == {'b2', ';b2'}


def test_profile_of_the_user_is_left_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor is another middleware given one that it does not read."""
    environment = {PROFILES[0]: '/mine.xml'}
    assert not keep_to_mission(environment, tmp_path, 'a1', OPEN)
    monkeypatch.setattr(
        mission_partition, 'get_rmw_implementation_identifier', lambda: 'rmw_other'
    )
    assert not keep_to_mission({}, tmp_path, 'a1', OPEN)
    assert environment == {PROFILES[0]: '/mine.xml'}


def test_stranger_of_the_same_name_is_neither_heard_nor_asked(
    own_domain: None, tmp_path: Path
) -> None:
    """It hears the mission, may call it, and is heard where others may publish."""
    path = os.pathsep.join(entry for entry in sys.path if entry)
    outside = {**os.environ, 'PYTHONPATH': path, RANGE: 'SUBNET', TRANSPORTS: 'UDPv4'}
    inside = dict(outside)
    keep_to_mission(inside, tmp_path, 'a1', OPEN)
    nodes = {
        name: subprocess.Popen(
            [sys.executable, '-c', NODE, name], stdout=subprocess.PIPE, text=True, env=environment
        )
        for name, environment in (('one', inside), ('two', inside), ('stranger', outside))
    }
    names, closed = ('open', 'free', 'rav1/fix', 'rav1/hold'), ('free', 'rav1/fix', 'rav1/hold')
    everything = {f'{name} {who}\n' for name in names for who in nodes}
    wanted = everything - {f'{name} stranger\n' for name in closed}
    heard: dict[str, set[str]] = {'one': set(), 'stranger': set()}
    try:
        for name, goal in (('one', wanted), ('stranger', everything)):
            for line in nodes[name].stdout:
                heard[name].add(line)
                if heard[name] >= goal:
                    break
        assert heard == {'one': wanted, 'stranger': everything}
    finally:
        for node in nodes.values():
            node.kill()
            node.wait(timeout=DEADLINE_S)
            node.stdout.close()
