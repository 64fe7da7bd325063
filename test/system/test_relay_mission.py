# SPDX-License-Identifier: Apache-2.0
"""A mission with a late take-off, a battery change and landings elsewhere, flown as planned."""

import json
from pathlib import Path
from typing import Any

import pytest

from rocsafe_orchestrator.products.run_reading import read_run
from rocsafe_orchestrator.products.run_record import RunRecord
from rocsafe_orchestrator.products.separation import airborne_spans_ns

from .conftest import Flight

pytestmark = pytest.mark.system

SCENARIO = Path(__file__).with_name('relay.yaml')
STEP_S = 0.2
WAITING = 11
NS = 1e9


@pytest.fixture(scope='module')
def record(complete: Flight) -> RunRecord:
    """Give what the run recorded."""
    return read_run(complete.run.path)


def test_flight_takes_as_long_as_the_plan(complete: Flight) -> None:
    """Times with delay and battery change, lengths, viewpoints: what was planned was flown."""
    plan = json.loads(complete.run.plan.read_text())
    summary = json.loads(complete.run.summary.read_text())
    assert {len(route['sorties']) for route in plan['routes']} == {1, 2}
    assert any(route['delay_s'] for route in plan['routes'])
    for vehicle in summary['vehicles']:
        assert vehicle['flown_duration_s'] == pytest.approx(
            vehicle['planned_duration_s'], abs=2.0 * STEP_S
        )
        assert vehicle['flown_length_m'] == pytest.approx(vehicle['planned_length_m'], rel=1e-3)
        assert vehicle['state'] == 'landed'
    assert summary['mission_duration_s'] == pytest.approx(plan['makespan_s'], abs=2.0 * STEP_S)
    visited = sum(vehicle['viewpoints_visited'] for vehicle in summary['vehicles'])
    assert visited == plan['viewpoint_count']


def test_vehicles_without_cameras_take_no_photographs(complete: Flight) -> None:
    """Nothing is missing: the mission is complete, and says why there is no map."""
    assert complete.info()['outcome'] == 'complete'
    assert complete.images() == {}
    assert read_run(complete.run.path).missing == (
        'no photographs and no map: no vehicle has a camera',
    )


def test_vehicles_keep_apart_as_planned(complete: Flight) -> None:
    """The least distance of the recorded tracks is the plan's, and above what was asked for."""
    summary: dict[str, Any] = json.loads(complete.run.summary.read_text())
    planned = summary['plan']['minimum_separation_m']
    assert planned >= summary['plan']['separation_m'] == 16.0
    assert summary['nearest']['distance_m'] == pytest.approx(planned, abs=0.2)


def test_waits_are_told(complete: Flight, record: RunRecord) -> None:
    """On the ground before a late take-off, and between two flights, the state says why."""
    assert record.log is not None
    plan = json.loads(complete.run.plan.read_text())
    swapping = next(r['vehicle'] for r in plan['routes'] if len(r['sorties']) > 1)
    late = next(r for r in plan['routes'] if r['delay_s'])
    texts = {
        name: {sample.text.partition(':')[0] for sample in samples if sample.state == WAITING}
        for name, samples in record.log.samples.items()
    }
    assert texts[swapping] == {'gets a new battery'}
    assert texts[late['vehicle']] == {'keeps away from others'}
    (_, landed), (again, _) = airborne_spans_ns(record.log.samples[swapping])
    assert (again - landed) / NS == pytest.approx(30.0, abs=2.0 * STEP_S)


def test_vehicles_land_where_their_routes_end(complete: Flight, record: RunRecord) -> None:
    """One at its own end, one below its last viewpoint, one at home."""
    assert record.log is not None
    plan = json.loads(complete.run.plan.read_text())
    last = plan['routes'][2]['viewpoints'][-1]
    ends = {
        'rav1': (53.27970, -9.06330),
        'rav2': (53.28040, -9.06350),
        'rav3': (last['latitude_deg'], last['longitude_deg']),
    }
    for name, (latitude, longitude) in ends.items():
        track = record.log.tracks[name]
        assert track.latitude_deg[-1] == pytest.approx(latitude, abs=1e-6)
        assert track.longitude_deg[-1] == pytest.approx(longitude, abs=1e-6)
        assert track.altitude_m[-1] == pytest.approx(66.0, abs=0.01)


def test_report_tells_of_it(complete: Flight) -> None:
    """The page says who took off late, who changed batteries, and how near they came."""
    page = complete.run.report.read_text(encoding='utf-8')
    for words in ('Take-off delayed', 'Battery changes', 'rav1 1 ×', 'flown (', 'takes off again'):
        assert words in page
