# SPDX-License-Identifier: Apache-2.0
"""Table and summary of a run hold what was recorded, with units and without repeats."""

import csv
import json
import math
import shutil

import pytest

from rocsafe_orchestrator.products.readings_table import COLUMNS
from rocsafe_orchestrator.products.run_reading import read_run
from rocsafe_orchestrator.products.run_record import Reading, VehicleSample
from rocsafe_orchestrator.products.summary import (
    flight_ns,
    highest_reading,
    integrated_dose_usv,
    summarise,
    utc_text,
    viewpoints_of,
)
from rocsafe_orchestrator.report.run_texts import lead
from rocsafe_orchestrator.write_products import write_products

pytestmark = pytest.mark.slow

SECOND = 1_000_000_000
SIGMA_USVPS = 25.0


@pytest.fixture(scope='module')
def finished(flown_run, tmp_path_factory):
    """A run with its products, and its summary."""
    copy = tmp_path_factory.mktemp('finished') / flown_run.name
    shutil.copytree(flown_run, copy)
    return copy, write_products(copy)


@pytest.fixture(scope='module')
def rows(finished):
    """The rows of readings.csv."""
    with (finished[0] / 'readings.csv').open(encoding='utf-8', newline='') as stream:
        return list(csv.DictReader(stream))


def reading(seconds, dose_rate_usvh, vehicle='rav1'):
    """A reading at a time."""
    return Reading(
        round(seconds * SECOND), vehicle, 53.0, -9.0, 98.0, dose_rate_usvh, 0.0, 0, math.nan, ''
    )


def sample(seconds, state, plan_id='', planned=0, visited=0):
    """A vehicle's state at a time."""
    return VehicleSample(
        time_ns=seconds * SECOND, state=state, plan_id=plan_id, viewpoint_count=planned,
        viewpoints_visited=visited, shots_taken=0, battery_fraction=1.0,
        distance_flown_m=0.0, text='',
    )  # fmt: skip


def test_viewpoints_of_all_plans_are_counted():
    """A second round adds its viewpoints; a plan that was replaced, only those visited."""
    samples = [sample(0, 1), sample(5, 4, 'first', 9, 3), sample(9, 4, 'first', 9, 4)]
    assert viewpoints_of(samples, None) == (4, 9)
    samples += [sample(12, 4, 'second', 8, 0), sample(20, 8, 'second', 8, 7)]
    assert viewpoints_of(samples, None) == (11, 12)


def test_vehicle_without_a_plan_visited_nothing():
    """Nothing is known of a vehicle that was never heard."""
    assert viewpoints_of([sample(0, 1)], None) == (0, None)
    assert viewpoints_of([], None) == (None, None)


def test_table_has_the_documented_columns(rows):
    """Each column is documented with its unit."""
    assert list(rows[0]) == [name for name, _ in COLUMNS]


def test_table_is_sorted_and_holds_each_reading_once(rows, finished):
    """By time, then vehicle."""
    keys = [(int(row['time_ns']), row['vehicle']) for row in rows]
    assert keys == sorted(set(keys))
    assert len(keys) == finished[1].reading_count


def test_positions_of_the_table_are_about_the_origin(rows):
    """The highest dose rate was measured above the source: up is the height flown."""
    high = max(rows, key=lambda row: float(row['dose_rate_usvh']))
    assert float(high['up_m']) == pytest.approx(32.0, abs=0.01)
    # The source stands 1 m above the ground: sigma / d^2 with d >= 31 m.
    assert float(high['dose_rate_usvh']) <= SIGMA_USVPS * 3600.0 / 31.0**2


def test_unknown_numbers_are_empty(rows):
    """NaN is no number for a spreadsheet."""
    assert {row['live_time_s'] for row in rows} == {''}


def test_dose_rates_keep_every_digit(rows, finished):
    """The highest of the table is the highest of the summary, exactly."""
    highest = finished[1].highest_reading
    assert max(float(row['dose_rate_usvh']) for row in rows) == highest.dose_rate_usvh


def test_summary_file_is_json_without_nan(finished):
    """Strict readers can read it, and it says what the summary says."""

    def refuse(constant):
        raise ValueError(constant)

    text = (finished[0] / 'summary.json').read_text(encoding='utf-8')
    plain = json.loads(text, parse_constant=refuse)
    assert plain['outcome'] == 'complete'
    assert plain['images_stored'] == plain['images_expected'] == finished[1].images_stored
    assert plain['processes_restarted'] == {'rav2': 1}
    assert plain['plan']['gap_fraction'] == pytest.approx(0.23)


def test_flown_time_is_near_the_planned_one(finished):
    """The synthetic plan is one per cent shorter than the flight."""
    for vehicle in finished[1].vehicles:
        assert vehicle.flown_duration_s == pytest.approx(vehicle.planned_duration_s, rel=0.03)


def test_products_can_be_made_again(finished):
    """The recording is finished already; table, summary and figures come out the same."""
    path, summary = finished
    before = (path / 'readings.csv').read_bytes()
    assert write_products(path) == summary
    assert (path / 'readings.csv').read_bytes() == before


def test_vehicles_without_cameras_lack_no_photographs(flown_run, tmp_path):
    """The reader is told once that there was no camera, not of each viewpoint."""
    copy = tmp_path / flown_run.name
    shutil.copytree(flown_run, copy, ignore=shutil.ignore_patterns('images', 'mosaic*'))
    scenario = copy / 'scenario.yaml'
    scenario.write_text(scenario.read_text() + 'camera: {backend: none}\n')
    record = read_run(copy)
    assert [line for line in record.missing if 'photo' in line] == [
        'no photographs and no map: no vehicle has a camera'
    ]
    summary = summarise(record)
    assert summary.images_expected is None
    assert 'photograph' not in lead(summary)


def test_dose_is_the_area_under_the_readings():
    """An hour at 2 uSv/h, then an hour down to 0: 3 uSv."""
    readings = [reading(0, 2.0), reading(3600, 2.0), reading(7200, 0.0)]
    assert integrated_dose_usv(readings) == pytest.approx(3.0, rel=1e-12)
    assert integrated_dose_usv(readings[:1]) is None


def test_first_of_equal_highest_readings_counts():
    """Who was first decides."""
    top = highest_reading([reading(1, 5.0, 'rav2'), reading(2, 5.0), reading(3, 1.0)])
    assert (top.vehicle, top.time) == ('rav2', '1970-01-01T00:00:01.000Z')
    assert highest_reading([]) is None


def test_flight_lasts_from_take_off_to_touch_down():
    """On the ground before and after; without a landing until the last word."""
    flown = [sample(0, 1), sample(5, 3), sample(9, 4), sample(20, 8), sample(30, 8)]
    assert flight_ns(flown) == (5 * SECOND, 20 * SECOND)
    assert flight_ns(flown[:3]) == (5 * SECOND, 9 * SECOND)
    assert flight_ns(flown[:1]) is None


def test_times_are_utc_with_milliseconds():
    """Known answer: 2025-06-01 10:00 UTC."""
    assert utc_text(1_748_772_000_120_000_000) == '2025-06-01T10:00:00.120Z'


def test_what_is_no_directory_is_refused(tmp_path):
    """The error names the path."""
    with pytest.raises(ValueError, match='nowhere is no run directory'):
        write_products(tmp_path / 'nowhere')
