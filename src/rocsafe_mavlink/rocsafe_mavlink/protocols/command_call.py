# SPDX-License-Identifier: Apache-2.0
"""One command and its answer: ``(state, message or tick) -> (state, messages to send)``.

A command is repeated while no answer comes, with its `confirmation` counted up. An autopilot says
why it refused in a text of its own, from half a second before to a second and a half after the
refusal; these texts belong to the answer.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

from rocsafe_mavlink.protocols.timing import COMMAND_TIMING, CommandTiming
from rocsafe_mavlink.wire.authority import (
    COMPONENT_ARM_DISARM,
    DO_CHANGE_SPEED,
    DO_PAUSE_CONTINUE,
    DO_SET_MISSION_CURRENT,
    MISSION_START,
    SET_MESSAGE_INTERVAL,
)
from rocsafe_mavlink.wire.dialect import Message, addressed

LARGEST_TEXT_COUNT = 10
ACCEPTED, IN_PROGRESS = 0, 5
RESULTS = {
    1: 'temporarily rejected',
    2: 'denied',
    3: 'not supported',
    4: 'failed',
    6: 'cancelled',
}
GROUND_SPEED = 1.0
Target = tuple[int, int]


class CallStage(Enum):
    """Progress of a command."""

    WAITING = 'waiting'
    EXPLAINING = 'explaining'
    ACCEPTED = 'accepted'
    REFUSED = 'refused'
    UNANSWERED = 'unanswered'


@dataclass(frozen=True, slots=True)
class HeardText:
    """A text of the autopilot and when it came, steady seconds."""

    time_s: float
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandCall:
    """State of one command.

    Attributes
    ----------
    command
        The COMMAND_LONG or COMMAND_INT.
    us
        Our own (system, component), which an answer may name.
    stage
        Progress of the command.
    wait_until_s
        Steady time until which nothing is done.
    until_s
        Steady time at which it is given up, whatever is answered.
    sends
        How often it was sent.
    result
        MAV_RESULT of the answer, -1 before.
    heard
        Texts of the autopilot around its refusal.
    timing
        Deadlines and repetitions.
    """

    command: Message
    us: Target
    stage: CallStage = CallStage.WAITING
    wait_until_s: float = 0.0
    until_s: float = math.inf
    sends: int = 0
    result: int = -1
    heard: tuple[HeardText, ...] = ()
    timing: CommandTiming = COMMAND_TIMING

    @property
    def is_over(self) -> bool:
        """Whether the answer is known, or will not come."""
        return self.stage not in (CallStage.WAITING, CallStage.EXPLAINING)

    @property
    def error(self) -> str:
        """Why it was not done, with the autopilot's own texts; empty if it was."""
        if self.stage is CallStage.UNANSWERED:
            return f'no answer to command {self.command["command"]}'
        if self.stage is not CallStage.REFUSED:
            return ''
        what = RESULTS.get(self.result, f'result {self.result}')
        texts = (word.text for word in self.heard)
        return '; '.join((f'command {self.command["command"]} {what}', *texts))

    def is_due(self, now_s: float) -> bool:
        """Whether it is repeated or given up at `now_s`."""
        return self.stage is CallStage.WAITING and now_s >= self.wait_until_s

    def begin(
        self, now_s: float, heard: Sequence[HeardText] = ()
    ) -> tuple['CommandCall', list[Message]]:
        """Send it; `heard` are the latest texts."""
        until_s = now_s + self.timing.longest_s
        return replace(self, heard=self._recent(heard, now_s), until_s=until_s)._send(now_s)

    def on_message(self, message: Message, now_s: float) -> 'CommandCall':
        """Take a message of the autopilot; those of others change nothing."""
        if self.is_over or message.system != self.command['target_system']:
            return self
        if message.name == 'STATUSTEXT':
            return self._hear(HeardText(now_s, str(message['text'])))
        if self.stage is CallStage.WAITING and self._is_answer(message):
            return self._answered(int(message['result']), now_s)
        return self

    def on_tick(self, now_s: float) -> tuple['CommandCall', list[Message]]:
        """Let time pass."""
        if self.is_over or now_s < self.wait_until_s:
            return self, []
        if self.stage is CallStage.EXPLAINING:
            return replace(self, stage=CallStage.REFUSED), []
        if self.sends >= self.timing.largest_send_count or now_s >= self.until_s:
            return replace(self, stage=CallStage.UNANSWERED), []
        return self._send(now_s)

    def _send(self, now_s: float) -> tuple['CommandCall', list[Message]]:
        fields = dict(self.command.fields)
        if self.command.name == 'COMMAND_LONG':
            fields['confirmation'] = self.sends
        sent = replace(self, sends=self.sends + 1, wait_until_s=now_s + self.timing.repeat_s)
        return sent, [Message(self.command.name, fields)]

    def _hear(self, word: HeardText) -> 'CommandCall':
        is_explaining = self.stage is CallStage.EXPLAINING
        kept = self.heard if is_explaining else self._recent(self.heard, word.time_s)
        return replace(self, heard=(*kept, word)[:LARGEST_TEXT_COUNT])

    def _recent(self, heard: Sequence[HeardText], now_s: float) -> tuple[HeardText, ...]:
        before_s = self.timing.text_before_s
        return tuple(word for word in heard if now_s - word.time_s <= before_s)

    def _is_answer(self, message: Message) -> bool:
        if message.name != 'COMMAND_ACK' or message['command'] != self.command['command']:
            return False
        fields = message.fields
        named = (fields.get('target_system', 0), fields.get('target_component', 0))
        return all(part in (0, ours) for part, ours in zip(named, self.us, strict=True))

    def _answered(self, result: int, now_s: float) -> 'CommandCall':
        if result == ACCEPTED:
            return replace(self, stage=CallStage.ACCEPTED, result=result)
        if result == IN_PROGRESS:
            wait_until_s = min(now_s + self.timing.progress_s, self.until_s)
            return replace(self, wait_until_s=wait_until_s)
        stage = CallStage.EXPLAINING
        until_s = now_s + self.timing.text_after_s
        heard = self._recent(self.heard, now_s)
        return replace(self, stage=stage, result=result, wait_until_s=until_s, heard=heard)


def command(number: int, target: Target, *parameters: float) -> Message:
    """Return a COMMAND_LONG with its first parameters; the rest are 0."""
    fields = {f'param{place}': float(value) for place, value in enumerate(parameters, start=1)}
    return addressed('COMMAND_LONG', target, command=number, **fields)


def arm(target: Target) -> Message:
    """Return the command to start the motors."""
    return command(COMPONENT_ARM_DISARM, target, 1.0)


def disarm(target: Target) -> Message:
    """Return the command to stop the motors, which autopilots refuse in flight."""
    return command(COMPONENT_ARM_DISARM, target, 0.0)


def start_mission(target: Target, item: int = 0) -> Message:
    """Return the command to start the mission with `item`; ArduPilot denies all but 0."""
    return command(MISSION_START, target, item)


def pause(target: Target) -> Message:
    """Return the command to stop within a mission."""
    return command(DO_PAUSE_CONTINUE, target, 0.0)


def resume(target: Target) -> Message:
    """Return the command to continue after a pause."""
    return command(DO_PAUSE_CONTINUE, target, 1.0)


def change_speed(target: Target, speed_mps: float) -> Message:
    """Return the command to fly at `speed_mps` over ground."""
    return command(DO_CHANGE_SPEED, target, GROUND_SPEED, speed_mps)


def set_current(target: Target, item: int) -> Message:
    """Return the command to continue with item `item`."""
    return command(DO_SET_MISSION_CURRENT, target, item)


def set_interval(target: Target, message_id: int, rate_hz: float) -> Message:
    """Return the command to send a message at a rate."""
    return command(SET_MESSAGE_INTERVAL, target, message_id, 1e6 / rate_hz)
