# SPDX-License-Identifier: Apache-2.0
"""The report shows the drive that was planned on a run, and none where there is none."""

import json

import pytest

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_orchestrator.report.drive_view import drive_view
from rocsafe_view.pages import render

FRAME = LocalFrame(GeoPosition(53.28, -9.06, 66.0))
PLACES = ((0.0, 0.0, ''), (30.0, 40.0, 'drum <1>'), (0.0, 0.0, ''))


def route():
    """Return the document of a drive out and back."""
    stops = []
    for east, north, evidence in PLACES:
        place = FRAME.position_of([east, north, 0.0])
        stops.append({
            'latitude_deg': place.latitude_deg, 'longitude_deg': place.longitude_deg,
            'evidence': evidence,
        })  # fmt: skip
    return {
        'dose_budget_usv': 60.0,
        'time_s': 120.0,
        'length_m': 100.0,
        'dose_usv': {
            'mean': 40.0, 'of_dwells': 10.0, 'low_95': 36.0, 'high_95': 44.0,
            'probability_within_budget': 0.99,
        },
        'proof': {
            'grid_time_s': 121.0, 'lower_bound_s': 119.0, 'gap_fraction': 0.002,
            'seconds_per_usv': 1.5,
        },
        'fastest': {'time_s': 110.0, 'dose_usv': 80.0},
        'trade_off': [
            {'dose_budget_usv': 30.0, 'time_s': 200.0},
            {'dose_budget_usv': 60.0, 'time_s': 120.0},
            {'dose_budget_usv': 80.0, 'time_s': 110.0},
        ],
        'left_out': [{'evidence': 'flask', 'why': 'it would take a dose budget of 90 uSv'}],
        'stops': stops,
    }  # fmt: skip


def written(folder, document):
    """Write the document of a drive where a run has it."""
    (folder / 'ground').mkdir()
    (folder / 'ground' / 'route.json').write_text(json.dumps(document))
    return folder


def test_drive_is_drawn_and_told(tmp_path):
    """Places in map coordinates, figures, the curve falling, names as text."""
    view = drive_view(written(tmp_path, route()), FRAME)
    assert view.way[1] == pytest.approx((30.0, -40.0), abs=0.01)
    assert view.stands == ((view.way[1], 'drum <1>'),)
    heights = [y for _, y in view.chart]
    assert heights == sorted(heights)
    page = render('drive.html', 'rocsafe_orchestrator.report', drive=view, map=None)
    assert 'drum &lt;1&gt;' in page
    assert 'a dose budget of 90 uSv' in page
    assert '<1>' not in page


@pytest.mark.parametrize('content', ['{', '{}', '[]', '{"stops": []}'])
def test_damaged_route_is_not_fatal(tmp_path, content):
    """A report without this section is better than none."""
    (tmp_path / 'ground').mkdir()
    (tmp_path / 'ground' / 'route.json').write_text(content)
    assert drive_view(tmp_path, FRAME) is None


def test_run_without_a_drive_has_no_section(tmp_path):
    """As before there were ground vehicles."""
    assert drive_view(tmp_path, FRAME) is None
    assert drive_view(written(tmp_path, route()), None) is None
