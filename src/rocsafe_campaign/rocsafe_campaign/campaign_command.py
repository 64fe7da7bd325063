# SPDX-License-Identifier: Apache-2.0
"""`rocsafe campaign`: many missions of a scenario, a table and a page."""

import argparse
import os
import sys
from collections.abc import Generator, Sequence
from contextlib import closing
from pathlib import Path

from rich.console import Console

from rocsafe_campaign.design.campaign import Campaign, Run, read_campaign
from rocsafe_campaign.errors import CampaignError
from rocsafe_campaign.execution.cluster_workers import rows_of_cluster
from rocsafe_campaign.execution.full_run import PATIENCE_S, FullRuns
from rocsafe_campaign.execution.journal import Journal
from rocsafe_campaign.execution.local_workers import rows_here
from rocsafe_campaign.execution.one_run import Task, row_of_run, task_key
from rocsafe_campaign.flight.pure_mission import impure_keys
from rocsafe_campaign.results.metrics import METRICS
from rocsafe_campaign.results.page import moving, result_of, write_page
from rocsafe_campaign.results.row import COMPLETE, Row
from rocsafe_campaign.results.table import write_table
from rocsafe_geo.evidence.code_version import git_revision
from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_scenario.errors import ScenarioError

EXIT_COMPLETE, EXIT_FAILED, EXIT_USAGE = 0, 1, 2
MOST_WORKERS = 256
_DOMAIN = 'ROS_DOMAIN_ID'


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return 0 if all runs are complete, 1 if some failed, 2 for mistakes."""
    try:
        return _obey(_arguments(argv))
    except (CampaignError, ScenarioError, OrchestratorError) as error:
        for line in str(error).splitlines():
            sys.stderr.write(f'campaign: {line}\n')
        return EXIT_USAGE
    except KeyboardInterrupt:
        sys.stderr.write('campaign: stopped; the same command goes on\n')
        return 130


def _arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog='rocsafe campaign',
        description='Fly many missions of a scenario with keys that vary or are drawn, and write '
        'their table, a page, and which key moves the result. The same command goes on where it '
        'was stopped.',
    )
    parser.add_argument(
        'file', type=Path, metavar='FILE.yaml', help='file of the campaign: docs/campaigns.md'
    )
    parser.add_argument(
        '--out', type=Path, metavar='DIR', help='folder of the results (default: campaigns/NAME)'
    )
    parser.add_argument(
        '--workers', type=int, default=os.cpu_count() or 1, metavar='N',
        help='processes at a time (default: one a core)',
    )  # fmt: skip
    parser.add_argument(
        '--full', action='store_true',
        help='whole processes by `rocsafe run`, each mission in a ROS domain of its own, from '
        'ROS_DOMAIN_ID on',
    )  # fmt: skip
    parser.add_argument(
        '--scheduler', metavar='ADDRESS',
        help='carry the runs out on the workers of this Dask scheduler, e.g. tcp://host:8786',
    )  # fmt: skip
    return parser.parse_args(argv)


def _obey(arguments: argparse.Namespace) -> int:
    if not 1 <= arguments.workers <= MOST_WORKERS:
        raise CampaignError(f'--workers = {arguments.workers}: must be 1 to {MOST_WORKERS}')
    if arguments.full and arguments.scheduler:
        raise CampaignError('--full: runs on this machine only, without --scheduler')
    campaign = read_campaign(arguments.file)
    if campaign.block.result not in METRICS:
        known = ', '.join(METRICS)
        raise CampaignError(f'result = {campaign.block.result!r}: must be one of: {known}')
    runs = campaign.runs()
    if not arguments.full and (reasons := list(impure_keys(campaign.scenario_of(runs[0])))):
        raise CampaignError('\n'.join(reasons))
    folder = arguments.out or Path('campaigns') / campaign.block.name
    task = Task(campaign=campaign, full=_full(arguments, folder) if arguments.full else None)
    console = Console()
    with Journal(folder) as journal:
        # A command that was killed leaves workers that end their runs.
        journal.collect(campaign.block.limit_s + PATIENCE_S)
        left = [run for run in runs if task_key(task, run) not in journal.rows]
        console.print(f'{len(runs)} runs, {len(runs) - len(left)} of them done before')
        with closing(_rows(task, left, arguments, folder)) as rows:
            for count, row in enumerate(rows, start=1):
                journal.add(row)
                _tell(console, row, count, len(left))
        journal.collect(PATIENCE_S)
        done = [row_of_run(journal.rows[task_key(task, run)], task, run) for run in runs]
    return _finish(console, folder, campaign, done)


def _full(arguments: argparse.Namespace, folder: Path) -> FullRuns:
    text = os.environ.get(_DOMAIN) or '0'
    if not text.isdecimal():
        raise CampaignError(f'{_DOMAIN} = {text!r}: must be a whole number')
    first = int(text)
    return FullRuns(
        folder=folder.resolve() / 'runs', domains=tuple(range(first, first + arguments.workers))
    )


def _rows(
    task: Task, runs: Sequence[Run], arguments: argparse.Namespace, folder: Path
) -> Generator[Row, None, None]:
    if arguments.scheduler:
        return rows_of_cluster(task, runs, arguments.scheduler)
    return rows_here(task, runs, arguments.workers, folder)


def _tell(console: Console, row: Row, count: int, total: int) -> None:
    """Print a failure at once, and every tenth part of the progress."""
    if row.outcome != COMPLETE:
        text = f'run {row.number}, seed {row.seed}: {row.outcome}: {row.text}'
        console.print(text, highlight=False, markup=False)
    if count * 10 // total > (count - 1) * 10 // total:
        console.print(f'{count} of {total}', highlight=False)


def _finish(console: Console, folder: Path, campaign: Campaign, rows: Sequence[Row]) -> int:
    revision = git_revision(Path(__file__).resolve().parent) or ''
    written = [
        *write_table(folder, rows, campaign.keys),
        write_page(folder, campaign, rows, revision),
    ]
    complete = [row for row in rows if row.outcome == COMPLETE]
    found = result_of(complete, campaign.block.result)
    console.print(
        f'{len(complete)} complete; {campaign.block.result} {found.mean:.4g} '
        f'(95 %: {found.low:.4g} to {found.high:.4g}, {found.count} runs)',
        highlight=False,
    )
    for one in moving(campaign, complete)[:5]:
        text = f'  {one.key}: share {one.share:.2f}, rank correlation {one.correlation:+.2f}'
        console.print(text, highlight=False, markup=False)
    for path in written:
        console.print(f'written: {path}', highlight=False, soft_wrap=True)
    return EXIT_COMPLETE if len(complete) == len(rows) else EXIT_FAILED


if __name__ == '__main__':
    raise SystemExit(main())
