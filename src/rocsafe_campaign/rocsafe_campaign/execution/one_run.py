# SPDX-License-Identifier: Apache-2.0
"""One run of a campaign, and its row: a failure is a row like any other."""

import errno
import resource
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from types import FrameType

from rocsafe_campaign.design.campaign import Campaign, Run
from rocsafe_campaign.errors import CampaignError, MachineError
from rocsafe_campaign.execution.full_run import FullRuns
from rocsafe_campaign.flight.pure_mission import run_purely
from rocsafe_campaign.results.metrics import Metrics, metrics_of_mission
from rocsafe_campaign.results.row import COMPLETE, FAILED, FAULT, Row
from rocsafe_planner.errors import PlannerError
from rocsafe_radiation.errors import RadiationError
from rocsafe_scenario.errors import ScenarioError
from rocsafe_sim.errors import SimError

# Outcomes of a failed run that are no fault of the software.
_REASONS = (CampaignError, PlannerError, RadiationError, ScenarioError, SimError, ValueError)

# A full or broken disk, too many files.
_OF_MACHINE = (errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EROFS, errno.EMFILE, errno.ENFILE)


class OverTimeError(CampaignError):
    """A run took longer than the campaign allows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """What a worker needs to carry out runs.

    Attributes
    ----------
    campaign
        The campaign that the runs belong to.
    full
        How whole processes are run; None: the missions are flown without them.
    """

    campaign: Campaign
    full: FullRuns | None = None


def carry_out(task: Task, run: Run) -> Row:
    """Carry out a run and return its row, whatever happens in it.

    Raises
    ------
    MachineError
        If the machine cannot carry out runs: the same command goes on when it can.
    """
    begun_s = _cpu_s()
    outcome, text, metrics = _carried_out(task, run)
    row = row_without_figures(task, run, outcome, text)
    return replace(row, metrics=metrics, cpu_s=round(_cpu_s() - begun_s, 3))


def row_without_figures(task: Task, run: Run, outcome: str, text: str) -> Row:
    """Return the row of a run of which nothing but the outcome is known."""
    return Row(
        number=run.number,
        key=task_key(task, run),
        seed=run.seed,
        repeat=run.repeat,
        inputs={key: run.inputs[key] for key in task.campaign.keys},
        outcome=outcome,
        text=text,
    )


def row_of_run(row: Row, task: Task, run: Run) -> Row:
    """Return a row, of whatever campaign, as the row of the same run in this one."""
    inputs = {key: run.inputs[key] for key in task.campaign.keys}
    return replace(row, number=run.number, seed=run.seed, repeat=run.repeat, inputs=inputs)


def task_key(task: Task, run: Run) -> str:
    """Return the key of a run's row: whole processes have rows of their own."""
    return task.campaign.key_of(run) + ('-full' if task.full else '')


def _carried_out(task: Task, run: Run) -> tuple[str, str, Metrics]:
    limit_s = task.campaign.block.limit_s
    try:
        scenario = task.campaign.scenario_of(run)
        if task.full is not None:
            return COMPLETE, '', task.full.metrics(scenario, run, limit_s)
        with _at_most(limit_s):
            return COMPLETE, '', metrics_of_mission(run_purely(scenario))
    except MachineError:
        raise
    except OSError as error:
        if error.errno in _OF_MACHINE:
            raise MachineError(f'run {run.number}: {error}') from error
        return FAULT, f'{type(error).__name__}: {error}', Metrics()
    except _REASONS as error:
        return FAILED, '; '.join(str(error).splitlines()), Metrics()
    # A fault of the software in one run must not end the others: it is seen in the table.
    except Exception as error:  # noqa: BLE001
        return FAULT, f'{type(error).__name__}: {error}', Metrics()


@contextmanager
def _at_most(limit_s: float) -> Iterator[None]:
    """Raise `OverTimeError` in what runs longer; only a main thread can be interrupted."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def over(_number: int, _frame: FrameType | None) -> None:
        raise OverTimeError(f'took longer than limit_s = {limit_s:g}')

    before = signal.signal(signal.SIGALRM, over)
    signal.setitimer(signal.ITIMER_REAL, limit_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _cpu_s() -> float:
    """Return the CPU time of this process and of its ended children."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + ended.ru_utime + ended.ru_stime
