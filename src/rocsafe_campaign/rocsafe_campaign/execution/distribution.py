# SPDX-License-Identifier: Apache-2.0
"""Distribution of the runs of a campaign to workers, whatever these are."""

from collections import deque
from collections.abc import Iterator, Sequence
from typing import Protocol, TypeVar

from rocsafe_campaign.design.campaign import Run
from rocsafe_campaign.execution.one_run import Task, row_without_figures
from rocsafe_campaign.results.row import FAULT, Row

Name = TypeVar('Name')
_ENDED = 'its process ended unexpectedly (memory?)'


class Workers(Protocol[Name]):
    """Workers that carry out one run at a time each."""

    @property
    def is_busy(self) -> bool:
        """Whether the end of a run is still to come."""

    def free(self) -> Sequence[Name]:
        """Return the workers that can be given a run now."""

    def start(self, worker: Name, run: Run) -> None:
        """Give a run to a worker that is free."""

    def ended(self) -> Sequence[tuple[Run, Row | None]]:
        """Wait a while and return the runs that ended; without a row if their worker was lost."""


def distributed_rows(task: Task, runs: Sequence[Run], workers: Workers[Name]) -> Iterator[Row]:
    """Yield the rows of runs as they end.

    A worker that is lost costs the run that it was in, and no other. That run is tried once more
    when all others are done, beside none: if a worker is lost by it again, its row says so.
    """
    lost: list[Run] = []
    yield from _spread(runs, workers, lost)
    for run in lost:
        again: list[Run] = []
        yield from _spread([run], workers, again)
        if again:
            yield row_without_figures(task, run, FAULT, _ENDED)


def _spread(runs: Sequence[Run], workers: Workers[Name], lost: list[Run]) -> Iterator[Row]:
    rest = deque(runs)
    while rest or workers.is_busy:
        if rest:
            for worker in workers.free()[: len(rest)]:
                workers.start(worker, rest.popleft())
        for run, row in workers.ended():
            if row is None:
                lost.append(run)
            else:
                yield row
