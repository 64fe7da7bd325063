# SPDX-License-Identifier: Apache-2.0
"""The folder of a run, and what is noted about where the run comes from."""

import json
from datetime import datetime, timezone
from pathlib import Path

import pytest

from rocsafe_geo.evidence.code_version import git_revision
from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.provenance import provenance, write_json
from rocsafe_orchestrator.run_directory import create_run_directory, remove_parts, run_name

NOW = datetime(2026, 11, 20, 23, 5, 9, tzinfo=timezone.utc)


def test_folder_is_named_after_scenario_and_time(tmp_path: Path) -> None:
    """`runs/<scenario>-<YYYYMMDD-HHMMSS>/` with the folders that nodes write to."""
    run = create_run_directory(tmp_path / 'runs', run_name('derailment', NOW))
    assert run.name == 'derailment-20261120-230509'
    for folder in (run.images, run.logs, run.parameters, run.spool):
        assert folder.is_dir()


def test_two_runs_of_one_second_do_not_mix(tmp_path: Path) -> None:
    """The second gets a folder of its own."""
    runs = [create_run_directory(tmp_path, run_name('derailment', NOW)) for _ in range(3)]
    assert [run.name.removeprefix('derailment-20261120-') for run in runs] == [
        '230509',
        '230509-2',
        '230509-3',
    ]


def test_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    """A file in the way is told in one line."""
    (tmp_path / 'runs').write_text('')
    with pytest.raises(SetupError, match='cannot make a run directory'):
        create_run_directory(tmp_path / 'runs', run_name('derailment', NOW))


def test_provenance_fits_json() -> None:
    """Command, revision and versions are there, and can be written."""
    info = json.loads(json.dumps(provenance(['/usr/bin/rocsafe', 'run', 'x.yaml'], NOW)))
    assert info['command'] == ['rocsafe', 'run', 'x.yaml']
    assert info['started'] == '2026-11-20T23:05:09+00:00'
    assert {'python', 'numpy', 'pydantic'} <= set(info['versions'])


def test_revision_outside_a_checkout_is_unknown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An installed copy has no revision, and says so; temporary files may lie in a checkout."""
    monkeypatch.setenv('GIT_CEILING_DIRECTORIES', str(tmp_path.parent))
    assert git_revision(tmp_path) is None


def test_json_is_replaced_as_a_whole(tmp_path: Path) -> None:
    """Nothing but the new content is left."""
    path = tmp_path / 'run.json'
    write_json(path, {'outcome': None})
    write_json(path, {'outcome': 'complete'})
    assert json.loads(path.read_text()) == {'outcome': 'complete'}
    assert list(tmp_path.iterdir()) == [path]


def test_what_is_half_written_is_removed_and_nothing_else(tmp_path: Path) -> None:
    """A map that a process was killed over must not be sealed as evidence."""
    run = create_run_directory(tmp_path, 'run')
    for name in ('mosaic.tif.part', 'mosaic.tif', 'mission.part-0.mcap', 'images/a.part'):
        (run.path / name).touch()
    remove_parts(run)
    left = {path.name for path in run.path.rglob('*') if path.is_file()}
    assert left == {'mosaic.tif', 'mission.part-0.mcap', 'a.part'}
