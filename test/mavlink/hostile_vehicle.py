# SPDX-License-Identifier: Apache-2.0
"""A vehicle that misbehaves, and a link that loses, repeats, delays and reorders: all from a seed.

It is written apart from `test.fakes`: not as a real autopilot behaves, but as badly as one could.
Each heartbeat is marked with whose the vehicle was when it was sent; the bridge does not see that.
"""

import heapq
import math

from rocsafe_mavlink.autopilots.ardupilot import ARDUPILOT
from rocsafe_mavlink.autopilots.px4 import PX4
from rocsafe_mavlink.wire.dialect import Message

HOME_E7 = (473977420, 85455940)
PREARM = 1 << 28
TAKEOFF_S, ITEM_S, LANDING_S, ON_GROUND_S = 3.0, 5.0, 8.0, 10.0
# Whose the vehicle is.
OURS, PILOT, FAILSAFE, OTHER = 'ours', 'pilot', 'failsafe', 'other station'
TEXTS = (
    'Battery Failsafe',
    'GCS Failsafe',
    'EKF Failsafe: changed to LAND Mode',
    'Circle fence breached',
)
# A rover tells its battery and a crash by these words alone: its status stays as it was.
ROVER_TEXTS = ('Battery 1 is low 10.60V used 274 mAh', 'Crash: Going to HOLD')
# Positions and the like come this often, as on a slow radio.
FAST_S = 1.0
PIECE = 50
WAYPOINT = 16
READING = ('PARAM_REQUEST_READ', 'MISSION_REQUEST_LIST', 'MISSION_REQUEST_INT')
REAL32 = 9
# Settings with which a flight may begin.
SETTINGS = {
    ARDUPILOT: {
        'WPNAV_SPEED': 500.0,
        'WPNAV_ACCEL': 250.0,
        'WPNAV_RADIUS': 200.0,
        'FS_GCS_ENABLE': 1.0,
        'BATT_FS_LOW_ACT': 2.0,
        'FS_OPTIONS': 0.0,
        'FS_THR_ENABLE': 1.0,
        'FENCE_ENABLE': 0.0,
        'FENCE_TYPE': 7.0,
        'FENCE_ACTION': 1.0,
        'FENCE_RADIUS': 900.0,
        'FENCE_ALT_MAX': 110.0,
        'WP_YAW_BEHAVIOR': 0.0,
        'SYSID_MYGCS': 255.0,
        'RTL_ALT': 3000.0,
        'ARMING_CHECK': 1.0,
        'RALLY_LIMIT_KM': 0.3,
        'RALLY_INCL_HOME': 1.0,
        'OA_TYPE': 0.0,
    },
    PX4: {
        'MPC_XY_CRUISE': 5.0,
        'MPC_ACC_HOR': 3.0,
        'NAV_ACC_RAD': 5.0,
        'NAV_DLL_ACT': 2.0,
        'COM_LOW_BAT_ACT': 3.0,
        'GF_ACTION': 3.0,
        'COM_DLL_EXCEPT': 0.0,
        'NAV_RCL_ACT': 2.0,
        'RTL_RETURN_ALT': 30.0,
        'RTL_TYPE': 0.0,
        'GF_MAX_HOR_DIST': 0.0,
        'GF_MAX_VER_DIST': 0.0,
    },
}


# With these the pre-flight lets exclusions pass: it flies home around them by itself.
AROUND = {
    ARDUPILOT: {'OA_TYPE': 2.0, 'FENCE_ENABLE': 1.0, 'FENCE_TYPE': 4.0},
    PX4: {'RTL_TYPE': 2.0},
}


class Channel:
    """One direction of a link."""

    def __init__(self, rng, loss, repeat, delay_s):
        self._rng, self._loss, self._repeat, self._delay_s = rng, loss, repeat, delay_s
        self._queue, self._count = [], 0
        self.is_cut = False

    def put(self, now_s, message):
        """Take a message; it arrives late, twice, or not at all."""
        if self.is_cut or self._rng.random() < self._loss:
            return
        for _ in range(2 if self._rng.random() < self._repeat else 1):
            self._count += 1
            at_s = now_s + self._rng.random() * self._delay_s
            heapq.heappush(self._queue, (at_s, self._count, message))

    def due(self, now_s):
        """Yield what has arrived."""
        while self._queue and self._queue[0][0] <= now_s:
            yield heapq.heappop(self._queue)[2]


class HostileVehicle:
    """One vehicle of a kind (an `Autopilot` table); `rng` is a `random.Random`.

    Attributes
    ----------
    owner : whose it is now.
    stored : items by mission type, each as the fields of `_KEPT`.
    changed_s : when somebody else changed the mission; negative: not since our last upload.
    told_missions : what MISSION_CURRENT has told.
    obeys_another : whether it obeys another station, and ignores ours.
    owners : owner of each heartbeat, by the identity of the message.
    """

    def __init__(self, kind, modes, rng, spite):
        self.kind, self.modes, self.rng, self.spite = kind, modes, rng, spite
        self.said, self.owners = [], {}
        self.stored = {0: [], 1: [], 2: []}
        self.settings = dict(SETTINGS[kind.number])
        self.boot_s = -60.0
        self.changed_s = -1.0
        self.nowhere_until_s = self.flaps_until_s = self.mute_until_s = -1.0
        self.mute, self.current_off = '', 0
        self.told_missions = [{'seq': 0, 'mission_state': 2, 'total': 3}]
        self._start(0.0)

    def _start(self, now_s):
        self.mode = self.modes['idle']
        self.owner, self.status = OURS, 3
        self.is_armed = self.is_flying = self.is_paused = self.is_complete = False
        self.current, self.phase, self.reached = 0, 1, 0
        self.since_s = self.next_s = now_s
        self.home, self.home_mm = HOME_E7, 488_000
        self.is_stuck = self.obeys_another = self.fails_in_upload = False
        self.shift_e7, self.is_lost_until_s = 0, -1.0
        self.place_e7 = HOME_E7
        self._late = []
        self._taking = None
        self._beat_s = self._fast_s = now_s
        self.is_breached = False

    def say(self, name, **fields):
        """Send a message, unless its stream has stopped."""
        message = Message(name, fields, 1, 1)
        if name != self.mute:
            self.said.append(message)
        return message

    # Faults and other people.

    def take(self, owner, mode, now_s):
        """Somebody switches it."""
        self.owner, self.mode, self.since_s = owner, mode, now_s

    def fail(self, now_s):
        """A failsafe acts: with or without words, with or without a status."""
        kind = self.rng.randrange(3)
        if kind != 1:
            self._announce(self.rng.choice(TEXTS + ROVER_TEXTS if self.kind.drives else TEXTS))
        if kind != 2:
            self.status = 5
        self.take(FAILSAFE, self.modes[self.rng.choice(('return', 'land', 'hold'))], now_s)

    def _announce(self, text):
        """Say it in one message, or in two of which one may be lost."""
        if self.rng.random() < 0.7:
            self.say('STATUSTEXT', severity=2, text=text, id=0, chunk_seq=0)
            return
        is_first = self.rng.random() < 0.5
        before = '' if is_first else f'{"Navigation of vehicle one says:":{PIECE}}'
        whole = f'{before}{text}: the charge is at 12 percent, it flies home at 30 m'
        lost = self.rng.choice((None, 0, 1))
        for number, piece in enumerate((whole[:PIECE], whole[PIECE:])):
            if number != lost:
                self.say('STATUSTEXT', severity=2, text=piece, id=7, chunk_seq=number)

    def fence_off(self, ring):
        """Let a polygon that it must not fly over be in its fence."""
        corners = ((round(one.latitude_deg * 1e7), round(one.longitude_deg * 1e7)) for one in ring)
        self.stored[1] = [(0, 5002, float(len(ring)), 0.0, 0.0, 0.0, *at, 0.0) for at in corners]

    def reboot(self, now_s):
        """Start again, on the ground or in the air."""
        if self.rng.random() < 0.7:
            self.stored = {0: [], 1: [], 2: []}
        self.boot_s = self.changed_s = now_s
        self._start(now_s)
        self.status = 1

    def overwrite(self, now_s):
        """Another station writes another mission, often one of the same length."""
        is_alike = self.stored[0] and self.rng.random() < 0.5
        count = len(self.stored[0]) if is_alike else self.rng.randrange(1, 6)
        self.stored[0] = [(3, 16, 0.0, 0.0, 0.0, 0.0, 1, 2, 3.0)] * count
        self.changed_s = now_s

    # What it is told.

    def receive(self, message, now_s):
        """Take a message of the bridge."""
        if self.obeys_another and message.name not in READING:
            return
        if message.name in ('COMMAND_LONG', 'COMMAND_INT'):
            self._command(message, now_s)
        elif message.name == 'PARAM_REQUEST_READ':
            self._tell_setting(message['param_id'])
        elif message.name == 'MISSION_COUNT':
            self._offer(message)
        elif message.name == 'MISSION_ITEM_INT':
            self._item(message)
        elif message.name == 'MISSION_CLEAR_ALL':
            self.stored[message['mission_type']] = []
            self._taking = None
            self.say('MISSION_ACK', type=0, mission_type=message['mission_type'])
        elif message.name == 'MISSION_REQUEST_LIST':
            kind = message['mission_type']
            self.say('MISSION_COUNT', count=len(self.stored[kind]), mission_type=kind)
        elif message.name == 'MISSION_REQUEST_INT':
            self._give(message['mission_type'], message['seq'])

    def _command(self, message, now_s):
        number = message['command']
        if number == 511:
            return
        rng, spite = self.rng, self.spite
        result = self._obey(message, now_s) if rng.random() >= spite['refusing'] else 4
        if rng.random() < spite['lying']:
            result = rng.choice((0, 1, 4, 5, 77))
        if rng.random() >= spite['silent']:
            self.say('COMMAND_ACK', command=number, result=result)
        if spite['endless'] and rng.random() < 0.9:
            self.say('COMMAND_ACK', command=number, result=5)
        if rng.random() < spite['rebooting']:
            self.reboot(now_s)

    def _obey(self, message, now_s):
        number, first = message['command'], message.fields.get('param1', 0.0)
        if number == 176:
            packed = self.kind.is_mode_packed
            main, sub = int(message['param2']), int(message.fields.get('param3', 0.0))
            self._switch(sub << 24 | main << 16 if packed else main, now_s)
        elif number == 193 and self.kind.drives:
            return 4
        elif number == 400:
            self.is_armed = first == 1.0 or (self.is_flying and not self.kind.drives)
            self.since_s = now_s
            # It goes on where it was in its mission if it is switched off within it.
            if self.kind.drives and not self.is_armed and self.mode != self.modes['mission']:
                self.current = 0
            if self.is_armed and self.rng.random() < self.spite['rehomes']:
                self.home = (HOME_E7[0] + self.rng.choice((100, 9000)), HOME_E7[1])
                self.home_mm += self.rng.choice((0, 5000))
        elif number == 300:
            self._switch(self.modes['mission'], now_s)
        elif number == 193:
            self.is_paused = first == 0.0
        elif number == 224:
            self.current, self.is_complete = int(first), False
        elif number == 192:
            self.place_e7 = (message['x'], message['y'])
            self._switch(self.modes['hold' if self.kind.repositions_itself else 'guided'], now_s)
        return 0

    def _switch(self, mode, now_s):
        rng = self.rng
        if rng.random() < self.spite['deaf']:
            return
        if rng.random() < self.spite['late']:
            self._late.append((now_s + 4.0 * rng.random(), mode))
            return
        self._obeyed(mode, now_s)

    def _obeyed(self, mode, now_s):
        self.take(OURS, mode, now_s)
        self.is_paused = False
        if mode == self.modes['mission'] and self.is_complete:
            self.current, self.is_complete = 0, False
        self.next_s = now_s + ITEM_S

    def _offer(self, message):
        if self.rng.random() < self.spite['refusing']:
            result, kind = self.rng.choice((1, 4, 14)), message['mission_type']
            self.say('MISSION_ACK', type=result, mission_type=kind)
            return
        self._taking = (message['mission_type'], message['count'], [])
        self._ask()

    def _item(self, message):
        if self._taking is None:
            return None
        kind, count, items = self._taking
        if message['mission_type'] != kind or message['seq'] != len(items):
            return self._ask()
        z = message['z']
        if self.rng.random() < self.spite['torn']:
            z = 300.0
        items.append((*tuple(message[name] for name in _KEPT[:-1]), z))
        if self.spite['stuck'] and len(items) == self.spite['stuck']:
            items.clear()
        # Items overwrite those before as they arrive.
        self.stored[kind] = items + self.stored[kind][len(items) : count]
        if len(items) == count:
            self._taking = None
            self.stored[kind] = items
            return self.say('MISSION_ACK', type=0, mission_type=kind)
        return self._ask()

    def _ask(self):
        kind, count, items = self._taking
        if not count:
            self.stored[kind], self._taking = [], None
            return self.say('MISSION_ACK', type=0, mission_type=kind)
        name = 'MISSION_REQUEST' if self.rng.random() < 0.3 else 'MISSION_REQUEST_INT'
        named = {'target_system': 255, 'target_component': 190}
        return self.say(name, seq=len(items), mission_type=kind, **named)

    def _tell_setting(self, name):
        if name in self.settings and self.rng.random() >= self.spite['untold']:
            value = self.settings[name]
            self.say('PARAM_VALUE', param_id=name, param_value=value, param_type=REAL32)

    def _give(self, kind, number):
        if number < len(self.stored[kind]):
            fields = dict(zip(_KEPT, self.stored[kind][number], strict=True))
            self.say('MISSION_ITEM_INT', seq=number, mission_type=kind, **fields)

    # What it does and says.

    def step(self, now_s):
        """Fly on; return what it said."""
        for at_s, mode in [late for late in self._late if late[0] <= now_s]:
            self._late.remove((at_s, mode))
            self._obeyed(mode, now_s)
        if self.fails_in_upload and self._taking is not None and self.is_armed:
            self.fails_in_upload = False
            self.fail(now_s)
        self._fly(now_s)
        if now_s - self._fast_s >= FAST_S and not self.is_stuck:
            self._fast_s = now_s
            self._tell(now_s)
        if now_s - self._beat_s >= 1.0:
            self._beat_s = now_s
            if self._taking is not None and self.rng.random() < 0.7:
                self._ask()
            self._beat()
        said, self.said = self.said, []
        return said

    def _beat(self, **odd):
        beat = self.say(
            'HEARTBEAT',
            **{
                'type': 10 if self.kind.drives else 2,
                'autopilot': self.kind.number,
                'base_mode': 0x80 if self.is_armed else 0,
                'custom_mode': self.mode,
                'system_status': self.status,
                **odd,
            },
        )
        self.owners[id(beat)] = (beat, self.owner)

    def beat_beside(self):
        """Let another component beat, in a state that is not the vehicle's."""
        rng = self.rng
        fields = {
            'type': rng.choice((18, 26, 2)),
            'autopilot': rng.choice((0, 8, self.kind.number)),
            'base_mode': rng.choice((0, 0x80)),
            'custom_mode': rng.choice(list(self.modes['pilot'])),
            'system_status': rng.choice((0, 1, 3, 4, 5)),
        }
        self.said.append(Message('HEARTBEAT', fields, 1, rng.choice((100, 154, 191))))

    def beat_oddly(self):
        """Say once in a heartbeat what is not so."""
        rng = self.rng
        self._beat(
            **rng.choice(
                (
                    {'type': rng.choice((1, 6, 10, 20))},
                    {'autopilot': rng.choice((0, 8, 3, 12))},
                    {'base_mode': rng.choice((0, 0x80))},
                    {'custom_mode': rng.choice((0, 99, 2**31))},
                    {'system_status': rng.choice((0, 2, 6, 7, 8, 200))},
                )
            )
        )

    def _fly(self, now_s):
        if self.status == 1 and now_s - self.boot_s > 3.0:
            self.status = 3
        if not self.is_armed:
            self.is_flying = False
            return
        for_s = now_s - self.since_s
        if self.kind.drives:
            self._drive(for_s, now_s)
        elif self.mode in (self.modes['return'], self.modes['land']):
            if for_s > LANDING_S:
                self._land(now_s)
        elif self.mode == self.modes['mission'] and self.stored[0]:
            self.is_flying = self.is_flying or for_s > TAKEOFF_S
            self.status = max(self.status, 4)
            if self.is_flying and not self.is_paused and now_s >= self.next_s:
                self.next_s = now_s + ITEM_S
                self.say('MISSION_ITEM_REACHED', seq=self.current)
                self._move_on()
                if self.current >= len(self.stored[0]):
                    self.current = 0
                    self._land(now_s)
        elif not self.is_flying and for_s > ON_GROUND_S:
            self._land(now_s)

    def _drive(self, for_s, now_s):
        """Stand at the end of a way or at home, switched on."""
        self.is_flying = True
        if self.mode == self.modes['return'] and for_s > LANDING_S:
            self.place_e7 = HOME_E7
        elif self.mode == self.modes['mission'] and self.stored[0] and now_s >= self.next_s:
            self.next_s = now_s + ITEM_S
            self.current = max(self.current, 1)
            if self.current < len(self.stored[0]):
                self.say('MISSION_ITEM_REACHED', seq=self.current)
                self._move_on()
            self.is_complete = self.current >= len(self.stored[0])

    def _move_on(self):
        """Be where the item led, and go on with the next one."""
        for _, command, *_turns, x_e7, y_e7, _z in self.stored[0][self.current :][:1]:
            if command == WAYPOINT:
                self.place_e7 = (x_e7, y_e7)
        self.current += 1

    def _land(self, now_s):
        self.is_armed = self.is_flying = False
        self.place_e7, self.current = HOME_E7, 0
        self.owner, self.status, self.since_s = OURS, 3, now_s

    def _tell(self, now_s):
        up_ms = max(1, round((now_s - self.boot_s) * 1000))
        height = 30_000 if self.is_flying and not self.kind.drives else 0
        is_lost = now_s < self.is_lost_until_s
        if now_s > self.mute_until_s:
            self.mute = ''
        # As before the first fix.
        here = (self.place_e7[0] + self.shift_e7, self.place_e7[1])
        here = (0, 0) if now_s < self.nowhere_until_s else here
        self.say(
            'GLOBAL_POSITION_INT',
            time_boot_ms=up_ms % 2**32,
            lat=here[0],
            lon=here[1],
            alt=488_000 + height,
            relative_alt=height,
            vx=0,
            vy=0,
            vz=0,
            hdg=0,
        )
        self.say(
            'GPS_RAW_INT',
            time_usec=up_ms * 1000,
            fix_type=6,
            alt=488_000,
            alt_ellipsoid=535_000,
            satellites_visible=12,
            h_acc=0,
            v_acc=0,
        )
        self.say('EKF_STATUS_REPORT', flags=37 if is_lost else 831)
        self.say(
            'SYS_STATUS',
            onboard_control_sensors_health=PREARM,
            battery_remaining=90,
            voltage_battery=12_600,
            current_battery=100,
        )
        landed = 0 if self.kind.drives else 2 if self.is_flying else 1
        if now_s < self.flaps_until_s:
            landed = self.rng.choice((0, 1, 2, 3, 4))
        if self.spite['landed'] is not None:
            landed = self.spite['landed']
        self.say('EXTENDED_SYS_STATE', landed_state=landed)
        phase = 4 if self.is_paused else 3 if self.is_flying else 2
        phase = 5 if self.is_complete else phase
        total = max(0, len(self.stored[0]) - self.kind.first_own_item)
        seq = max(0, self.current + self.current_off)
        told = {'seq': seq, 'mission_state': phase, 'total': total}
        if told not in self.told_missions:
            self.told_missions.append(told)
        self.say('MISSION_CURRENT', **told)
        latitude, longitude = self.home
        self.say('HOME_POSITION', latitude=latitude, longitude=longitude, altitude=self.home_mm)


_KEPT = (
    *('frame', 'command', 'param1', 'param2', 'param3', 'param4', 'x', 'y'),
    'z',
)


# A vehicle that does what it is told.
KIND = {
    **dict.fromkeys(('refusing', 'lying', 'silent', 'torn', 'deaf'), 0.0),
    **dict.fromkeys(('rebooting', 'rehomes', 'late', 'untold'), 0.0),
    'endless': False,
    'stuck': 0,
    # What it tells of its landing whatever it does; None: the truth.
    'landed': None,
}


def spite_of(rng):
    """Draw how the vehicle misbehaves: not at all, in one way, or in all at once."""
    amount = dict(KIND)
    for name in ('refusing', 'lying', 'silent', 'torn', 'deaf'):
        if rng.random() < 0.15:
            amount[name] = rng.choice((0.05, 0.2, 0.6))
    for name in ('rebooting', 'rehomes', 'late', 'untold'):
        amount[name] = rng.choice((0.05, 0.3)) if rng.random() < 0.1 else 0.0
    amount['endless'] = rng.random() < 0.05
    amount['stuck'] = rng.randrange(1, 4) if rng.random() < 0.05 else 0
    amount['landed'] = rng.choice((0, 1, 1, 2)) if rng.random() < 0.15 else None
    return amount


def modes_of(kind, verbs):
    """Return the modes that the model needs, by name."""
    named = {verb.value: kind.modes[verb] for verb in verbs}
    pilots = [mode for mode in kind.mode_names if mode not in named.values()]
    return {**named, 'idle': pilots[0], 'pilot': pilots}


def is_finite(message):
    """Whether all numbers of a message are finite."""
    numbers = (value for value in message.fields.values() if isinstance(value, float))
    return all(map(math.isfinite, numbers))
