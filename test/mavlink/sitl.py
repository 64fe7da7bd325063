# SPDX-License-Identifier: Apache-2.0
"""Real ArduCopters in their own simulator, where ROCSAFE_SITL names its executable."""

import os
import subprocess
from pathlib import Path

from test.fakes.fake_autopilot import HOME
from test.mavlink.airspace import SET_CURRENT, WORDS, free_port
from test.mavlink.real_copter import Copter, RealAirspace, Tap

BINARY = os.environ.get('ROCSAFE_SITL', '')
# A quadrotor whose sensors count as calibrated, and whose battery is measured.
PARAMETERS = {
    'FRAME_CLASS': 1,
    'FRAME_TYPE': 0,
    'BATT_MONITOR': 4,
    # It looks where its mission says.
    'WP_YAW_BEHAVIOR': 0,
    # A servo that pulls the shutter makes a camera.
    'SERVO9_FUNCTION': 10,
    **{f'COMPASS_OFS{n}_X': 5 for n in ('', '2', '3')},
    **{f'COMPASS_OFS{n}_Y': 13 for n in ('', '2', '3')},
    **{f'COMPASS_OFS{n}_Z': -18 for n in ('', '2', '3')},
    **{f'INS_ACC{n}OFFS_{axis}': 0.001 for n in ('', '2') for axis in 'XYZ'},
    **{f'INS_ACC{n}SCAL_{axis}': 1.001 for n in ('', '2') for axis in 'XYZ'},
}
# What makes a failsafe of a test act.
PRECAUTIONS = {
    '': {},
    'battery': {'BATT_LOW_VOLT': 11.0, 'BATT_FS_LOW_ACT': 2},
    'fence': {'FENCE_ENABLE': 1, 'FENCE_TYPE': 2, 'FENCE_RADIUS': 1000, 'FENCE_ACTION': 1},
    'link': {'FS_GCS_ENABLE': 1},
}
# A rover comes back on its own tracks, or stands.
ROVER_PRECAUTIONS = {
    '': {},
    'battery': {'BATT_LOW_VOLT': 11.0, 'BATT_FS_LOW_ACT': 4},
    'battery holds': {'BATT_LOW_VOLT': 11.0, 'BATT_FS_LOW_ACT': 2},
    'link': {'FS_GCS_ENABLE': 1, 'FS_ACTION': 4},
}
PARAM_SET_REAL32 = 9
# Of COMPONENT_ARM_DISARM.
FORCED = 21196.0
ROVER_BINARY = os.environ.get('ROCSAFE_SITL_ROVER', '')
# Tracks, and speeds of a robot that takes evidence.
ROVER_PARAMETERS = {
    'BATT_MONITOR': 4,
    'SERVO1_FUNCTION': 73,
    'SERVO3_FUNCTION': 74,
    **{f'SERVO{n}_{end}': value for n in (1, 3) for end, value in (('MIN', 1000), ('MAX', 2000))},
    **{f'RC{n}_{end}': value for n in (1, 3) for end, value in (('MIN', 1000), ('MAX', 2000))},
    'ATC_STR_RAT_FF': 0.2,
    'CRUISE_SPEED': 3,
    'CRUISE_THROTTLE': 75,
    'WP_SPEED': 3,
    'WP_RADIUS': 1,
    **{key: value for key, value in PARAMETERS.items() if key.startswith(('COMPASS', 'INS_'))},
}


class SitlCopter(Copter):
    """One ArduCopter."""

    binary, model, parameters = BINARY, '+', PARAMETERS

    def __init__(self, system, link_port, folder, speedup, parameters):
        super().__init__(system, Tap(link_port))
        folder.mkdir()
        lines = {**self.parameters, 'MAV_SYSID': system, **parameters}
        (folder / 'own.parm').write_text(''.join(f'{k} {v}\n' for k, v in lines.items()))
        self._folder, self._speedup = folder, speedup
        self.start()

    def start(self):
        """Switch it on; off before, if it is on."""
        self.stop()
        control_port = self._control.getsockname()[1]
        with (self._folder / 'sitl.log').open('ab') as log:
            self.process = subprocess.Popen(
                [
                    *(self.binary, '--model', self.model, '--wipe'),
                    *('--speedup', str(self._speedup)),
                    *('--home', f'{HOME[0]},{HOME[1]},488,0'),
                    *('--instance', str(self.system - 1), '--sysid', str(self.system)),
                    *('--serial0', f'udpclient:127.0.0.1:{self.tap.port}'),
                    *('--serial1', f'udpclient:127.0.0.1:{control_port}', '--serial2', 'none'),
                    *('--defaults', 'own.parm'),
                ],
                cwd=self._folder,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
            )

    @staticmethod
    def encoded(_name, value):
        """Return a parameter's value and type as the message has them: always a float."""
        return float(value), PARAM_SET_REAL32


class SitlRover(SitlCopter):
    """One Rover with tracks."""

    binary, model, parameters = ROVER_BINARY, 'rover-skid', ROVER_PARAMETERS


class SitlAirspace(RealAirspace):
    """ArduPilots on one link."""

    words = WORDS
    begins_with = SET_CURRENT
    kind = SitlCopter
    precautions = PRECAUTIONS

    def __init__(self, systems, folder, speedup=10, precaution=''):
        port = free_port()
        super().__init__(
            f'udp://127.0.0.1:{port}',
            {
                system: self.kind(
                    system,
                    port,
                    Path(folder) / f'sitl-{system}',
                    speedup,
                    self.precautions[precaution],
                )
                for system in systems
            },
        )

    def lose_gps(self, system=1):
        """Switch the receiver off."""
        self.copters[system].set('SIM_GPS1_ENABLE', 0)

    def leave_fence(self, system=1):
        """Draw its circle closer: a route that leaves it would not be begun at all."""
        self.copters[system].set('FENCE_RADIUS', 120)

    def drain(self, system=1):
        """Let the battery's voltage fall below its limit."""
        self.copters[system].set('SIM_BATT_VOLTAGE', 10.6)


class SitlGround(SitlAirspace):
    """Rovers on one link."""

    kind = SitlRover
    precautions = ROVER_PRECAUTIONS

    def be_switched(self, mode, system=1):
        """Let a second station switch its mode."""
        self.copters[system].command(176, 1.0, float(mode))

    def be_switched_off(self, system=1):
        """Let a second station stop its motors, whatever it does."""
        self.copters[system].command(400, 0.0, FORCED)
