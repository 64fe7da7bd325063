# SPDX-License-Identifier: Apache-2.0
"""Commands for runs, drafts, campaigns and vehicles: only the words of the command line."""

import stat
import time

import pytest

from rocsafe_console.errors import ConsoleError, RefusedError
from rocsafe_console.runs.jobs import KINDS, Folders, Jobs

PROGRAM = """#!/bin/sh
echo "$@"; echo "by $ROCSAFE_COMMANDER"
[ "$1" = campaign ] && exec sleep 60
exit 0
"""


@pytest.fixture
def jobs(tmp_path) -> Jobs:
    """Commands of a `rocsafe` that prints its words."""
    runs, scenarios = tmp_path / 'runs', tmp_path / 'config' / 'scenarios'
    for folder in (runs / 'run1', runs / 'drafts', scenarios, tmp_path / 'config' / 'campaigns'):
        folder.mkdir(parents=True)
    (runs / 'run1' / 'scenario.yaml').write_text('name: yard')
    (runs / 'drafts' / 'yard.yaml').write_text('name: yard')
    (scenarios.parent / 'campaigns' / 'c1.yaml').write_text('name: c1\nscenario: yard.yaml\n')
    (scenarios.parent / 'campaigns' / 'yard.yaml').write_text('name: yard\n')
    program = tmp_path / 'bin' / 'rocsafe'
    program.parent.mkdir()
    program.write_text(PROGRAM)
    program.chmod(program.stat().st_mode | stat.S_IEXEC)
    folders = Folders(runs=runs, scenarios=scenarios)
    return Jobs(folders, {'PATH': f'{program.parent}:/usr/bin:/bin'})


@pytest.mark.parametrize(
    ('kind', 'name', 'words'),
    [
        ('resume', 'run1', 'run --resume {runs}/run1'),
        ('report', 'run1', 'report {runs}/run1'),
        ('replay', 'run1', 'replay {runs}/run1'),
        ('whatif', 'yard', 'whatif {runs}/drafts/yard.yaml'),
        ('clear', 'rav1', 'clear rav1 --out {runs}'),
    ],
)
def test_a_command_has_the_words_of_the_command_line(jobs, kind, name, words):
    """It runs as its user, and what it prints is told."""
    job = jobs.begin(kind, name, 'anna')
    expected = words.format(runs=jobs.folders.runs)
    assert (job.state, job.text) == ('done', f'{expected}\nby anna')
    assert jobs.look(kind, name) == job


@pytest.mark.slow
def test_a_campaign_is_one_at_a_time_and_can_be_ended(jobs):
    """Of the files beside the scenarios, those of campaigns are offered."""
    assert jobs.campaigns() == ['c1']
    assert jobs.begin('campaign', 'c1', 'anna').state == 'running'
    with pytest.raises(RefusedError, match='end it first'):
        jobs.begin('campaign', 'c1', 'anna')
    jobs.end('campaign', 'c1')
    end_s = time.monotonic() + 20.0
    while jobs.look('campaign', 'c1').state == 'running' and time.monotonic() < end_s:
        time.sleep(0.05)
    assert jobs.look('campaign', 'c1').state == 'failed'


@pytest.mark.parametrize('kind', KINDS)
@pytest.mark.parametrize('name', ['', '..', '../x', '--out=/', 'a/b', 'none\0', 'x' * 300])
def test_a_wrong_name_starts_nothing(jobs, kind, name):
    """No path, no option, nothing that is not there."""
    with pytest.raises(ConsoleError):
        jobs.begin(kind, name, 'anna')
    assert not list((jobs.folders.runs / 'jobs').glob('*'))
