# SPDX-License-Identifier: Apache-2.0
"""Fake copters that fly in a thread and speak over UDP to a bridge."""

import argparse
import socket
import threading
import time

from test.fakes.fake_autopilot import HOME
from test.fakes.fake_process import TICK_S, Served


class Airspace:
    """Copters behind one socket, `rate` times as fast as the wall's clock.

    Attributes
    ----------
    link : where the bridge has to listen.
    copters : by their system.
    """

    def __init__(self, systems=(1,), rate=1.0, images=None, **options):
        port = free_port()
        self.link = f'udp://127.0.0.1:{port}'
        arguments = argparse.Namespace(
            to=f'127.0.0.1:{port}',
            systems=list(systems),
            rate=rate,
            boot=60.0,
            home=HOME,
            images=images,
            returns=options.get('returns', False),
        )
        self._served = Served(arguments)
        self.copters = self._served.copters
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._fly, daemon=True)
        self._thread.start()

    def lose_gps(self, system=1):
        """Switch the receiver off."""
        self.copters[system].has_gps = False

    def drain(self, system=1):
        """Let the battery's voltage fall below its limit."""
        self.copters[system].lose_battery()

    def leave_fence(self, system=1):
        """Fly out of the circle."""
        self.copters[system].breach_fence()

    def restart(self, system=1):
        """Switch the autopilot off and on; it has been on for long enough to fly."""
        self.copters[system].reboot()
        self.copters[system].boot_s -= 60.0

    def fall_silent(self, system=1):
        """End the autopilot."""
        self.copters[system].is_silent = True

    def close(self):
        """End the flights."""
        self._is_over.set()
        self._thread.join(timeout=5.0)
        self._served.socket.close()

    def _fly(self):
        while not self._is_over.is_set():
            self._served.step()
            time.sleep(TICK_S)


def free_port():
    """Return a UDP port that nobody has."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(('127.0.0.1', 0))
        return probe.getsockname()[1]
