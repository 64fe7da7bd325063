# SPDX-License-Identifier: Apache-2.0
"""Reading a mission back: ``(state, message or tick) -> (state, messages to send)``."""

from dataclasses import dataclass, replace
from enum import Enum

from rocsafe_mavlink.protocols.mission_item import MissionItem, item_of
from rocsafe_mavlink.protocols.timing import TRANSFER_TIMING, TransferTiming
from rocsafe_mavlink.wire.dialect import Message, addressed

# More items than any autopilot holds.
LARGEST_ITEM_COUNT = 5000


class DownloadStage(Enum):
    """Progress of a download."""

    LISTING = 'listing'
    READING = 'reading'
    DONE = 'done'
    FAILED = 'failed'


@dataclass(frozen=True, slots=True, kw_only=True)
class Download:
    """State of one download.

    Attributes
    ----------
    target
        (system, component) of the autopilot.
    mission_type
        Mission, fence or rally points.
    stage
        Progress of the download.
    count
        Number of items, once it is known.
    items
        Items read so far.
    asked_s
        Steady time of the last question.
    asks
        How often the last question was asked.
    error
        Why the download failed.
    timing
        Deadlines and repetitions.
    """

    target: tuple[int, int]
    mission_type: int = 0
    stage: DownloadStage = DownloadStage.LISTING
    count: int = 0
    items: tuple[MissionItem, ...] = ()
    asked_s: float = 0.0
    asks: int = 0
    error: str = ''
    timing: TransferTiming = TRANSFER_TIMING

    def begin(self, now_s: float) -> tuple['Download', list[Message]]:
        """Ask for the number of items."""
        return self._ask(now_s)

    def on_message(self, message: Message, now_s: float) -> tuple['Download', list[Message]]:
        """Take a message of the autopilot."""
        if message.fields.get('mission_type', 0) != self.mission_type:
            return self, []
        if message.name == 'MISSION_COUNT' and self.stage is DownloadStage.LISTING:
            return self._on_count(int(message['count']), now_s)
        if message.name == 'MISSION_ITEM_INT' and self.stage is DownloadStage.READING:
            return self._on_item(message, now_s)
        return self, []

    def on_tick(self, now_s: float) -> tuple['Download', list[Message]]:
        """Let time pass."""
        is_over = self.stage in (DownloadStage.DONE, DownloadStage.FAILED)
        if is_over or now_s - self.asked_s < self.timing.ask_again_s:
            return self, []
        if self.asks >= self.timing.largest_ask_count:
            what = f'item {len(self.items)}' if self.stage is DownloadStage.READING else 'a count'
            error = f'the mission could not be read back: no answer to {what}'
            return replace(self, stage=DownloadStage.FAILED, error=error), []
        return self._ask(now_s)

    def _on_count(self, count: int, now_s: float) -> tuple['Download', list[Message]]:
        if count > LARGEST_ITEM_COUNT:
            error = f'the mission is said to have {count} items'
            return replace(self, stage=DownloadStage.FAILED, error=error), []
        return replace(self, stage=DownloadStage.READING, count=count, asks=0)._next(now_s)

    def _on_item(self, message: Message, now_s: float) -> tuple['Download', list[Message]]:
        if message['seq'] != len(self.items):
            return self, []
        return replace(self, items=(*self.items, item_of(message)), asks=0)._next(now_s)

    def _next(self, now_s: float) -> tuple['Download', list[Message]]:
        if len(self.items) < self.count:
            return self._ask(now_s)
        return replace(self, stage=DownloadStage.DONE), [self._message('MISSION_ACK', type=0)]

    def _ask(self, now_s: float) -> tuple['Download', list[Message]]:
        asked = replace(self, asked_s=now_s, asks=self.asks + 1)
        if self.stage is DownloadStage.LISTING:
            return asked, [self._message('MISSION_REQUEST_LIST')]
        return asked, [self._message('MISSION_REQUEST_INT', seq=len(self.items))]

    def _message(self, name: str, **fields: int) -> Message:
        return addressed(name, self.target, mission_type=self.mission_type, **fields)
