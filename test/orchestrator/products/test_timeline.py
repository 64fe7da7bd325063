# SPDX-License-Identifier: Apache-2.0
"""The report tells what an inquiry asks, and does not say complete where it is not."""

import dataclasses
import json
import shutil
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_orchestrator.mission.status import FlightState
from rocsafe_orchestrator.products.run_reading import read_run
from rocsafe_orchestrator.products.run_record import (
    Alarm,
    FlightLog,
    Notice,
    Photograph,
    RecordingFacts,
    RunRecord,
    VehicleSample,
)
from rocsafe_orchestrator.products.source_estimates import SourceEstimates
from rocsafe_orchestrator.products.summary import summarise
from rocsafe_orchestrator.products.viewpoint_balance import ViewpointBalance, viewpoint_balance
from rocsafe_orchestrator.recording.finalising import finalise
from rocsafe_orchestrator.report.run_texts import lead, verdict
from rocsafe_orchestrator.report.timeline import deviations, recorded_events
from rocsafe_planner.plan.plan_reading import read_plan

SECOND = 1_000_000_000
HERE = GeoPosition(53.28, -9.06, 98.0)


def sample(at_s, state, plan_id='first', taken_by='', text=''):
    """Return a state of a vehicle."""
    return VehicleSample(
        time_ns=at_s * SECOND, state=int(state), plan_id=plan_id, viewpoint_count=0,
        viewpoints_visited=0, shots_taken=0, battery_fraction=1.0, distance_flown_m=0.0,
        text=text, taken_by=taken_by,
    )  # fmt: skip


def recorded(**log):
    """Return a run with a recording alone."""
    facts = RecordingFacts(message_count=0, start_ns=0)
    return RunRecord(
        path=Path('run'), info={}, scenario=None, plan=None, photographs=(), missing=(),
        log=FlightLog(facts=facts, **log),
    )  # fmt: skip


def told(record):
    """Return the events, the earliest first, and the deviations."""
    events = sorted(recorded_events(record, 10 * SECOND))
    return [(e.time_s, e.text) for e in events], deviations(events, record, summarise(record))


def test_holds_takeovers_and_crashes_are_told():
    """Vehicles that hold within a second are told together."""
    flying, holding = FlightState.FLYING, FlightState.HOLDING
    record = recorded(
        samples={
            'rav1': (sample(10, flying), sample(20, holding), sample(30, flying),
                     sample(40, flying, taken_by='pilot', text='mode LOITER'), sample(50, flying)),
            'rav2': (sample(10, flying), sample(20, holding), sample(35, FlightState.CRASHED)),
        }
    )  # fmt: skip
    events, otherwise = told(record)
    assert events == [
        (10.0, 'rav1 and rav2: hold in the air'),
        (20.0, 'rav1: end of the hold'),
        (25.0, 'rav2: crashed'),
        (25.0, 'rav2: end of the hold'),
        (30.0, 'rav1: taken by the pilot: mode LOITER'),
        (40.0, 'rav1: given back'),
    ]
    assert [line.partition(' ')[0] for line in otherwise] == ['00:10', '00:25', '00:30', '00:40']


def test_alarms_and_decisions_are_told():
    """Routine is left out; what turned a vehicle back or failed is a deviation."""
    alarm = Alarm(
        time_ns=20 * SECOND, vehicle='rav1', is_reached=True, is_dose=False,
        threshold_usv=100.0, value_usv=112.0, name='inner cordon', turns_back=True,
    )  # fmt: skip
    notices = (
        Notice(time_ns=0, severity=0, kind='phase', by='orchestrator', vehicles=(), text='flying'),
        Notice(time_ns=30 * SECOND, severity=1, kind='loss', by='orchestrator',
               vehicles=('rav2',), text='lost', reason='battery failed'),
        Notice(time_ns=32 * SECOND, severity=1, kind='restart', by='orchestrator', vehicles=(),
               text='process rav3 was ended by SIGKILL'),
        Notice(time_ns=33 * SECOND, severity=1, kind='failsafe', by='rav3', vehicles=('rav3',),
               text='battery'),
    )  # fmt: skip
    events, otherwise = told(recorded(alarms=(alarm,), notices=notices))
    texts = [text.replace('\u00a0', ' ') for _, text in events]
    assert texts == [
        'rav1 reaches 100 µSv/h, inner cordon (read 112 µSv/h)',
        'orchestrator: rav2: lost: battery failed',
        'orchestrator: process rav3 was ended by SIGKILL',
        'rav3: battery',
    ]
    assert len(otherwise) == 4


def test_a_loss_that_was_decided_on_is_told_once():
    """With the reason of the decision; a crash after it is news."""
    loss = Notice(
        time_ns=30 * SECOND, severity=1, kind='loss', by='orchestrator',
        vehicles=('rav2',), text='lost', reason='battery failed',
    )  # fmt: skip
    states = FlightState.FLYING, FlightState.LOST, FlightState.CRASHED
    record = recorded(
        samples={'rav2': tuple(sample(20 + 10 * n, state) for n, state in enumerate(states))},
        notices=(loss,),
    )
    events, otherwise = told(record)
    assert events == [
        (20.0, 'orchestrator: rav2: lost: battery failed'),
        (30.0, 'rav2: crashed'),
    ]
    assert len(otherwise) == 2


def test_recordings_without_decisions_tell_losses_and_restarts():
    """As run.json has them."""
    record = dataclasses.replace(
        recorded(), info={'lost_vehicles': {'rav2': 'battery'}, 'restarts': {'rav1': 2}}
    )
    _, otherwise = told(record)
    assert otherwise == ('rav2 is lost: battery', 'process rav1 was restarted 2 ×')


@pytest.fixture(scope='module')
def plan(flown_run):
    """The plan of the synthetic run."""
    return read_plan(flown_run / 'plan.json')


def shot(name, viewpoint_id, position=HERE):
    """Return a photograph."""
    return Photograph(
        shot_id=name, vehicle='rav1', viewpoint_id=viewpoint_id, time_ns=0, position=position,
        path=Path(name),
    )  # fmt: skip


def moved(plan, metres):
    """Return a plan whose viewpoints, of the same numbers, are elsewhere."""

    def elsewhere(view):
        return dataclasses.replace(view, position=offset(view.position, metres, 0.0))

    routes = tuple(
        dataclasses.replace(
            route,
            sorties=tuple(
                dataclasses.replace(s, viewpoints=tuple(map(elsewhere, s.viewpoints)))
                for s in route.sorties
            ),
        )
        for route in plan.routes
    )
    return dataclasses.replace(plan, plan_id='second', routes=routes)


def test_a_further_round_does_not_make_more_than_all(plan):
    """83 of 63 cannot be: places of all plans count once, and photographs of one place once."""
    views = [view for route in plan.routes for view in route.viewpoints]
    shots = [shot(f'a{v.id}', v.id, v.position) for v in views]
    again = [shot(f'b{v.id}', v.id, offset(v.position, 0.5, 0.5)) for v in views]
    assert viewpoint_balance([plan], [*shots, *again]).missing == 0
    both = viewpoint_balance([plan, moved(plan, 300.0)], [*shots, *again])
    assert (both.planned, both.photographed) == (2 * len(views), len(views))
    rest = viewpoint_balance([plan, dataclasses.replace(plan, plan_id='rest')], shots[:-2])
    assert (rest.planned, rest.missing) == (len(views), 2)


@pytest.mark.slow
@given(st.lists(st.tuples(st.integers(0, 40), st.floats(-200, 200), st.floats(-200, 200))))
def test_never_more_photographed_than_planned(plan, shots):
    """Whatever the photographs say of themselves."""
    photographs = [
        shot(str(k), number, offset(HERE, east, north))
        for k, (number, east, north) in enumerate(shots)
    ]
    balance = viewpoint_balance([plan, moved(plan, 5.0)], photographs)
    assert 0 <= balance.missing <= balance.planned


def test_balance_refuses_more_than_all():
    """The value itself cannot say -20 missing."""
    with pytest.raises(ValueError, match='photographed is 83: must be 0 to planned, 63'):
        ViewpointBalance(planned=63, photographed=83)


def enough(is_enough):
    """Return estimates with a verdict."""
    return SourceEstimates(
        sources=(), source_count_probability=(0.6, 0.4), background_usvh=0.1, reading_count=10,
        is_enough=is_enough, verdict='1 source or none',
    )  # fmt: skip


def test_complete_is_said_only_of_what_is(flown_run, tmp_path):
    """Neither with photographs missing nor with evidence that is not enough."""
    run = tmp_path / flown_run.name
    shutil.copytree(flown_run, run)
    record = dataclasses.replace(read_run(run), estimates=enough(True))
    assert verdict(summarise(record)).words == 'Complete'
    doubtful = dataclasses.replace(record, estimates=enough(False))
    assert verdict(summarise(doubtful)).words == 'Flown, evidence not enough yet'
    partial = dataclasses.replace(record, photographs=record.photographs[1:])
    assert verdict(summarise(partial)).words == 'Flown, photographs missing'
    info = {**record.info, 'outcome': 'failed'}
    assert verdict(summarise(dataclasses.replace(record, info=info))).kind == 'failed'


def test_headline_names_the_height(flown_run, tmp_path):
    """The synthetic vehicles fly 32 m above the ground, which the scenario says is level."""
    run = tmp_path / flown_run.name
    shutil.copytree(flown_run, run)
    finalise(run)
    summary = summarise(read_run(run))
    assert 'measured 32\u00a0m above the ground' in lead(summary)
    unknown = dataclasses.replace(summary.highest_reading, height_agl_m=None)
    assert 'at an altitude of' in lead(dataclasses.replace(summary, highest_reading=unknown))


def test_further_plans_come_in_the_order_flown(flown_run, plan, tmp_path):
    """A plan that replaced the first is drawn beside it, with its viewpoints counted once."""
    run = tmp_path / flown_run.name
    shutil.copytree(flown_run, run)
    (run / 'further-beef').mkdir()
    document = json.loads((run / 'plan.json').read_text(encoding='utf-8'))
    (run / 'further-beef/plan.json').write_text(json.dumps({**document, 'plan_id': 'beef'}))
    record = read_run(run)
    assert [p.plan_id for p in record.plans] == ['0a1b2c', 'beef']
    assert summarise(record).images_expected == plan.viewpoint_count
