# SPDX-License-Identifier: Apache-2.0
"""Verified upload: a mission is read back after its upload and compared.

An acknowledgement is no proof, and an upload that failed has overwritten the mission before it. So
after an upload the mission is read back and compared. If it differs it is sent again, and if that
does not help it is cleared, so that no partial mission can be flown.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

from rocsafe_mavlink.protocols.mission_download import Download, DownloadStage
from rocsafe_mavlink.protocols.mission_item import MissionItem, difference
from rocsafe_mavlink.protocols.mission_results import ACCEPTED, MissionType, result_text
from rocsafe_mavlink.protocols.mission_upload import REQUESTS, Upload, UploadStage, cancelled
from rocsafe_mavlink.wire.dialect import Message, addressed


class TransferStage(Enum):
    """Progress of a transfer."""

    UPLOADING = 'uploading'
    READING_BACK = 'reading back'
    RELEASING = 'releasing'
    CLEARING = 'clearing'
    VERIFIED = 'verified'
    FAILED = 'failed'


@dataclass(frozen=True, slots=True, kw_only=True)
class Transfer:
    """State of one verified transfer.

    Attributes
    ----------
    upload, download
        The parts under way.
    first_compared
        Items before it belong to the autopilot (1 where item 0 is home).
    stage
        Progress of the transfer.
    tries
        Uploads begun.
    until_s
        Steady time at which it is given up, whatever the autopilot asks for.
    error
        Why it failed, or why the try before this one did.
    asked_s, clears
        Steady time of the last request to clear, and number of requests.
    is_cleared
        Whether the autopilot confirmed, after a failure, that its mission is empty.
    clears_after_failure
        Whether a partial mission is cleared; not while it may be flown.
    reads_only
        Whether nothing is sent: what lies on the autopilot is read once and compared.
    """

    upload: Upload
    download: Download
    first_compared: int
    stage: TransferStage = TransferStage.UPLOADING
    tries: int = 0
    until_s: float = math.inf
    error: str = ''
    asked_s: float = 0.0
    clears: int = 0
    is_cleared: bool = False
    clears_after_failure: bool = True
    reads_only: bool = False

    @property
    def is_over(self) -> bool:
        """Whether it is verified or has failed."""
        return self.stage in (TransferStage.VERIFIED, TransferStage.FAILED)

    @property
    def mission_type(self) -> MissionType:
        """Mission, fence or rally points."""
        return MissionType(self.upload.mission_type)

    def begin(self, now_s: float) -> tuple['Transfer', list[Message]]:
        """Start the upload, or the reading where nothing is sent."""
        timing = self.upload.timing
        longest_s = timing.longest_s + timing.longest_item_s * len(self.upload.items)
        bounded = replace(self, until_s=min(self.until_s, now_s + longest_s))
        return bounded._read(now_s) if self.reads_only else bounded._send(now_s)

    def _send(self, now_s: float) -> tuple['Transfer', list[Message]]:
        fresh = replace(
            self.upload,
            stage=UploadStage.OFFERED,
            offers=0,
            is_stuck=False,
            highest=-1,
            last=-1,
            error='',
            heard_s=now_s,
        )
        upload, sent = fresh.begin(now_s)
        stage, tries = TransferStage.UPLOADING, self.tries + 1
        return replace(self, stage=stage, upload=upload, tries=tries), sent

    def _read(self, now_s: float) -> tuple['Transfer', list[Message]]:
        fresh = replace(self.download, stage=DownloadStage.LISTING, items=(), asks=0, error='')
        download, asked = fresh.begin(now_s)
        return replace(self, stage=TransferStage.READING_BACK, download=download), asked

    def on_message(self, message: Message, now_s: float) -> tuple['Transfer', list[Message]]:
        """Take a message of the autopilot; those of others change nothing."""
        is_its = (message.system, message.component) == self.upload.target
        if not is_its or not message.name.startswith('MISSION_'):
            return self, []
        if self.stage is TransferStage.UPLOADING:
            upload, sent = self.upload.on_message(message, now_s)
            return replace(self, upload=upload)._after_upload(now_s, sent)
        if self.stage is TransferStage.READING_BACK:
            download, sent = self.download.on_message(message, now_s)
            return replace(self, download=download)._after_download(now_s, sent)
        if self.stage is TransferStage.RELEASING and message.name in REQUESTS:
            return self, [cancelled(message)]
        if self.stage is TransferStage.CLEARING and message.name == 'MISSION_ACK':
            return self._on_cleared(int(message['type']))
        return self, []

    def on_tick(self, now_s: float) -> tuple['Transfer', list[Message]]:
        """Let time pass."""
        is_ending = self.stage is TransferStage.CLEARING or self.is_over
        if not is_ending and now_s >= self.until_s:
            error = self.error or 'it took too long'
            return self._try_again(now_s, error, is_passing=False)
        if self.stage is TransferStage.UPLOADING:
            upload, sent = self.upload.on_tick(now_s)
            return replace(self, upload=upload)._after_upload(now_s, sent)
        if self.stage is TransferStage.READING_BACK:
            download, sent = self.download.on_tick(now_s)
            return replace(self, download=download)._after_download(now_s, sent)
        if self.stage is TransferStage.RELEASING:
            is_released = now_s - self.asked_s >= self.upload.timing.release_s
            return self.begin(now_s) if is_released else (self, [])
        if self.stage is TransferStage.CLEARING and now_s - self.asked_s >= self._clear_again_s:
            return self._clear(now_s)
        return self, []

    @property
    def _clear_again_s(self) -> float:
        return self.upload.timing.clear_again_s

    def _after_upload(self, now_s: float, sent: list[Message]) -> tuple['Transfer', list[Message]]:
        if self.upload.stage is UploadStage.FAILED:
            return self._try_again(now_s, self.upload.error, is_passing=self.upload.is_passing)
        if self.upload.stage is UploadStage.DONE:
            reading, asked = self._read(now_s)
            return reading, sent + asked
        return self, sent

    def _after_download(
        self, now_s: float, sent: list[Message]
    ) -> tuple['Transfer', list[Message]]:
        if self.download.stage is DownloadStage.FAILED:
            return self._try_again(now_s, self.download.error, is_passing=True)
        if self.download.stage is not DownloadStage.DONE:
            return self, sent
        error = compare(self.upload.items, self.download.items, self.first_compared)
        if not error:
            return replace(self, stage=TransferStage.VERIFIED, error=''), sent
        again, more = self._try_again(now_s, error, is_passing=True)
        return again, sent + more

    def _try_again(
        self, now_s: float, error: str, *, is_passing: bool
    ) -> tuple['Transfer', list[Message]]:
        noted = replace(self, error=error)
        if self.reads_only:
            return replace(noted, stage=TransferStage.FAILED), []
        if is_passing and self.tries < self.upload.timing.largest_try_count:
            return noted._release(now_s) if self.upload.is_stuck else noted.begin(now_s)
        if not self.clears_after_failure:
            return replace(noted, stage=TransferStage.FAILED), []
        return replace(noted, stage=TransferStage.CLEARING)._clear(now_s)

    def _release(self, now_s: float) -> tuple['Transfer', list[Message]]:
        """Begin a reading that is left to time out, which ends all transfers of a PX4."""
        upload = self.upload
        ask = addressed('MISSION_REQUEST_LIST', upload.target, mission_type=upload.mission_type)
        return replace(self, stage=TransferStage.RELEASING, asked_s=now_s), [ask]

    def _clear(self, now_s: float) -> tuple['Transfer', list[Message]]:
        if self.clears >= self.upload.timing.largest_clear_count:
            return replace(self, stage=TransferStage.FAILED), []
        asked, upload = replace(self, asked_s=now_s, clears=self.clears + 1), self.upload
        clear = addressed('MISSION_CLEAR_ALL', upload.target, mission_type=upload.mission_type)
        return asked, [clear]

    def _on_cleared(self, result: int) -> tuple['Transfer', list[Message]]:
        if result == ACCEPTED:
            return replace(self, stage=TransferStage.FAILED, is_cleared=True), []
        error = f'{self.error}; clearing it: {result_text(result)}'
        return replace(self, stage=TransferStage.FAILED, error=error), []


def transfer(
    items: Sequence[MissionItem],
    target: tuple[int, int],
    *,
    first_compared: int,
    mission_type: int = 0,
    clears_after_failure: bool = True,
    reads_only: bool = False,
) -> Transfer:
    """Return a transfer that has not begun.

    Parameters
    ----------
    items
        As they shall lie on the autopilot, its own item 0 included where it has one.
    target
        (system, component) of the autopilot.
    first_compared
        1 where item 0 is the autopilot's home, else 0.
    clears_after_failure, reads_only
        As in `Transfer`.
    """
    return Transfer(
        upload=Upload(items=tuple(items), target=target, mission_type=mission_type),
        download=Download(target=target, mission_type=mission_type),
        first_compared=first_compared,
        clears_after_failure=clears_after_failure,
        reads_only=reads_only,
    )


def compare(sent: Sequence[MissionItem], back: Sequence[MissionItem], first_compared: int) -> str:
    """Return how a mission that was read back differs from what was sent; empty if it does not."""
    if len(sent) != len(back):
        return f'the mission read back has {len(back)} items, sent were {len(sent)}'
    for number in range(first_compared, len(sent)):
        found = difference(sent[number], back[number])
        if found:
            return f'item {number} read back: {found}'
    return ''
