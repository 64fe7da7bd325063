# SPDX-License-Identifier: Apache-2.0
"""Real PX4s that simulate themselves (SIH), where ROCSAFE_PX4 names the folder of a build.

That is the folder of `px4_sitl` with `bin/px4` and `etc` in it. Its UDP ports follow from the
number of the vehicle, so that one set of them flies at a time on a machine.
"""

import fcntl
import os
import struct
import subprocess
import tempfile
import time
from pathlib import Path

from test.fakes.fake_autopilot import HOME
from test.mavlink.airspace import free_port
from test.mavlink.real_copter import Copter, RealAirspace, Tap

BUILD = os.environ.get('ROCSAFE_PX4', '')
# What a machine of two cores simulates in good time, shared by the vehicles.
SPEEDUP = 6.0
QUADROTOR = '10040'
HOME_MSL_M = 488.0
# Of the first vehicle: where a companion listens, and where the ground station's link is.
COMPANION_PORT, STATION_PORT = 14540, 18570
# It logs nothing, and a camera is triggered by its mission.
PARAMETERS = {'SDLOG_MODE': -1, 'TRIG_MODE': 4}
# What makes a failsafe of a test act, and in which words it says so.
PRECAUTIONS = {
    '': {},
    'battery': {'COM_LOW_BAT_ACT': 3},
    'fence': {'GF_ACTION': 3},
    'link': {'NAV_DLL_ACT': 2},
}
WORDS = {
    'battery': 'battery level',
    'fence': 'Geofence violation',
    'link': 'GCS connection loss',
    'position': '',
}
FLOATS = ('GF_MAX_HOR_DIST', 'MIS_TAKEOFF_ALT', 'SIM_BAT_DRAIN', 'SIM_BAT_MIN_PCT')
INT32, REAL32 = 6, 9
LOCK_DEADLINE_S = 300.0


class Px4Copter(Copter):
    """One PX4."""

    def __init__(self, system, link_port, folder, speedup, parameters):
        tap = Tap(link_port, COMPANION_PORT + system - 1)
        super().__init__(system, tap, ('127.0.0.1', STATION_PORT + system - 1))
        folder.mkdir()
        self._folder, self._speedup = folder, speedup
        self._parameters = {**PARAMETERS, **parameters}
        self.start()

    def start(self):
        """Switch it on; off before, if it is on."""
        self.stop()
        with (self._folder.parent / f'px4-{self.system}.log').open('ab') as log:
            self.process = subprocess.Popen(
                [
                    *(f'{BUILD}/bin/px4', '-d', f'{BUILD}/etc', '-w', str(self._folder)),
                    *('-i', str(self.system - 1)),
                ],
                cwd=self._folder,
                env={
                    **os.environ,
                    'PX4_SYS_AUTOSTART': QUADROTOR,
                    'PX4_SIM_SPEED_FACTOR': str(self._speedup),
                    'PX4_HOME_LAT': str(HOME[0]),
                    'PX4_HOME_LON': str(HOME[1]),
                    'PX4_HOME_ALT': str(HOME_MSL_M),
                    **{f'PX4_PARAM_{name}': str(v) for name, v in self._parameters.items()},
                },
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
            )

    @staticmethod
    def encoded(name, value):
        """Return a parameter's value and type as the message has them: an integer's bits."""
        if name in FLOATS:
            return float(value), REAL32
        return struct.unpack('<f', struct.pack('<i', value))[0], INT32


class Px4Airspace(RealAirspace):
    """PX4s on one link."""

    words = WORDS
    # One order begins a mission and flies it.
    begins_with = 'COMMAND_LONG 300'

    def __init__(self, systems, folder, speedup=SPEEDUP, precaution=''):
        self._lock = _locked()
        speedup = min(speedup, SPEEDUP / len(systems))
        port = free_port()
        super().__init__(
            f'udp://127.0.0.1:{port}',
            {
                system: Px4Copter(
                    system, port, Path(folder) / f'px4-{system}', speedup, PRECAUTIONS[precaution]
                )
                for system in systems
            },
        )

    def lose_gps(self, system=1):
        """Leave its receiver no satellites."""
        self.copters[system].set('SIM_GPS_USED', 0)

    def leave_fence(self, system=1):
        """Draw its circle closer: a route that leaves it would not be begun at all."""
        self.copters[system].set('GF_MAX_HOR_DIST', 120.0)

    def drain(self, system=1):
        """Let the battery's charge fall below its limit."""
        self.copters[system].set('SIM_BAT_MIN_PCT', 6.0)
        self.copters[system].set('SIM_BAT_DRAIN', 5.0)

    def close(self):
        """End all, and let the next ones fly."""
        super().close()
        os.close(self._lock)


def _locked():
    """Return an open file whose lock is held until it is closed."""
    path = Path(tempfile.gettempdir(), 'rocsafe-px4.lock')
    file = os.open(path, os.O_CREAT | os.O_RDWR, 0o600)
    end_s = time.monotonic() + LOCK_DEADLINE_S
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            assert time.monotonic() < end_s, f'{path} is held by another process'
            time.sleep(0.2)
        else:
            return file
