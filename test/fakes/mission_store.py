# SPDX-License-Identifier: Apache-2.0
"""The missions of a fake ArduPilot: how the recorded one took, kept and gave them."""

import math
from dataclasses import dataclass, replace

from rocsafe_mavlink.protocols.mission_item import MissionItem
from rocsafe_mavlink.wire.dialect import Message

LARGEST_COUNT = 650
ASK_AGAIN_S = 1.0
GIVE_UP_S = 8.0
COMMANDS = {16, 20, 21, 22, 115, 178, 203, 206, 2000, 5001, 5002, 5100}
FRAMES = {0, 2, 3, 5, 6, 10, 11}
READ_BACK = {6: 3, 5: 0}
ACCEPTED, ERROR, FRAME, UNSUPPORTED, NO_SPACE = 0, 1, 2, 3, 4
LATITUDE, LONGITUDE, HEIGHT, SEQUENCE, DENIED, CANCELLED = 10, 11, 12, 13, 14, 15
FENCE = 1


@dataclass
class Session:
    """One upload under way."""

    station: tuple
    mission_type: int
    count: int
    wanted: int = 0
    asked_s: float = 0.0
    heard_s: float = 0.0


class MissionStore:
    """Takes and gives missions of the three types.

    Items overwrite the stored mission as they arrive, so that a failed upload destroys it.
    """

    def __init__(self, system=1, home=None, asks_by='MISSION_REQUEST'):
        self.stored = {0: [], 1: [], 2: []}
        self.home = home or MissionItem(
            command=16, frame=0, x_e7=473977420, y_e7=85455940, z_m=488
        )
        self.is_flying = False
        self._system = system
        self._asks_by = asks_by
        self._session = None

    def receive(self, message, station, now_s):
        """Return the answers to a message of `station`, (system, component)."""
        handler = {
            'MISSION_COUNT': self._on_count,
            'MISSION_ITEM_INT': self._on_item,
            'MISSION_REQUEST_LIST': self._on_list,
            'MISSION_REQUEST_INT': self._on_request,
            'MISSION_CLEAR_ALL': self._on_clear,
        }.get(message.name)
        return handler(message, station, now_s) if handler else []

    def tick(self, now_s):
        """Ask again after a second, give up after eight."""
        session = self._session
        if session is None:
            return []
        if now_s - session.heard_s >= GIVE_UP_S:
            self._session = None
            return [
                self._say('STATUSTEXT', severity=4, text='Mission upload timeout'),
                self._ack(CANCELLED, session.mission_type),
            ]
        if now_s - session.asked_s >= ASK_AGAIN_S:
            return self._ask(now_s)
        return []

    def _on_count(self, message, station, now_s):
        kind, count = message.fields.get('mission_type', 0), message['count']
        if self._session is not None and self._session.station != station:
            return [self._ack(DENIED, kind)]
        if count > LARGEST_COUNT:
            text = f'Only {LARGEST_COUNT} items are supported'
            return [self._say('STATUSTEXT', severity=4, text=text), self._ack(NO_SPACE, kind)]
        self.stored[kind] = self.stored[kind][:count]
        if count == 0:
            self._session = None
            return [self._ack(ACCEPTED, kind)]
        self._session = Session(station, kind, count, heard_s=now_s)
        return self._ask(now_s)

    def _on_item(self, message, station, now_s):
        session = self._session
        kind = message.fields.get('mission_type', 0)
        if session is None or session.station != station:
            return []
        if message['seq'] != session.wanted:
            return [self._ack(SEQUENCE, kind)]
        fault = self._fault(message)
        if fault:
            # What had arrived stays, and nothing of the mission before.
            self.stored[kind] = self.stored[kind][: session.wanted]
            self._session = None
            return [self._ack(fault, kind)]
        self._keep(message, kind)
        session.wanted += 1
        session.heard_s = now_s
        if session.wanted < session.count:
            return self._ask(now_s)
        self._session = None
        return self._finish(kind)

    def _finish(self, kind):
        if kind == FENCE and len(self.stored[kind]) < 3:
            text = 'Fence validation failed'
            return [self._say('STATUSTEXT', severity=4, text=text), self._ack(ERROR, kind)]
        text = {0: 'Flight plan received', 1: 'Fence Indexed OK', 2: 'Rally points received'}[kind]
        return [self._say('STATUSTEXT', severity=6, text=text), self._ack(ACCEPTED, kind)]

    def _keep(self, message, kind):
        item = MissionItem(
            command=message['command'],
            frame=READ_BACK.get(message['frame'], message['frame']),
            x_e7=message['x'],
            y_e7=message['y'],
            z_m=round(message['z'], 2),
            parameters=tuple(message[f'param{number}'] for number in (1, 2, 3, 4)),
        )
        if kind == 0 and message['seq'] == 0:
            item = self.home
        stored = self.stored[kind]
        stored[message['seq'] :] = [item, *stored[message['seq'] + 1 :]]

    def _fault(self, message):
        if message['command'] not in COMMANDS:
            return UNSUPPORTED
        if message['frame'] not in FRAMES:
            return FRAME
        if abs(message['x']) > 90e7:
            return LATITUDE
        return HEIGHT if not math.isfinite(message['z']) else 0

    def _on_list(self, message, _station, _now_s):
        kind = message.fields.get('mission_type', 0)
        return [self._say('MISSION_COUNT', count=len(self.stored[kind]), mission_type=kind)]

    def _on_request(self, message, _station, _now_s):
        kind, number = message.fields.get('mission_type', 0), message['seq']
        if number >= len(self.stored[kind]):
            return [self._ack(SEQUENCE, kind)]
        item = self.stored[kind][number].message(number, (255, 190), kind)
        return [replace(item, system=self._system, component=1)]

    def _on_clear(self, message, _station, _now_s):
        kind = message.fields.get('mission_type', 0)
        if self.is_flying and kind == 0:
            return [self._ack(ERROR, kind)]
        self._session = None
        self.stored[kind] = []
        return [self._ack(ACCEPTED, kind)]

    def _ask(self, now_s):
        session = self._session
        session.asked_s = now_s
        return [self._say(self._asks_by, seq=session.wanted, mission_type=session.mission_type)]

    def _ack(self, result, kind):
        return self._say('MISSION_ACK', type=result, mission_type=kind)

    def _say(self, name, **fields):
        return Message(name, fields, self._system, 1)
