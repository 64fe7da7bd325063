# SPDX-License-Identifier: Apache-2.0
"""The report shows the drive that was planned on a run, and none where there is none."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_orchestrator.products.run_record import (
    FlightLog,
    GasSample,
    Reading,
    RecordingFacts,
    RunRecord,
    Track,
    VehicleSample,
)
from rocsafe_orchestrator.products.summary import summarise
from rocsafe_orchestrator.report.run_texts import lead
from rocsafe_orchestrator.report.sections.drive_view import drive_view
from rocsafe_scenario.scenario_file import read_scenario
from rocsafe_view.pages import render

SCENARIO = Path(__file__).parents[3] / 'config' / 'scenarios' / 'evidence.yaml'
FRAME = LocalFrame(GeoPosition(53.28, -9.06, 66.0))
PLACES = ((0.0, 0.0, ''), (30.0, 40.0, 'drum <1>'), (0.0, 0.0, ''))


def route():
    """Return the document of a drive out and back."""
    stops = []
    for east, north, evidence in PLACES:
        place = FRAME.position_of([east, north, 0.0])
        stops.append({
            'latitude_deg': place.latitude_deg, 'longitude_deg': place.longitude_deg,
            'evidence': evidence, 'duration_s': 50.0, 'dose_usv': 20.0,
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


def record_of(folder, **parts):
    """Return a run without anything but what is given."""
    nothing = {'scenario': None, 'plan': None, 'log': None, 'photographs': (), 'missing': ()}
    return RunRecord(path=folder, info={}, **{**nothing, **parts})


def written(folder, document, **parts):
    """Return a run that has the document of a drive."""
    (folder / 'ground').mkdir()
    (folder / 'ground' / 'route.json').write_text(json.dumps(document))
    return record_of(folder, **parts)


def test_drive_is_drawn_and_told(tmp_path):
    """Places in map coordinates, figures, the curve falling, names as text."""
    view = drive_view(written(tmp_path, route()), FRAME)
    (way,) = view.ways
    assert way[1] == pytest.approx((30.0, -40.0), abs=0.01)
    assert view.stands == ((way[1], 'drum <1>'),)
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
    assert drive_view(record_of(tmp_path), FRAME) is None


def test_run_without_a_drive_has_no_section(tmp_path):
    """As before there were ground vehicles."""
    assert drive_view(record_of(tmp_path), FRAME) is None
    assert drive_view(written(tmp_path, route()), None) is None


def log_of_a_drive():
    """Return the log of a vehicle that stands 10 s, drives 100 s at 720 uSv/h, and has arrived."""
    second = 1_000_000_000
    states = [(0, 1), (10, 4), (60, 4), (110, 8), (120, 8)]
    samples = tuple(
        VehicleSample(
            time_ns=time * second, state=state, plan_id='drive-1', viewpoint_count=1,
            viewpoints_visited=int(time > 50), shots_taken=0, battery_fraction=0.9,
            distance_flown_m=float(max(0, min(time, 110) - 10)), text='',
        )
        for time, state in states
    )  # fmt: skip
    readings = tuple(
        Reading(time * second, 'rgv1', 53.28, -9.06, 67.0, 720.0, 0.0, 0, 0.0, 'paper')
        for time in range(121)
    )
    times = np.arange(0, 121) * second
    track = Track(
        time_ns=times, latitude_deg=np.full(121, 53.28), longitude_deg=np.full(121, -9.06),
        altitude_m=np.full(121, 67.0), is_truth=False,
    )  # fmt: skip
    gases = tuple(
        GasSample(
            time_ns=time * second, vehicle=vehicle, sensor=sensor, unit='ppm', raw=raw, limit=0.5
        )
        for time, vehicle, sensor, raw in (
            (5, 'rgv1', 'pid_10_6_ev', 99.0),
            (20, 'rgv1', 'pid_10_6_ev', 3.25),
            (30, 'rgv1', 'pid_10_6_ev', 1.0),
            (20, 'rgv1', 'metal_oxide', 0.2),
            (20, 'rav1', 'pid_10_6_ev', 50.0),
        )
    )
    return FlightLog(
        facts=RecordingFacts(message_count=1, start_ns=0), gases=gases,
        readings=readings, samples={'rgv1': samples}, tracks={'rgv1': track},
    )  # fmt: skip


def test_what_was_driven_stands_beside_the_prediction(tmp_path):
    """Only the readings of the drive count, not those of the wait before."""
    scenario = read_scenario(SCENARIO)
    view = drive_view(written(tmp_path, route(), scenario=scenario, log=log_of_a_drive()), FRAME)
    rows = dict(view.driven.rows)
    assert rows['Evidence taken'] == '1 of 1'
    # 720 uSv/h for 100 s are 20 uSv; the three stops were predicted with 20 uSv each.
    assert rows['Dose by its own readings'].startswith('20')
    assert 'predicted 60' in rows['Dose by its own readings']
    assert rows['Driven'].startswith('100')
    assert rows['Dose before and after, where it stood'].startswith('4.00')
    # The highest of each of its own gas sensors, while it drove.
    assert rows['Highest reading, pid 10 6 ev'] == '3.25 ppm'
    assert rows['Highest reading, metal oxide'] == 'below its limit of 0.5 ppm'
    assert view.driven.taken[-1] == pytest.approx((320.0 * 100.0 / 150.0, 160.0 * 2.0 / 3.0))
    assert view.driven.predicted[-1] == pytest.approx((320.0, 0.0))
    assert len(view.driven.way) == 101


def test_drive_that_was_planned_anew_is_compared_with_both_plans(tmp_path):
    """The first plan counts up to where it was broken off, then the second, from there."""
    log = log_of_a_drive()
    (samples,) = log.samples.values()
    later = [replace(one, plan_id='drive-2') for one in samples if one.time_ns >= 60_000_000_000]
    broken = replace(log, samples={'rgv1': (*samples[:2], *later)})
    record = written(tmp_path, route(), scenario=read_scenario(SCENARIO), log=broken)
    (tmp_path / 'ground' / 'again-1').mkdir()
    second = {**route(), 'left_out': []}
    (tmp_path / 'ground' / 'again-1' / 'route.json').write_text(json.dumps(second))
    view = drive_view(record, FRAME)
    rows = dict(view.driven.rows)
    # The first was driven for 50 of its 150 s, 20 of its 60 uSv; the second takes 60 in 150 s.
    assert rows['Driven'].endswith('planned 3\xa0min\xa020\xa0s')
    assert 'predicted 80' in rows['Dose by its own readings']
    assert rows['Evidence taken'] == '1 of 1'
    assert rows['Planned anew after'].startswith('50')
    assert len(view.ways) == 2
    assert len(view.stands) == 1
    assert view.left_out == []


def test_a_ground_vehicle_is_not_counted_among_those_that_flew(tmp_path):
    """It is told how far it drove; its flight time and state are those of a drive."""
    summary = summarise(
        record_of(tmp_path, scenario=read_scenario(SCENARIO), log=log_of_a_drive())
    )
    assert lead(summary).startswith('3 vehicles flew up to')
    assert 'rgv1 drove 100' in lead(summary)
    assert [one.name for one in summary.vehicles if one.is_ground_vehicle] == ['rgv1']


def test_drive_that_was_only_planned_has_no_track(tmp_path):
    """Also where the run knows a ground vehicle that never left."""
    record = written(tmp_path, route(), scenario=read_scenario(SCENARIO))
    assert drive_view(record, FRAME).driven is None
