# SPDX-License-Identifier: Apache-2.0
"""Planning beside the node's event loop: one thread, a look at its progress, a way to stop it."""

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from rocsafe_planner.planning import Progress

ResultT = TypeVar('ResultT')


@dataclass(frozen=True, slots=True, kw_only=True)
class JobProgress:
    """Wall time since the start, and the best makespan and bound so far, NaN while unknown."""

    elapsed_s: float
    makespan_s: float
    lower_bound_s: float


class PlanningJob(Generic[ResultT]):
    """Runs `work` in a thread of its own from now on.

    `work` is given a progress function to hand to `plan_survey`. The thread ends with the process.
    """

    def __init__(self, work: Callable[[Progress], ResultT]) -> None:
        self._work = work
        self._started_s = time.monotonic()
        self._figures = (math.nan, math.nan)
        self._is_cancelled = threading.Event()
        self._results: list[ResultT] = []
        self._errors: list[BaseException] = []
        self._thread = threading.Thread(target=self._run, name='planning', daemon=True)
        self._thread.start()

    @property
    def progress(self) -> JobProgress:
        """How far the work has come."""
        makespan, bound = self._figures
        elapsed = time.monotonic() - self._started_s
        return JobProgress(elapsed_s=elapsed, makespan_s=makespan, lower_bound_s=bound)

    @property
    def is_done(self) -> bool:
        """Whether the result, or the error, is there."""
        return bool(self._results or self._errors)

    def cancel(self) -> None:
        """Ask the work to end with PlanningCancelledError; it does at its next report."""
        self._is_cancelled.set()

    def result(self) -> ResultT:
        """Return what the work returned, or raise what it raised; only when it is done."""
        if self._errors:
            raise self._errors[0]
        return self._results[0]

    def _run(self) -> None:
        try:
            self._results.append(self._work(self._report))
        except BaseException as error:  # noqa: BLE001 - handed to whoever asks for the result
            self._errors.append(error)

    def _report(self, makespan_s: float, lower_bound_s: float) -> bool:
        self._figures = (makespan_s, lower_bound_s)
        return not self._is_cancelled.is_set()
