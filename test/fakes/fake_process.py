# SPDX-License-Identifier: Apache-2.0
"""Fake copters as a process of its own: they speak MAVLink to a bridge over UDP.

    python test/fakes/fake_process.py --to 127.0.0.1:14550 --systems 1 2 --rate 5

Time runs `--rate` times as fast as on the wall. What was commanded is printed, a line each; the
camera, if there is one, leaves a JPEG file a shot.
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

from rocsafe_mavlink.dialect import decode, encode
from rocsafe_mavlink.framing import pack_frame, scan

TICK_S = 0.02


class Served:
    """Copters behind one socket."""

    def __init__(self, arguments):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(('127.0.0.1', 0))
        self.socket.setblocking(False)
        host, _, port = arguments.to.rpartition(':')
        self.station = (host, int(port))
        self.rate = arguments.rate
        self.began_s = time.time()
        self.images = arguments.images
        self.sequence = 0
        self.copters = {
            system: FakeCopter(
                system,
                home=tuple(arguments.home),
                boot_s=arguments.boot,
                unix_s=self.began_s,
                fs_gcs_enable=arguments.returns,
                patience=max(1.0, arguments.rate),
            )
            for system in arguments.systems
        }
        frame = arguments.images and arguments.images.parent / 'frame.jpg'
        self.frame = frame.read_bytes() if frame else b''

    def step(self):
        """Let the wall's time pass."""
        self.hear()
        now_s = (time.time() - self.began_s) * self.rate
        for system, copter in self.copters.items():
            for message in copter.step(now_s):
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
            number = message.fields.get('command', 0)
            sys.stdout.write(f'{target} {message.name} {number}\n')
            sys.stdout.flush()
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


def main():
    """Fly until the process is ended."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--to', default='127.0.0.1:14550')
    parser.add_argument('--systems', type=int, nargs='+', default=[1])
    parser.add_argument('--rate', type=float, default=1.0)
    parser.add_argument('--boot', type=float, default=60.0)
    parser.add_argument('--home', type=float, nargs=2, default=list(HOME))
    parser.add_argument('--images', type=Path)
    parser.add_argument('--returns', action='store_true', help='when it hears nobody')
    served = Served(parser.parse_args())
    while True:
        served.step()
        time.sleep(TICK_S)


if __name__ == '__main__':
    sys.exit(main())
