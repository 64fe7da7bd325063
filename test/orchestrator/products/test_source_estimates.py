# SPDX-License-Identifier: Apache-2.0
"""What the readings say of sources reaches summary and report."""

import json
import shutil
import sys

import pytest

from rocsafe_orchestrator.write_products import write_products
from rocsafe_scenario.scenario_file import read_scenario


@pytest.fixture
def run(flown_run, tmp_path, monkeypatch):
    """A run whose `localize` is the real one, in a prefix of its own."""
    executable = tmp_path / 'prefix' / 'lib' / 'rocsafe_radiation' / 'localize'
    executable.parent.mkdir(parents=True)
    executable.write_text(
        f'#!/bin/sh\nexec {sys.executable} '
        '-m rocsafe_radiation.command_line.localize_command "$@"\n'
    )
    executable.chmod(0o755)
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path / 'prefix'))
    monkeypatch.setenv('PYTHONPATH', ':'.join(sys.path))
    copy = tmp_path / flown_run.name
    shutil.copytree(flown_run, copy)
    return copy, executable


@pytest.mark.slow
def test_the_true_source_is_found_from_the_readings(run):
    """Within 2 m, and told in summary, report and GeoJSON."""
    folder, _ = run
    truth = _true_source(folder)
    (source,) = write_products(folder).estimates.sources
    assert source.position.latitude_deg == pytest.approx(truth[0], abs=2e-5)
    assert source.position.longitude_deg == pytest.approx(truth[1], abs=3e-5)
    summary = json.loads((folder / 'summary.json').read_text())
    assert summary['estimates']['source_count_probability'][1] > 0.9
    assert 'source 1 (estimated)' in (folder / 'report.html').read_text()
    assert (folder / 'sources.geojson').is_file()


@pytest.mark.slow
def test_a_run_without_an_estimate_says_why(run):
    """The report is there all the same."""
    folder, executable = run
    executable.write_text('#!/bin/sh\necho "error: the dog ate it" >&2\nexit 2\n')
    summary = write_products(folder)
    assert summary.estimates is None
    assert 'no estimate of sources: the dog ate it' in summary.missing
    assert (folder / 'report.html').is_file()


def _true_source(folder):
    """Return latitude and longitude of the source of the scenario."""
    (source,) = read_scenario(folder / 'scenario.yaml').radiation.sources
    return source.position
