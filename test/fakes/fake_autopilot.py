# SPDX-License-Identifier: Apache-2.0
"""A fake ArduCopter: answers, refuses and fails as the recorded one did, in simulated time.

Recorded on ArduCopter 4.7.0-dev in its own simulator. Flight is a point at constant speed: what is
recorded is what it says and when, not how it flies.
"""

import math

from test.fakes.mission_store import MissionStore

from rocsafe_mavlink.protocols.mission_item import MissionItem
from rocsafe_mavlink.wire.dialect import Message, decode, encode

STABILIZE, AUTO, GUIDED, LOITER, RTL, LAND, BRAKE = 0, 3, 4, 5, 6, 9, 17
MODES = {STABILIZE, AUTO, GUIDED, LOITER, RTL, LAND, BRAKE}
ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4
EKF_GOOD, EKF_LOST = 831, 37
HOME = (47.3977420, 8.5455940)
HOME_MSL_M = 488.0
DEG_M = 111_190.0
STEP_S = 0.1
CLIMB_MPS, DESCENT_MPS = 2.5, 1.5
ARRIVED_M = 2.0
DISARM_DELAY_S = 10.0
GCS_TIMEOUT_S = 5.0
GPS_LOSS_LAND_S = 8.0
EKF_READY_S, PREARM_S, FIX_S, HOME_S = 41.4, 23.5, 10.0, 19.9
PREARM = 1 << 28
STREAM_S = 0.5
WORDS_DELAY_S = 0.3
IDS = {
    33: 'GLOBAL_POSITION_INT',
    24: 'GPS_RAW_INT',
    1: 'SYS_STATUS',
    193: 'EKF_STATUS_REPORT',
    42: 'MISSION_CURRENT',
    245: 'EXTENDED_SYS_STATE',
    30: 'ATTITUDE',
    2: 'SYSTEM_TIME',
    242: 'HOME_POSITION',
    87: 'POSITION_TARGET_GLOBAL_INT',
}


class FakeCopter:
    """One copter on a link.

    Parameters
    ----------
    home : latitude and longitude, degrees.
    boot_s : for how long it has been on already.
    unix_s : time of day at simulated time 0, seconds since 1970.
    fs_gcs_enable : whether it returns when the station's heartbeats stop; off by default, as on
        the real one.
    has_streams : whether it speaks without being asked, as by its stream parameters.

    Attributes
    ----------
    home_msl_m : altitude of its home, which every station may set anew.
    patience : by how much it waits longer for a station, where its time runs fast.
    """

    def __init__(
        self,
        system=1,
        *,
        fs_gcs_enable=False,
        speed_mps=10.0,
        home=HOME,
        boot_s=0.0,
        unix_s=0.0,
        has_streams=False,
    ):
        self.patience = 1.0
        self.missions = MissionStore(system, home=_home_item(home))
        self.home = home
        self.home_msl_m = HOME_MSL_M
        self.heading_deg = 0.0
        self._unix_s = unix_s
        self._head_start_s = boot_s
        self.parameters = {
            'WPNAV_SPEED': 1000.0,
            'WP_YAW_BEHAVIOR': 0.0,
            'WPNAV_ACCEL': 250.0,
            'WPNAV_RADIUS': 200.0,
            'FS_GCS_ENABLE': float(fs_gcs_enable),
            'BATT_FS_LOW_ACT': 0.0,
            'FS_GCS_TIMEOUT': GCS_TIMEOUT_S,
            'FENCE_ENABLE': 0.0,
            'SYSID_MYGCS': 255.0,
        }
        self.has_gps = True
        self.is_silent = False
        self.commands = []
        self._system = system
        self._speed_mps = speed_mps
        self._now_s = self._station_s = 0.0
        self._start()
        if has_streams:
            self._rates = dict.fromkeys(IDS.values(), STREAM_S)

    def _start(self):
        self.boot_s = self._now_s - self._head_start_s
        self._head_start_s = 0.0
        self.mode = STABILIZE
        self.is_armed = False
        self.is_paused = False
        self.place = (0.0, 0.0)
        self.height_m = 0.0
        self.status = 1
        self.current = 0
        self.mission_state = 1
        self.target = None
        self.velocity = (0.0, 0.0, 0.0)
        self.shot_count = 0
        self.trigger_m = 0.0
        self._since_shot_m = 0.0
        self._rates = {}
        self._sent = {}
        self._armed_s = 0.0
        self._gcs_s = None
        self._gps_lost_s = None
        self._gps_time_us = 0
        self._out = []
        self._words = []

    @property
    def up_s(self):
        """Seconds since it was started."""
        return self._now_s - self.boot_s

    @property
    def is_flying(self):
        """Whether it is in the air."""
        return self.height_m > 0.05

    @property
    def has_ekf(self):
        """Whether its estimate uses the receiver."""
        return self.has_gps and self.up_s >= EKF_READY_S

    def receive(self, message, station=(255, 190)):
        """Take a message of a station."""
        if self.is_silent:
            return
        if message.name == 'HEARTBEAT':
            self._gcs_s = self._station_s
        elif message.name in ('COMMAND_LONG', 'COMMAND_INT'):
            self._on_command(message)
        elif message.name == 'PARAM_REQUEST_READ':
            self._on_parameter(message)
        else:
            self._out += self.missions.receive(message, station, self._station_s)
            is_change = message.name in ('MISSION_COUNT', 'MISSION_ITEM_INT', 'MISSION_CLEAR_ALL')
            if is_change and not message.fields.get('mission_type') and not self.is_flying:
                self.mission_state = 2 if self.missions.stored[0] else 1

    def step(self, now_s):
        """Fly until `now_s`; return what it said since the last step."""
        while self._now_s + STEP_S <= now_s + 1e-9:
            self._now_s += STEP_S
            self._station_s += STEP_S / self.patience
            while self._words and self._words[0][0] <= self._now_s:
                self._text(*self._words.pop(0)[1:])
            self._fail_safe()
            self._fly()
            self._out += self.missions.tick(self._station_s)
            self._speak()
        said, self._out = self._out, []
        return [] if self.is_silent else said

    # Faults.

    def reboot(self):
        """Start again: rates, home and the mission of the simulator are gone."""
        self.missions = MissionStore(self._system, home=_home_item(self.home))
        self._start()

    def lose_battery(self):
        """Low voltage for longer than its timer."""
        self._text(4, 'Battery 1 is low 10.60V used 274 mAh')
        self._text(4, 'Battery Failsafe')
        self.status, self.mode = 5, RTL

    def lose_remote(self):
        """The remote control falls silent."""
        self._text(4, 'Radio Failsafe')
        self.status, self.mode = 5, RTL

    def breach_fence(self):
        """Fly out of the circle."""
        self._say('FENCE_STATUS', breach_status=1, breach_type=3, breach_count=1)
        self.status, self.mode = 5, RTL
        # The words come a little later.
        self._words.append((self._now_s + WORDS_DELAY_S, 4, 'Circle fence breached'))

    def _fail_safe(self):
        heard_s = self._gcs_s
        silent_s = 0.0 if heard_s is None else self._station_s - heard_s
        is_silent = silent_s > self.parameters['FS_GCS_TIMEOUT']
        returns = bool(self.parameters['FS_GCS_ENABLE'])
        if returns and is_silent and self.is_flying and self.status != 5:
            self._text(4, 'GCS Failsafe')
            self.status, self.mode = 5, RTL
        if self.has_gps:
            self._gps_lost_s = None
        elif self._gps_lost_s is None:
            self._gps_lost_s = self._now_s
        elif self._now_s - self._gps_lost_s >= GPS_LOSS_LAND_S and self._must_land():
            self._text(2, 'EKF Failsafe: changed to LAND Mode')
            self.status, self.mode = 5, LAND

    def _must_land(self):
        return self.is_flying and self.mode != LAND

    # Commands.

    def _on_command(self, message):
        number = message['command']
        self.commands.append(number)
        handler = {
            176: self._on_mode,
            193: self._on_pause,
            224: self._on_current,
            300: self._on_start,
            400: self._on_arm,
            511: self._on_interval,
            178: self._on_speed,
            192: self._on_reposition,
        }.get(number)
        result = UNSUPPORTED if handler is None else handler(message)
        self._say('COMMAND_ACK', command=number, result=result)

    def _parameter(self, message, number):
        return message.fields.get(f'param{number}', 0.0)

    def _on_mode(self, message):
        mode = int(self._parameter(message, 2))
        if mode not in MODES:
            return FAILED
        items = self.missions.stored[0]
        has_takeoff = len(items) > 1 and items[1].command == 22
        if mode == AUTO and self.is_armed and not self.is_flying and not has_takeoff:
            self._text(4, 'Auto: Missing Takeoff Cmd')
            self._text(4, 'Mode change to AUTO failed: init failed')
            return FAILED
        if mode == AUTO and self.is_armed and self.mode != AUTO:
            self.current = max(self.current, 1)
            self.mission_state, self.is_paused = 3, False
            if not self.is_flying:
                self._text(6, 'Mission: 1 Takeoff')
        self.mode = mode
        return ACCEPTED

    def _on_arm(self, message):
        wanted = self._parameter(message, 1) == 1.0
        if not wanted:
            if self.is_flying:
                return FAILED
            self._disarm()
            return ACCEPTED
        reason = ''
        if self.mode == AUTO:
            reason = 'Arm: AUTO mode not armable'
        elif self.mode == GUIDED and not self.has_ekf:
            reason = 'Arm: Need Position Estimate'
        if reason:
            self._text(3, reason)
            return FAILED
        self.is_armed, self._armed_s = True, self._station_s
        return ACCEPTED

    def _on_start(self, message):
        return ACCEPTED if self._parameter(message, 1) == 0.0 else DENIED

    def _on_pause(self, message):
        if self.mode != AUTO or not self.is_flying:
            return FAILED
        items = self.missions.stored[0]
        if self.current >= len(items) or items[self.current].command in (20, 22):
            self._text(4, 'Failed to pause')
            return FAILED
        self.is_paused = self._parameter(message, 1) == 0.0
        self.mission_state = 4 if self.is_paused else 3
        return ACCEPTED

    def _on_current(self, message):
        number = int(self._parameter(message, 1))
        if not 0 < number < len(self.missions.stored[0]):
            return FAILED
        self.current = number
        return ACCEPTED

    def _on_speed(self, message):
        self._speed_mps = self._parameter(message, 2)
        return ACCEPTED

    def _on_reposition(self, message):
        if self.mode != GUIDED or not self.is_flying:
            return DENIED
        self.target = self._local(message['x'], message['y']), message['z']
        return ACCEPTED

    def _on_parameter(self, message):
        name = message['param_id']
        if name in self.parameters:
            # As a number, whatever it is: ArduPilot casts.
            self._say(
                'PARAM_VALUE', param_id=name, param_value=self.parameters[name], param_type=9
            )

    def _local(self, x_e7, y_e7):
        east = (y_e7 / 1e7 - self.home[1]) * DEG_M * math.cos(math.radians(self.home[0]))
        return east, (x_e7 / 1e7 - self.home[0]) * DEG_M

    def _on_interval(self, message):
        name = IDS.get(int(self._parameter(message, 1)))
        if name is None:
            return DENIED
        self._rates[name] = self._parameter(message, 2) / 1e6
        return ACCEPTED

    # Flight.

    def _fly(self):
        self.missions.is_flying = self.is_flying
        # Whoever approaches nothing stands.
        self.velocity = (0.0, 0.0, 0.0)
        if not self.is_armed:
            return
        if not self.is_flying and self.mode != AUTO:
            if self._station_s - self._armed_s > DISARM_DELAY_S:
                self._disarm()
        elif self.mode == AUTO and not self.is_paused:
            self._fly_item()
        elif self.mode == RTL:
            self._fly_home()
        elif self.mode == GUIDED and self.target is not None:
            place, height_m = self.target
            self.height_m += max(-0.25, min(0.25, height_m - self.height_m))
            self._approach(place)
        elif self.mode == LAND:
            self._descend()

    def _fly_item(self):
        items = self.missions.stored[0]
        if self.current >= len(items):
            return
        item = items[self.current]
        if item.command == 22:
            self.height_m += CLIMB_MPS * STEP_S
            if self.height_m >= item.z_m:
                self._reached()
        elif item.command == 16:
            self.height_m += max(-0.25, min(0.25, item.z_m - self.height_m))
            if self._approach(self._local(item.x_e7, item.y_e7)):
                self._reached()
        elif item.command == 20:
            self._fly_home()
        else:
            self._do(item)
            self.current += 1

    def _do(self, item):
        if item.command == 203:
            self._shoot()
        elif item.command == 115:
            self.heading_deg = item.parameters[0]
        elif item.command == 178:
            self._speed_mps = item.parameters[1]
        elif item.command == 206:
            self.trigger_m = item.parameters[0]
            if item.parameters[2] == 1.0:
                self._shoot()

    def _reached(self):
        self._say('MISSION_ITEM_REACHED', seq=self.current)
        self.current += 1

    def _approach(self, goal):
        east, north = goal[0] - self.place[0], goal[1] - self.place[1]
        left = math.hypot(east, north)
        share = min(1.0, self._speed_mps * STEP_S / left) if left else 1.0
        self.place = (self.place[0] + share * east, self.place[1] + share * north)
        self.velocity = (share * east / STEP_S, share * north / STEP_S, 0.0)
        self._fly_past(share * left)
        return left * (1.0 - share) < ARRIVED_M

    def _fly_past(self, way_m):
        if self.trigger_m:
            self._since_shot_m += way_m
            if self._since_shot_m >= self.trigger_m:
                self._since_shot_m -= self.trigger_m
                self._shoot()

    def _shoot(self):
        place = self._global_position_int()
        self._say(
            'CAMERA_FEEDBACK',
            time_usec=round((self._unix_s + self._now_s) * 1e6),
            img_idx=self.shot_count,
            lat=place['lat'],
            lng=place['lon'],
            alt_msl=place['alt'] / 1000.0,
            alt_rel=place['relative_alt'] / 1000.0,
        )
        self.shot_count += 1

    def _fly_home(self):
        if self._approach((0.0, 0.0)):
            self._descend()

    def _descend(self):
        self.height_m = max(0.0, self.height_m - DESCENT_MPS * STEP_S)
        if not self.is_flying:
            if self.mode == AUTO:
                self._say('MISSION_ITEM_REACHED', seq=self.current)
                self.current, self.mission_state = 0, 5
            self._text(6, 'Disarming motors')
            self._disarm()

    def _disarm(self):
        self.is_armed = False

    def be_flown(self, mode):
        """Let the pilot start the motors and hover in a mode."""
        self._armed_s = self._station_s
        self.is_armed, self.mode, self.height_m = True, mode, 5.0

    def be_landed(self):
        """Let the pilot land, and stop the motors."""
        self.is_armed, self.height_m = False, 0.0

    # What it says.

    def _speak(self):
        if self.status != 5:
            self.status = 4 if self.is_flying else 3 if self.up_s > 3.0 else 1
        self._due('HEARTBEAT', 1.0, self._heartbeat)
        for name, period_s in self._rates.items():
            self._due(name, period_s, getattr(self, f'_{name.lower()}'))

    def _due(self, name, period_s, fields):
        last_s = self._sent.get(name, -math.inf)
        if self._now_s - last_s >= period_s - 1e-6:
            self._sent[name] = self._now_s
            said = fields()
            if said is not None:
                self._say(name, **said)

    def _heartbeat(self):
        return {
            'type': 2,
            'autopilot': 3,
            'base_mode': 0x80 if self.is_armed else 0,
            'custom_mode': self.mode,
            'system_status': self.status,
        }

    def _global_position_int(self):
        east, north = self.place
        has_place = self.up_s >= FIX_S
        longitude = self.home[1] + east / DEG_M / math.cos(math.radians(self.home[0]))
        return {
            'time_boot_ms': round(self.up_s * 1000),
            'lat': round((self.home[0] + north / DEG_M) * 1e7) if has_place else 0,
            'lon': round(longitude * 1e7) if has_place else 0,
            'alt': round((HOME_MSL_M + self.height_m) * 1000),
            'relative_alt': round(self.height_m * 1000),
            'vx': round(self.velocity[1] * 100),
            'vy': round(self.velocity[0] * 100),
            'vz': 0,
            'hdg': round(100.0 * self.heading_deg) % 36000,
        }

    def _position_target_global_int(self):
        """Return the place of a go-to above the sea, whatever frame it was sent in."""
        if self.mode != GUIDED or self.target is None:
            return None
        (east, north), height_m = self.target
        longitude = self.home[1] + east / DEG_M / math.cos(math.radians(self.home[0]))
        return {
            'lat_int': round((self.home[0] + north / DEG_M) * 1e7),
            'lon_int': round(longitude * 1e7),
            'alt': self.home_msl_m + height_m,
        }

    def _gps_raw_int(self):
        has_fix = self.has_gps and self.up_s >= FIX_S
        if has_fix or self.up_s < FIX_S:
            self._gps_time_us = round(self._now_s * 1e6)
        msl_mm = round((HOME_MSL_M + self.height_m) * 1000)
        return {
            'time_usec': self._gps_time_us,
            'fix_type': 6 if has_fix else 1,
            'alt': msl_mm,
            'alt_ellipsoid': msl_mm,
            'satellites_visible': 10,
            'h_acc': 300,
            'v_acc': 500,
        }

    def _sys_status(self):
        return {
            'onboard_control_sensors_health': PREARM if self.up_s >= PREARM_S else 0,
            'battery_remaining': 80,
            'voltage_battery': 12600,
            'current_battery': 2800,
        }

    def _ekf_status_report(self):
        return {'flags': EKF_GOOD if self.has_ekf else EKF_LOST}

    def _mission_current(self):
        total = max(0, len(self.missions.stored[0]) - 1)
        return {'seq': self.current, 'mission_state': self.mission_state, 'total': total}

    def _extended_sys_state(self):
        if not self.is_flying:
            return {'landed_state': 1}
        is_takeoff = self.mode == AUTO and self.current == 1
        return {'landed_state': 3 if is_takeoff else 4 if self.mode == LAND else 2}

    def _home_position(self):
        if self.up_s < HOME_S:
            return None
        return {
            'latitude': round(self.home[0] * 1e7),
            'longitude': round(self.home[1] * 1e7),
            'altitude': round(self.home_msl_m * 1000),
        }

    def _attitude(self):
        yaw = math.remainder(math.radians(self.heading_deg), math.tau)
        return {'time_boot_ms': round(self.up_s * 1000), 'yaw': yaw}

    def _system_time(self):
        unix_us = round((self._unix_s + self._now_s) * 1e6)
        return {'time_unix_usec': unix_us, 'time_boot_ms': round(self.up_s * 1000)}

    def _text(self, severity, text):
        self._say('STATUSTEXT', severity=severity, text=text)

    def _say(self, name, **fields):
        # Through the codec, so that what is read is what can be on a wire.
        filled = _complete(name, fields)
        self._out.append(Message(name, filled, self._system, 1))


def _home_item(home):
    x_e7, y_e7 = (round(angle * 1e7) for angle in home)
    return MissionItem(command=16, frame=0, x_e7=x_e7, y_e7=y_e7, z_m=HOME_MSL_M)


def _complete(name, fields):
    number, payload = encode(Message(name, fields))
    return decode(number, payload, 1, 1).fields
