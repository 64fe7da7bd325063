# SPDX-License-Identifier: Apache-2.0
"""The report says how good the map is, in the words of the one who made it."""

import json

import pytest

from rocsafe_orchestrator.report.map_facts import map_facts
from rocsafe_view.formats import GAP

QUALITY = {
    'is_georeferenced': True,
    'why_not_georeferenced': [],
    'photographs': {'total': 59, 'placed_by_features': 57},
    'held_out_ties': {'px': {'median': 0.0461}},
    'fixes': {'all': {'horizontal_rmse_m': 0.0155}},
    'stated_error_m': {'rms': 0.0166},
    'coverage': {'of': 'region', 'share': 0.987, 'largest_hole_m2': 12.5},
}


@pytest.fixture
def told(tmp_path):
    """Return a function that writes a quality and reads its facts."""

    def read(document):
        (tmp_path / 'map').mkdir(exist_ok=True)
        text = document if isinstance(document, str) else json.dumps(document)
        (tmp_path / 'map' / 'quality.json').write_text(text)
        return dict(map_facts(tmp_path))

    return read


def test_coverage_hole_and_errors_are_told(told):
    """Each figure with its unit."""
    assert {name: value.replace(GAP, ' ') for name, value in told(QUALITY).items()} == {
        'Placed by features': '57 of 59 photographs',
        'Georeferenced': 'yes',
        'Stated error, RMS': '0.017 m',
        'Held-out ties, median': '0.046 px',
        'Fixes off the map, RMS': '0.015 m',
        'Shown of the region': '98.7 %',
        'Largest hole': '12 m²',
    }


def test_refusal_is_told_with_its_reasons(told):
    """A map that lies nobody knows where says so."""
    reasons = ['no fix', 'tilted by 20 degrees']
    found = told({**QUALITY, 'is_georeferenced': False, 'why_not_georeferenced': reasons})
    assert found['Georeferenced'] == 'no: no fix; tilted by 20 degrees'
    assert told({'coverage': {'share': 1.0, 'largest_hole_m2': 0.0}})['Largest hole'] == 'none'


@pytest.mark.parametrize(
    'document', ['', '[1]', '{"coverage": 3}', '{"photographs": {"total": "x"}}']
)
def test_what_is_damaged_is_left_out(told, document):
    """A report is made of what there is."""
    assert told(document) == {}


def test_page_of_the_map_is_linked(told, tmp_path):
    """The link leads to the page beside the map."""
    told(QUALITY)
    (tmp_path / 'map' / 'quality.html').write_text('<p>')
    assert 'href="map/quality.html"' in str(dict(map_facts(tmp_path))['More'])


def test_run_without_a_map_has_no_facts(tmp_path):
    """No file, no column."""
    assert map_facts(tmp_path) == []
