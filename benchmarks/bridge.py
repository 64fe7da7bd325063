# SPDX-License-Identifier: Apache-2.0
"""The bridge against its targets: processor, latency, upload, parser. Needs ROS.

    python benchmarks/bridge.py

Ten drones, each 10 positions a second and the rest of what the bridge asks for, through one
bridge process over UDP on loopback. Latency is from a position handed to the socket to the fix
heard by a subscriber in another process, so it holds twice ROS's own way. The upload is written,
read back and compared.
"""

import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
sys.path[:0] = [
    str(path) for path in (ROOT / 'src').glob('rocsafe_*') if path.name[8:] != 'interfaces'
]
import test  # noqa: E402

test.__path__.append(str(ROOT / 'test'))

import numpy as np  # noqa: E402
import rclpy  # noqa: E402
from rclpy.experimental.events_executor import EventsExecutor  # noqa: E402
from rich.console import Console  # noqa: E402
from rich.table import Table  # noqa: E402
from test.fakes.fake_autopilot import HOME, FakeCopter  # noqa: E402
from test.mavlink.airspace import write_drones  # noqa: E402

from rocsafe_geo.position import GeoPosition, offset  # noqa: E402
from rocsafe_mavlink.autopilots.ardupilot import COPTER  # noqa: E402
from rocsafe_mavlink.link.link import Link, LinkRules  # noqa: E402
from rocsafe_mavlink.plan.flight_plan import FlightPlan, FlightWaypoint, mission_of  # noqa: E402
from rocsafe_mavlink.protocols.mission_transfer import TransferStage, transfer  # noqa: E402
from rocsafe_mavlink.wire.dialect import Message, decode, encode  # noqa: E402
from rocsafe_mavlink.wire.framing import pack_frame, scan  # noqa: E402
from rocsafe_ros.interfaces import topics  # noqa: E402

DRONES = 10
RATE_HZ = 10.0
WARM_UP_S, MEASURED_S = 6.0, 20.0
ITEMS = 500
MESSAGES = 60_000
PHASES = ('out of phase', 'in step')
PORT = 14987
LONGITUDE = 85_455_940
# Ticks of a quarter of a millisecond, wrapped after ten seconds: a drone at 30 m/s.
TICK_S = 0.1
TICKS_PER_S, WRAP = 4000, 40_000


def main() -> int:
    """Measure all four and print the table; return 1 if one misses its target."""
    rows = []
    for phase in PHASES:
        core, p99_ms, heard = bridge_load(phase)
        rows.append(
            (
                f'{DRONES} drones at {RATE_HZ:g} Hz, {phase}',
                f'{100 * core:.1f} % of one core',
                '25 %',
                core <= 0.25,
            )
        )
        rows.append(
            (
                f'position in to topic out, {phase}, p99 of {heard}',
                f'{p99_ms:.1f} ms',
                '20 ms',
                p99_ms <= 20.0,
            )
        )
    seconds = upload_seconds()
    rows.append((f'upload of {ITEMS} items, verified', f'{seconds:.2f} s', '3 s', seconds <= 3.0))
    rate = parser_rate()
    rows.append(
        (
            'parser, messages a second of processor',
            f'{rate:,.0f}',
            '20,000 or more',
            rate >= 20_000,
        )
    )
    table = Table(title='MAVLink bridge')
    for column in ('what', 'measured', 'target', ''):
        table.add_column(column)
    for what, measured, target, is_met in rows:
        table.add_row(what, measured, target, 'met' if is_met else 'MISSED')
    Console().print(table)
    return 0 if all(row[3] for row in rows) else 1


def stamp() -> int:
    """Return the time in ticks, the same in all processes of this machine."""
    return int(time.monotonic() * TICKS_PER_S) % WRAP


def bridge_load(phase: str) -> tuple[float, float, int]:
    """Return the share of a core, the p99 latency in ms, and how many fixes that is of.

    Real drones do not speak in step; that they do is the worst that can be.
    """
    names = [f'rav{number + 1}' for number in range(DRONES)]
    folder = tempfile.TemporaryDirectory(prefix='rocsafe-bridge-')
    link = f'udp://127.0.0.1:{PORT}'
    command = [sys.executable, '-m', 'rocsafe_mavlink.bridge_node', '--ros-args']
    for key, value in {
        'drones_file': write_drones(Path(folder.name), link, range(1, DRONES + 1)),
        'position_rate_hz': RATE_HZ,
        'origin_latitude_deg': HOME[0],
        'origin_longitude_deg': HOME[1],
    }.items():
        command += ['-p', f'{key}:={value}']
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)}
    bridge = subprocess.Popen(command, env=environment)
    air = subprocess.Popen([sys.executable, __file__, '--air', phase])
    try:
        return watch(bridge, names)
    finally:
        air.kill()
        air.wait()
        bridge.send_signal(signal.SIGINT)
        bridge.wait(timeout=20.0)
        folder.cleanup()


def watch(bridge: 'subprocess.Popen[bytes]', names: list[str]) -> tuple[float, float, int]:
    """Listen to the fixes while the bridge works."""
    rclpy.init()
    node = rclpy.create_node('listener')
    latencies: list[float] = []

    def on_fix(message: Any) -> None:
        # The longitude tells when it was sent.
        sent = round(message.longitude * 1e7) - LONGITUDE
        latencies.append((stamp() - sent) % WRAP / TICKS_PER_S)

    for name in names:
        topics.create_subscription(node, topics.FIX, on_fix, name)
    executor = EventsExecutor()
    executor.add_node(node)
    spin(executor, WARM_UP_S)
    latencies.clear()
    used, began = cpu_s(bridge.pid), time.monotonic()
    spin(executor, MEASURED_S)
    share = (cpu_s(bridge.pid) - used) / (time.monotonic() - began)
    rclpy.shutdown()
    return share, 1e3 * float(np.percentile(latencies, 99)), len(latencies)


def spin(executor: EventsExecutor, seconds: float) -> None:
    """Serve for a while."""
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0.0:
        executor.spin_once(timeout_sec=left)


def cpu_s(pid: int) -> float:
    """Return the processor time that a process has used."""
    fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


class Air:
    """Ten fake copters in a process of their own; their longitude tells the time."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(('127.0.0.1', 0))
        self.socket.setblocking(False)
        self.copters = {n + 1: FakeCopter(n + 1, boot_s=60.0) for n in range(DRONES)}

    def fly(self, lag_s: float) -> None:
        """Speak and listen for ever, each `lag_s` before the next."""
        began = time.monotonic()
        while True:
            self.hear()
            now_s = time.monotonic() - began
            for system, copter in self.copters.items():
                for message in copter.step(now_s + system * lag_s):
                    self.say(system, message)
            time.sleep(0.005)

    def hear(self) -> None:
        """Obey what has come."""
        while True:
            try:
                data = self.socket.recv(4096)
            except BlockingIOError:
                return
            except OSError:
                continue
            for frame in scan(data, is_whole=True).frames:
                message = decode(frame.message_id, frame.payload, frame.system, frame.component)
                for system, copter in self.copters.items():
                    if message.fields.get('target_system', 0) in (0, system):
                        copter.receive(message, (frame.system, frame.component))

    def say(self, system: int, message: Message) -> None:
        """Send a message; note when a position goes out."""
        if message.name == 'GLOBAL_POSITION_INT':
            message = Message(message.name, {**message.fields, 'lon': LONGITUDE + stamp()})
        data = pack_frame(*encode(message), system, 1, 0, sign=False)
        try:
            self.socket.sendto(data, ('127.0.0.1', PORT))
        except OSError:
            return


def upload_seconds() -> float:
    """Return the wall time of a verified upload, each message a datagram over loopback."""
    ours, theirs = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
    for end in (ours, theirs):
        end.bind(('127.0.0.1', 0))
        end.settimeout(0.05)
    ours.connect(theirs.getsockname())
    theirs.connect(ours.getsockname())
    copter, is_over = FakeCopter(), threading.Event()
    thread = threading.Thread(target=answer, args=(theirs, copter, is_over))
    thread.start()
    link = Link(LinkRules(allowed=frozenset({'copter'})))
    home = GeoPosition(*HOME)
    stops = tuple(
        FlightWaypoint(position=offset(home, n % 20 * 10.0, n // 20 * 10.0), height_m=30.0)
        for n in range(ITEMS - 4)
    )
    items = mission_of(FlightPlan(waypoints=stops, speed_mps=8.0), COPTER).items
    began = time.monotonic()
    moving, sent = transfer(items, (1, 1), first_compared=1).begin(began)
    while True:
        now = time.monotonic()
        for message in sent:
            ours.send(link.pack(message, now, time.time()))
        if moving.is_over:
            break
        sent = []
        try:
            for message in link.receive('copter', ours.recv(4096), now, time.time()):
                moving, more = moving.on_message(message, now)
                sent += more
        except TimeoutError:
            moving, sent = moving.on_tick(now)
    seconds = time.monotonic() - began
    is_over.set()
    thread.join()
    if moving.stage is not TransferStage.VERIFIED or len(copter.missions.stored[0]) != len(items):
        raise RuntimeError(f'not verified: {moving.error}')
    return seconds


def answer(end: socket.socket, copter: FakeCopter, is_over: threading.Event) -> None:
    """Let a copter answer until it is over."""
    began = time.monotonic()
    while not is_over.is_set():
        try:
            for frame in scan(end.recv(4096), is_whole=True).frames:
                copter.receive(
                    decode(frame.message_id, frame.payload, frame.system, frame.component)
                )
        except OSError:
            pass
        for message in copter.step(time.monotonic() - began):
            end.send(pack_frame(*encode(message), 1, 1, 0, sign=False))


def parser_rate() -> float:
    """Return messages read a second of processor, a datagram each, with every check."""
    kinds = [
        Message('GLOBAL_POSITION_INT', {'time_boot_ms': 1000, 'lat': 473977420, 'lon': 85455940}),
        Message('ATTITUDE', {'time_boot_ms': 1000, 'roll': 0.1}),
        Message('GPS_RAW_INT', {'time_usec': 10, 'fix_type': 6, 'satellites_visible': 12}),
        Message('SYS_STATUS', {'battery_remaining': 70}),
    ]
    frames = [pack_frame(*encode(kind), 1, 1, n, sign=False) for n, kind in enumerate(kinds)]
    link = Link(LinkRules(allowed=frozenset({'drone'})))
    began, count = time.process_time(), 0
    for number in range(MESSAGES):
        # A clock of its own, so that the limit of a peer's rate is no limit here.
        count += len(link.receive('drone', frames[number % 4], number / 1000.0, 1.7e9))
    if count != MESSAGES:
        raise RuntimeError(f'{count} of {MESSAGES} messages were read')
    return count / (time.process_time() - began)


if __name__ == '__main__':
    if '--air' in sys.argv:
        Air().fly(0.0 if PHASES[1] in sys.argv else TICK_S / DRONES)
    raise SystemExit(main())
