# SPDX-License-Identifier: Apache-2.0
"""What the report says of releases of gas, from what the estimator wrote."""

import dataclasses
import json
from pathlib import Path
from typing import Any

import pytest

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.products import release_estimates
from rocsafe_orchestrator.products.release_estimates import estimate_releases
from rocsafe_orchestrator.products.run_record import RunRecord
from rocsafe_orchestrator.products.summary import summarise
from rocsafe_orchestrator.report.gas_zones import ZONES, read_zones, release_points, true_releases
from rocsafe_orchestrator.report.run_facts import release_facts
from rocsafe_orchestrator.report.run_texts import lead, verdict
from rocsafe_orchestrator.report.sections.gas_view import gas_view
from rocsafe_scenario.scenario_file import read_scenario

CONTENT: dict[str, Any] = {
    'releases': [
        {
            'latitude_deg': 53.28,
            'longitude_deg': -9.06,
            'rate': 61.2,
            'rate_unit': 'g/s',
            'rate_95': [40.0, 90.0],
            'std_m': [3.0, 4.0],
            'region_95_m2': 250.0,
        }
    ],
    'agent': 'ammonia',
    'wind_towards_mps': [-3.0, -4.0],
    'sensor': 'pid_10_6_ev',
    'reading_count': 80,
    'is_enough': True,
    'verdict': '1 release, placed within 9 m (95 %)',
    'highest_reading': {
        'value': 4.42,
        'unit': 'ppm',
        'vehicle': 'rav2',
        'time_ns': 5,
        'latitude_deg': 53.28,
        'longitude_deg': -9.06,
        'height_agl_m': 12.0,
        'is_saturated': True,
    },
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
FRAME = LocalFrame(GeoPosition(53.28, -9.06, 60.0))


def zone_features(level: str, ppm: float, side_deg: float, *, is_empty: bool = False) -> list[Any]:
    """Return both features of a square zone, north-east of the release."""
    north, east = 53.28 + side_deg, -9.06 + side_deg
    ring = [[-9.06, 53.28], [east, 53.28], [east, north], [-9.06, north], [-9.06, 53.28]]
    return [
        {
            'type': 'Feature',
            'properties': {
                'level': level, 'averaging_minutes': 60.0, 'ppm': ppm, 'kind': kind,
                'is_cut_by_the_map': False, 'agent': 'ammonia',
            },
            'geometry': {
                'type': 'MultiPolygon',
                'coordinates': [] if is_empty or kind == 'expected' else [[ring]],
            },
        }
        for kind in ('expected', 'outer bound 95 %')
    ]  # fmt: skip


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
    view = gas_view(estimate_releases(estimated / 'estimator.yaml', estimated), ())
    assert view is not None
    assert not view.leave
    assert view.sentence.replace('\u00a0', ' ') == (
        'ammonia, read by PID 10.6 eV: 1 release, placed within 9 m (95 %) (enough). '
        'Wind as measured in flight, on average: 5.0 m/s from 37°.'
    )
    assert view.figure == FIGURE
    assert view.release_rows[0][3] == '61.2 g/s (40 to 90)'
    assert view.zone_rows[0][:2] == ('AEGL-2 (60 min)', '160 ppm')
    assert view.zone_rows[0][3].startswith('at least')


def test_people_leave_the_outer_bound_of_lasting_harm(estimated: Path) -> None:
    """From the file of the zones; one that nothing reaches is not drawn."""
    found = estimate_releases(estimated / 'estimator.yaml', estimated)
    features = [
        *zone_features('AEGL-3', 1100.0, 0.0, is_empty=True),
        *zone_features('AEGL-2', 160.0, 0.001),
        *zone_features('AEGL-1', 30.0, 0.004),
    ]
    (estimated / ZONES).write_text(json.dumps({'features': features}))
    releases = release_points(found, FRAME)
    assert releases[0].radius_m == pytest.approx(8.9, abs=0.1)
    zones = read_zones(estimated, FRAME, releases)
    assert [zone.level for zone in zones] == ['AEGL-1', 'AEGL-2']
    # 0.001 degrees are 111.3 m to the north and 66.7 m to the east here.
    assert zones[1].reach_m == pytest.approx(129.8, abs=0.5)
    view = gas_view(found, zones)
    assert view is not None
    text = view.leave.replace('\u202f', ' ').replace('\xa0', ' ')
    assert 'outer bound of AEGL-2 (160 ppm over 60 minutes' in text
    assert 'reaches 130 m to the NE of the release' in text


@pytest.mark.parametrize('content', ['', '{}', '{"features": [{}]}', '[]'])
def test_zones_that_cannot_be_read_are_none(estimated: Path, content: str) -> None:
    """The report is made all the same."""
    found = estimate_releases(estimated / 'estimator.yaml', estimated)
    (estimated / ZONES).write_text(content)
    assert read_zones(estimated, FRAME, release_points(found, FRAME)) == ()


def test_without_estimates_there_is_no_section() -> None:
    """The report says elsewhere what is missing."""
    assert gas_view(None, ()) is None


def test_a_file_that_lacks_something_is_told(estimated: Path) -> None:
    """In one line."""
    (estimated / 'release.json').write_text('{"releases": []}')
    with pytest.raises(OrchestratorError, match=r'release\.json cannot be read'):
        estimate_releases(estimated / 'estimator.yaml', estimated)


def test_a_mission_for_gas_is_told_by_its_gas(estimated: Path, tmp_path: Path) -> None:
    """The highest reading, the releases, and that they are not enough, also in the summary."""
    found = estimate_releases(estimated / 'estimator.yaml', estimated)
    record = RunRecord(
        path=tmp_path, info={'outcome': 'complete'}, scenario=None, plan=None, log=None,
        photographs=(), missing=(), releases=found,
    )  # fmt: skip
    summary = summarise(record)
    text = lead(summary).replace('\u00a0', ' ')
    assert 'highest reading of PID 10.6 eV was over 4.42 ppm, measured 12 m above' in text
    assert 'Ammonia: 1 release, placed within 9 m (95 %).' in text
    assert verdict(summary).kind == 'complete'
    doubtful = dataclasses.replace(record, releases=dataclasses.replace(found, is_enough=False))
    assert verdict(summarise(doubtful)).words == 'Flown, evidence not enough yet'
    plain = summary.to_plain()['releases']
    assert plain['highest_reading']['value'] == 4.42
    particles = dataclasses.replace(found.releases[0], rate=3e9, rate_unit='particles/s')
    view = gas_view(dataclasses.replace(found, releases=(particles,)), ())
    assert view is not None
    assert view.release_rows[0][3] == '3e+09 particles/s (40 to 90)'
    assert 'figure' not in plain


def test_true_releases_stand_beside_what_was_found(estimated: Path, tmp_path: Path) -> None:
    """54.5 m north and 23.2 m west of the truth; the wind of the scenario blows to the NNW."""
    scenario = read_scenario(Path(__file__).parents[3] / 'config/scenarios/tanker_ammonia.yaml')
    found = estimate_releases(estimated / 'estimator.yaml', estimated)
    place = dataclasses.replace(
        found.releases[0], latitude_deg=53.34973 + 54.5 / 111_300.0,
        longitude_deg=-6.26001 - 23.2 / 66_580.0,
    )  # fmt: skip
    record = RunRecord(
        path=tmp_path, info={}, scenario=scenario, plan=None, log=None, photographs=(),
        missing=(), releases=dataclasses.replace(found, releases=(place,)),
    )  # fmt: skip
    facts = {name: text.replace('\u00a0', ' ') for name, text in release_facts(record)}
    assert facts['Wind'] == '2.8 m/s from 154° at 10 m; stability B'
    assert facts['tanker'] == (
        'ammonia, 60 g/s; 53.34973° N, 6.26001° W, 1 m above ground; '
        'the nearest found is 59 m away'
    )
    (point,) = true_releases(scenario, LocalFrame(GeoPosition(53.34973, -6.26001, 20.0)))
    assert (point.x, point.y) == pytest.approx((0.0, 0.0), abs=0.01)
    assert not record.has_radiation
    assert release_facts(dataclasses.replace(record, scenario=None)) == []


def test_particles_that_move_for_a_while_are_told_as_such(tmp_path: Path) -> None:
    """A lorry drives from the first minute on, for two."""
    scenario = read_scenario(Path(__file__).parents[3] / 'config/scenarios/particles.yaml')
    record = RunRecord(
        path=tmp_path, info={}, scenario=scenario, plan=None, log=None, photographs=(), missing=(),
    )  # fmt: skip
    facts = {name: text.replace('\u00a0', ' ') for name, text in release_facts(record)}
    assert facts['lorry'].startswith('particles, 5e+09 particles/s; ')
    assert facts['lorry'].endswith(', 1.5 m above ground, from 01:00, for 2 min 00 s, moves')


def test_detectors_with_nothing_to_read_say_nothing() -> None:
    """A scenario without source, background or real detector has no dose rates to show."""
    scenarios = Path(__file__).parents[3] / 'config/scenarios'
    has = {name: read_scenario(scenarios / f'{name}.yaml').has_radiation for name in (
        'tanker_ammonia', 'derailment', 'sitl')}  # fmt: skip
    assert has['derailment']
    assert not has['tanker_ammonia']
