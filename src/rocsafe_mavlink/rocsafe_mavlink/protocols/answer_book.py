# SPDX-License-Identifier: Apache-2.0
"""Tells which COMMAND_ACK answers the newest command of its number, and which an older one.

An answer carries the number of a command and nothing else: a late one to "speed 8 m/s" looks like
one to "speed 2 m/s", and one to "continue" like one to "pause". So as long as an older command of
the number is owed an answer, that many answers are taken for its own; the newest command is then
repeated. Where telemetry shows what was ordered that decides, not the answer.
"""

import math
from dataclasses import dataclass, replace

from rocsafe_mavlink.wire.dialect import Message

COMMANDS = ('COMMAND_LONG', 'COMMAND_INT')
IN_PROGRESS = 5
# A link that holds a message for longer counts as lost.
LATEST_S = 10.0


@dataclass(frozen=True, slots=True, kw_only=True)
class _Sent:
    """The newest command of a number, and what older ones are owed.

    Attributes
    ----------
    fields
        Its content, as text: NaN differs from itself.
    open_count, owed_count
        Answers that it, and that older commands, have not got.
    last_s, owed_until_s
        Steady time at which it was sent last, and until which older answers may come.
    """

    fields: str = ''
    open_count: int = 0
    owed_count: int = 0
    last_s: float = -math.inf
    owed_until_s: float = -math.inf


class AnswerBook:
    """Counts commands to one vehicle and their answers."""

    def __init__(self) -> None:
        self._sent: dict[int, _Sent] = {}

    def note(self, message: Message, now_s: float) -> None:
        """Note a message that is sent; all but commands change nothing."""
        if message.name not in COMMANDS:
            return
        sent = self._sent.get(message['command'], _Sent())
        if not _is_repeated(message, sent.fields):
            owed_count = sent.owed_count if now_s < sent.owed_until_s else 0
            sent = _Sent(
                fields=repr(message.fields),
                owed_count=owed_count + sent.open_count,
                owed_until_s=sent.last_s + LATEST_S,
            )
        self._sent[message['command']] = replace(
            sent, open_count=sent.open_count + 1, last_s=now_s
        )

    def answers_newest(self, answer: Message, now_s: float) -> bool:
        """Take a COMMAND_ACK; return whether it can be that of the newest command."""
        sent = self._sent.get(answer['command'])
        if sent is None:
            return True
        is_older = sent.owed_count > 0 and now_s < sent.owed_until_s
        if answer['result'] != IN_PROGRESS:
            sent = (
                replace(sent, owed_count=sent.owed_count - 1)
                if is_older
                else replace(sent, open_count=max(0, sent.open_count - 1))
            )
            self._sent[answer['command']] = sent
        return not is_older


def _is_repeated(message: Message, before: str) -> bool:
    """Whether a command is the one before again; a COMMAND_INT has no count of its repetitions."""
    if message.name == 'COMMAND_LONG':
        return bool(message.fields.get('confirmation', 0))
    return repr(message.fields) == before
