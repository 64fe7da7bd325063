# SPDX-License-Identifier: Apache-2.0
"""Real ArduCopters in their own simulator, where ROCSAFE_SITL names its executable.

They speak to a bridge on one UDP port, each through a tap that notes what it is told; faults are
made by parameters that are set from a second station, on a serial port of its own.
"""

import contextlib
import os
import select
import socket
import subprocess
import threading
import time
from pathlib import Path

import pytest
from test.fakes.fake_autopilot import HOME
from test.mavlink.airspace import Airspace, free_port

from rocsafe_mavlink.dialect import Message, decode, encode
from rocsafe_mavlink.framing import pack_frame, scan

BINARY = os.environ.get('ROCSAFE_SITL', '')
# A quadrotor whose sensors count as calibrated, and whose battery is measured.
PARAMETERS = {
    'FRAME_CLASS': 1,
    'FRAME_TYPE': 0,
    'BATT_MONITOR': 4,
    # A servo that pulls the shutter makes a camera.
    'SERVO9_FUNCTION': 10,
    **{f'COMPASS_OFS{n}_X': 5 for n in ('', '2', '3')},
    **{f'COMPASS_OFS{n}_Y': 13 for n in ('', '2', '3')},
    **{f'COMPASS_OFS{n}_Z': -18 for n in ('', '2', '3')},
    **{f'INS_ACC{n}OFFS_{axis}': 0.001 for n in ('', '2') for axis in 'XYZ'},
    **{f'INS_ACC{n}SCAL_{axis}': 1.001 for n in ('', '2') for axis in 'XYZ'},
}
PARAM_SET_REAL32 = 9
SECOND_STATION = (254, 190)
ARMED = 0x80
# As `told` of the fake.
ORDERS = ('COMMAND_LONG', 'COMMAND_INT', 'MISSION_COUNT', 'MISSION_CLEAR_ALL')
# Of a test: first the fake, which is everywhere.
AUTOPILOTS = [
    'fake',
    pytest.param(
        'sitl',
        marks=[
            pytest.mark.skipif(not BINARY, reason='ROCSAFE_SITL names no ArduPilot simulator'),
            pytest.mark.system,
        ],
    ),
]


def make_airspace(kind, folder, systems=(1,), parameters=None, rate=None):
    """Put copters of a kind of `AUTOPILOTS` into the air; `rate` is for the real ones."""
    if kind == 'sitl':
        return SitlAirspace(systems, folder, rate or 10.0, parameters)
    air = Airspace(systems)
    for copter in air.copters.values():
        copter.parameters.update(parameters or {})
    return air


class Tap:
    """Carries what a copter and a bridge say to each other, and notes what it was told.

    Attributes
    ----------
    port : to which the copter speaks.
    told : orders to it, as 'message command'.
    is_armed : by its last heartbeat.
    """

    def __init__(self, bridge_port):
        self.told = []
        self.is_armed = False
        self._copter, self._bridge = (
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2)
        )
        self._copter.bind(('127.0.0.1', 0))
        self.port = self._copter.getsockname()[1]
        self._bridge.connect(('127.0.0.1', bridge_port))
        # A refusal makes a socket look ready, and is gone with the next thing that is sent.
        self._bridge.setblocking(False)
        self._peer = None
        self._is_busy = False
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._carry, daemon=True)
        self._thread.start()

    def hear_all(self):
        """Wait until all that the bridge has sent is noted, and sent on."""
        end = time.monotonic() + 10.0
        while select.select([self._bridge], [], [], 0.0)[0] or self._is_busy:
            assert time.monotonic() < end, 'it carries nothing'
            time.sleep(0.01)

    def close(self):
        """Carry no more."""
        self._is_over.set()
        self._thread.join(timeout=5.0)
        self._copter.close()
        self._bridge.close()

    def _carry(self):
        while not self._is_over.is_set():
            ready, _, _ = select.select([self._copter, self._bridge], [], [], 0.1)
            self._is_busy = True
            for side in ready:
                # Nobody may listen at the moment, as on a radio.
                with contextlib.suppress(OSError):
                    self._pass_on(side)
            self._is_busy = False

    def _pass_on(self, side):
        data, address = side.recvfrom(4096)
        for frame in scan(data, is_whole=True).frames:
            said = decode(frame.message_id, frame.payload, frame.system, frame.component)
            self._note(said, is_order=side is self._bridge)
        if side is self._copter:
            self._peer = address
            self._bridge.send(data)
        elif self._peer is not None:
            self._copter.sendto(data, self._peer)

    def _note(self, message, *, is_order):
        if is_order and message.name in ORDERS:
            self.told.append(f'{message.name} {message.fields.get("command", 0)}')
        elif message.name == 'HEARTBEAT' and not is_order:
            self.is_armed = bool(message['base_mode'] & ARMED)


class SitlCopter:
    """One ArduCopter."""

    def __init__(self, system, link_port, folder, speedup, parameters):
        self.system = system
        self._control = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._control.bind(('127.0.0.1', 0))
        self._control.settimeout(0.2)
        self._peer = None
        folder.mkdir()
        lines = {**PARAMETERS, 'MAV_SYSID': system, **parameters}
        (folder / 'own.parm').write_text(''.join(f'{k} {v}\n' for k, v in lines.items()))
        control = self._control.getsockname()[1]
        self.tap = Tap(link_port)
        self._folder, self._speedup, self._control_port = folder, speedup, control
        self._log = (folder / 'sitl.log').open('wb')
        self.process = None
        self.start()

    def start(self):
        """Switch it on; off before, if it is on."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()
        system, speedup, folder = self.system, self._speedup, self._folder
        self.process = subprocess.Popen(
            [
                *(BINARY, '--model', '+', '--wipe', '--speedup', str(speedup)),
                *('--home', f'{HOME[0]},{HOME[1]},488,0'),
                *('--instance', str(system - 1), '--sysid', str(system)),
                *('--serial0', f'udpclient:127.0.0.1:{self.tap.port}'),
                *('--serial1', f'udpclient:127.0.0.1:{self._control_port}', '--serial2', 'none'),
                *('--defaults', 'own.parm'),
            ],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=self._log,
            stderr=subprocess.STDOUT,
        )

    def set(self, name, value):
        """Set a parameter, and wait until the copter says so."""
        wanted = Message(
            'PARAM_SET',
            {
                'target_system': self.system,
                'target_component': 1,
                'param_id': name,
                'param_value': float(value),
                'param_type': PARAM_SET_REAL32,
            },
        )

        def is_taken(said):
            is_it = said.name == 'PARAM_VALUE' and said['param_id'] == name
            return is_it and abs(said['param_value'] - value) < 1e-3

        self._ask(wanted, is_taken)

    def item_count(self, kind):
        """Return how many items of a kind lie on it."""
        fields = {'target_system': self.system, 'target_component': 1, 'mission_type': kind}

        def is_answer(said):
            return said.name == 'MISSION_COUNT' and said.fields.get('mission_type', 0) == kind

        return self._ask(Message('MISSION_REQUEST_LIST', fields), is_answer)['count']

    def stop(self):
        """End the process, as a crash would."""
        self.process.kill()
        self.process.wait()
        self._log.close()

    def close(self):
        """End the process and the station."""
        if self.process.poll() is None:
            self.stop()
        self._control.close()
        self.tap.close()

    def _ask(self, question, is_answer, deadline_s=30.0):
        """Ask from the second station until it answers; return the answer."""
        data = pack_frame(*encode(question), *SECOND_STATION, 0, sign=False)
        end = time.monotonic() + deadline_s
        while time.monotonic() < end:
            if self._peer is not None:
                self._control.sendto(data, self._peer)
            for said in self._hear():
                if is_answer(said):
                    return said
        raise AssertionError(f'{question} was not answered')

    def _hear(self):
        """Return what comes within a fifth of a second, and a little more."""
        for _ in range(50):
            try:
                data, self._peer = self._control.recvfrom(4096)
            except TimeoutError:
                return
            for frame in scan(data, is_whole=True).frames:
                yield decode(frame.message_id, frame.payload, frame.system, frame.component)


class SitlAirspace:
    """ArduCopters on one link; what it offers is what `Airspace` does."""

    is_real = True

    def __init__(self, systems, folder, speedup=10, parameters=None):
        port = free_port()
        self.link = f'udp://127.0.0.1:{port}'
        self.copters = {
            system: SitlCopter(
                system, port, Path(folder) / f'sitl-{system}', speedup, parameters or {}
            )
            for system in systems
        }

    def step(self):
        """Do nothing: they fly by themselves."""

    def hear_all(self):
        """Let all arrive that was sent."""
        for copter in self.copters.values():
            copter.tap.hear_all()

    def calm(self, _rate=None):
        """Return a context that changes nothing: their time runs as it was begun."""
        return contextlib.nullcontext()

    def told(self):
        """Return the orders that came, as 'message command'."""
        return [order for copter in self.copters.values() for order in copter.tap.told]

    def item_count(self, kind, system=1):
        """Return how many items of a kind lie on a copter."""
        return self.copters[system].item_count(kind)

    def is_armed(self, system=1):
        """Whether its motors run."""
        return self.copters[system].tap.is_armed

    def lose_gps(self, system=1):
        """Switch the receiver off."""
        self.copters[system].set('SIM_GPS1_ENABLE', 0)

    def drain(self, system=1):
        """Let the battery's voltage fall below its limit."""
        self.copters[system].set('SIM_BATT_VOLTAGE', 10.6)

    def leave_fence(self, system=1):
        """Do nothing: it flies out of its circle by its route."""

    def restart(self, system=1):
        """Switch the autopilot off and on."""
        self.copters[system].start()

    def fall_silent(self, system=1):
        """End the autopilot."""
        self.copters[system].stop()

    def close(self):
        """End all."""
        for copter in self.copters.values():
            copter.close()
