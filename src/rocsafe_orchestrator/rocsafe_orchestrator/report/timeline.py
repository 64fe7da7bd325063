# SPDX-License-Identifier: Apache-2.0
"""Events of a mission: holds, takeovers, alarms, plans, decisions.

The same events make the timeline of the report and its list of deviations from the plan.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from rocsafe_geo.time_units import NS_PER_S
from rocsafe_orchestrator.mission.status import FlightState
from rocsafe_orchestrator.products.run_record import FlightLog, Notice, RunRecord, VehicleSample
from rocsafe_orchestrator.products.summary import RunSummary
from rocsafe_orchestrator.products.viewpoint_balance import places_of
from rocsafe_view import formats

# Kinds of decisions of every mission, which other parts of the report show.
ROUTINE = frozenset({'phase', 'order'})
_ENDS = frozenset({FlightState.LOST, FlightState.CRASHED})
HOLD = 'hold in the air'
LOSS = 'loss'


@dataclass(frozen=True, slots=True, order=True)
class Event:
    """Something that happened `time_s` seconds after the first take-off.

    `is_deviation`: the mission went otherwise than planned.
    """

    time_s: float
    text: str
    is_deviation: bool = False


def recorded_events(record: RunRecord, zero_ns: int) -> Iterator[Event]:
    """Yield the events of vehicles, operators and nodes, unordered."""
    if record.log is None:
        return
    yield from _of_states(record.log, zero_ns, record.driver)
    yield from _of_alarms(record.log, zero_ns)
    yield from _of_notices(record.log.notices, zero_ns)
    yield from _of_plans(record, zero_ns)


def deviations(events: Sequence[Event], record: RunRecord, summary: RunSummary) -> tuple[str, ...]:
    """Return one line for each deviation from the plan, the earliest first.

    Losses and restarts that no node told, as in recordings of earlier versions, come first.
    """
    told = {notice.kind for notice in (record.log.notices if record.log else ())}
    lost = {} if LOSS in told else summary.lost_vehicles
    restarts = {} if 'restart' in told else summary.processes_restarted
    return (
        *(f'{name} is lost: {why}' for name, why in lost.items()),
        *(f'process {name} was restarted {count} ×' for name, count in restarts.items()),
        *(f'{formats.clock(event.time_s)} {event.text}' for event in events if event.is_deviation),
    )


def seconds(time_ns: int, zero_ns: int) -> float:
    """Return a time since the first take-off; what was before the vehicles were heard is at 0."""
    return max(time_ns - zero_ns, 0) / NS_PER_S if time_ns else 0.0


def _of_states(log: FlightLog, zero_ns: int, driver: str = '') -> Iterator[Event]:
    """Yield the changes of state, those of several vehicles within a second as one."""
    together: dict[tuple[int, str, bool], list[tuple[float, str]]] = {}
    decided_ns = {
        name: notice.time_ns
        for notice in log.notices
        if notice.kind == LOSS
        for name in notice.vehicles
    }
    for name, samples in log.samples.items():
        for before, after in pairwise(samples):
            at_s = seconds(after.time_ns, zero_ns)
            # A decision tells the loss with its reason: the end that it acts on is not told again.
            is_decided = after.time_ns <= decided_ns.get(name, -1)
            for said, is_deviation in _changes(before, after, is_decided=is_decided):
                text = said.replace(HOLD, 'stop') if name == driver else said
                key = (int(at_s), text, is_deviation)
                together.setdefault(key, []).append((at_s, name))
    for (_, text, is_deviation), found in together.items():
        names = formats.sentence_list(list(dict.fromkeys(name for _, name in found)))
        yield Event(min(found)[0], f'{names}: {text}', is_deviation=is_deviation)


def _changes(
    before: VehicleSample, after: VehicleSample, *, is_decided: bool
) -> Iterator[tuple[str, bool]]:
    """Yield what changed in words, and whether it is a deviation from the plan."""
    if after.taken_by != before.taken_by:
        text = f'taken by the {after.taken_by}' if after.taken_by else 'given back'
        yield _with_reason(text, after.text), True
    if after.state == before.state:
        return
    if after.state == FlightState.HOLDING:
        yield _with_reason(HOLD, after.text), True
    elif before.state == FlightState.HOLDING:
        yield 'end of the hold', False
    if after.state in _ENDS and not is_decided:
        what = 'lost' if after.state == FlightState.LOST else 'crashed'
        yield _with_reason(what, after.text), True


def _of_alarms(log: FlightLog, zero_ns: int) -> Iterator[Event]:
    for alarm in log.alarms:
        show = formats.dose if alarm.is_dose else formats.dose_rate
        level = formats.spaced(show(alarm.threshold_usv))
        value = formats.spaced(show(alarm.value_usv))
        verb = 'reaches' if alarm.is_reached else 'comes down from'
        text = f'{alarm.vehicle} {verb} {level}, {alarm.name} (read {value})'
        turns_back = alarm.turns_back and alarm.is_reached
        yield Event(seconds(alarm.time_ns, zero_ns), text, is_deviation=turns_back)


def _of_notices(notices: Sequence[Notice], zero_ns: int) -> Iterator[Event]:
    for notice in notices:
        if notice.severity == 0 and notice.kind in ROUTINE:
            continue
        who = '' if notice.by in notice.vehicles or not notice.by else f'{notice.by}: '
        whom = f'{formats.sentence_list(list(notice.vehicles))}: ' if notice.vehicles else ''
        text = _with_reason(f'{who}{whom}{notice.text}', notice.reason)
        yield Event(seconds(notice.time_ns, zero_ns), text, is_deviation=notice.severity > 0)


def _of_plans(record: RunRecord, zero_ns: int) -> Iterator[Event]:
    samples = record.log.samples if record.log else {}
    for number, plan in enumerate(record.further, 1):
        before = record.plans[:number]
        begun = [
            sample.time_ns
            for own in samples.values()
            for sample in own
            if sample.plan_id == plan.plan_id
        ]
        names = [route.vehicle.name for route in plan.routes if route.viewpoints]
        count = f'{plan.viewpoint_count} viewpoint{"" if plan.viewpoint_count == 1 else "s"}'
        is_rest = bool(places_of(plan) & places_of(*before))
        rest = 'the rest' if is_rest else 'another round'
        text = f'plan {plan.plan_id[:8]} for {rest}: {count} for {formats.sentence_list(names)}'
        if begun:
            yield Event(seconds(min(begun), zero_ns), text, is_deviation=is_rest)


def _with_reason(text: str, reason: str) -> str:
    return f'{text}: {reason}' if reason else text
