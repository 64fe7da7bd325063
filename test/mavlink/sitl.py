# SPDX-License-Identifier: Apache-2.0
"""Real ArduCopters in their own simulator, where ROCSAFE_SITL names its executable.

They speak to a bridge on one UDP port; faults are made by parameters that are set from a second
station, on a serial port of its own.
"""

import os
import socket
import subprocess
import time
from pathlib import Path

from test.fakes.fake_autopilot import HOME
from test.mavlink.airspace import free_port

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
        self._link_port = link_port
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
                *('--serial0', f'udpclient:127.0.0.1:{self._link_port}'),
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
        data = pack_frame(*encode(wanted), *SECOND_STATION, 0, sign=False)
        end = time.monotonic() + 10.0
        while time.monotonic() < end:
            self._control.settimeout(0.2)
            if self._peer is not None:
                self._control.sendto(data, self._peer)
            if self._hears(name, value):
                return
        raise AssertionError(f'{name} was not taken')

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

    def _hears(self, name, value):
        for _ in range(50):
            try:
                data, self._peer = self._control.recvfrom(4096)
            except TimeoutError:
                return False
            for frame in scan(data, is_whole=True).frames:
                said = decode(frame.message_id, frame.payload, frame.system, frame.component)
                is_it = said.name == 'PARAM_VALUE' and said['param_id'] == name
                if is_it and abs(said['param_value'] - value) < 1e-3:
                    return True
        return False


class SitlAirspace:
    """ArduCopters on one link; the faults are those of `FakeAirspace`."""

    is_real = True

    def __init__(self, systems, folder, speedup=10, parameters=None):
        port = free_port()
        self.link = f'udp://127.0.0.1:{port}'
        self.rate = speedup
        self.copters = {
            system: SitlCopter(
                system, port, Path(folder) / f'sitl-{system}', speedup, parameters or {}
            )
            for system in systems
        }

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
