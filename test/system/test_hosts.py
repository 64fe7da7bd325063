# SPDX-License-Identifier: Apache-2.0
"""Missions over three hosts, each a network namespace: lost packets, no multicast, and cuts.

Needs root, `ip` and, for lost packets, `nft`.
"""

import json
import os
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rocsafe_orchestrator.processes.ros_reach import REACH_VARIABLES
from rocsafe_orchestrator.products.photographs import read_photographs
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_ros.domain.network import PEERS, PROFILES

pytestmark = [
    pytest.mark.system,
    pytest.mark.all,
    pytest.mark.skipif(os.geteuid() != 0 or shutil.which('ip') is None, reason='needs root, ip'),
]
SCENARIO = Path(__file__).with_name('hosts.yaml')
HOSTS = ('base', 'van', 'boat')
DEADLINE_S = 300.0
LOSS_PERCENT = 5
# A namespace shares the memory of the machine, a host does not.
OWN_MEMORY = 'mount -t tmpfs tmpfs /dev/shm && exec "$@"'


def sh(*words: str) -> None:
    """Run a command that must succeed."""
    subprocess.run(words, check=True, capture_output=True)


class Network:
    """Three hosts at a switch, without multicast."""

    def __init__(self, command: Path, domain: int, folder: Path) -> None:
        self._command, self._domain, self._folder = command, domain, folder
        self._spaces = [f'rocsafe{os.getpid()}{name}' for name in (*HOSTS, 'switch')]
        self._switch = self._spaces[-1]
        self._started: dict[str, subprocess.Popen[bytes]] = {}

    def open(self) -> None:
        """Make the namespaces and their links."""
        for space in self._spaces:
            sh('ip', 'netns', 'add', space)
        sh('ip', '-n', self._switch, 'link', 'add', 'bridge', 'type', 'bridge')
        sh('ip', '-n', self._switch, 'link', 'set', 'bridge', 'up')
        for number, name in enumerate(HOSTS, 1):
            space = self._spaces[number - 1]
            ends = ('type', 'veth', 'peer', 'name', 'eth0', 'netns', space)
            sh('ip', '-n', self._switch, 'link', 'add', name, *ends)
            sh('ip', '-n', self._switch, 'link', 'set', name, 'master', 'bridge', 'up')
            sh('ip', '-n', space, 'link', 'set', 'lo', 'up')
            sh('ip', '-n', space, 'addr', 'add', f'10.91.0.{number}/24', 'dev', 'eth0')
            sh('ip', '-n', space, 'link', 'set', 'eth0', 'up', 'multicast', 'off')

    def lose(self, percent: int) -> None:
        """Lose so many of the packets that each host receives."""
        rule = f'iif eth0 numgen random mod 100 < {percent} drop'
        for space in self._spaces[:3]:
            nft = ('ip', 'netns', 'exec', space, 'nft')
            sh(*nft, 'add table ip radio')
            sh(*nft, 'add chain ip radio in { type filter hook input priority 0 ; }')
            sh(*nft, f'add rule ip radio in {rule}')

    def cut(self, name: str, *, is_cut: bool = True) -> None:
        """Cut a host off, or connect it again."""
        sh('ip', '-n', self._switch, 'link', 'set', name, 'down' if is_cut else 'up')

    def start(self, name: str, *words: str | Path) -> None:
        """Start the `rocsafe` command on a host."""
        folder = self._folder / name
        (folder / 'tmp').mkdir(parents=True)
        dropped = {*REACH_VARIABLES, *PROFILES, PEERS}
        kept = {key: value for key, value in os.environ.items() if key not in dropped}
        inside = ('ip', 'netns', 'exec', self._spaces[HOSTS.index(name)], 'unshare', '-m')
        with (folder / 'output.txt').open('wb') as output:
            self._started[name] = subprocess.Popen(
                [*inside, 'sh', '-c', OWN_MEMORY, 'sh', self._command, *words],
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                env={**kept, 'ROS_DOMAIN_ID': str(self._domain), 'TMPDIR': str(folder / 'tmp')},
            )

    def start_all(self, link: str = 'dds') -> None:
        """Start the mission on all hosts, whose agents meet over `link`."""
        scenario = self._folder / 'hosts.yaml'
        text = SCENARIO.read_text()
        scenario.write_text(text.replace('agents: true', f'agents: true\n  link: {link}'))
        for name in HOSTS[1:]:
            self.start(
                name, 'join', scenario, '--host', name, '--out', self._folder / name / 'runs'
            )
        runs = self._folder / 'base' / 'runs'
        self.start('base', 'run', scenario, '--out', runs, '--speed', '8')

    def output(self, name: str) -> str:
        """Return what a host has printed."""
        return (self._folder / name / 'output.txt').read_text()

    def run(self, name: str) -> RunDirectory:
        """Return the run directory of a host."""
        found = list((self._folder / name / 'runs').glob('hosts-*'))
        return RunDirectory(found[0])

    def photographed(self, name: str) -> list[int]:
        """Return the viewpoints of the photographs in the store of a host."""
        return [shot.viewpoint_id for shot in read_photographs(self.run(name).images)]

    def wait_until(self, condition: Callable[[], bool]) -> None:
        """Wait until `condition` holds."""
        end_s = time.monotonic() + DEADLINE_S
        while not condition():
            assert time.monotonic() < end_s, '\n'.join(map(self.output, self._started))
            time.sleep(0.1)

    def wait_for_images(self, count: int) -> None:
        """Wait until the hosts together have so many photographs."""

        def is_enough() -> bool:
            stores = self._folder.glob('*/runs/hosts-*/images/*.jpg')
            return len({path.name for path in stores}) >= count

        self.wait_until(is_enough)

    def end(self, name: str) -> int:
        """Wait for the end of the command of a host and return its exit code."""
        process = self._started[name]
        self.wait_until(lambda: process.poll() is not None)
        return int(process.returncode)

    def pids(self, name: str) -> list[int]:
        """Return the processes of a host."""
        words = ['ip', 'netns', 'pids', self._spaces[HOSTS.index(name)]]
        text = subprocess.run(words, check=True, capture_output=True, text=True).stdout
        return [int(pid) for pid in text.split()]

    def close(self) -> None:
        """End what runs, and remove the namespaces."""
        for name in HOSTS:
            for pid in self.pids(name):
                os.kill(pid, signal.SIGKILL)
        for process in self._started.values():
            process.wait()
        for space in self._spaces:
            subprocess.run(['ip', 'netns', 'del', space], check=False)


@pytest.fixture
def network(rocsafe: Path, ros_domain_id: int, tmp_path: Path) -> Iterator[Network]:
    """Give three hosts."""
    made = Network(rocsafe, ros_domain_id, tmp_path)
    try:
        made.open()
    except subprocess.CalledProcessError as error:
        pytest.skip(f'no network namespaces here: {error.stderr.decode().strip()}')
    yield made
    made.close()


def planned(run: RunDirectory) -> list[int]:
    """Return the viewpoints of the survey."""
    plan = json.loads(run.plan.read_text())
    return sorted(view['id'] for route in plan['routes'] for view in route['viewpoints'])


def test_mission_over_three_hosts_on_a_lossy_network_is_complete(network: Network) -> None:
    """One packet of twenty is lost, a host is cut off for 3 s: nothing is missing at the head."""
    if shutil.which('nft') is None:
        pytest.skip('nft is not installed')
    network.lose(LOSS_PERCENT)
    network.start_all()
    network.wait_for_images(3)
    network.cut('boat')
    time.sleep(3.0)
    network.cut('boat', is_cut=False)
    assert network.end('base') == 0, network.output('base')
    assert sorted(set(network.photographed('base'))) == planned(network.run('base'))
    for name in HOSTS[1:]:
        assert network.end(name) == 0, network.output(name)
        assert network.photographed(name)
        assert network.pids(name) == []
    assert network.run('base').report.is_file()


@pytest.mark.parametrize('link', ['dds', 'zenoh'])
def test_mission_goes_on_when_the_head_is_cut_off_for_good(network: Network, link: str) -> None:
    """After the take-off: the other hosts photograph everything, land, and end by themselves."""
    if link == 'zenoh':
        pytest.importorskip('zenoh', reason='needs pip install eclipse-zenoh')
    network.start_all(link)
    network.wait_for_images(2)
    network.cut('base')
    for name in HOSTS[1:]:
        assert network.end(name) == 0, network.output(name)
        assert 'go on by themselves' in network.output(name)
        assert network.pids(name) == []
    found = {point for name in HOSTS for point in network.photographed(name)}
    assert sorted(found) == planned(network.run('van'))
    # The head does not wait for ever, and says what is wrong.
    assert network.end('base') == 1, network.output('base')
    assert 'simulated time stands still' in network.output('base')
