# SPDX-License-Identifier: Apache-2.0
"""A mission whose ground vehicle drives to evidence on what the drones have found."""

import csv
import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from .conftest import Flight

SCENARIO = Path(__file__).with_name('drive.yaml')
# 9 viewpoints, see drive.yaml; then a mark, and the source that is found.
VIEWPOINTS, EVIDENCE = 9, ['mark', 'source-1']

pytestmark = pytest.mark.system


def test_survey_map_route_drive_and_evidence_are_one_mission(
    fly: Callable[..., Flight],
) -> None:
    """The dose that the vehicle reads on its way is the one that was planned."""
    flight = fly()
    assert flight.end() == 0, flight.output
    run = flight.run.path
    images = flight.images()
    assert len(images) == VIEWPOINTS + len(EVIDENCE)
    assert sum(name.startswith('rgv1-') for name in images) == len(EVIDENCE)
    summary = json.loads((run / 'summary.json').read_text())
    assert summary['outcome'] == 'complete'
    route = json.loads((run / 'ground' / 'route.json').read_text())
    assert sorted(stop['evidence'] for stop in route['stops'] if stop['evidence']) == EVIDENCE
    drive = _driven(run, 'rgv1')
    assert drive['dose_usv'] == pytest.approx(route['dose_usv']['mean'], rel=0.2)
    assert drive['seconds'] == pytest.approx(route['time_s'], rel=0.07)
    report = (run / 'report.html').read_text()
    assert 'Way as planned (yellow) and as driven' in report
    assert flight.living() == []


def _driven(run: Path, vehicle: str) -> dict[str, Any]:
    """Return dose and time of a drive from the table of readings: while the vehicle moves."""
    ledger = json.loads((run / 'spool' / vehicle / 'drive.json').read_text())['ledger']
    with (run / 'readings.csv').open(encoding='utf-8', newline='') as stream:
        rows = [
            (int(row['time_ns']), float(row['dose_rate_usvh']))
            for row in csv.DictReader(stream)
            if row['vehicle'] == vehicle
            and ledger['began_ns'] <= int(row['time_ns']) <= ledger['ended_ns']
        ]
    dose = sum(0.5 * (a[1] + b[1]) * (b[0] - a[0]) * 1e-9 / 3600.0 for a, b in pairwise(rows))
    return {'dose_usv': dose, 'seconds': (ledger['ended_ns'] - ledger['began_ns']) * 1e-9}
