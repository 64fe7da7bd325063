# SPDX-License-Identifier: Apache-2.0
"""`rocsafe plan`: what becomes of its arguments."""

import json
from pathlib import Path

import numpy as np
import pytest
from test.planner.terrains import write_terrain

from rocsafe_orchestrator.cli import main
from rocsafe_orchestrator.errors import EXIT_COMPLETE, EXIT_FAILED, EXIT_USAGE
from rocsafe_orchestrator.planning_commands import plan_command
from rocsafe_orchestrator.planning_commands.plan_tables import separation_remark
from rocsafe_planner.errors import PlannerError
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.survey_options import (
    AirspaceOptions,
    CoverageOptions,
    Effort,
    SeparationOptions,
)

CORNERS = ([-9.07, 53.28], [-9.069, 53.28], [-9.069, 53.281])
OPTIONS = (
    '--method strips --budget 3 --height 50 --home 53.2805 -9.071 --objective energy '
    '--grid rotated --max-viewpoints 900 --overlap 0.5 --front-overlap 0.7 '
    '--spacing-rule linear --clearance 4 '
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
def asked(monkeypatch: pytest.MonkeyPatch) -> list[SurveyRequest]:
    """Return what the planner is asked; it refuses everything."""
    requests: list[SurveyRequest] = []

    def refuse(request: SurveyRequest) -> None:
        requests.append(request)
        raise PlannerError('enough')

    monkeypatch.setattr(plan_command, 'checked_plan', refuse)
    return requests


def test_a_region_file_is_one_plan(fields: Path, asked: list[SurveyRequest]) -> None:
    """Each of its polygons is a region; the fleet starts at the first corner."""
    assert main(['plan', str(fields), '--drones', '2']) == EXIT_FAILED
    (request,) = asked
    first, second = (region.area for region in request.regions)
    assert (first.name, second.name) == ('two-fields', 'two-fields 2')
    assert first.boundary[0].longitude_deg == -9.07
    assert second.boundary[0].longitude_deg == -9.068
    assert [vehicle.name for vehicle in request.vehicles] == ['rav1', 'rav2']
    assert request.vehicles[0].home.longitude_deg == -9.07


def test_every_option_reaches_the_planner(
    fields: Path, asked: list[SurveyRequest], tmp_path: Path
) -> None:
    """What the command line says replaces the defaults; a zone may have several polygons."""
    terrain = tmp_path / 'dem.tif'
    write_terrain(terrain, np.zeros((50, 50)))
    words = OPTIONS.replace('dem.tif', str(terrain)).split()
    assert main(['plan', str(fields), *words, '--exclude', str(fields)]) == EXIT_FAILED
    (request,) = asked
    assert request.coverage == CoverageOptions(
        height_agl_m=50.0,
        grid='rotated',
        max_viewpoints=900,
        overlap_fraction=0.5,
        front_overlap_fraction=0.7,
        spacing_rule='linear',
    )
    assert request.airspace == AirspaceOptions(
        clearance_m=4.0, terrain_clearance_m=6.0, wind_mps=(1.0, -2.0)
    )
    assert request.separation == SeparationOptions(distance_m=10.0, by='layers')
    assert request.effort == Effort(method='strips', objective='energy', budget_s=3.0, seed=5)
    assert request.terrain is not None
    assert len(request.exclusions) == 2
    vehicle = request.vehicles[2]
    assert (vehicle.home.latitude_deg, vehicle.home.altitude_m) == (53.2805, 0.0)
    assert vehicle.endurance_s == pytest.approx(540.0)
    assert (vehicle.cruise_speed_mps, vehicle.hover_s, vehicle.battery_swap_s) == (7.0, 0.0, 90.0)
    assert vehicle.is_open


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


@pytest.mark.slow
def test_a_plan_is_checked_and_gone_on_with(
    fields: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`rocsafe check` passes the plan as written and names what was changed in it."""
    out = tmp_path / 'out'
    words = ['--method', 'strips', '--drones', '2', '--out', str(out)]
    assert main(['plan', str(fields), *words]) == EXIT_COMPLETE
    path = out / 'two fields' / 'plan.json'
    assert main(['check', str(path)]) == EXIT_COMPLETE
    assert 'the plan has no fault' in capsys.readouterr().out
    assert main(['replan', str(path), '--visited', '0-5', '--lost', 'rav2']) == EXIT_COMPLETE
    assert 'rav2' not in capsys.readouterr().out
    document = json.loads(path.read_text())
    document['covered_area_m2'] *= 0.5
    path.write_text(json.dumps(document))
    assert main(['check', str(path)]) == EXIT_FAILED
    assert 'covered_area_m2 is' in capsys.readouterr().err


@pytest.mark.slow
def test_a_plan_over_terrain_needs_its_file(
    fields: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the same heights it is checked; without, or with others, it is refused."""
    ridge, other = tmp_path / 'ridge.tif', tmp_path / 'other.tif'
    slope = np.linspace(0.0, 30.0, 200) * np.ones((200, 1))
    write_terrain(ridge, slope)
    write_terrain(other, 2.0 * slope)
    words = ['--method', 'strips', '--terrain', str(ridge), '--out', str(tmp_path)]
    assert main(['plan', str(fields), *words]) == EXIT_COMPLETE
    path = str(tmp_path / 'two fields' / 'plan.json')
    assert main(['check', path, '--terrain', str(ridge)]) == EXIT_COMPLETE
    assert main(['check', path]) == EXIT_USAGE
    assert 'must be given that file' in capsys.readouterr().err
    assert main(['check', path, '--terrain', str(other)]) == EXIT_USAGE
    assert 'has other heights' in capsys.readouterr().err
