# SPDX-License-Identifier: Apache-2.0
"""The mission protocol of a PX4 as its states are, with the flag that it forgets to take back.

After PX4's `MavlinkMissionManager` of 2025: a list that is asked for while an upload waits for its
first item ends that upload, but not the flag that a transfer is in progress; while the flag is set
every offer is refused. It is taken back where an upload ends, is cancelled, or anything times out.
"""

from rocsafe_mavlink.wire.dialect import Message

IDLE, TAKING, GIVING = 'idle', 'taking', 'giving'
RETRY_S, TIMEOUT_S = 0.25, 5.0
DONE, ERROR, CANCELLED = 0, 1, 15
FIELDS = ('frame', 'command', 'param1', 'param2', 'param3', 'param4', 'x', 'y', 'z')


class Px4Missions:
    """Lists of one PX4: mission, fence and rally points; `stored` holds items by type."""

    def __init__(self):
        self.stored = {0: [], 1: [], 2: []}
        self.state, self.kind = IDLE, 0
        self.is_in_progress = False
        self.partner = (0, 0)
        self.number = self.count = 0
        self.sent_s = self.heard_s = 0.0
        self._taken, self._out = [], []

    def receive(self, message, sender, now_s):
        """Take a message; return the answers."""
        handler = {
            'MISSION_COUNT': self._on_count,
            'MISSION_ITEM_INT': self._on_item,
            'MISSION_REQUEST_LIST': self._on_list,
            'MISSION_REQUEST_INT': self._on_request,
            'MISSION_ACK': self._on_ack,
            'MISSION_CLEAR_ALL': self._on_clear,
        }.get(message.name)
        if handler is not None:
            handler(message, sender, now_s)
        return self._said()

    def tick(self, now_s):
        """Let time pass; return what it says."""
        if self.state == TAKING and now_s - self.sent_s > RETRY_S:
            self._ask(now_s)
        if self.state != IDLE and now_s - self.heard_s > TIMEOUT_S:
            self.state, self.is_in_progress = IDLE, False
        return self._said()

    def _said(self):
        said, self._out = self._out, []
        return said

    def _say(self, name, to=None, **fields):
        system, component = to or self.partner
        named = {'target_system': system, 'target_component': component}
        self._out.append(Message(name, {**named, 'mission_type': self.kind, **fields}, 1, 1))

    def _ask(self, now_s):
        self.sent_s = now_s
        self._say('MISSION_REQUEST_INT', seq=self.number)

    def _on_count(self, message, sender, now_s):
        if self.state == GIVING or (self.state == TAKING and sender != self.partner):
            self._say('MISSION_ACK', sender, type=ERROR)
            return
        self.heard_s = now_s
        if self.state == TAKING:
            if self.number:
                self._say('MISSION_ACK', type=ERROR)
            else:
                self._ask(now_s)
            return
        if self.is_in_progress:
            self._say('MISSION_ACK', sender, type=ERROR)
            return
        self.partner, self.kind = sender, message['mission_type']
        if not message['count']:
            self.stored[self.kind] = []
            self._say('MISSION_ACK', type=DONE)
            return
        self.is_in_progress, self.state = True, TAKING
        self.number, self.count, self._taken = 0, message['count'], []
        self._ask(now_s)

    def _on_item(self, message, sender, now_s):
        if sender != self.partner:
            return
        if message['mission_type'] != self.kind or self.state != TAKING:
            self._say('MISSION_ACK', type=ERROR)
            return
        self.heard_s = now_s
        if message['seq'] != self.number:
            return
        self._taken.append({name: message[name] for name in FIELDS})
        self.number += 1
        if self.number < self.count:
            self._ask(now_s)
            return
        self.stored[self.kind] = self._taken
        self.state, self.is_in_progress = IDLE, False
        self._say('MISSION_ACK', type=DONE)

    def _on_list(self, message, sender, now_s):
        if self.number == len(self.stored[self.kind]):
            # Taken for a reading that is complete; the flag of an upload stays.
            self.state = IDLE
        is_again = (self.kind, self.partner) == (message['mission_type'], sender)
        if self.state != IDLE and not (self.state == GIVING and is_again):
            return
        self.heard_s, self.state = now_s, GIVING
        self.kind, self.partner, self.number = message['mission_type'], sender, 0
        self._say('MISSION_COUNT', count=len(self.stored[self.kind]))

    def _on_request(self, message, sender, now_s):
        if sender != self.partner or self.state != GIVING or message['mission_type'] != self.kind:
            return
        self.heard_s = now_s
        if message['seq'] == self.number < len(self.stored[self.kind]):
            self.number += 1
        elif message['seq'] != self.number - 1:
            self.state = IDLE
            self._say('MISSION_ACK', type=ERROR)
            return
        item = self.stored[self.kind][message['seq']]
        self._say('MISSION_ITEM_INT', seq=message['seq'], **item)

    def _on_ack(self, message, sender, now_s):
        if sender != self.partner:
            return
        if self.state == GIVING and message['mission_type'] == self.kind:
            self.heard_s, self.state = now_s, IDLE
        elif self.state == TAKING and message['type'] == CANCELLED:
            self.state, self.is_in_progress = IDLE, False

    def _on_clear(self, message, sender, now_s):
        if self.state == IDLE:
            self.heard_s, self.kind = now_s, message['mission_type']
            self.stored[self.kind] = []
            self._say('MISSION_ACK', sender, type=DONE)
