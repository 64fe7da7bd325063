# SPDX-License-Identifier: Apache-2.0
"""Sources are estimated while the map is written, and once more only if other readings come."""

import dataclasses
import os
import shutil
import sys
from itertools import chain, repeat
from threading import Thread

import pytest

from rocsafe_orchestrator import report_process
from rocsafe_orchestrator.products.source_estimates import SourceEstimates
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_orchestrator.write_products import estimate_early, write_products


@pytest.fixture
def tables(monkeypatch):
    """Tables of readings of which sources were estimated."""
    found = []

    def estimate(readings, _options):
        found.append(readings.read_bytes())
        return SourceEstimates(
            sources=(), source_count_probability=(1.0,), background_usvh=0.1, reading_count=1
        )

    monkeypatch.setattr(sys.modules[write_products.__module__], 'estimate_sources', estimate)
    return found


@pytest.mark.slow
def test_sources_are_estimated_once_if_no_reading_comes(flown_run, tmp_path, tables):
    """The recorder's segments stay; readings and estimate are those of the whole recording."""
    copy = tmp_path / flown_run.name
    shutil.copytree(flown_run, copy)
    (copy / 'spool').mkdir()
    parts = sorted(path.name for path in copy.glob('*.mcap'))
    early = estimate_early(RunDirectory(copy))
    assert sorted(path.name for path in copy.glob('*.mcap')) == parts
    summary = write_products(copy, early)
    assert summary.estimates == early.estimates
    assert tables == [(copy / 'readings.csv').read_bytes()]
    write_products(copy, dataclasses.replace(early, table=b'another'))
    assert len(tables) == 2


@pytest.fixture
def made(monkeypatch):
    """What the process has made."""
    found = []
    monkeypatch.setattr(report_process, 'estimate_early', lambda _run: 'early')
    monkeypatch.setattr(report_process, 'write_products', lambda *given: found.append(given))
    return found


def test_products_wait_until_all_is_recorded(tmp_path, made):
    """The process begins while the map is written."""
    run = RunDirectory(tmp_path)
    run.spool.mkdir()
    process = Thread(target=report_process.main, args=(tmp_path,))
    process.start()
    process.join(0.2)
    assert (made, process.is_alive()) == ([], True)
    run.flown.touch()
    process.join(10.0)
    assert made == [(tmp_path, 'early')]


def test_the_process_ends_with_its_orchestrator(tmp_path, made, monkeypatch):
    """Nobody would tell it that all is recorded."""
    parents = chain([os.getppid()], repeat(1))
    monkeypatch.setattr(report_process.os, 'getppid', lambda: next(parents))
    assert report_process.main(tmp_path) == 1
    assert not made
