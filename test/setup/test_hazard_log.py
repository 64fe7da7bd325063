# SPDX-License-Identifier: Apache-2.0
"""The hazard log names code and tests that exist."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LOG = ROOT / 'docs/safety.md'
COLUMNS = ['hazard', 'cause', 'severity', 'mitigation', 'where', 'test']
FOLDERS = ('src', 'test', 'tools', 'benchmarks', 'examples')
FILES = [f'/{path.relative_to(ROOT)}' for top in FOLDERS for path in (ROOT / top).rglob('*.*')]
# Of the files that are collected; some names are of several folders.
TESTS = {}
for file in (ROOT / 'test').rglob('test_*.py'):
    found = re.findall(r'^\s*def (test_\w+)', file.read_text(), re.M)
    TESTS.setdefault(file.stem, set()).update(found)


def rows():
    """Return the hazards of all tables, each as its cells by column."""
    cells = [
        [cell.strip() for cell in re.split(r'(?<!`)\|(?! head`)', line.strip().strip('|'))]
        for line in LOG.read_text().splitlines()
        if line.startswith('|') and not line.startswith('|---')
    ]
    return [
        dict(zip(COLUMNS, row, strict=True))
        for row in cells
        if len(row) == len(COLUMNS) and row != COLUMNS
    ]


ROWS = rows()


def test_every_hazard_is_read():
    """None is left out because its row has another number of cells."""
    lines = LOG.read_text().splitlines()
    heads = [n for n, line in enumerate(lines) if line.startswith('| hazard |')]
    tables = [next(n for n in range(h, len(lines)) if not lines[n].startswith('|')) for h in heads]
    count = sum(end - head - 2 for head, end in zip(heads, tables, strict=True))
    assert len(ROWS) == count > 150


@pytest.mark.parametrize('row', ROWS, ids=lambda row: row['hazard'][:60])
def test_every_hazard_has_code_and_a_test_that_exist(row):
    """Each file that is named is one of the repository, each test is one of its tests."""
    named = re.findall(r'[\w/]+\.(?:py|mjs|js|yaml)\b', f'{row["where"]} {row["test"]}')
    assert [name for name in named if not any(f.endswith(f'/{name}') for f in FILES)] == []
    stands_in = set().union(*TESTS.values())
    tests = []
    for name in re.findall(r'\btest_\w+\b(?!/)', row['test']):
        if name in TESTS:
            stands_in = TESTS[name]
            continue
        assert name in stands_in, f'{name} is no test of the file that is named before it'
        tests.append(name)
    assert tests or re.search(r'(test_|benchmarks/)\w+\.py', row['test']), 'no test is named'


def test_every_severity_is_one_of_those_explained():
    """A reader compares hazards by it."""
    text = LOG.read_text()
    explained = re.search(r'^Severity: (.*?)\n\n', text, re.M | re.S)[1]
    words = set(re.findall(r'(\w+) \(', explained))
    assert {row['severity'] for row in ROWS} - words == set()


# Calls that only ask.
QUESTIONS = {'preflight', 'camera/look', 'radiation_field/query'}


def test_every_order_has_its_unsafe_control_actions():
    """All that moves, plans or leads, by service, action or topic."""
    pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')
    from rocsafe_ros.interfaces import calls, topics

    table = LOG.read_text().split('## Unsafe control actions')[1].split('## Known and open')[0]
    firsts = ' '.join(re.findall(r'^\| (.*?) \|', table, re.M))
    named = set(re.findall(r'`([^`]+)`', firsts))
    orders = {spec.name for spec in calls.CALLS} - QUESTIONS
    orders |= {topics.CMD_VEL.name, topics.GIMBAL_COMMAND.name}
    assert orders - named == set()
