# SPDX-License-Identifier: Apache-2.0
"""Workers of a Dask scheduler."""

import contextlib
import threading
import time
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import Any

from rocsafe_campaign.design.campaign import Run
from rocsafe_campaign.errors import CampaignError
from rocsafe_campaign.execution.distribution import distributed_rows
from rocsafe_campaign.execution.one_run import Task, carry_out, row_without_figures
from rocsafe_campaign.results.row import FAILED, Row

# Longest wait for an answer of the scheduler, for a worker, and for a row on its way, seconds.
ANSWER_S = 30.0
# Time between two looks at which workers there are, seconds.
_LOOK_S = 0.5
_CLOSE_S = 5.0
_GOES_ON = 'the same command goes on'


def rows_of_cluster(
    task: Task, runs: Sequence[Run], address: str, answer_s: float = ANSWER_S
) -> Generator[Row, None, None]:
    """Yield the rows of runs carried out by the workers of a Dask scheduler, as they end.

    Parameters
    ----------
    answer_s
        Longest wait for an answer of the scheduler, for a worker, and for a row on its way.

    Raises
    ------
    CampaignError
        If `distributed` is not installed, the scheduler does not answer, no worker is left, or a
        worker cannot carry out runs at all.
    """
    try:
        import distributed
    except ModuleNotFoundError as error:
        raise CampaignError('--scheduler: install distributed: pip install distributed') from error
    try:
        client: Any = distributed.Client(address, timeout=answer_s, set_as_default=False)
    except (OSError, ValueError) as error:
        raise CampaignError(f'--scheduler = {address}: does not answer: {error}') from error
    try:
        yield from distributed_rows(task, runs, ClusterWorkers(task, client, address, answer_s))
    finally:
        # A scheduler that is gone needs no farewell.
        with contextlib.suppress(OSError):
            client.close(timeout=_CLOSE_S)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Flown:
    """A run at a worker; after `until_s`, of the monotonic clock, it is over time."""

    worker: str
    run: Run
    until_s: float


class ClusterWorkers:
    """The workers that a scheduler knows at each moment, with a run each.

    A run is bound to its worker, so that it is known which run a lost worker was in.
    """

    def __init__(self, task: Task, client: Any, address: str, answer_s: float) -> None:
        self._task, self._client, self._address = task, client, address
        self._answer_s = answer_s
        self._flown: dict[Any, _Flown] = {}
        # Over time, but still at their workers: a thread cannot be stopped.
        self._late: dict[Any, _Flown] = {}
        self._has_ended = threading.Event()
        self._useful_s = time.monotonic()

    @property
    def is_busy(self) -> bool:
        """Whether the end of a run is still to come."""
        return bool(self._flown)

    def free(self) -> Sequence[str]:
        """Return the addresses of the workers without a run.

        Raises
        ------
        CampaignError
            If there has been no worker for too long.
        """
        known = self._known()
        busy = {one.worker for one in (*self._flown.values(), *self._late.values())}
        free = sorted(known - busy)
        now_s = time.monotonic()
        if free or self._flown:
            self._useful_s = now_s
        elif now_s - self._useful_s > self._answer_s:
            late = f', {len(self._late)} fly runs that are over time' if self._late else ''
            raise CampaignError(
                f'--scheduler = {self._address}: has no free worker for {self._answer_s:g} s'
                f'{late}; {_GOES_ON}'
            )
        return free

    def start(self, worker: str, run: Run) -> None:
        """Send a run to a worker."""
        future = self._client.submit(
            carry_out, self._task, run, pure=False, workers=[worker], allow_other_workers=False
        )
        future.add_done_callback(lambda _: self._has_ended.set())
        until_s = time.monotonic() + self._task.campaign.block.limit_s + self._answer_s
        self._flown[future] = _Flown(worker=worker, run=run, until_s=until_s)

    def ended(self) -> Sequence[tuple[Run, Row | None]]:
        """Wait `_LOOK_S` at most for the end of a run."""
        self._has_ended.wait(_LOOK_S)
        self._has_ended.clear()
        self._late = {future: one for future, one in self._late.items() if not future.done()}
        found: list[tuple[Run, Row | None]] = []
        for future in [future for future in self._flown if future.done()]:
            one = self._flown.pop(future)
            found.append((one.run, self._row(future, one)))
        known = self._known() if self._flown or self._late else set()
        self._late = {k: one for k, one in self._late.items() if one.worker in known}
        for future, one in list(self._flown.items()):
            if one.worker not in known:
                del self._flown[future]
                found.append((one.run, None))
            elif time.monotonic() > one.until_s:
                self._late[future] = self._flown.pop(future)
                found.append((one.run, self._over_time(one.run)))
        return found

    def _row(self, future: Any, one: _Flown) -> Row | None:
        """Return the row of a future that is done; None if it went with its worker."""
        import distributed

        try:
            row: Row = future.result(timeout=self._answer_s)
        except (TimeoutError, distributed.scheduler.KilledWorker):
            return None
        except distributed.CancelledError as error:
            raise self._gone(error) from error
        # Runs tell of their own errors in rows: this worker cannot carry out any.
        except Exception as error:
            reason = f'{type(error).__name__}: {error}'.splitlines()[0]
            raise CampaignError(
                f'--scheduler = {self._address}: worker {one.worker} cannot carry out runs '
                f'(have it and the scheduler this software?): {reason}'
            ) from error
        return row

    def _known(self) -> set[str]:
        """Return the addresses of the workers that the scheduler knows now."""
        try:
            return set(
                self._client.sync(
                    self._client.scheduler.ncores, workers=None, callback_timeout=self._answer_s
                )
            )
        except OSError as error:
            raise self._gone(error) from error

    def _gone(self, error: BaseException) -> CampaignError:
        reason = (str(error).splitlines() or [''])[0] or 'no answer'
        return CampaignError(
            f'--scheduler = {self._address}: does not answer any more: {reason}; {_GOES_ON}'
        )

    def _over_time(self, run: Run) -> Row:
        limit_s = self._task.campaign.block.limit_s
        text = f'took longer than limit_s = {limit_s:g}'
        return row_without_figures(self._task, run, FAILED, text)
