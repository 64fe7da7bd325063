# SPDX-License-Identifier: Apache-2.0
"""A copter as a process, by pymavlink alone, with habits of its own.

    python second_copter.py --port PORT [habits]

It shares no code with `test.fakes` and `hostile_vehicle`. Time in the air runs ten times faster.
"""

import argparse
import math
import os
import socket
import time

os.environ['MAVLINK20'] = '1'
from pymavlink.dialects.v20 import ardupilotmega as mavlink

HOME = (47.397742, 8.545594, 488.0)
HASTE = 10.0
STABILIZE, AUTO, GUIDED, LOITER, RTL, LAND = 0, 3, 4, 5, 6, 9
PARAMETERS = {
    'FS_GCS_ENABLE': 1, 'BATT_FS_LOW_ACT': 2, 'FENCE_ENABLE': 1, 'WP_YAW_BEHAVIOR': 0,
    'WP_SPD': 10, 'WP_ACC': 2.5, 'WP_RADIUS_M': 2, 'MAV_GCS_SYSID': 255, 'FS_OPTIONS': 0,
}  # fmt: skip
METRES = 111195.0
PACE = METRES * math.cos(math.radians(HOME[0]))


def habits():
    """Return the arguments."""
    parser = argparse.ArgumentParser()
    parser.add_argument('--port', type=int, required=True)
    parser.add_argument('--late-ack', type=float, default=0.0, help='answers come so late, s')
    parser.add_argument('--echo', action='store_true', help='answers come again 3 s later')
    parser.add_argument('--foreign-answers', action='store_true', help='refusals for another')
    parser.add_argument('--reject-first', action='store_true', help='each command once')
    parser.add_argument('--twin', action='store_true', help='a second one of the same number')
    parser.add_argument('--miscount', type=int, default=0, help='it tells so many items more')
    parser.add_argument('--accept-early', action='store_true', help='before it has all items')
    parser.add_argument('--kind', type=int, default=mavlink.MAV_TYPE_QUADROTOR)
    parser.add_argument('--maker', type=int, default=mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA)
    parser.add_argument('--odd-mode-at', type=int, default=0, help='item at which a mode comes')
    parser.add_argument('--for-ever', type=int, default=0, help='this command is in progress')
    parser.add_argument('--restart-armed', action='store_true', help='as soon as it is armed')
    parser.add_argument(
        '--shape-shift', action='store_true', help='another type now and then, once armed'
    )
    parser.add_argument('--junk', action='store_true', help='bytes and impossible numbers')
    parser.add_argument('--swap', default='', help='another station changes its mission: when')
    parser.add_argument('--deaf-after-offer', action='store_true', help='never asks for an item')
    return parser.parse_args()


class Copter:
    """Answers, flies and talks."""

    def __init__(self, wanted):
        self.wanted = wanted
        self.sockets = [self._socket() for _ in range(2 if wanted.twin else 1)]
        self.mav = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self.ears = mavlink.MAVLink(None)
        self.ears.robust_parsing = True
        self.begin = time.monotonic()
        self.mode, self.armed, self.running = STABILIZE, False, False
        self.place, self.current = [0.0, 0.0, 0.0], 0
        self.items, self.incoming, self.asked = {0: [None], 1: [], 2: []}, None, 0.0
        self.refused, self.later, self.never_done = set(), [], 0
        self.is_swapped, self.swap_at = False, math.inf

    def _socket(self):
        made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        made.connect(('127.0.0.1', self.wanted.port))
        made.setblocking(False)
        return made

    def log(self, *words):
        """Write down what happens."""
        print(f'{time.monotonic() - self.begin:7.2f}', *words, flush=True)  # noqa: T201

    def send(self, message, after_s=0.0, number=0):
        """Send a message, now or later; that of the twin goes by its own socket."""
        data = message.pack(self.mav)
        self.mav.seq = (self.mav.seq + 1) % 256
        self.later.append((time.monotonic() + after_s, number, data))

    def flush(self):
        """Send what is due."""
        now, waiting = time.monotonic(), self.later
        self.later = [one for one in waiting if one[0] > now]
        for at, number, data in waiting:
            if at <= now:
                try:
                    self.sockets[number].send(data)
                except OSError:
                    continue

    def hear(self):
        """Take what has come."""
        for number, ear in enumerate(self.sockets):
            while True:
                try:
                    data = ear.recv(4096)
                except OSError:
                    break
                for message in self.ears.parse_buffer(data) or []:
                    if number == 0 and getattr(message, 'target_system', 1) == 1:
                        getattr(self, 'on_' + message.get_type().lower(), lambda _m: None)(message)

    def on_mission_count(self, message):
        """Begin to take a list."""
        self.log('OFFER', message.count, 'of kind', message.mission_type)
        self.incoming = [message.mission_type, message.count, []]
        self.ask()

    def ask(self):
        """Ask for the next item."""
        if self.wanted.deaf_after_offer or self.incoming is None:
            return
        kind, _count, taken = self.incoming
        self.send(mavlink.MAVLink_mission_request_int_message(255, 190, len(taken), kind))
        self.asked = time.monotonic()

    def on_mission_item_int(self, message):
        """Take the item that was asked for."""
        if self.incoming is None or message.seq != len(self.incoming[2]):
            return
        kind, count, taken = self.incoming
        taken.append(message)
        is_early = self.wanted.accept_early and len(taken) == 3
        if len(taken) < count and not is_early:
            self.ask()
            return
        self.items[kind], self.incoming = taken, None
        self.log('STORED', len(taken), 'of kind', kind)
        self.swap_at = time.monotonic() + 1.0 if kind == 0 else math.inf
        self.send(mavlink.MAVLink_mission_ack_message(255, 190, 0, kind))

    def on_mission_request_list(self, message):
        """Tell how many items there are."""
        more = self.wanted.miscount if message.mission_type == 0 else 0
        count = len(self.items[message.mission_type]) + more
        self.send(mavlink.MAVLink_mission_count_message(255, 190, count, message.mission_type))

    def on_mission_request_int(self, message):
        """Give an item."""
        kind, items = message.mission_type, self.items[message.mission_type]
        if message.seq >= len(items):
            self.send(mavlink.MAVLink_mission_ack_message(255, 190, 13, kind))
            return
        item = items[message.seq]
        if item is None:
            fields = (0, 0, 16, 0, 1, 0, 0, 0, 0, int(HOME[0] * 1e7), int(HOME[1] * 1e7), HOME[2])
        else:
            frame = {6: 3, 5: 0}.get(item.frame, item.frame)
            turns = (item.param1, item.param2, item.param3, item.param4)
            fields = (item.seq, frame, item.command, 0, 1, *turns, item.x, item.y, item.z)
        self.send(mavlink.MAVLink_mission_item_int_message(255, 190, *fields, kind))

    def on_mission_clear_all(self, message):
        """Forget a list."""
        self.items[message.mission_type] = [None] if message.mission_type == 0 else []
        self.send(mavlink.MAVLink_mission_ack_message(255, 190, 0, message.mission_type))

    def on_param_request_read(self, message):
        """Tell a parameter, if it has it."""
        name = message.param_id
        if name in PARAMETERS:
            value = (name.encode(), PARAMETERS[name], 9, len(PARAMETERS), 0)
            self.send(mavlink.MAVLink_param_value_message(*value))

    def on_command_long(self, message):
        """Obey, and answer as it is used to."""
        number, wanted = message.command, self.wanted
        if number != mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
            self.log('CMD', number, message.param1, message.param2)
        if wanted.for_ever == number:
            self.never_done = number
            return
        if wanted.reject_first and number not in self.refused:
            self.refused.add(number)
            self.answer(number, mavlink.MAV_RESULT_TEMPORARILY_REJECTED)
            return
        if wanted.foreign_answers:
            refusal = mavlink.MAVLink_command_ack_message(
                number, mavlink.MAV_RESULT_DENIED, target_system=77, target_component=1
            )
            self.send(refusal)
        self.answer(number, self.obey(number, message))

    def answer(self, number, result):
        """Answer late or twice."""
        answer = mavlink.MAVLink_command_ack_message(number, result)
        self.send(answer, self.wanted.late_ack)
        if self.wanted.echo:
            self.send(answer, self.wanted.late_ack + 3.0)

    def obey(self, number, message):
        """Do what a command says; return the result."""
        if number == mavlink.MAV_CMD_DO_SET_MODE:
            self.mode = int(message.param2)
        elif number == mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
            if not message.param1 and self.place[2] > 0.5:
                return mavlink.MAV_RESULT_FAILED
            self.armed = bool(message.param1)
            self.log('ARMED', self.armed)
            if self.armed and self.wanted.restart_armed:
                self.wanted.restart_armed = False
                self.begin, self.armed, self.mode = time.monotonic(), False, STABILIZE
                self.log('RESTART')
        elif number == mavlink.MAV_CMD_MISSION_START:
            self.mode, self.running = AUTO, True
        elif number == mavlink.MAV_CMD_DO_SET_MISSION_CURRENT:
            self.current = int(message.param1)
        elif number == mavlink.MAV_CMD_DO_PAUSE_CONTINUE:
            self.running = bool(message.param1)
        elif number not in (mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, mavlink.MAV_CMD_DO_CHANGE_SPEED):
            return mavlink.MAV_RESULT_UNSUPPORTED
        return mavlink.MAV_RESULT_ACCEPTED

    def fly(self, step_s):
        """Move for some seconds."""
        if not self.armed:
            return
        if self.mode in (RTL, LAND):
            self.down(step_s)
        elif self.mode == AUTO and self.running and len(self.items[0]) > 1:
            self.current = max(1, self.current)
            item = self.items[0][min(self.current, len(self.items[0]) - 1)]
            if item.command == mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH:
                self.down(step_s)
            elif self.is_done(item, step_s):
                self.reach()

    def reach(self):
        """Go on to the next item; somebody may switch the mode then."""
        self.send(mavlink.MAVLink_mission_item_reached_message(self.current))
        if self.current == self.wanted.odd_mode_at:
            self.mode = 77
            self.log('MODE 77')
        self.current = min(self.current + 1, len(self.items[0]) - 1)

    def swap(self):
        """Let another station store a mission, once."""
        if not self.is_swapped:
            self.is_swapped = True
            self.items[0] = self.items[0][:-1]
            self.log('SWAPPED')

    def is_done(self, item, step_s):
        """Fly an item for a while; return whether it is done."""
        if item.command == mavlink.MAV_CMD_NAV_TAKEOFF:
            return self.go(self.place[0], self.place[1], item.z, step_s)
        if item.command == mavlink.MAV_CMD_NAV_WAYPOINT:
            east = (item.y / 1e7 - HOME[1]) * PACE
            return self.go(east, (item.x / 1e7 - HOME[0]) * METRES, item.z, step_s)
        return True

    def go(self, east, north, up, step_s):
        """Move towards a place; return whether it is reached."""
        gap = math.dist((east, north, up), self.place)
        part = min(1.0, 6.0 * step_s / gap) if gap else 1.0
        ends = zip(self.place, (east, north, up), strict=True)
        self.place = [here + part * (there - here) for here, there in ends]
        return part == 1.0

    def down(self, step_s):
        """Come home, unless it lands where it is, and land."""
        east, north = self.place[:2] if self.mode == LAND else (0.0, 0.0)
        over = math.dist(self.place[:2], (east, north)) < 0.5
        self.go(east, north, 0.0 if over else max(15.0, self.place[2]), step_s)
        if self.place[2] < 0.05:
            self.armed, self.running = False, False
            self.log('ARMED', False)

    def talk(self, tick):
        """Send what a copter tells, by ticks of a tenth of a second."""
        up_ms = int((time.monotonic() - self.begin) * 1e3)
        where = (int((HOME[0] + self.place[1] / METRES) * 1e7),
                 int((HOME[1] + self.place[0] / PACE) * 1e7))  # fmt: skip
        landed = 2 if self.place[2] > 0.3 else 1
        if tick % 10 == 0:
            base, status = 0x51 | (0x80 if self.armed else 0), 4 if landed == 2 else 3
            kind, maker = self.wanted.kind, self.wanted.maker
            if self.wanted.shape_shift and self.armed and tick % 70 == 60:
                kind = mavlink.MAV_TYPE_FIXED_WING
            if self.never_done:
                self.answer(self.never_done, mavlink.MAV_RESULT_IN_PROGRESS)
            self.send(mavlink.MAVLink_heartbeat_message(kind, maker, base, self.mode, status, 3))
            home = (int(HOME[0] * 1e7), int(HOME[1] * 1e7), int(HOME[2] * 1e3))
            self.send(mavlink.MAVLink_home_position_message(*home, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0))
            self.twin(kind, maker, up_ms)
        if tick % 2 == 0:
            heights = (int((HOME[2] + self.place[2]) * 1e3), int(self.place[2] * 1e3))
            self.send(
                mavlink.MAVLink_global_position_int_message(up_ms, *where, *heights, 0, 0, 0, 0)
            )
            self.send(mavlink.MAVLink_attitude_message(up_ms, 0, 0, 0, 0, 0, 0))
        if tick % 5 == 0:
            self.health(where, landed)
        if self.wanted.junk:
            self.spit(up_ms)

    def health(self, where, landed):
        """Tell receiver, battery, filter, landing and mission."""
        fix = (int(time.time() * 1e6), 6, *where, 535000, 80, 80, 0, 0, 14, 582000, 300, 300, 0, 0)
        self.send(mavlink.MAVLink_gps_raw_int_message(*fix))
        power = (1 << 28, 1 << 28, 1 << 28, 100, 12300, 500, 90, 0, 0, 0, 0, 0, 0)
        self.send(mavlink.MAVLink_sys_status_message(*power))
        self.send(mavlink.MAVLink_ekf_status_report_message(831, 0.1, 0.1, 0.1, 0.1, 0.1))
        self.send(mavlink.MAVLink_extended_sys_state_message(0, landed))
        if self.wanted.swap == 'before' and time.monotonic() > self.swap_at:
            self.swap()
        count = len(self.items[0]) - 1
        state = 3 if self.running else 2
        self.send(mavlink.MAVLink_mission_current_message(self.current, count, state, 0))

    def spit(self, up_ms):
        """Send what no copter means: numbers that are none, places beyond, bytes."""
        nan, far = math.nan, 2**31 - 1
        self.send(mavlink.MAVLink_attitude_message(up_ms, nan, math.inf, nan, nan, nan, nan))
        self.send(
            mavlink.MAVLink_global_position_int_message(
                up_ms, far, far, far, far, 32767, 32767, 32767, 65535
            )
        )
        self.send(mavlink.MAVLink_mission_current_message(65535, 65535, 200, 200))
        self.send(mavlink.MAVLink_command_ack_message(65535, 200))
        self.send(mavlink.MAVLink_mission_ack_message(255, 190, 200, 200))
        self.send(mavlink.MAVLink_mission_request_int_message(255, 190, 65535, 200))
        self.send(mavlink.MAVLink_statustext_message(255, b'\xff' * 50))
        for _ in range(20):
            self.later.append((0.0, 0, os.urandom(300)))

    def twin(self, kind, maker, up_ms):
        """Let the second one of the same number say that it is elsewhere, in a failsafe."""
        if self.wanted.twin:
            self.send(mavlink.MAVLink_heartbeat_message(kind, maker, 0xD1, RTL, 5, 3), number=1)
            self.send(
                mavlink.MAVLink_global_position_int_message(up_ms, 10, 10, 0, 0, 0, 0, 0, 0),
                number=1,
            )

    def run(self):
        """Live until it is killed."""
        tick, next_s = 0, time.monotonic()
        while True:
            self.hear()
            if self.incoming is not None and time.monotonic() - self.asked > 1.5:
                self.ask()
            if time.monotonic() >= next_s:
                next_s += 0.1
                self.fly(0.1 * HASTE)
                self.talk(tick)
                tick += 1
            self.flush()
            time.sleep(0.005)


if __name__ == '__main__':
    Copter(habits()).run()
