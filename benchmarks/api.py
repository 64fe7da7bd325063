# SPDX-License-Identifier: Apache-2.0
"""Measures what other people's programs get: ``python benchmarks/api.py [--frames 1000000]``.

The server of AirSim's API over the vehicles of the derailment, with a client that only speaks the
protocol; damaged frames against that server; the environments for learning; a campaign of source
searches, fewer than a thousand and scaled. Each figure stands beside its target and what is
published of others. CPU times are of all processes of the server; the machine should be idle.
"""

import argparse
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

import msgpack
from learning import one_agent, several_agents
from rich.console import Console
from rich.table import Table

from rocsafe_learning.environments.fleet_search_env import FleetSearchEnv
from rocsafe_learning.environments.source_search_env import SourceSearchEnv

ROOT = Path(__file__).resolve().parents[1]
SCENARIO = ROOT / 'config' / 'scenarios' / 'derailment_engine.yaml'
CAMPAIGN = ROOT / 'config' / 'campaigns' / 'one_source.yaml'
READY_S, END_S, CALL_S = 180.0, 30.0, 60.0
RGB_HZ, ALL_HZ, STATE_US = 20.0, 12.0, 300.0
STEPS_HZ, AGENTS_HZ, CAMPAIGN_MIN = 10_000.0, 4_000.0, 35.0
# Users of AirSim report these rates, with a graphics card: its issues 2425, 1761, 2521.
PEER_IMAGES = '3 to 17/s, AirSim with a GPU'
# Thirteen metres north of the middle of the derailed train, from where it is in the picture.
WRECK_DEG, HEIGHT_M = (53.27997, -9.06330), 32.0
SCENE = {'camera_name': '0', 'image_type': 0, 'pixels_as_float': False, 'compress': False}
DEPTH = {**SCENE, 'image_type': 1, 'pixels_as_float': True}
LABELS = {**SCENE, 'image_type': 5}
# Of a connection on which damaged frames are sent.
FRAMES_A_CONNECTION, QUIET_S = 200, 2.0
METHODS = (
    'ping', 'getMultirotorState', 'enableApiControl', 'takeoff', 'moveToPosition', 'moveOnPath',
    'moveByVelocity', 'simSetVehiclePose', 'simGetDetections', 'simSetSegmentationObjectID',
    'simPlotPoints', 'simSetWind', 'simSetWeatherParameter', 'land', 'nonsense',
)  # fmt: skip

VALUES: tuple[Any, ...] = (
    0, -1.5, 1e300, '', 'rav1', None, True, [], {'x_val': 1.0}, [[]] * 9,
)  # fmt: skip


class Client:
    """The least that speaks the protocol."""

    def __init__(self, port: int) -> None:
        self._socket = socket.create_connection(('127.0.0.1', port), CALL_S)
        self._unpacker = msgpack.Unpacker(raw=False, max_buffer_size=2**30)
        self._number = 0

    def call(self, method: str, *arguments: Any) -> Any:
        """Return the result of a call; raises `RuntimeError` with the refusal."""
        self._number += 1
        self._socket.sendall(msgpack.packb([0, self._number, method, list(arguments)]))
        while True:
            for _, _, error, result in self._unpacker:
                if error is not None:
                    raise RuntimeError(error)
                return result
            data = self._socket.recv(1_048_576)
            if not data:
                raise ConnectionError('the server has closed the connection')
            self._unpacker.feed(data)


def main(argv: Sequence[str] | None = None) -> int:
    """Measure and print; return 0 if nothing crashed."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').splitlines()[0])
    parser.add_argument('--seconds', type=float, default=8.0, help='of each rate (default: 8)')
    parser.add_argument('--frames', type=int, default=1_000_000, help='that are damaged')
    parser.add_argument('--missions', type=int, default=40, help='of the campaign, to be scaled')
    parser.add_argument('--steps', type=int, default=20_000, help='of each environment')
    arguments = parser.parse_args(argv)
    table = Table('what', 'measured', 'target', 'others')
    with server() as (port, process):
        _add_server(table, port, process, arguments.seconds)
        left = damaged(port, arguments.frames)
        is_alive = process.poll() is None and Client(port).call('ping')
        table.add_row(
            f'{arguments.frames} damaged frames',
            f'{"serves on" if is_alive else "DEAD"}, {left} connections without an end',
            'serves on, 0', '-',
        )  # fmt: skip
    steps = one_agent(SourceSearchEnv(), arguments.steps)
    table.add_row('SourceSearchEnv', f'{steps:.0f} steps/s', f'>= {STEPS_HZ:.0f}', '-')
    agents = several_agents(FleetSearchEnv(), arguments.steps)
    table.add_row('FleetSearchEnv, 3', f'{agents:.0f} agent-steps/s', f'>= {AGENTS_HZ:.0f}', '-')
    cpu_s = campaign_cpu_s(arguments.missions)
    table.add_row(
        '1000 source searches on 2 cores',
        f'{1000.0 * cpu_s / 2.0 / 60.0:.1f} min, scaled from {arguments.missions} '
        f'at {cpu_s:.2f} CPU-s each',
        f'<= {CAMPAIGN_MIN:.0f} min', '-',
    )  # fmt: skip
    console = Console()
    console.print(table)
    console.print(f'{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}')
    return 0 if is_alive and not left else 1


def _add_server(table: Table, port: int, process: Any, seconds: float) -> None:
    client = Client(port)
    _stand_over_wreck(client)
    for name, requests, target in (
        ('simGetImages 640 x 480, RGB', [SCENE], RGB_HZ),
        ('simGetImages 640 x 480, RGB, depth, segmentation', [SCENE, DEPTH, LABELS], ALL_HZ),
    ):
        hz, cpu_s = rate(process, partial(client.call, 'simGetImages', requests, ''), seconds)
        table.add_row(
            name, f'{hz:.1f}/s, {1e3 * cpu_s:.0f} CPU-ms', f'>= {target:.0f}/s', PEER_IMAGES
        )
    hz, cpu_s = rate(process, partial(client.call, 'getMultirotorState', ''), seconds)
    table.add_row(
        'getMultirotorState', f'{1e6 * cpu_s:.0f} CPU-us, {hz:.0f}/s', f'<= {STATE_US:.0f} us', '-'
    )


def _stand_over_wreck(client: Client) -> None:
    """Let the first vehicle see the derailed train from the height of its survey."""
    home = client.call('getHomeGeoPoint', '')
    north_m = (WRECK_DEG[0] - home['latitude']) * 111_300.0
    east_m = (WRECK_DEG[1] - home['longitude']) * 66_700.0
    place = dict(zip(('x_val', 'y_val', 'z_val'), (north_m, east_m, 0.0), strict=True))
    client.call('enableApiControl', True, '')
    client.call('simSetVehiclePose', {'position': place}, True, '')
    yaw = {'is_rate': True, 'yaw_or_rate': 0.0}
    if not client.call('moveToPosition', 0.0, 0.0, -HEIGHT_M, 5.0, 60.0, 0, yaw, -1, 1, ''):
        raise SystemExit('the vehicle cannot stand over the train: it has crashed, or is late')


def rate(process: Any, ask: Callable[[], Any], seconds: float) -> tuple[float, float]:
    """Return calls per second of wall time, and CPU-seconds of the server for one of them.

    What the server's processes use without calls is measured before and taken off.
    """
    ask()
    idle_s, began_s = cpu_of(process.pid), time.monotonic()
    time.sleep(seconds / 2.0)
    idle = (cpu_of(process.pid) - idle_s) / (time.monotonic() - began_s)
    used_s, began_s, count = cpu_of(process.pid), time.monotonic(), 0
    while time.monotonic() < began_s + seconds:
        ask()
        count += 1
    passed_s = time.monotonic() - began_s
    used_s = cpu_of(process.pid) - used_s - idle * passed_s
    return count / passed_s, max(0.0, used_s) / count


def cpu_of(root: int) -> float:
    """Return the CPU-seconds of a process and all below it that live (Linux)."""
    parents, used = {}, {}
    for folder in Path('/proc').glob('[0-9]*'):
        with suppress(OSError):
            fields = (folder / 'stat').read_text().rpartition(')')[2].split()
            parents[int(folder.name)] = int(fields[1])
            used[int(folder.name)] = int(fields[11]) + int(fields[12])
    family = {root}
    while more := {pid for pid, parent in parents.items() if parent in family} - family:
        family |= more
    return sum(used.get(pid, 0) for pid in family) / os.sysconf('SC_CLK_TCK')


def damaged(port: int, frames: int) -> int:
    """Send damaged calls; return how many connections were neither answered nor closed."""
    rng, left = random.Random(1), 0  # noqa: S311 - no secret is drawn
    for begin in range(0, frames, FRAMES_A_CONNECTION):
        data = b''.join(_frame(rng) for _ in range(min(FRAMES_A_CONNECTION, frames - begin)))
        with socket.create_connection(('127.0.0.1', port), QUIET_S) as link:
            # The server closes at the first frame that is no call, also while this one sends.
            with suppress(ConnectionError, TimeoutError):
                link.sendall(data)
                link.shutdown(socket.SHUT_WR)
            left += not _ends(link)
    return left


def _ends(link: socket.socket) -> bool:
    try:
        while link.recv(65_536):
            pass
    except ConnectionError:
        return True
    except TimeoutError:
        return False
    return True


def _frame(rng: random.Random) -> bytes:
    """Return a call with wrong parameters, a damaged call, or noise."""
    arguments = [rng.choice(VALUES) for _ in range(rng.randrange(8))]
    frame = bytearray(msgpack.packb([0, rng.randrange(2**32), rng.choice(METHODS), arguments]))
    kind = rng.random()
    if kind > 0.999:
        return rng.randbytes(rng.randrange(1, 40))
    if kind > 0.995:
        frame[rng.randrange(len(frame))] = rng.randrange(256)
    return bytes(frame)


def campaign_cpu_s(missions: int) -> float:
    """Return the CPU-seconds of a mission of the campaign, its start shared by all."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, 'campaign.yaml')
        text = CAMPAIGN.read_text().replace('seeds: 50 ', f'seeds: {missions // 2} ')
        scenario = CAMPAIGN.with_name('one_source_scenario.yaml')
        file.write_text(text.replace('one_source_scenario.yaml', str(scenario)))
        before = os.times()
        command = ['rocsafe', 'campaign', str(file), '--out', str(Path(folder, 'out'))]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        after = os.times()
    used = after.children_user + after.children_system
    return (used - before.children_user - before.children_system) / (missions // 2 * 2)


@contextmanager
def server() -> Iterator[tuple[int, Any]]:
    """Serve the vehicles of the scenario in real time; give port and process."""
    with socket.create_server(('127.0.0.1', 0)) as free:
        port = free.getsockname()[1]
    with tempfile.TemporaryDirectory() as folder:
        command = ['rocsafe', 'airsim', str(SCENARIO), '--out', folder, '--port', str(port)]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        try:
            _await(process, port)
            yield port, process
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(END_S)


def _await(process: Any, port: int) -> None:
    end_s = time.monotonic() + READY_S
    while time.monotonic() < end_s:
        if process.poll() is not None:
            raise SystemExit(f'rocsafe airsim has ended with {process.returncode}')
        with suppress(OSError):
            socket.create_connection(('127.0.0.1', port), 1.0).close()
            return
        time.sleep(0.2)
    raise SystemExit(f'rocsafe airsim is not ready within {READY_S:g} s')


if __name__ == '__main__':
    sys.exit(main())
