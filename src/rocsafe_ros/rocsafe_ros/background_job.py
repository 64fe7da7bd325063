# SPDX-License-Identifier: Apache-2.0
"""One piece of long work beside a node's event loop, with its progress and a way to cancel it.

Pure Python: a node looks at the job from a timer, so that no callback waits for the work.
"""

import time
from collections.abc import Callable
from concurrent.futures import Future
from threading import Event, Thread
from typing import Generic, TypeVar

ResultT = TypeVar('ResultT')
ProgressT = TypeVar('ProgressT')


class BackgroundJob(Generic[ResultT, ProgressT]):
    """Runs one function in a daemon thread, which ends with the process.

    An executor of `concurrent.futures` would keep the process alive until its work is done; here
    only its `Future` is used.

    Parameters
    ----------
    work
        Function to run. It is given `report`, which stores a progress value and returns False
        once the job is cancelled; the work should then end, with or without a result.
    name
        Name of the thread.
    progress
        Progress value before the first report.
    """

    def __init__(
        self,
        work: Callable[[Callable[[ProgressT], bool]], ResultT],
        name: str,
        progress: ProgressT,
    ) -> None:
        self._work = work
        self._started_s = time.monotonic()
        self._progress = progress
        self._is_cancelled = Event()
        self._future: Future[ResultT] = Future()
        try:
            Thread(target=self._run, name=name, daemon=True).start()
        except RuntimeError as error:
            raise MemoryError(f'{name}: {error}') from error

    @property
    def progress(self) -> ProgressT:
        """Progress value of the newest report."""
        return self._progress

    @property
    def elapsed_s(self) -> float:
        """Wall time since the start, seconds."""
        return time.monotonic() - self._started_s

    @property
    def is_done(self) -> bool:
        """Whether the work has returned or raised."""
        return self._future.done()

    def cancel(self) -> None:
        """Ask the work to end: its next report returns False."""
        self._is_cancelled.set()

    def result(self) -> ResultT:
        """Return what the work returned, or raise what it raised; waits if it is not done."""
        return self._future.result()

    def _run(self) -> None:
        try:
            self._future.set_result(self._work(self._report))
        except BaseException as error:  # noqa: BLE001 - handed to whoever asks for the result
            self._future.set_exception(error)

    def _report(self, progress: ProgressT) -> bool:
        self._progress = progress
        return not self._is_cancelled.is_set()
