# SPDX-License-Identifier: Apache-2.0
"""What the report says of releases of gas, from what the estimator wrote."""

import json
from pathlib import Path
from typing import Any

import pytest

from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.products import release_estimates
from rocsafe_orchestrator.products.release_estimates import estimate_releases
from rocsafe_orchestrator.report.sections.gas_view import gas_view

CONTENT: dict[str, Any] = {
    'releases': [
        {
            'latitude_deg': 53.28,
            'longitude_deg': -9.06,
            'rate_g_s': 61.2,
            'rate_95_g_s': [40.0, 90.0],
            'std_m': [3.0, 4.0],
            'region_95_m2': 250.0,
        }
    ],
    'agent': 'ammonia',
    'sensor': 'pid_10_6_ev',
    'reading_count': 80,
    'is_enough': True,
    'verdict': '1 release, placed within 9 m (95 %)',
    'threat_zones': [
        {
            'level': 'AEGL-2 (60 min)',
            'ppm': 160.0,
            'expected_m2': 900.0,
            'outer_95_m2': 2000.0,
            'is_cut_by_the_map': True,
        }
    ],
}
FIGURE = '<svg class="gas-figure"></svg>'


@pytest.fixture
def estimated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Give a folder with the files that the command would have written."""
    monkeypatch.setattr(release_estimates, 'run_estimator', lambda *_: None)
    (tmp_path / 'release.json').write_text(json.dumps(CONTENT))
    (tmp_path / 'gas.svg').write_text(FIGURE)
    return tmp_path


def test_releases_and_zones_are_rows(estimated: Path) -> None:
    """With units; a bound that the map cuts is a lower limit."""
    view = gas_view(estimate_releases(estimated / 'estimator.yaml', estimated))
    assert view is not None
    assert view.sentence == (
        'ammonia, read by pid_10_6_ev: 1 release, placed within 9 m (95 %) (enough).'
    )
    assert view.figure == FIGURE
    assert view.release_rows[0][3] == '61.2 g/s (40 to 90)'
    assert view.zone_rows[0][:2] == ('AEGL-2 (60 min)', '160 ppm')
    assert view.zone_rows[0][3].startswith('at least')


def test_without_estimates_there_is_no_section() -> None:
    """The report says elsewhere what is missing."""
    assert gas_view(None) is None


def test_a_file_that_lacks_something_is_told(estimated: Path) -> None:
    """In one line."""
    (estimated / 'release.json').write_text('{"releases": []}')
    with pytest.raises(OrchestratorError, match=r'release\.json cannot be read'):
        estimate_releases(estimated / 'estimator.yaml', estimated)
