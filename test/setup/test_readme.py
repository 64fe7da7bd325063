# SPDX-License-Identifier: Apache-2.0
"""The README says what the code does."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / 'README.md').read_text()


def test_tables_are_current():
    """``make docs`` would change nothing."""
    pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')
    import readme_tables

    assert readme_tables.with_tables(README) == README


def test_named_targets_and_paths_exist():
    """Every make target, file and folder of this repository that is named is there."""
    targets = set(re.findall(r'^([a-z-]+):', (ROOT / 'Makefile').read_text(), re.M))
    assert set(re.findall(r'(?:`|^ *|&& )make ([a-z]+)', README, re.M)) <= targets
    paths = re.findall(r'`((?:src|config|test|benchmarks|requirements|tools)/[\w./]*)`', README)
    assert len(paths) > 10
    assert [path for path in paths if not (ROOT / path).exists()] == []


def test_exit_codes_are_those_of_the_command():
    """The table of exit codes has every code of ``rocsafe --help``."""
    from rocsafe_orchestrator.cli import EPILOG

    told = set(re.findall(r'\b(\d+)\b', EPILOG.split('exit codes:')[1]))
    table = README.split('| exit code | means |')[1].split('\n\n')[0]
    first_columns = ' '.join(re.findall(r'^\| ([\d, ]+) \|', table, re.M))
    assert set(re.findall(r'\d+', first_columns)) == told
