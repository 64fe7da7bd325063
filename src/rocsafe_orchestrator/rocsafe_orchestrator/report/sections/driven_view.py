# SPDX-License-Identifier: Apache-2.0
"""What the ground vehicle of a run has driven: its track, and its dose beside the prediction."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any

import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_orchestrator.mission.status import FlightState
from rocsafe_orchestrator.products.run_record import (
    GasSample,
    Photograph,
    Reading,
    RunRecord,
    VehicleSample,
)
from rocsafe_orchestrator.products.summary import integrated_dose_usv
from rocsafe_view import formats
from rocsafe_view.svg import Point

CHART_WIDTH, CHART_HEIGHT = 320.0, 160.0
# A longer gap between two readings does not count, as for the vehicle itself.
LONGEST_GAP_S = 5.0
SECONDS_PER_HOUR = 3600.0

Curve = list[tuple[float, float]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """One of the drives that follow each other when the rest is planned anew.

    Attributes
    ----------
    begin_s, duration_s
        Since the first one began, and up to the next one.
    last
        State of the vehicle when it ended.
    """

    begin_s: float
    duration_s: float
    last: VehicleSample


@dataclass(frozen=True, slots=True, kw_only=True)
class DrivenView:
    """A drive as it went; places are in map coordinates.

    Attributes
    ----------
    way
        Places in driving order, as the vehicle's receiver measured them.
    rows
        Name and value of each figure.
    taken, predicted
        Accumulated dose over time, in the coordinates of the chart.
    scale
        Time and dose at the right upper corner of the chart.
    photographs
        Taken at the evidence.
    """

    way: tuple[Point, ...]
    rows: list[list[str]]
    taken: tuple[Point, ...]
    predicted: tuple[Point, ...]
    scale: tuple[str, str]
    photographs: tuple[Photograph, ...]


def driven_view(
    record: RunRecord, frame: LocalFrame, routes: Sequence[Mapping[str, Any]]
) -> DrivenView | None:
    """Return how `routes` were driven one after the other, None if they were not."""
    driver = record.scenario.driver_name if record.scenario else ''
    samples = record.log.samples.get(driver, ()) if record.log else ()
    span = _span(samples)
    if span is None or record.log is None:
        return None
    readings = [one for one in record.log.readings if one.vehicle == driver]
    taken = _taken(readings, span)
    drives = _drives(samples, span)
    predicted = _predicted(drives, routes)
    end = max(taken[-1][0], predicted[-1][0], 1e-9), max(taken[-1][1], predicted[-1][1], 1e-9)
    return DrivenView(
        way=_way(record, driver, frame, span),
        rows=[
            *_rows(samples, span, drives, taken, predicted),
            *_gas_rows([one for one in record.log.gases if one.vehicle == driver], span),
            ['Dose before and after, where it stood', _dose(_elsewhere_usv(readings, taken))],
        ],
        taken=_drawn(taken, end),
        predicted=_drawn(predicted, end),
        scale=(formats.duration(end[0]), formats.spaced(formats.dose(end[1]))),
        photographs=tuple(one for one in record.photographs if one.vehicle == driver),
    )


def _span(samples: Sequence[VehicleSample]) -> tuple[int, int] | None:
    """Return begin and end of the drive, nanoseconds."""
    under_way = [FlightState(one.state).is_in_air for one in samples]
    if not any(under_way):
        return None
    last = len(under_way) - 1 - under_way[::-1].index(True)
    end = samples[min(last + 1, len(samples) - 1)]
    return samples[under_way.index(True)].time_ns, end.time_ns


def _elsewhere_usv(readings: Sequence[Reading], taken: Curve) -> float:
    """Return the dose of a vehicle before and after its drive."""
    return max((integrated_dose_usv(readings) or 0.0) - taken[-1][1], 0.0)


def _taken(readings: Sequence[Reading], span: tuple[int, int]) -> Curve:
    """Return seconds and accumulated dose of the readings of a drive."""
    own = [
        ((one.time_ns - span[0]) / NS_PER_S, one.dose_rate_usvh)
        for one in readings
        if span[0] <= one.time_ns <= span[1]
    ]
    steps = (
        0.5 * (a[1] + b[1]) * (b[0] - a[0]) / SECONDS_PER_HOUR
        if b[0] - a[0] <= LONGEST_GAP_S
        else 0.0
        for a, b in pairwise(own)
    )
    doses = accumulate(steps, initial=0.0)
    return [(second, dose) for (second, _), dose in zip(own, doses, strict=True)] or [(0.0, 0.0)]


def _drives(samples: Sequence[VehicleSample], span: tuple[int, int]) -> list[Drive]:
    """Return the drives of a span; one that was broken off ends where the next begins."""
    begins: dict[str, int] = {}
    lasts: dict[str, VehicleSample] = {}
    for one in samples:
        if span[0] <= one.time_ns <= span[1] and FlightState(one.state).is_in_air:
            begins.setdefault(one.plan_id, one.time_ns)
        if one.plan_id in begins:
            lasts[one.plan_id] = one
    ends = [*list(begins.values())[1:], span[1]]
    return [
        Drive(
            begin_s=(begin - span[0]) / NS_PER_S,
            duration_s=(end - begin) / NS_PER_S,
            last=lasts[plan_id],
        )
        for (plan_id, begin), end in zip(begins.items(), ends, strict=True)
    ]


def _predicted(drives: Sequence[Drive], routes: Sequence[Mapping[str, Any]]) -> Curve:
    """Return seconds and dose at each stop, of a drive that was broken off up to its end."""
    curve: Curve = []
    before_usv = 0.0
    for number, (drive, route) in enumerate(zip(drives, routes, strict=False)):
        stops = route['stops']
        times_s = [0.0, *accumulate(stop['duration_s'] for stop in stops)]
        doses_usv = [0.0, *accumulate(stop['dose_usv'] for stop in stops)]
        is_last = number == len(drives) - 1
        until_s = math.inf if is_last else drive.duration_s
        end_s = min(until_s, times_s[-1])
        known = [s for s in times_s[1:] if s < end_s] + [end_s]
        for second in known:
            dose = float(np.interp(second, times_s, doses_usv))
            curve.append((drive.begin_s + second, before_usv + dose))
        before_usv = curve[-1][1]
    return curve


def _rows(
    samples: Sequence[VehicleSample],
    span: tuple[int, int],
    drives: Sequence[Drive],
    taken: Curve,
    predicted: Curve,
) -> list[list[str]]:
    own = [one for one in samples if span[0] <= one.time_ns <= span[1]]
    length = own[-1].distance_flown_m - own[0].distance_flown_m
    driven_s = (span[1] - span[0]) / NS_PER_S
    visited = sum(drive.last.viewpoints_visited for drive in drives[:-1])
    last = drives[-1].last
    evidence = visited + last.viewpoints_visited, visited + last.viewpoint_count
    anew = ', '.join(formats.duration(drive.begin_s) for drive in drives[1:])
    texts = list(dict.fromkeys(one.text for one in own if one.text))
    planned_s, planned_usv = predicted[-1]
    lengths = f'{formats.length(length)} in {formats.duration(driven_s)}'
    return [
        ['Driven', f'{lengths}, planned {formats.duration(planned_s)}'],
        ['Dose by its own readings', f'{_dose(taken[-1][1])}, predicted {_dose(planned_usv)}'],
        ['Evidence taken', f'{evidence[0]} of {evidence[1]}'],
        *([['Planned anew after', anew]] if anew else []),
        *([['On the way', '; '.join(texts)]] if texts else []),
    ]


def _gas_rows(gases: Sequence[GasSample], span: tuple[int, int]) -> list[list[str]]:
    """Return the highest reading of each gas sensor of the vehicle while it drove."""
    highest: dict[str, GasSample] = {}
    for one in gases:
        if span[0] <= one.time_ns <= span[1]:
            known = highest.get(one.sensor)
            if known is None or one.raw > known.raw:
                highest[one.sensor] = one
    return [
        [f'Highest reading, {sensor.replace("_", " ")}', _gas(one)]
        for sensor, one in sorted(highest.items())
    ]


def _gas(one: GasSample) -> str:
    unit = formats.gas_unit(one.unit)
    if one.raw < one.limit:
        return f'below its limit of {one.limit:.3g} {unit}'
    return f'{"at least " if one.saturated else ""}{one.raw:.3g} {unit}'


def _way(
    record: RunRecord, driver: str, frame: LocalFrame, span: tuple[int, int]
) -> tuple[Point, ...]:
    track = record.log.tracks.get(driver) if record.log else None
    if track is None:
        return ()
    is_own = (track.time_ns >= span[0]) & (track.time_ns <= span[1])
    enu = frame.to_enu(
        track.latitude_deg[is_own],
        track.longitude_deg[is_own],
        np.full(int(is_own.sum()), math.nan),
    )
    return tuple((float(east), -float(north)) for east, north, _ in enu)


def _drawn(curve: Curve, end: tuple[float, float]) -> tuple[Point, ...]:
    return tuple(
        (CHART_WIDTH * second / end[0], CHART_HEIGHT * (1.0 - dose / end[1]))
        for second, dose in curve
    )


def _dose(value_usv: float) -> str:
    return formats.spaced(formats.dose(value_usv))
