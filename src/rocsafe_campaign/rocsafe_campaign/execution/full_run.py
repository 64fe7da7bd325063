# SPDX-License-Identifier: Apache-2.0
"""A run of whole processes: `rocsafe run` in a ROS domain of its own."""

import errno
import os
import signal
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

from rocsafe_campaign.design.campaign import Run
from rocsafe_campaign.errors import CampaignError, MachineError
from rocsafe_campaign.results.metrics import Metrics, metrics_of_summary
from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.process_table.executables import find_executable
from rocsafe_orchestrator.processes.domain_lock import domain_lock
from rocsafe_scenario.scenario import Scenario

# Time in which an interrupted mission can end in order before it is killed, seconds.
PATIENCE_S = 60.0
LARGEST_DOMAIN = 101
LOOK_S = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class FullRuns:
    """How runs of whole processes are carried out.

    Attributes
    ----------
    folder
        Where the directories of the runs are made.
    domains
        ROS domains, of which a run takes one that is free.
    """

    folder: Path
    domains: tuple[int, ...]

    def __post_init__(self) -> None:
        if not self.domains or not all(0 <= one <= LARGEST_DOMAIN for one in self.domains):
            raise CampaignError(
                f'ROS domains {list(self.domains)}: must be 0 to {LARGEST_DOMAIN}: '
                'set ROS_DOMAIN_ID lower, or use fewer workers'
            )

    def metrics(self, scenario: Scenario, run: Run, limit_s: float) -> Metrics:
        """Fly a scenario by `rocsafe run` and return the figures of its summary.

        Raises
        ------
        CampaignError
            If the mission fails, with its last words, takes longer than `limit_s`, or would fly a
            real vehicle.
        MachineError
            If the disk is full, or other missions are in all domains for as long.
        """
        for name in scenario.real_names:
            raise CampaignError(f'{name}: has a link: campaigns fly simulated vehicles only')
        folder = self.folder / f'{run.number:06d}'
        folder.mkdir(parents=True, exist_ok=True)
        file = folder / 'scenario.yaml'
        file.write_text(scenario.to_yaml(), encoding='utf-8')
        rocsafe = str(find_executable('rocsafe_orchestrator', 'rocsafe'))
        command = [rocsafe, 'run', str(file), '--quiet', '--out', str(folder)]
        code, words = _ended(command, self._free_domain(limit_s), limit_s)
        if code and os.strerror(errno.ENOSPC) in words:
            raise MachineError(f'run {run.number}: {words}')
        if code:
            raise CampaignError(f'rocsafe run: exit code {code}: {words or "no reason given"}')
        summaries = sorted(folder.glob('*/summary.json'), key=lambda path: path.stat().st_mtime)
        if not summaries:
            raise CampaignError(f'{folder}: the run left no summary.json')
        return metrics_of_summary(scenario, summaries[-1])

    def _free_domain(self, limit_s: float) -> int:
        """Return a domain in which no mission of this user runs now.

        Each worker begins its search at another one; `rocsafe run` locks the domain itself. A
        mission of a campaign that was killed flies on to its end, for which this waits.
        """
        first = os.getpid() % len(self.domains)
        until_s = time.monotonic() + limit_s
        while True:
            for domain in (*self.domains[first:], *self.domains[:first]):
                try:
                    with domain_lock(str(domain), 'rocsafe campaign'):
                        return domain
                except SetupError:
                    continue
            if time.monotonic() > until_s:
                domains = f'ROS domains {list(self.domains)}'
                raise MachineError(f'{domains}: a mission runs in each for {limit_s:g} s')
            time.sleep(LOOK_S)


def _ended(command: list[str], domain: int, limit_s: float) -> tuple[int, str]:
    """Return exit code and last line of a command; it is stopped when it takes too long."""
    process = subprocess.Popen(
        command,
        env={**os.environ, 'ROS_DOMAIN_ID': str(domain)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        words = process.communicate(timeout=limit_s)[1]
    except subprocess.TimeoutExpired:
        process.terminate()
        try:
            process.communicate(timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
        raise CampaignError(f'took longer than limit_s = {limit_s:g}') from None
    return process.returncode, (words.strip().splitlines() or [''])[-1]
