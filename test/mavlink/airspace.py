# SPDX-License-Identifier: Apache-2.0
"""Fake copters that fly while their test spins, and speak over UDP to a bridge."""

import argparse
import contextlib
import itertools
import socket

import yaml
from test.fakes.fake_autopilot import HOME, FakeCopter
from test.fakes.fake_process import Served

# Geoid above the ellipsoid where the fake copters live.
SEPARATION_M = 47.0
# As fast as a bridge reads on a machine that has nothing else to do; on others time waits for it.
FAST = 40.0
# Nothing of this changes what a vehicle does.
HARMLESS = {'COMMAND_LONG 511', 'COMMAND_LONG 512'}
# While an operator acts: some tenths of a second of his are a second of the flight.
CALM = 4.0
# With which an ArduCopter begins another route in the air, before it is told to fly it.
SET_CURRENT = 'COMMAND_LONG 224'
# In which an ArduCopter announces a failsafe.
WORDS = {
    'battery': 'Battery',
    'fence': 'fence breached',
    'link': 'GCS Failsafe',
    'position': 'EKF Failsafe',
}


class Airspace:
    """Copters behind one socket; their time passes in `step` only.

    Attributes
    ----------
    link : where the bridge has to listen.
    copters : by their system.
    words : in which a failsafe is announced.
    begins_with : order with which another route begins in the air; a mode follows the fake's.
    """

    words = WORDS
    begins_with = SET_CURRENT

    def __init__(self, systems=(1,), rate=FAST, images=None, **options):
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
            streams=options.get('streams', True),
            kind=options.get('kind', FakeCopter),
        )
        self._served = Served(arguments)
        self.copters = self._served.copters

    def step(self):
        """Fly on."""
        self._served.step()

    def hear_all(self):
        """Let all arrive that was sent."""
        self._served.hear()

    @contextlib.contextmanager
    def calm(self, rate=CALM):
        """Let time run slowly, while an operator acts."""
        before, self._served.rate = self._served.rate, min(rate, self._served.rate)
        try:
            yield
        finally:
            self._served.rate = before

    def told(self):
        """Return the orders that came, as 'message command'."""
        return [f'{name} {number}' for _, name, number in self._served.told]

    def item_count(self, kind, system=1):
        """Return how many items of a kind (mission 0, fence 1, rally 2) lie on a copter."""
        return len(self.copters[system].missions.stored[kind])

    def is_armed(self, system=1):
        """Whether its motors run."""
        return self.copters[system].is_armed

    def lose_gps(self, system=1):
        """Switch the receiver off."""
        self.copters[system].has_gps = False

    def drain(self, system=1):
        """Let the battery's voltage fall below its limit."""
        self.copters[system].lose_battery()

    def be_switched(self, mode, system=1):
        """Let its pilot switch its mode."""
        self.copters[system].be_switched(mode)

    def be_switched_off(self, system=1):
        """Let its pilot stop its motors."""
        self.copters[system].be_switched_off()

    def leave_fence(self, system=1):
        """Fly out of the circle."""
        self.copters[system].breach_fence()

    def restart(self, system=1):
        """Switch the autopilot off and on."""
        self.copters[system].reboot()

    def fall_silent(self, system=1):
        """End the autopilot."""
        self.copters[system].is_silent = True

    def close(self):
        """End the flights."""
        self._served.socket.close()


def told_once(orders):
    """Return orders without what changes nothing; one that was sent again at once counts once.

    It is, where its answer is late.
    """
    return [order for order, _ in itertools.groupby(o for o in orders if o not in HARMLESS)]


def write_drones(folder, link, systems=(1,), **more):
    """Write the drones file of a bridge to the copters behind `link`; return its path."""
    folder.mkdir(parents=True, exist_ok=True)
    drones = [
        {
            'name': f'rav{system}',
            'link': link,
            'system': system,
            'geoid_separation_m': SEPARATION_M,
            'speed_mps': 10.0,
            'hover_s': 0.0,
            **more,
        }
        for system in systems
    ]
    path = folder / 'drones.yaml'
    path.write_text(yaml.safe_dump({'drones': drones}))
    return str(path)


def free_port():
    """Return a UDP port that nobody has."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(('127.0.0.1', 0))
        return probe.getsockname()[1]
