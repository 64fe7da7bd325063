# SPDX-License-Identifier: Apache-2.0
"""DDS listens where it is told to, and nowhere else."""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rocsafe_ros.domain import network
from rocsafe_ros.domain.network import INTERFACES, PROFILES, RANGE, TRANSPORTS, bind_interfaces
from rocsafe_ros.parameters import ParameterError

DEADLINE_S = 60.0
NODE = """
import os
import sys
from rclpy.node import Node
from std_msgs.msg import String
from rocsafe_ros.process.run import run

class Subject(Node):
    def __init__(self, **options):
        super().__init__('subject_' + os.environ['SUBJECT'], **options)
        self.said = self.create_publisher(String, 'said', 10)
        self.heard = self.create_subscription(String, 'said', self.on_said, 10)
        self.create_timer(0.1, lambda: self.said.publish(String(data=os.environ['SUBJECT'])))
        self.others = set()

    def on_said(self, message):
        if message.data != os.environ['SUBJECT'] and message.data not in self.others:
            self.others.add(message.data)
            print(message.data, flush=True)

sys.exit(run(Subject))
"""


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """Keep profiles out of the home folder."""
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))


def profile_of(environment):
    """Return the profile that an environment names, both variables alike."""
    first, second = (environment[name] for name in PROFILES)
    assert first == second
    return Path(first).read_text(encoding='utf-8')


def test_loopback_alone_where_discovery_ends_at_this_machine():
    """The range then only says how to search; the profile says where to listen."""
    environment = {RANGE: 'LOCALHOST'}
    bind_interfaces(environment)
    assert re.findall('<address>(.*?)</address>', profile_of(environment)) == ['127.0.0.1']
    assert environment[RANGE] == 'SUBNET'
    before = dict(environment)
    bind_interfaces(environment)
    assert environment == before


@pytest.mark.parametrize('environment', [{}, {RANGE: 'SUBNET'}, {RANGE: 'OFF'}])
def test_nothing_is_bound_unasked(environment):
    """The defaults of ROS hold, but for shared memory."""
    before = dict(environment)
    bind_interfaces(environment)
    assert environment == {**before, TRANSPORTS: 'UDPv4'}


def test_transports_that_the_user_chose_are_left():
    """Where they are not bound to interfaces."""
    environment = {TRANSPORTS: 'SHM'}
    bind_interfaces(environment)
    assert environment == {TRANSPORTS: 'SHM'}


def test_named_interfaces_are_bound_beside_loopback():
    """By address or by name."""
    environment = {INTERFACES: 'lo, 127.0.0.2'}
    bind_interfaces(environment)
    listed = re.search('<interfaceWhiteList>(.*)</interfaceWhiteList>', profile_of(environment))
    assert listed.group(1) == (
        '<address>127.0.0.1</address><interface>lo</interface><address>127.0.0.2</address>'
    )


def test_profile_of_the_user_is_left_alone():
    """But then nothing else is asked for."""
    environment = {RANGE: 'LOCALHOST', PROFILES[0]: '/mine.xml'}
    before = dict(environment)
    bind_interfaces(environment)
    assert environment == before
    with pytest.raises(ParameterError, match='are both set'):
        bind_interfaces({**environment, INTERFACES: 'lo'})


@pytest.mark.parametrize(
    ('named', 'words'),
    [
        ('wg7', "'wg7' is no address and none of lo"),
        ('192.0.2.77', 'is no IPv4 address of this machine'),
        ('::1', 'is no IPv4 address'),
        ('0.0.0.0', 'is no IPv4 address'),  # noqa: S104
        ('<x>', "'<x>' is no address"),
    ],
)
def test_wrong_interface_is_refused(named, words):
    """Never bound to something else instead."""
    with pytest.raises(ParameterError, match=words):
        bind_interfaces({INTERFACES: named})


@pytest.mark.skipif(os.geteuid() != 0 or not shutil.which('unshare'), reason='needs root, unshare')
def test_a_machine_without_loopback_is_told():
    """Nodes of a mission would wait for each other in vain."""
    words = [
        sys.executable,
        '-c',
        'from rocsafe_ros.process.run import run; raise SystemExit(run(None))',
    ]
    environment = {name: value for name, value in os.environ.items() if name not in PROFILES} | {
        'PYTHONPATH': os.pathsep.join(filter(None, sys.path))
    }
    ended = subprocess.run(
        ['unshare', '-n', *words],
        env=environment, capture_output=True, text=True, check=False, timeout=DEADLINE_S,
    )  # fmt: skip
    assert ended.returncode == 2
    told = ended.stderr.strip().splitlines()[-1]
    assert told == 'error: 127.0.0.1 cannot be reached: bring up interface lo'


def test_another_middleware_is_not_trusted_with_it(monkeypatch):
    """What cannot be bound as asked is refused; a limited range stays as it is."""
    monkeypatch.setattr(network, 'get_rmw_implementation_identifier', lambda: 'rmw_other')
    with pytest.raises(ParameterError, match='is for rmw_fastrtps_cpp only'):
        bind_interfaces({INTERFACES: 'lo'})
    environment = {RANGE: 'LOCALHOST'}
    bind_interfaces(environment)
    assert environment == {RANGE: 'LOCALHOST', TRANSPORTS: 'UDPv4'}


def listening(pid):
    """Return the addresses of the UDP sockets of a process, as hexadecimal text of the kernel."""
    links = [str(entry.readlink()) for entry in Path(f'/proc/{pid}/fd').iterdir()]
    own = {link[8:-1] for link in links if link.startswith('socket:[')}
    rows = [row.split() for row in Path(f'/proc/{pid}/net/udp').read_text().splitlines()[1:]]
    return {row[1].split(':')[0] for row in rows if row[9] in own}


def segments(pid):
    """Return the files of shared memory that a process has mapped for DDS."""
    return re.findall('/dev/shm/.*fast.*', Path(f'/proc/{pid}/maps').read_text())


@pytest.mark.parametrize('reach', ['LOCALHOST', 'SUBNET'])
def test_no_process_shares_memory_with_others(own_domain, reach):
    """What one that is killed leaves there would stop the others, or their start."""
    path = os.pathsep.join(entry for entry in sys.path if entry)
    environment = {**os.environ, 'PYTHONPATH': path, RANGE: reach}
    environment.pop(TRANSPORTS, None)
    nodes = [
        subprocess.Popen(
            [sys.executable, '-c', NODE],
            stdout=subprocess.PIPE,
            text=True,
            env={**environment, 'SUBJECT': name},
        )
        for name in ('one', 'two')
    ]
    try:
        assert nodes[0].stdout.readline() == 'two\n'
        assert [segments(node.pid) for node in nodes] == [[], []]
    finally:
        for node in nodes:
            node.kill()
            node.wait(timeout=DEADLINE_S)
            node.stdout.close()


@pytest.mark.parametrize('other', ['bound', 'unbound'])
def test_no_socket_of_a_node_is_open_to_the_network(own_domain, tmp_path, other):
    """Neither in wait nor to send; bound nodes meet each other, and others of this machine."""
    path = os.pathsep.join(entry for entry in sys.path if entry)
    environment = {**os.environ, 'PYTHONPATH': path, RANGE: 'LOCALHOST'}
    nothing = tmp_path / 'nothing.xml'
    nothing.write_text('<dds xmlns="http://www.eprosima.com"><profiles></profiles></dds>')
    elsewhere = {} if other == 'bound' else {PROFILES[0]: str(nothing)}
    nodes = [
        subprocess.Popen(
            [sys.executable, '-c', NODE],
            stdout=subprocess.PIPE,
            text=True,
            env={**environment, **extra, 'SUBJECT': name},
        )
        for name, extra in (('one', {}), ('two', elsewhere))
    ]
    try:
        # Fast DDS prints a line about a profile without content.
        assert any(line == 'two\n' for line in nodes[0].stdout)
        assert any(line == 'one\n' for line in nodes[1].stdout)
        loopback, multicast = '0100007F', '0100FFEF'
        assert listening(nodes[0].pid) <= {loopback, multicast}
        assert loopback in listening(nodes[0].pid)
    finally:
        for node in nodes:
            node.terminate()
        end = time.monotonic() + DEADLINE_S
        for node in nodes:
            node.wait(timeout=max(0.1, end - time.monotonic()))
            node.stdout.close()
