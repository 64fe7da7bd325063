# SPDX-License-Identifier: Apache-2.0
"""Campaigns: what they vary, their rows, their statistics."""

import csv
import errno
import math
import os
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from rocsafe_campaign.campaign_command import main
from rocsafe_campaign.design.campaign import Campaign, Run, read_campaign
from rocsafe_campaign.design.key_path import with_value
from rocsafe_campaign.errors import CampaignError, MachineError
from rocsafe_campaign.execution.cluster_workers import rows_of_cluster
from rocsafe_campaign.execution.full_run import FullRuns
from rocsafe_campaign.execution.journal import FILE, Journal
from rocsafe_campaign.execution.one_run import Task, carry_out
from rocsafe_campaign.flight.pure_mission import impure_keys
from rocsafe_campaign.results.intervals import bootstrap_mean
from rocsafe_campaign.results.metrics import Metrics, match
from rocsafe_campaign.results.page import page_text
from rocsafe_campaign.results.row import COMPLETE, FAILED, FAULT, Row
from rocsafe_campaign.results.sensitivity import influences
from rocsafe_orchestrator.processes.domain_lock import domain_lock
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario

SCENARIO = Path(__file__).with_name('search_once.yaml')
SHIPPED = Path(__file__).resolve().parents[2] / 'config' / 'campaigns'
BASE = {
    'name': 'one_source',
    'scenario': str(SCENARIO),
    'seeds': 2,
    'vary': {'survey.height_agl_m': [25.0, 35.0]},
    'draw': {
        'radiation.sources[0].position': {'distribution': 'in_region'},
        'radiation.sources[0].activity_gbq': {
            'distribution': 'log_uniform', 'low': 0.5, 'high': 20.0,
        },
    },
}  # fmt: skip


def written(folder: Path, **changes: object) -> Path:
    """Write the campaign, changed, and return its path."""
    path = folder / 'campaign.yaml'
    path.write_text(yaml.safe_dump({**BASE, **changes}))
    return path


def campaign(folder: Path, **changes: object) -> Campaign:
    """Return the campaign, changed."""
    return read_campaign(written(folder, **changes))


def results(folder: Path) -> list[dict[str, str]]:
    """Return the table."""
    return list(csv.DictReader((folder / 'results.csv').read_text().splitlines()))


def test_combinations_have_the_same_draws(tmp_path: Path) -> None:
    """Two heights are compared with the same sources, two seeds have different ones."""
    runs = campaign(tmp_path).runs()
    low, high = runs[:2], runs[2:]
    key = 'radiation.sources[0].position'
    assert [run.inputs[key] for run in low] == [run.inputs[key] for run in high]
    assert low[0].inputs[key] != low[1].inputs[key]
    assert {run.inputs['survey.height_agl_m'] for run in low} == {25.0}


@pytest.mark.parametrize('path', sorted(SHIPPED.glob('*.yaml')), ids=lambda path: path.stem)
def test_shipped_campaigns_can_be_flown(path: Path) -> None:
    """Every campaign in config/campaigns is valid and needs no processes."""
    if 'scenario:' in path.read_text():
        found = read_campaign(path)
        assert not list(impure_keys(found.scenario_of(found.runs()[-1])))


def test_draws_have_their_distribution(tmp_path: Path) -> None:
    """Places lie in the region, activities are even over the orders of magnitude."""
    runs = campaign(tmp_path, vary={}, seeds=400).runs()
    places = np.array([run.inputs['radiation.sources[0].position'] for run in runs])
    assert (places.min(axis=0) >= [53.28, -9.061]).all()
    assert (places.max(axis=0) <= [53.2806, -9.06]).all()
    assert places.mean(axis=0) == pytest.approx([53.2803, -9.0605], abs=5e-5)
    logs = np.log([run.inputs['radiation.sources[0].activity_gbq'] for run in runs])
    assert logs.mean() == pytest.approx(math.log(math.sqrt(10.0)), abs=0.2)


def test_a_row_belongs_to_the_files_of_its_scenario(tmp_path: Path) -> None:
    """Another polygon in a file of the same name is another run."""
    scenario = yaml.safe_load(SCENARIO.read_text())
    polygon = scenario['region'].pop('polygon')
    scenario['region']['file'] = 'region.csv'
    (tmp_path / 'scenario.yaml').write_text(yaml.safe_dump(scenario))
    keys = set()
    for number, corner in enumerate((53.2806, 53.2807)):
        rows = [*polygon[:2], [corner, -9.0610], [corner, -9.0600]]
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / 'scenario.yaml').write_text((tmp_path / 'scenario.yaml').read_text())
        lines = ['latitude,longitude', *(f'{a},{b}' for a, b in rows)]
        (folder / 'region.csv').write_text('\n'.join(lines))
        found = campaign(folder, scenario='scenario.yaml', vary={}, draw={}, seeds=1)
        keys.add(found.key_of(found.runs()[0]))
    assert len(keys) == 2


def test_a_key_path_reaches_every_entry_and_makes_blocks() -> None:
    """``[*]`` stands for all entries; a block that the file leaves out is made."""
    content = {'vehicles': ({'name': 'a'}, {'name': 'b'})}
    changed = with_value(content, 'vehicles[*].hover_s', 2.0)
    assert [vehicle['hover_s'] for vehicle in changed['vehicles']] == [2.0, 2.0]
    assert with_value({}, 'survey.effort.method', 'x') == {'survey': {'effort': {'method': 'x'}}}
    assert content == {'vehicles': ({'name': 'a'}, {'name': 'b'})}


@pytest.mark.parametrize(
    ('changes', 'words'),
    [
        ({'seeds': 0}, 'seeds'),
        ({'unknown': 1}, 'unknown: unknown key'),
        ({'draw': {'seed': {'distribution': 'uniform', 'low': 0.0, 'high': 1.0}}}, 'by the key'),
        ({'draw': {'a': {'distribution': 'uniform', 'low': 1.0, 'high': 1.0}}}, 'above low'),
        ({'vary': {'vehicles[7].hover_s': [1.0]}}, 'has 1 entries'),
        ({'vary': {'survey height': [1.0]}}, 'must be a key'),
        ({'vary': {'survey.heigth_agl_m': [1.0]}}, 'survey.heigth_agl_m: unknown key'),
        ({'vary': {'survey.height_agl_m': []}}, 'must have a value'),
        ({'scenario': 'nowhere.yaml'}, 'nowhere.yaml'),
    ],
)
def test_a_mistake_is_told_before_anything_runs(
    tmp_path: Path, changes: dict[str, object], words: str
) -> None:
    """Each mistake gives one line that names the key."""
    with pytest.raises((CampaignError, ScenarioError), match=words.replace('[', r'\[')):
        campaign(tmp_path, **changes)


def test_a_run_that_cannot_be_flown_is_a_row(tmp_path: Path) -> None:
    """A height that the airspace forbids gives a row with the reason."""
    found = campaign(tmp_path, vary={'survey.height_agl_m': [25.0, 500.0]}, seeds=1)
    row = carry_out(Task(campaign=found), found.runs()[1])
    assert row.outcome == FAILED
    assert '500' in row.text


@pytest.mark.parametrize(
    'vary',
    [
        {'radiation.search.extra_rounds': [1]},
        {'vehicles[0].fails_after_s': [20.0]},
    ],
)
def test_what_only_processes_do_is_refused(tmp_path: Path, vary: dict[str, object]) -> None:
    """A key that a mission without processes would ignore is never ignored in silence."""
    found = campaign(tmp_path, vary=vary, seeds=1)
    row = carry_out(Task(campaign=found), found.runs()[0])
    assert row.outcome == FAILED
    assert '--full' in row.text


def test_a_campaign_never_flies_a_real_vehicle(tmp_path: Path) -> None:
    """Neither way of running starts anything for a scenario with a link."""
    changes = {'vary': {'vehicles[0].link': ['udp:127.0.0.1:14550']}, 'seeds': 1}
    found = campaign(tmp_path, **changes)
    full = FullRuns(folder=tmp_path / 'runs', domains=(1,))
    for task in (Task(campaign=found), Task(campaign=found, full=full)):
        row = carry_out(task, found.runs()[0])
        assert row.outcome == FAILED
        assert 'simulated vehicles only' in row.text
    assert not (tmp_path / 'runs').exists()


@dataclass(frozen=True, kw_only=True)
class FullDisk:
    """Takes the place of whole processes, on a disk that is full."""

    number: int = errno.ENOSPC

    def metrics(self, _scenario: Scenario, _run: Run, _limit_s: float) -> Metrics:
        """Write nothing."""
        raise OSError(self.number, os.strerror(self.number), 'scenario.yaml')


def test_what_the_machine_cannot_do_is_no_result(tmp_path: Path, ros_domain_id: int) -> None:
    """A full disk, or missions in all domains: no row stays, so that the command goes on."""
    found = campaign(tmp_path, seeds=1, limit_s=1)
    full = FullRuns(folder=tmp_path / 'runs', domains=(ros_domain_id,))
    with domain_lock(str(ros_domain_id), 'a test'), pytest.raises(MachineError, match='for 1 s'):
        carry_out(Task(campaign=found, full=full), found.runs()[0])
    task = Task(campaign=found, full=FullDisk())  # type: ignore[arg-type]
    with pytest.raises(MachineError, match=r'run 0: .*No space left on device'):
        carry_out(task, found.runs()[0])
    fault = Task(campaign=found, full=FullDisk(number=errno.ENOENT))  # type: ignore[arg-type]
    assert carry_out(fault, found.runs()[0]).outcome == FAULT


def test_a_torn_line_costs_one_run(tmp_path: Path) -> None:
    """Whatever byte the writer was killed at, all rows before are read, and writing goes on."""
    row = Row(number=0, key='a', seed=1, repeat=0, inputs={}, outcome=COMPLETE)
    other = Row(number=1, key='b', seed=2, repeat=0, inputs={}, outcome=FAILED, text='why')
    with Journal(tmp_path) as journal:
        journal.add(row)
        journal.add(other)
    whole = (tmp_path / FILE).read_bytes()
    first = whole.index(b'\n') + 1
    for size in range(first, len(whole)):
        (tmp_path / FILE).write_bytes(whole[:size])
        with Journal(tmp_path) as journal:
            assert set(journal.rows) == {'a'}
            journal.add(other)
        assert (tmp_path / FILE).read_bytes() == whole


def test_two_campaigns_do_not_write_to_one_folder(tmp_path: Path) -> None:
    """The second one is refused."""
    with Journal(tmp_path), pytest.raises(CampaignError, match='another campaign'):
        Journal(tmp_path)


@pytest.mark.all
def test_the_table_does_not_depend_on_workers_or_kills(tmp_path: Path) -> None:
    """One process, two processes, and one killed in the middle and started again: one table."""
    file = written(tmp_path)
    assert main([str(file), '--out', str(tmp_path / 'one'), '--workers', '1']) == 0
    command = [
        sys.executable, '-m', 'rocsafe_campaign.campaign_command', str(file), '--workers', '2',
        '--out', str(tmp_path / 'two'),
    ]  # fmt: skip
    killed = subprocess.Popen(command, stdout=subprocess.PIPE, start_new_session=True, text=True)
    assert killed.stdout is not None
    seen = next(line for line in killed.stdout if '1 of 4' in line)
    killed.kill()
    # The output ends when no process has it open any more: the workers have ended too.
    killed.communicate()
    with Journal(tmp_path / 'two') as journal:
        assert len(journal.rows) >= 1, seen
    again = subprocess.run(command, check=True, capture_output=True, text=True)
    assert '4 runs, 0 of them' not in again.stdout
    one, two = (tmp_path / out / 'results.csv' for out in ('one', 'two'))
    assert one.read_bytes() == two.read_bytes()
    assert [row['outcome'] for row in results(tmp_path / 'one')] == [COMPLETE] * 4
    page = (tmp_path / 'one' / 'campaign.html').read_text()
    assert '4 of 4 runs complete' in page


@pytest.mark.slow
def test_a_campaign_is_flown_and_goes_on(tmp_path: Path) -> None:
    """One run finds the source; a longer campaign in the same folder does not fly it again."""
    short = written(tmp_path, vary={}, seeds=[3])
    assert main([str(short), '--out', str(tmp_path / 'out'), '--workers', '1']) == 0
    (row,) = results(tmp_path / 'out')
    assert (row['found_count'], row['missed'], row['invented']) == ('1.0', '0.0', '0.0')
    assert float(row['error_m']) < 6.0
    with Journal(tmp_path / 'out') as journal:
        before = journal.rows
    found = campaign(tmp_path, vary={}, seeds=[2, 3])
    assert found.key_of(found.runs()[1]) in before
    assert found.key_of(found.runs()[0]) not in before


@pytest.mark.all
def test_a_cluster_gives_the_same_rows(tmp_path: Path) -> None:
    """Two workers of a Dask scheduler give what this process gives."""
    distributed = pytest.importorskip('distributed', reason='needs pip install distributed')
    found = campaign(tmp_path, seeds=1)
    task, runs = Task(campaign=found), found.runs()
    own = [carry_out(task, run) for run in runs]
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, host='127.0.0.1'
    ) as cluster:
        rows = sorted(
            rows_of_cluster(task, runs, cluster.scheduler_address), key=lambda row: row.number
        )
    assert [replace(row, cpu_s=0.0) for row in rows] == [replace(row, cpu_s=0.0) for row in own]


def test_sources_and_estimates_are_matched() -> None:
    """The nearest pairs count; what is farther than 25 m is missed, and invented."""
    found = match([(0.0, 0.0), (40.0, 0.0)], [(41.0, 0.0), (200.0, 0.0), (3.0, 4.0)])
    assert found['error_m'] == pytest.approx(3.0)
    assert (found['missed'], found['invented']) == (0.0, 1.0)
    lost = match([(0.0, 0.0)], [])
    assert lost['missed'] == 1.0
    assert math.isnan(lost['error_m'])


def test_a_far_estimate_takes_no_source_from_a_near_one() -> None:
    """The sum of distances alone would pair the far one too."""
    found = match([(0.0, 0.0), (10.0, 0.0)], [(9.0, 0.0), (-500.0, 0.0)])
    assert found['missed'] == 1.0
    assert found['error_m'] <= 1.0


def test_intervals_cover_the_mean_as_often_as_they_say() -> None:
    """Of 200 samples of 30 normal values, about 95 % of the intervals hold the true mean."""
    generator = np.random.default_rng(3)
    intervals = [bootstrap_mean(generator.normal(5.0, 2.0, 30).tolist(), k) for k in range(200)]
    covered = sum(one.low <= 5.0 <= one.high for one in intervals) / 200
    assert 0.89 <= covered <= 0.98


def test_the_key_that_moves_the_result_is_found() -> None:
    """Of three keys one decides, one counts for a little, one for nothing."""
    generator = np.random.default_rng(1)
    inputs = [
        {'strong': a, 'weak': b, 'none': c, 'kind': k}
        for a, b, c, k in zip(
            *generator.uniform(size=(3, 300)), generator.choice(['x', 'y'], 300), strict=True
        )
    ]
    noise = generator.normal(0.0, 0.1, 300)
    values = [-3.0 * one['strong'] + one['weak'] for one in inputs]
    found = {one.key: one for one in influences(inputs, (values + noise).tolist())}
    assert next(iter(found)) == 'strong'
    assert found['strong'].correlation < -0.85
    assert found['strong'].share > 0.7
    assert 0.01 < found['weak'].share < 0.25
    assert found['none'].share < 0.05
    assert math.isnan(found['kind'].correlation)
    assert found['kind'].p_value > 0.01


def test_a_page_escapes_what_runs_say(tmp_path: Path) -> None:
    """A reason with markup is shown as text."""
    found = campaign(tmp_path)
    row = Row(
        number=0, key='a', seed=0, repeat=0, inputs=found.runs()[0].inputs, outcome=FAILED,
        text='<script>x</script>',
    )  # fmt: skip
    page = page_text(found, [row], 'abc')
    assert '<script>x' not in page
    assert '&lt;script&gt;x' in page
