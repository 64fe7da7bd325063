# SPDX-License-Identifier: Apache-2.0
"""Mission upload: ``(state, message or tick) -> (state, messages to send)``.

The autopilot leads: it asks for each item, as often as it likes, and a request is answered at
once, repeated ones too. Only a request that the link has doubled is not: an autopilot that asks
again for each item that comes twice and a link that doubles messages would multiply them without
end. Autopilots also ask by the old MISSION_REQUEST. The answer is MISSION_ITEM_INT all the same:
the older item rounds places to metres.
"""

from dataclasses import dataclass, replace
from enum import Enum

from rocsafe_mavlink.protocols.mission_item import MissionItem
from rocsafe_mavlink.protocols.mission_results import (
    ACCEPTED,
    CANCELLED,
    INVALID_SEQUENCE,
    PASSING,
    REFUSED,
    result_text,
)
from rocsafe_mavlink.protocols.timing import TRANSFER_TIMING, TransferTiming
from rocsafe_mavlink.wire.dialect import Message, addressed

REQUESTS = ('MISSION_REQUEST', 'MISSION_REQUEST_INT')


class UploadStage(Enum):
    """Progress of an upload."""

    OFFERED = 'offered'
    SENDING = 'sending'
    DONE = 'done'
    FAILED = 'failed'


@dataclass(frozen=True, slots=True, kw_only=True)
class Upload:
    """State of one upload.

    Attributes
    ----------
    items
        Items to send.
    target
        (system, component) of the autopilot.
    mission_type
        Mission, fence or rally points.
    stage
        Progress of the upload.
    heard_s
        Steady time of the last sign of progress.
    offers
        How often it was offered.
    highest
        Highest item that was asked for; -1 if none.
    last
        Item that was sent last; -1 if none.
    last_s
        Steady time at which it was sent.
    error
        Why the upload failed.
    is_passing
        Whether another try may succeed.
    is_stuck
        Whether offers are refused because of an earlier transfer.
    timing
        Deadlines and repetitions.
    """

    items: tuple[MissionItem, ...]
    target: tuple[int, int]
    mission_type: int = 0
    stage: UploadStage = UploadStage.OFFERED
    heard_s: float = 0.0
    offers: int = 0
    highest: int = -1
    last: int = -1
    last_s: float = 0.0
    error: str = ''
    is_passing: bool = False
    is_stuck: bool = False
    timing: TransferTiming = TRANSFER_TIMING

    def begin(self, now_s: float) -> tuple['Upload', list[Message]]:
        """Offer the mission."""
        begun = replace(self, heard_s=now_s, offers=self.offers + 1)
        return begun, [self._message('MISSION_COUNT', count=len(self.items))]

    def on_message(self, message: Message, now_s: float) -> tuple['Upload', list[Message]]:
        """Take a message of the autopilot."""
        if self._is_over:
            return self, []
        if message.fields.get('mission_type', 0) != self.mission_type:
            return self._on_other(message), []
        if message.name in REQUESTS:
            if self.stage is UploadStage.OFFERED and message['seq'] > 0:
                # It still waits for an earlier upload: nothing of this list belongs there.
                return self, [cancelled(message)]
            return self._on_request(int(message['seq']), now_s)
        if message.name == 'MISSION_ACK':
            return self._on_ack(int(message['type'])), []
        return self, []

    def on_tick(self, now_s: float) -> tuple['Upload', list[Message]]:
        """Let time pass."""
        silence_s = now_s - self.heard_s
        if self.stage is UploadStage.OFFERED and silence_s >= self.timing.offer_again_s:
            if self.offers >= self.timing.largest_offer_count:
                return self._failed('no answer to the offer of a mission', is_passing=False), []
            return self.begin(now_s)
        if self.stage is UploadStage.SENDING:
            if self._was_all_asked and silence_s >= self.timing.no_ack_s:
                # Only reading the mission back shows what lies on the vehicle now.
                return replace(self, stage=UploadStage.DONE), []
            if silence_s >= self.timing.no_request_s:
                text = (
                    f'no request for item {self.highest + 1} within {self.timing.no_request_s:g} s'
                )
                return self._failed(text, is_passing=True), []
        return self, []

    @property
    def _is_over(self) -> bool:
        return self.stage in (UploadStage.DONE, UploadStage.FAILED)

    @property
    def _was_all_asked(self) -> bool:
        return self.highest == len(self.items) - 1

    def _on_request(self, number: int, now_s: float) -> tuple['Upload', list[Message]]:
        is_doubled = number == self.last and now_s - self.last_s < self.timing.doubled_s
        if number >= len(self.items) or is_doubled:
            return self, []
        going = replace(
            self,
            stage=UploadStage.SENDING,
            heard_s=now_s,
            last=number,
            last_s=now_s,
            # A request for item 0 begins a new transfer: the offer was heard again.
            highest=0 if number == 0 else max(self.highest, number),
        )
        return going, [self.items[number].message(number, self.target, self.mission_type)]

    def _on_ack(self, result: int) -> 'Upload':
        if result == ACCEPTED:
            # Before the last item it belongs to an earlier transfer.
            return replace(self, stage=UploadStage.DONE) if self._was_all_asked else self
        if result == INVALID_SEQUENCE:
            # An item arrived twice; the autopilot goes on.
            return self
        where = f' at item {self.highest}' if self.stage is UploadStage.SENDING else ''
        failed = self._failed(f'{result_text(result)}{where}', is_passing=result in PASSING)
        is_stuck = result == REFUSED and self.stage is UploadStage.OFFERED
        return replace(failed, is_stuck=is_stuck)

    def _on_other(self, message: Message) -> 'Upload':
        """Take a message about a transfer of another type."""
        is_refusal = message.name == 'MISSION_ACK' and message['type'] in PASSING
        is_answer = (
            self.stage is UploadStage.OFFERED and self.offers >= self.timing.fewest_stuck_offers
        )
        if not is_refusal or not is_answer:
            return self
        failed = self._failed(result_text(int(message['type'])), is_passing=True)
        return replace(failed, is_stuck=True)

    def _failed(self, error: str, *, is_passing: bool) -> 'Upload':
        return replace(self, stage=UploadStage.FAILED, error=error, is_passing=is_passing)

    def _message(self, name: str, **fields: int) -> Message:
        return addressed(name, self.target, mission_type=self.mission_type, **fields)


def cancelled(request: Message) -> Message:
    """Return the answer to a request for an item of an upload that was given up.

    A PX4 ends its transfer then; an ArduPilot ignores it, and ends its own after 8 s.
    """
    sender = (request.system, request.component)
    kind = request.fields.get('mission_type', 0)
    return addressed('MISSION_ACK', sender, type=CANCELLED, mission_type=kind)
