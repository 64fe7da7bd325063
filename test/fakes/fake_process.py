# SPDX-License-Identifier: Apache-2.0
"""Fake copters as a process of its own: they speak MAVLink to a bridge over UDP.

    python test/fakes/fake_process.py --to 127.0.0.1:14550 --systems 1 2 --rate 5

Time runs `--rate` times as fast as on the wall, slower where the bridge does not keep up. What was
commanded is printed, a line each; the camera, if there is one, leaves a JPEG file a shot.
"""

import argparse
import os
import socket
import sys
import time
from pathlib import Path

import test

# The standard library has a package of this name, which would hide ours.
if str(Path(__file__).parents[1]) not in test.__path__:
    test.__path__.append(str(Path(__file__).parents[1]))

from test.fakes.fake_autopilot import HOME, FakeCopter
from test.fakes.fake_rover import FakeRover

from rocsafe_mavlink.wire.dialect import decode, encode
from rocsafe_mavlink.wire.framing import pack_frame, scan

TICK_S = 0.02
# Simulated time that passes at most at once, and bytes that may wait for the bridge: a socket
# that overflows would lose messages that a real link carries.
SHORTEST_STEP_S = 0.01
LARGEST_STEP_S = 1.0
LARGEST_BACKLOG = 32_000


class Served:
    """Copters behind one socket.

    Attributes
    ----------
    rate: how fast time runs.
    told: orders that came, as (system, message, command).
    """

    def __init__(self, arguments):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(('127.0.0.1', 0))
        self.socket.setblocking(False)
        host, _, port = arguments.to.rpartition(':')
        self.station = (host, int(port))
        self.rate = arguments.rate
        self.told = []
        self._now_s, self._last_s = 0.0, time.monotonic()
        self.images = arguments.images
        self.sequence = 0
        self.copters = {
            system: getattr(arguments, 'kind', FakeCopter)(
                system,
                home=tuple(arguments.home),
                boot_s=arguments.boot,
                unix_s=time.time(),
                fs_gcs_enable=arguments.returns,
                has_streams=arguments.streams,
            )
            for system in arguments.systems
        }
        frame = arguments.images and arguments.images.parent / 'frame.jpg'
        self.frame = frame.read_bytes() if frame else b''

    def step(self):
        """Let the wall's time pass; no more of it than the bridge can follow."""
        self.hear()
        now_s = time.monotonic()
        if now_s - self._last_s >= SHORTEST_STEP_S:
            passed_s = min(LARGEST_STEP_S, (now_s - self._last_s) * self.rate)
            self._last_s = now_s
            if waiting_bytes(self.station[1]) < LARGEST_BACKLOG:
                self._now_s += passed_s
        for system, copter in self.copters.items():
            copter.patience = max(1.0, self.rate)
            for message in copter.step(self._now_s):
                if message.name == 'CAMERA_FEEDBACK' and self.images:
                    self.photograph(system, message)
                self.say(system, message)

    def hear(self):
        """Hand the copters what has come."""
        while True:
            try:
                data = self.socket.recv(4096)
            except BlockingIOError:
                return
            except OSError:
                continue
            for frame in scan(data, is_whole=True).frames:
                message = decode(frame.message_id, frame.payload, frame.system, frame.component)
                self.obey(message, (frame.system, frame.component))

    def obey(self, message, station):
        """Hand one message to whom it is for."""
        target = message.fields.get('target_system', 0)
        if message.name in ('COMMAND_LONG', 'COMMAND_INT', 'MISSION_COUNT', 'MISSION_CLEAR_ALL'):
            self.told.append((target, message.name, message.fields.get('command', 0)))
        for system, copter in self.copters.items():
            if target in (0, system):
                copter.receive(message, station)

    def say(self, system, message):
        """Send one message of a copter."""
        data = pack_frame(*encode(message), system, 1, self.sequence, sign=False)
        self.sequence = (self.sequence + 1) % 256
        try:
            self.socket.sendto(data, self.station)
        except OSError:
            # Nobody listens at the moment.
            return

    def photograph(self, system, message):
        """Leave a file as a camera does: written whole, then named."""
        path = self.images / f'IMG_{system}_{message["img_idx"]:04d}.jpg'
        scratch = path.with_suffix('.part')
        scratch.write_bytes(self.frame)
        taken_s = message['time_usec'] / 1e6
        os.utime(scratch, (taken_s, taken_s))
        scratch.replace(path)


def waiting_bytes(port):
    """Return how much waits to be read at a UDP port of this machine; 0 if nobody tells."""
    wanted = f':{port:04X}'
    try:
        lines = Path('/proc/net/udp').read_text().splitlines()[1:]
    except OSError:
        return 0
    sockets = [line.split() for line in lines]
    return sum(int(each[4].partition(':')[2], 16) for each in sockets if each[1].endswith(wanted))


def main():
    """Fly until the process is ended."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--to', default='127.0.0.1:14550')
    parser.add_argument('--rover', dest='kind', action='store_const', const=FakeRover,
                        default=FakeCopter, help='ground vehicles')  # fmt: skip
    parser.add_argument('--systems', type=int, nargs='+', default=[1])
    parser.add_argument('--rate', type=float, default=1.0)
    parser.add_argument('--boot', type=float, default=60.0)
    parser.add_argument('--home', type=float, nargs=2, default=list(HOME))
    parser.add_argument('--images', type=Path)
    parser.add_argument('--returns', action='store_true', help='when it hears nobody')
    parser.add_argument('--streams', action='store_true', help='speak without being asked')
    served = Served(parser.parse_args())
    while True:
        served.step()
        for order in served.told:
            sys.stdout.write(' '.join(map(str, order)) + '\n')
        served.told.clear()
        sys.stdout.flush()
        time.sleep(TICK_S)


if __name__ == '__main__':
    sys.exit(main())
