# SPDX-License-Identifier: Apache-2.0
"""Events of a run, in order of time."""

from collections.abc import Iterable, Iterator
from itertools import pairwise

from rocsafe_geo.time_units import NS_PER_S
from rocsafe_orchestrator.products.run_record import RunRecord
from rocsafe_orchestrator.products.separation import Span, airborne_spans_ns
from rocsafe_orchestrator.products.summary import RunSummary, flight_ns
from rocsafe_orchestrator.report.timeline import Event, recorded_events, seconds
from rocsafe_view import formats
from rocsafe_view.charts import FlightBar

_MOST_NAMES = 5


def start_ns(record: RunRecord) -> int:
    """Return the first take-off, or the first thing recorded if nobody took off."""
    samples = record.log.samples.values() if record.log else ()
    starts = [flight[0] for flight in map(flight_ns, samples) if flight is not None]
    if starts:
        return min(starts)
    return record.log.facts.start_ns if record.log else 0


def flights(record: RunRecord, zero_ns: int) -> tuple[FlightBar, ...]:
    """Return the flight of each vehicle that took off, in the order of the vehicles."""
    samples = record.log.samples if record.log else {}
    routes = record.plan.routes if record.plan else ()
    planned = {route.vehicle.name: route.duration_s for route in routes}
    found = ((name, airborne_spans_ns(samples.get(name, ()))) for name in record.vehicles)
    shots: dict[str, list[float]] = {}
    for shot in record.photographs:
        shots.setdefault(shot.vehicle, []).append((shot.time_ns - zero_ns) / NS_PER_S)
    return tuple(
        _flight(name, spans, planned.get(name), shots.get(name, ()), zero_ns)
        for name, spans in found
        if spans
    )


def _flight(
    name: str,
    spans: tuple[Span, ...],
    planned_s: float | None,
    shots_s: Iterable[float],
    zero_ns: int,
) -> FlightBar:
    aloft = tuple(
        ((begin - zero_ns) / NS_PER_S, (end - zero_ns) / NS_PER_S) for begin, end in spans
    )
    return FlightBar(
        vehicle=name,
        shots_s=tuple(shots_s),
        start_s=aloft[0][0],
        end_s=aloft[-1][1],
        planned_s=planned_s,
        aloft_s=aloft,
    )


def events(record: RunRecord, summary: RunSummary, zero_ns: int) -> tuple[Event, ...]:
    """Return all events, the earliest first."""
    return tuple(
        sorted(
            (
                *_of_flights(record, zero_ns),
                *_of_mission(record, summary, zero_ns),
                *recorded_events(record, zero_ns),
            )
        )
    )


def _of_flights(record: RunRecord, zero_ns: int) -> Iterator[Event]:
    samples = record.log.samples if record.log else {}
    flown = flights(record, zero_ns)
    for start_s in sorted({flight.start_s for flight in flown}):
        names = [flight.vehicle for flight in flown if flight.start_s == start_s]
        yield Event(start_s, _take_off_text(names, record.driver))
    for flight in flown:
        for (_, landed_s), (again_s, _) in pairwise(flight.aloft_s):
            yield Event(landed_s, f'{flight.vehicle} lands between two flights')
            yield Event(again_s, f'{flight.vehicle} takes off again')
        last = samples[flight.vehicle][-1]
        if last.is_airborne:
            where = 'on its way' if flight.vehicle == record.driver else 'in the air'
            yield Event(flight.end_s, f'{flight.vehicle} is heard for the last time, {where}')
        else:
            shots = f'{last.shots_taken} photographs'
            verb = 'has arrived' if flight.vehicle == record.driver else 'lands'
            yield Event(flight.end_s, f'{flight.vehicle} {verb} with {shots}')


def _take_off_text(names: list[str], driver: str) -> str:
    if len(names) == 1:
        return f'{names[0]} drives off' if names[0] == driver else f'{names[0]} takes off'
    who = formats.sentence_list(names) if len(names) <= _MOST_NAMES else f'{len(names)} vehicles'
    return f'{who} take off'


def _of_mission(record: RunRecord, summary: RunSummary, zero_ns: int) -> Iterator[Event]:
    top = summary.highest_reading
    if top is not None:
        dose_rate = formats.spaced(formats.dose_rate(top.dose_rate_usvh))
        yield Event(
            seconds(top.time_ns, zero_ns),
            f'{top.vehicle} measures the highest dose rate, {dose_rate}',
        )
    if record.photographs:
        last = record.photographs[-1]
        at_s = seconds(last.time_ns, zero_ns)
        yield Event(at_s, f'{last.vehicle} takes the last photograph')
    for sample in record.log.mission if record.log else ():
        if sample.phase.is_over:
            reason = f': {sample.text}' if sample.text else ''
            yield Event(
                sample.mission_time_s,
                f'mission {sample.phase.name.lower()}{reason}',
            )
            return
