# SPDX-License-Identifier: Apache-2.0
"""Writer of the evidence log beside a recorder: a thread, so that no disk slows the recording."""

from collections.abc import Callable, Iterable
from pathlib import Path
from threading import Event as Flag
from threading import Lock, Thread

from rocsafe_geo.evidence.evidence_log import Event, EvidenceError, EvidenceLog, read_log

PERIOD_S = 0.2
MOST_WAITING = 100_000


class EvidenceWriter:
    """Adds events to a log, soon; what cannot be written waits.

    Parameters
    ----------
    say
        Told once of each fault.
    """

    def __init__(self, path: Path, say: Callable[[str], object]) -> None:
        self._path = path
        self._say = say
        self._told = ''
        self._log: EvidenceLog | None = None
        self._waiting: list[Event] = []
        self._lock, self._end = Lock(), Flag()
        self._thread = Thread(target=self._work, name='evidence', daemon=True)
        self._thread.start()

    def add(self, events: Iterable[Event]) -> None:
        """Take events over; those that are too many are left out, and that is told."""
        with self._lock:
            self._waiting.extend(events)
            is_full = len(self._waiting) > MOST_WAITING
            del self._waiting[MOST_WAITING:]
        if is_full:
            self._tell(f'more than {MOST_WAITING} events wait: the newest are left out')

    def close(self) -> None:
        """Write what waits, and close the log."""
        self._end.set()
        self._thread.join()
        if self._log is not None:
            self._log.close()

    def _work(self) -> None:
        is_last = False
        while not is_last:
            is_last = self._end.wait(PERIOD_S)
            self._write()

    def _write(self) -> None:
        with self._lock:
            events = tuple(self._waiting)
        if not events:
            return
        try:
            self._log = self._log or EvidenceLog(self._path)
            self._log.add(events)
        except OSError as error:
            self._tell(f'the evidence log cannot be written: {error}')
            return
        if self._log.damage:
            self._tell(f'the evidence log was damaged: {self._log.damage}')
        with self._lock:
            del self._waiting[: len(events)]

    def _tell(self, text: str) -> None:
        if text != self._told:
            self._told = text
            self._say(text)


def hashes_told(path: Path) -> set[tuple[str, str]]:
    """Return topics and hashes of the messages in a log; none if it cannot be read."""
    try:
        entries = read_log(path)
    except (OSError, EvidenceError):
        return set()
    return {(e['topic'], e['recorded_sha256']) for e in entries if 'recorded_sha256' in e}
