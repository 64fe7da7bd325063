# SPDX-License-Identifier: Apache-2.0
"""Workers that are processes of this machine."""

import ctypes
import multiprocessing
import os
import signal
from collections.abc import Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from types import FrameType, TracebackType

from rocsafe_campaign.design.campaign import Run
from rocsafe_campaign.execution.distribution import distributed_rows
from rocsafe_campaign.execution.journal import Journal, part_name
from rocsafe_campaign.execution.one_run import Task, carry_out
from rocsafe_campaign.results.row import Row

_PR_SET_PDEATHSIG = 1
# Time in which the system frees the files of a process that ended, seconds.
_FREED_S = 5.0


def rows_here(
    task: Task, runs: Sequence[Run], workers: int, folder: Path | None = None
) -> Generator[Row, None, None]:
    """Yield the rows of runs carried out by processes of this machine, as they end.

    Parameters
    ----------
    folder
        Where each process writes the row of a run before it is given the next one, so that a run
        that ended is never lost. Whoever reads the folder collects them: `Journal.collect`.
    """
    with LocalWorkers(task, min(workers, len(runs)), folder) as local:
        yield from distributed_rows(task, runs, local)


class LocalWorkers:
    """Processes with a run each; the first run fills the caches of compiled code alone.

    Each process is a pool of its own: one that is killed takes no other with it.
    """

    def __init__(self, task: Task, count: int, folder: Path | None) -> None:
        self._task, self._count, self._folder = task, count, folder
        self._pools: dict[int, ProcessPoolExecutor] = {}
        self._flown: dict[Future[Row], tuple[int, Run]] = {}
        self._is_warm = False

    def __enter__(self) -> 'LocalWorkers':
        return self

    def __exit__(
        self,
        _kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        for pool in self._pools.values():
            pool.shutdown()

    @property
    def is_busy(self) -> bool:
        """Whether the end of a run is still to come."""
        return bool(self._flown)

    def free(self) -> Sequence[int]:
        """Return the numbers of the processes without a run."""
        busy = {number for number, _ in self._flown.values()}
        count = self._count if self._is_warm else 1
        return [number for number in range(count) if number not in busy]

    def start(self, worker: int, run: Run) -> None:
        """Give a run to a process, which is started if there is none."""
        try:
            future = self._pool(worker).submit(_work, run)
        except BrokenProcessPool:
            # It was killed while it had nothing to do.
            self._drop(worker)
            future = self._pool(worker).submit(_work, run)
        self._flown[future] = worker, run

    def ended(self) -> Sequence[tuple[Run, Row | None]]:
        """Wait for the end of a run at least; each process limits the time of its run itself."""
        found: list[tuple[Run, Row | None]] = []
        for future in wait(self._flown, return_when=FIRST_COMPLETED).done:
            worker, run = self._flown.pop(future)
            self._is_warm = True
            if isinstance(future.exception(), BrokenProcessPool):
                self._drop(worker)
                found.append((run, None))
            else:
                found.append((run, future.result()))
        return found

    def _pool(self, worker: int) -> ProcessPoolExecutor:
        if worker not in self._pools:
            # Spawned, not forked: numerical libraries have threads.
            context = multiprocessing.get_context('spawn')
            state = (self._task, self._folder, worker, os.getpid())
            self._pools[worker] = ProcessPoolExecutor(1, context, _open, state)
        return self._pools[worker]

    def _drop(self, worker: int) -> None:
        self._pools.pop(worker).shutdown()


class _Process:
    """The state of a worker process."""

    task: Task
    part: Journal | None = None
    is_flying = False
    is_orphan = False


def _open(task: Task, folder: Path | None, worker: int, parent: int) -> None:
    # When the process that gives it runs ends, however, it ends after its run; Ctrl-C is not its.
    signal.signal(signal.SIGTERM, _end_after_run)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:
        os._exit(0)
    _Process.task = task
    if folder is not None:
        _Process.part = Journal(folder, part_name(worker), patience_s=_FREED_S)


def _end_after_run(_number: int, _frame: FrameType | None) -> None:
    _Process.is_orphan = True
    if not _Process.is_flying:
        os._exit(0)


def _work(run: Run) -> Row:
    _Process.is_flying = True
    row = carry_out(_Process.task, run)
    if _Process.part is not None:
        _Process.part.add(row)
    _Process.is_flying = False
    if _Process.is_orphan:
        os._exit(0)
    return row
