# SPDX-License-Identifier: Apache-2.0
"""Joins texts that are longer than one message.

A STATUSTEXT holds 50 characters. A longer text comes in pieces of one `id`, numbered by
`chunk_seq`; a piece that is not full is the last (MAVLink common, STATUSTEXT).
"""

from dataclasses import dataclass, replace

from rocsafe_mavlink.wire.dialect import Message

PIECE_LENGTH = 50
LARGEST_PIECE_COUNT = 10
# The next piece follows at once; a piece that is missing after this time was lost.
LATEST_S = 1.0


@dataclass(slots=True)
class TextJoiner:
    """Joins the pieces of the texts of one vehicle.

    Attributes
    ----------
    held
        Pieces so far of a text whose end has not come; None: none.
    pieces
        Number of these pieces.
    held_s
        Steady time of the last of them.
    """

    held: Message | None = None
    pieces: int = 0
    held_s: float = 0.0

    def take(self, message: Message, now_s: float) -> list[Message]:
        """Return the texts that are complete with `message`, or can no longer become so."""
        number, piece = message.fields.get('id', 0), message.fields.get('chunk_seq', 0)
        if self.held is not None and number == self.held['id'] and piece == self.pieces:
            message = _joined(self.held, message)
            before = []
        else:
            before = self.given_up()
            piece = 0
        is_full = len(message['text']) == PIECE_LENGTH * (piece + 1)
        if number and is_full and piece + 1 < LARGEST_PIECE_COUNT:
            self.held, self.pieces, self.held_s = message, piece + 1, now_s
            return before
        self.held = None
        return [*before, message]

    def late(self, now_s: float) -> list[Message]:
        """Return the text whose end is overdue, in a list, and stop holding it."""
        return self.given_up() if now_s - self.held_s > LATEST_S else []

    def given_up(self) -> list[Message]:
        """Return, as a list, the text that is held; it is no longer held."""
        held, self.held = self.held, None
        return [] if held is None else [held]


def _joined(held: Message, piece: Message) -> Message:
    return replace(held, fields={**held.fields, 'text': held['text'] + piece['text']})
