# SPDX-License-Identifier: Apache-2.0
"""Copies the photographs of a store elsewhere, each once, whatever happens on the way."""

import dataclasses
import hashlib
from collections.abc import Callable
from pathlib import Path
from threading import Event, Thread

from rocsafe_geo.storage.durable import AppendOnlyFile
from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.repository.sink import Sink
from rocsafe_mapping.store.catalogue import Notice, StoredShot, read_store
from rocsafe_mapping.store.store import Status

LEDGER = 'copied.txt'
FIRST_WAIT_S, LONGEST_WAIT_S = 0.5, 10.0


class Copier:
    """A thread that copies what a store has and the other place has not.

    Parameters
    ----------
    folder
        Of the store.
    open_sink
        Opens the other place; called in the thread, again after a failure.
    notice
        Is told, in one line each, of failures and refusals.
    """

    def __init__(self, folder: Path, open_sink: Callable[[], Sink], notice: Notice) -> None:
        self._folder = folder
        self._open_sink = open_sink
        self._notice = notice
        self._ledger = AppendOnlyFile(folder / LEDGER)
        self._copied = {line.decode() for line in self._ledger.lines()}
        self._wake, self._stop = Event(), Event()
        self._thread = Thread(target=self._run, name='copier', daemon=True)
        self._thread.start()

    def wake(self) -> None:
        """Say that there is a new photograph."""
        self._wake.set()

    def close(self, timeout_s: float = 5.0) -> None:
        """End the thread; what is not copied is copied by the next one."""
        self._stop.set()
        self._wake.set()
        self._thread.join(timeout_s)
        if not self._thread.is_alive():
            self._ledger.close()

    def _run(self) -> None:
        wait_s = FIRST_WAIT_S
        while not self._stop.is_set():
            self._wake.clear()
            try:
                self._copy_all()
                wait_s = FIRST_WAIT_S
                self._wake.wait()
            except StoreError as error:
                self._notice(f'copies wait {wait_s:g} s: {error}')
                self._stop.wait(wait_s)
                wait_s = min(2.0 * wait_s, LONGEST_WAIT_S)

    def _copy_all(self) -> None:
        todo = [
            shot
            for shot in read_store(self._folder, self._notice)
            if shot.record.shot_id not in self._copied
        ]
        if not todo:
            return
        sink = self._open_sink()
        try:
            for shot in todo:
                if self._stop.is_set():
                    return
                self._copy(sink, shot)
        finally:
            sink.close()

    def _copy(self, sink: Sink, shot: StoredShot) -> None:
        image = shot.read_image()
        record = dataclasses.replace(shot.record, sha256=hashlib.sha256(image).hexdigest())
        answer = sink.put(record, image)
        if answer.status is Status.REJECTED:
            self._notice(f'copy of {record.shot_id} was refused: {answer.reason}')
        self._ledger.append(record.shot_id.encode())
        self._copied.add(record.shot_id)
