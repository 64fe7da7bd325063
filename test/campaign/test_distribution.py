# SPDX-License-Identifier: Apache-2.0
"""Runs of campaigns at workers that die, stand still or never come."""

import importlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from threading import Thread
from typing import Any

import pytest
import yaml

from rocsafe_campaign.campaign_command import main
from rocsafe_campaign.design.campaign import read_campaign
from rocsafe_campaign.errors import CampaignError
from rocsafe_campaign.execution.cluster_workers import rows_of_cluster
from rocsafe_campaign.execution.journal import Journal
from rocsafe_campaign.execution.local_workers import rows_here
from rocsafe_campaign.execution.one_run import Task, carry_out
from rocsafe_campaign.results.row import COMPLETE, FAILED, FAULT, Row

HERE = Path(__file__).parent
ANSWER_S = 3.0


def until(found: Any, limit_s: float = 60.0) -> None:
    """Wait for what must come true."""
    end_s = time.monotonic() + limit_s
    while not found():
        assert time.monotonic() < end_s
        time.sleep(0.02)


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return the module of quick runs, such that worker processes import it, too."""
    monkeypatch.syspath_prepend(str(HERE))
    return importlib.import_module('quick_runs')


def campaign_file(folder: Path, seeds: int | list[int], **changes: object) -> Path:
    """Write a campaign of so many runs."""
    path = folder / 'campaign.yaml'
    content = {'name': 'x', 'scenario': str(HERE / 'search_once.yaml'), 'seeds': seeds}
    path.write_text(yaml.safe_dump({**content, **changes}))
    return path


def task_of(quick: Any, folder: Path, seeds: int = 6, limit_s: float = 60.0, **how: Any) -> Task:
    """Return a campaign of quick runs."""
    campaign = read_campaign(campaign_file(folder, seeds, limit_s=limit_s))
    runs = quick.QuickRuns(**{'folder': folder, 'duration_s': 0.1, **how})
    return Task(campaign=campaign, full=runs)


def outcomes(rows: Iterator[Row]) -> dict[int, str]:
    """Return the outcome of each run, each of which must have one row."""
    found = list(rows)
    assert len({row.number for row in found}) == len(found)
    return {row.number: row.outcome for row in found}


def plain(row: Row) -> dict[str, Any]:
    """Return a row without the time that it took."""
    return replace(row, cpu_s=0.0).to_plain()


def test_a_killed_worker_costs_its_own_run_only(quick: Any, tmp_path: Path) -> None:
    """The run is flown again; those beside it go on and are begun once."""
    task = task_of(quick, tmp_path, kills=((2, 1), (4, 9)))
    found = outcomes(rows_here(task, task.campaign.runs(), 3))
    assert found == {n: FAULT if n == 4 else COMPLETE for n in range(6)}
    assert [task.full.begun(n) for n in range(6)] == [1, 1, 2, 1, 2, 1]  # type: ignore[union-attr]


def test_a_kill_of_the_command_loses_no_run(quick: Any, tmp_path: Path) -> None:
    """The runs that are flown when it is killed end, and their rows are collected."""
    file = campaign_file(tmp_path, 8)
    command = [sys.executable, str(HERE / 'quick_runs.py'), str(file), str(tmp_path), '4']
    process = subprocess.Popen(command, stdout=subprocess.PIPE)
    until(lambda: len(list(tmp_path.glob('begun-*'))) >= 4)
    process.kill()
    process.communicate()
    begun = {int(path.name.split('-')[1]) for path in tmp_path.glob('begun-*')}
    with Journal(tmp_path) as journal:
        before = len(journal.rows)
        journal.collect(30.0)
        assert before < len(begun)
        assert {row.number for row in journal.rows.values()} == begun
    assert not list(tmp_path.glob('rows-*'))


def test_an_idle_worker_that_ends_costs_nothing(quick: Any, tmp_path: Path) -> None:
    """Another process takes its place."""
    task = task_of(quick, tmp_path, seeds=2)
    rows = rows_here(task, task.campaign.runs(), 1)
    next(rows)
    child = int(Path(f'/proc/self/task/{os.getpid()}/children').read_text().split()[-1])
    os.kill(child, signal.SIGTERM)
    assert outcomes(rows) == {1: COMPLETE}


def test_a_row_on_disk_is_a_row_in_memory(tmp_path: Path) -> None:
    """A table made of rows that were read has the bytes of one made at once."""
    row = Row(
        number=0, key='a', seed=1, repeat=0, inputs={'place': (1.5, 2.0)}, outcome=COMPLETE
    )  # fmt: skip
    with Journal(tmp_path) as journal:
        journal.add(row)
        at_once = repr(journal.rows)
    with Journal(tmp_path) as journal:
        assert repr(journal.rows) == at_once


@pytest.mark.all
def test_a_table_gone_on_with_has_the_same_bytes(tmp_path: Path) -> None:
    """Two runs, then four with a key told by name, give the table of four at once."""
    key = 'survey.height_agl_m'
    height = yaml.safe_load((HERE / 'search_once.yaml').read_text())['survey']['height_agl_m']
    first = campaign_file(tmp_path, [5, 4])
    assert main([str(first), '--out', str(tmp_path / 'part'), '--workers', '2']) == 0
    second = campaign_file(tmp_path, [4, 5], vary={key: [height, height + 5.0]})
    for out in ('part', 'whole'):
        assert main([str(second), '--out', str(tmp_path / out), '--workers', '1']) == 0
    part, whole = (tmp_path / out / 'results.csv' for out in ('part', 'whole'))
    assert part.read_bytes() == whole.read_bytes()


@contextmanager
def cluster_of(workers: int) -> Iterator[Any]:
    """Start a scheduler with so many workers of one thread."""
    distributed = pytest.importorskip('distributed', reason='needs pip install distributed')
    with distributed.LocalCluster(
        n_workers=workers, threads_per_worker=1, dashboard_address=None, host='127.0.0.1'
    ) as cluster:
        yield cluster


@pytest.mark.slow
@pytest.mark.parametrize('count', [1, 3])
def test_a_lost_worker_of_a_cluster_costs_its_own_run_only(
    quick: Any, tmp_path: Path, count: int
) -> None:
    """As here: once more for the run, then a row; the others are begun once."""
    task = task_of(quick, tmp_path, kills=((2, 1), (4, 9)))
    with cluster_of(count) as cluster:
        found = outcomes(rows_of_cluster(task, task.campaign.runs(), cluster.scheduler_address))
    assert found == {n: FAULT if n == 4 else COMPLETE for n in range(6)}
    assert [task.full.begun(n) for n in range(6)] == [1, 1, 2, 1, 2, 1]  # type: ignore[union-attr]


@pytest.mark.slow
def test_rows_do_not_depend_on_the_workers_of_a_cluster(quick: Any, tmp_path: Path) -> None:
    """One worker, three workers, and this process: the same rows."""
    task = task_of(quick, tmp_path)
    own = [plain(carry_out(task, run)) for run in task.campaign.runs()]
    for count in (1, 3):
        with cluster_of(count) as cluster:
            rows = list(rows_of_cluster(task, task.campaign.runs(), cluster.scheduler_address))
        rows.sort(key=lambda row: row.number)
        assert [plain(row) for row in rows] == own


@pytest.mark.slow
def test_a_cluster_without_workers_is_one_line(quick: Any, tmp_path: Path) -> None:
    """None at the start, and none any more, end with a reason in the time told."""
    task = task_of(quick, tmp_path, duration_s=20.0)
    runs = task.campaign.runs()
    with cluster_of(0) as cluster:
        with pytest.raises(CampaignError, match='has no free worker for 3 s; the same') as told:
            list(rows_of_cluster(task, runs, cluster.scheduler_address, ANSWER_S))
        assert '\n' not in str(told.value)
        cluster.scale(1)
        rows = rows_of_cluster(task, runs, cluster.scheduler_address, 5 * ANSWER_S)
        cluster.loop.call_later(8.0, cluster.scale, 0)
        with pytest.raises(CampaignError, match='has no free worker for 15 s'):
            next(rows)


@pytest.mark.slow
def test_a_run_over_time_at_a_cluster_is_a_row(quick: Any, tmp_path: Path) -> None:
    """It is not waited for, and the campaign goes on at the workers that are left."""
    task = task_of(quick, tmp_path, seeds=1, limit_s=1.0, duration_s=12.0)
    with cluster_of(1) as cluster:
        begun_s = time.monotonic()
        (row,) = rows_of_cluster(task, task.campaign.runs(), cluster.scheduler_address, ANSWER_S)
        assert time.monotonic() - begun_s < 11.0
    assert (row.outcome, row.text) == (FAILED, 'took longer than limit_s = 1')


@pytest.mark.slow
def test_a_scheduler_that_stands_still_is_one_line(quick: Any, tmp_path: Path) -> None:
    """A stopped scheduler ends the command in the time told, not never."""
    pytest.importorskip('distributed', reason='needs pip install distributed')
    place = tmp_path / 'scheduler.json'
    command = [
        sys.executable, '-m', 'distributed.cli.dask_scheduler', '--host', '127.0.0.1',
        '--port', '0', '--no-dashboard', '--scheduler-file', str(place),
    ]  # fmt: skip
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(filter(None, sys.path))}
    quiet: Any = {'stdout': subprocess.DEVNULL, 'stderr': subprocess.DEVNULL, 'env': environment}
    processes = [subprocess.Popen(command, **quiet)]
    try:
        until(place.exists)
        address = str(yaml.safe_load(place.read_text())['address'])
        worker = [sys.executable, '-m', 'distributed.cli.dask_worker', address, '--no-dashboard']
        processes.append(subprocess.Popen([*worker, '--nthreads', '1', '--no-nanny'], **quiet))
        task = task_of(quick, tmp_path, duration_s=30.0)
        rows = rows_of_cluster(task, task.campaign.runs(), address, 4 * ANSWER_S)
        freezing = Thread(target=freeze_when_begun, args=(tmp_path, processes[0]))
        freezing.start()
        begun_s = time.monotonic()
        with pytest.raises(CampaignError, match='does not answer any more'):
            next(rows)
        freezing.join()
        assert time.monotonic() - begun_s < 40.0
    finally:
        for process in processes:
            process.kill()
            process.wait()


def freeze_when_begun(folder: Path, process: subprocess.Popen[bytes]) -> None:
    """Stop a process as soon as a run is flown."""
    until(lambda: list(folder.glob('begun-*')))
    process.send_signal(signal.SIGSTOP)
