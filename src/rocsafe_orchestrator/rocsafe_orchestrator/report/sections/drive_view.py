# SPDX-License-Identifier: Apache-2.0
"""The drive of a ground vehicle that was planned on a run: ``ground/route.json``."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rocsafe_geo.frame import LocalFrame
from rocsafe_orchestrator.products.run_record import RunRecord
from rocsafe_orchestrator.report.sections.driven_view import (
    CHART_HEIGHT,
    CHART_WIDTH,
    DrivenView,
    driven_view,
)
from rocsafe_view import formats
from rocsafe_view.svg import Point

ROUTE, AGAIN = 'ground/route.json', 'ground/again-{}/route.json'
# Shown around the way, as a share of its extent, and at least so many metres.
MARGIN, LEAST_MARGIN_M = 0.15, 8.0


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveView:
    """What the template ``drive.html`` draws; places are in map coordinates.

    Attributes
    ----------
    sentence
        The drive in words.
    box
        Left, top, width, height of what is shown.
    ways
        Places in driving order, of each plan.
    stands
        Where evidence is taken, with its name.
    rows
        Name and value of each figure.
    left_out
        Points that are not visited, and why.
    curve
        Dose budget and time of each trade-off, and the same in the coordinates of the chart.
    driven
        How it was driven; None: it was only planned.
    """

    sentence: str
    box: tuple[float, float, float, float]
    ways: tuple[tuple[Point, ...], ...]
    stands: tuple[tuple[Point, str], ...]
    rows: list[list[str]]
    left_out: list[list[str]]
    curve: tuple[tuple[str, str], ...]
    chart: tuple[Point, ...]
    driven: DrivenView | None


def drive_view(record: RunRecord, frame: LocalFrame | None) -> DriveView | None:
    """Return the drive that was planned on a run, None if there is none or no `frame`."""
    if frame is None:
        return None
    try:
        routes = _routes(record.path)
        return _view(routes, frame, driven_view(record, frame, routes))
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _routes(folder: Path) -> list[Any]:
    """Return the first plan of a drive, and those by which its rest was planned anew."""
    paths = [folder / ROUTE]
    while (again := folder / AGAIN.format(len(paths))).exists():
        paths.append(again)
    return [json.loads(path.read_text(encoding='utf-8')) for path in paths]


def _view(
    routes: Sequence[Mapping[str, Any]], frame: LocalFrame, driven: DrivenView | None
) -> DriveView:
    route = routes[0]
    ways = tuple(_way(one, frame) for one in routes)
    shown = (*(place for way in ways for place in way), *(driven.way if driven else ()))
    stands = {
        stop['evidence']: place
        for one, way in zip(routes, ways, strict=True)
        for stop, place in zip(one['stops'], way, strict=True)
        if stop['evidence']
    }
    curve = [(one['dose_budget_usv'], one['time_s']) for one in route['trade_off']]
    return DriveView(
        sentence=_sentence(route),
        box=_box(shown),
        ways=ways,
        stands=tuple((place, name) for name, place in stands.items()),
        rows=[
            *_rows(route),
            *(['Planned anew', _sentence(one)] for one in routes[1:]),
        ],
        left_out=[[one['evidence'], one['why']] for one in routes[-1]['left_out']],
        curve=tuple((_dose(dose), formats.duration(time)) for dose, time in curve),
        chart=_chart(curve),
        driven=driven,
    )


def _way(route: Mapping[str, Any], frame: LocalFrame) -> tuple[Point, ...]:
    stops = route['stops']
    enu = frame.to_enu(
        [stop['latitude_deg'] for stop in stops],
        [stop['longitude_deg'] for stop in stops],
        [math.nan] * len(stops),
    )
    return tuple((float(east), -float(north)) for east, north, _ in enu)


def _sentence(route: Mapping[str, Any]) -> str:
    visited = [stop['evidence'] for stop in route['stops'] if stop['evidence']]
    dose = route['dose_usv']
    return (
        f'To {formats.sentence_list(visited)} and back: {formats.length(route["length_m"])} in '
        f'{formats.duration(route["time_s"])}, with {_dose(dose["mean"])} by the estimated field. '
        f'The budget of {_dose(route["dose_budget_usv"])} is kept with a probability of '
        f'{formats.probability(dose["probability_within_budget"])}.'
    )


def _rows(route: Mapping[str, Any]) -> list[list[str]]:
    dose, proof, fastest = route['dose_usv'], route['proof'], route['fastest']
    return [
        ['Dose, 95 of 100', f'{_dose(dose["low_95"])} to {_dose(dose["high_95"])}'],
        ['Of it at the evidence', _dose(dose['of_dwells'])],
        ['Fastest way', f'{formats.duration(fastest["time_s"])}, {_dose(fastest["dose_usv"])}'],
        ['Way over cells, turns not counted', _proof(proof)],
        ['1 µSv more would save about', f'{proof["seconds_per_usv"]:.3g} s'],
        *_age(route.get('oldest_ground_s')),
    ]


def _age(oldest_s: float | None) -> list[list[str]]:
    if oldest_s is None:
        return []
    text = f'{formats.duration(oldest_s)} before the newest photograph at most'
    return [['Ground on the way photographed', text]]


def _proof(proof: Mapping[str, Any]) -> str:
    bound, gap = (
        formats.duration(proof['lower_bound_s']),
        formats.percent(proof['gap_fraction'], 2),
    )
    time = formats.duration(proof['grid_time_s'])
    return f'{time}, at most {gap} above the shortest within the budget ({bound})'


def _dose(value_usv: float) -> str:
    return formats.spaced(formats.dose(value_usv))


def _box(way: Sequence[Point]) -> tuple[float, float, float, float]:
    xs, ys = zip(*way, strict=True)
    margin = max(MARGIN * max(max(xs) - min(xs), max(ys) - min(ys)), LEAST_MARGIN_M)
    width, height = (max(axis) - min(axis) + 2.0 * margin for axis in (xs, ys))
    return min(xs) - margin, min(ys) - margin, width, height


def _chart(curve: Sequence[tuple[float, float]]) -> tuple[Point, ...]:
    """Return the trade-off in a box: dose to the right, logarithmic, time upwards."""
    if len(curve) < 2:
        return ()
    doses = [math.log(max(dose, 1e-12)) for dose, _ in curve]
    times = [time for _, time in curve]
    wide = max(doses[-1] - doses[0], 1e-9)
    high = max(max(times) - min(times), 1e-9)
    return tuple(
        (
            CHART_WIDTH * (dose - doses[0]) / wide,
            CHART_HEIGHT * (1.0 - (time - min(times)) / high),
        )
        for dose, time in zip(doses, times, strict=True)
    )
