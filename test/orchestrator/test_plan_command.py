# SPDX-License-Identifier: Apache-2.0
"""`rocsafe plan`: what becomes of its arguments."""

import json
from pathlib import Path
from typing import Any

import pytest

from rocsafe_orchestrator.cli import main
from rocsafe_orchestrator.command_line import plan_command
from rocsafe_orchestrator.command_line.plan_command import planner_request
from rocsafe_orchestrator.command_line.plan_tables import separation_remark
from rocsafe_orchestrator.errors import EXIT_FAILED, EXIT_USAGE, OrchestratorError

CORNERS = ([-9.07, 53.28], [-9.069, 53.28], [-9.069, 53.281])
OPTIONS = (
    '--method strips --budget 3 --height 50 --home 53.2805 -9.071 --objective energy '
    '--grid best --overlap 0.5 --front-overlap 0.7 --spacing-rule linear --clearance 4 '
    '--wind 1 -2 --separation 10 --separation-by layers --terrain dem.tif '
    '--terrain-clearance 6 --seed 5 --speed 7 --hover 0 --endurance 600 --swap 90 --open'
)


@pytest.fixture
def fields(tmp_path: Path) -> Path:
    """Return a region file of two triangles."""
    rings = [[[x + east, y] for x, y in (*CORNERS, CORNERS[0])] for east in (0.0, 0.002)]
    path = tmp_path / 'two fields.geojson'
    path.write_text(json.dumps({'type': 'MultiPolygon', 'coordinates': [[r] for r in rings]}))
    return path


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """Return what the planner is asked, in place of which it is refused."""
    requests: list[dict[str, Any]] = []

    def planned(path: Path, scenario: Any, method: str, folder: Path) -> None:
        requests.append(planner_request(scenario, method, folder))
        raise OrchestratorError(f'{path}: enough')

    monkeypatch.setattr(plan_command, 'planned', planned)
    return requests


def test_a_region_file_is_one_plan(fields: Path, asked: list[dict[str, Any]]) -> None:
    """Each of its polygons is a region; the fleet starts at the first corner."""
    assert main(['plan', str(fields), '--drones', '2']) == EXIT_FAILED
    (request,) = asked
    assert request['region']['name'] == 'two-fields'
    assert request['region']['polygon'][0] == (53.28, -9.07)
    (other,) = request['other_regions']
    assert other['polygon'][0] == (53.28, -9.068)
    assert [v['name'] for v in request['vehicles']] == ['rav1', 'rav2']
    assert request['vehicles'][0]['home'][:2] == [53.28, -9.07]


def test_every_option_reaches_the_planner(fields: Path, asked: list[dict[str, Any]]) -> None:
    """What the command line says replaces the defaults; a zone may have several polygons."""
    assert main(['plan', str(fields), *OPTIONS.split(), '--exclude', str(fields)]) == EXIT_FAILED
    (request,) = asked
    assert {
        'method': 'strips',
        'budget_s': 3.0,
        'height_agl_m': 50.0,
        'objective': 'energy',
        'grid': 'best',
        'overlap_fraction': 0.5,
        'front_overlap_fraction': 0.7,
        'spacing_rule': 'linear',
        'clearance_m': 4.0,
        'wind_mps': (1.0, -2.0),
        'separation_m': 10.0,
        'separation_by': 'layers',
        'terrain_file': 'dem.tif',
        'terrain_clearance_m': 6.0,
        'seed': 5,
    }.items() <= request.items()
    assert len(request['exclusions']) == 2
    vehicle = request['vehicles'][2]
    assert vehicle['home'] == [53.2805, -9.071, 0.0]
    assert vehicle['endurance_s'] == pytest.approx(540.0)
    assert {
        'cruise_speed_mps': 7.0,
        'hover_s': 0.0,
        'battery_swap_s': 90.0,
        'is_open': True,
    }.items() <= vehicle.items()


def test_a_home_off_the_globe_is_one_line(
    fields: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The value and its limit are named."""
    assert main(['plan', str(fields), '--home', '99', '0']) == EXIT_USAGE
    assert capsys.readouterr().err == 'rocsafe: --home: latitude_deg is 99: must be -90 to 90\n'


def test_vehicles_nearer_than_asked_are_told() -> None:
    """Who is in the air already cannot wait on the ground: the table says so."""
    assert separation_remark(2.7, 12.0) == ': NEARER than the 12 m asked for'
    assert not separation_remark(12.0, 12.0)
    assert '--separation' in separation_remark(2.7, 0.0)
