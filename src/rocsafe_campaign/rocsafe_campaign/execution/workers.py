# SPDX-License-Identifier: Apache-2.0
"""Distribution of the runs of a campaign to processes of this machine, or of a cluster."""

import ctypes
import multiprocessing
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from itertools import islice
from typing import Any

from rocsafe_campaign.design.campaign import Run
from rocsafe_campaign.errors import CampaignError
from rocsafe_campaign.execution.one_run import Task, carry_out, task_key
from rocsafe_campaign.results.row import FAULT, Row

# Runs that wait at each worker, so that none is idle between two.
_AHEAD = 2
CONNECT_S = 30.0
_PR_SET_PDEATHSIG = 1


def rows_here(task: Task, runs: Sequence[Run], workers: int) -> Iterator[Row]:
    """Yield the rows of runs carried out by processes of this machine, as they end.

    The first run fills the caches of compiled code alone. A run in which a process is killed, for
    instance for its memory, gets a row that says so.
    """
    left = {run.number: run for run in runs}
    while left:
        suspects: list[Run] = []
        for row in _until_broken(task, list(left.values()), workers, suspects):
            del left[row.number]
            yield row
        for run in suspects:
            del left[run.number]
            yield _alone(task, run)


def _until_broken(
    task: Task, runs: Sequence[Run], workers: int, suspects: list[Run]
) -> Iterator[Row]:
    """Yield rows until all are done or a process ends; those then begun are the suspects."""
    with _pool(task, min(workers, len(runs))) as pool:
        waiting: dict[Future[Row], Run] = {}
        rest, room = iter(runs), 1
        while True:
            try:
                waiting.update({pool.submit(_work, run): run for run in islice(rest, room)})
            except BrokenProcessPool:
                suspects.extend(waiting.values())
                return
            if not waiting:
                return
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                if isinstance(future.exception(), BrokenProcessPool):
                    suspects.extend(waiting.values())
                    return
                del waiting[future]
                yield future.result()
            room = workers * _AHEAD - len(waiting)


def _alone(task: Task, run: Run) -> Row:
    """Return the row of a run in a process of its own, which may end with it."""
    with _pool(task, 1) as pool:
        try:
            return pool.submit(_work, run).result()
        except BrokenProcessPool:
            return _ended_unexpectedly(task, run)


def _ended_unexpectedly(task: Task, run: Run) -> Row:
    """Return the row of a run in which each process that tried it ended."""
    return Row(
        number=run.number,
        key=task_key(task, run),
        seed=run.seed,
        repeat=run.repeat,
        inputs=run.inputs,
        outcome=FAULT,
        text='its process ended unexpectedly (memory?)',
    )


def _pool(task: Task, workers: int) -> ProcessPoolExecutor:
    # Spawned, not forked: numerical libraries have threads.
    context = multiprocessing.get_context('spawn')
    return ProcessPoolExecutor(max(1, workers), context, _open, (task,))


class _Worker:
    """What a worker process carries out runs of."""

    task: Task


def _open(task: Task) -> None:
    # It ends with the process that gives it runs, however that ends, and leaves Ctrl-C to it.
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _Worker.task = task


def _work(run: Run) -> Row:
    return carry_out(_Worker.task, run)


def _with_task(run: Run, task: Task) -> Row:
    return carry_out(task, run)


def rows_of_cluster(task: Task, runs: Sequence[Run], address: str) -> Iterator[Row]:
    """Yield the rows of runs carried out by the workers of a Dask scheduler, as they end.

    Raises
    ------
    CampaignError
        If `distributed` is not installed or the scheduler does not answer.
    """
    try:
        import distributed
    except ModuleNotFoundError as error:
        raise CampaignError('--scheduler: install distributed: pip install distributed') from error
    try:
        client: Any = distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise CampaignError(f'--scheduler = {address}: does not answer: {error}') from error
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECT_S)
        except TimeoutError as error:
            raise CampaignError(f'--scheduler = {address}: has no workers') from error
        shared = client.scatter(task, broadcast=True)
        futures = client.map(_with_task, runs, task=shared, pure=False)
        by_key = {future.key: run for future, run in zip(futures, runs, strict=True)}
        limit_s = CONNECT_S + len(runs) * task.campaign.block.limit_s
        for future in distributed.as_completed(futures, loop=client.loop, timeout=limit_s):
            is_done = future.status == 'finished'
            yield future.result() if is_done else _ended_unexpectedly(task, by_key[future.key])
