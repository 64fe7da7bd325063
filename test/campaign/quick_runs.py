# SPDX-License-Identifier: Apache-2.0
"""Runs of a campaign that take as long, and end their process as often, as a test wants."""

import os
import signal
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from rocsafe_campaign.design.campaign import Run, read_campaign
from rocsafe_campaign.execution.journal import Journal
from rocsafe_campaign.execution.local_workers import rows_here
from rocsafe_campaign.execution.one_run import Task
from rocsafe_campaign.results.metrics import Metrics
from rocsafe_scenario.scenario import Scenario


@dataclass(frozen=True, kw_only=True)
class QuickRuns:
    """Takes the place of whole processes: a run leaves a file for each time that it was begun.

    Attributes
    ----------
    kills
        How many times a run of this number kills its process.
    """

    folder: Path
    duration_s: float
    kills: tuple[tuple[int, int], ...] = ()

    def begun(self, number: int) -> int:
        """Return how many times a run was begun."""
        return len(list(self.folder.glob(f'begun-{number}-*')))

    def metrics(self, _scenario: Scenario, run: Run, _limit_s: float) -> Metrics:
        """Sleep, or end the process."""
        before = self.begun(run.number)
        (self.folder / f'begun-{run.number}-{before}').touch()
        if before < dict(self.kills).get(run.number, 0):
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(self.duration_s)
        return Metrics(error_m=run.number / 3.0)


def main(file: str, folder: str, duration_s: str) -> None:
    """Carry out a campaign with three workers, as the command does."""
    campaign = read_campaign(Path(file))
    quick = QuickRuns(folder=Path(folder), duration_s=float(duration_s))
    task = Task(campaign=campaign, full=quick)  # type: ignore[arg-type]
    with Journal(Path(folder)) as journal:
        for row in rows_here(task, campaign.runs(), 3, Path(folder)):
            journal.add(row)


if __name__ == '__main__':
    main(*sys.argv[1:])
