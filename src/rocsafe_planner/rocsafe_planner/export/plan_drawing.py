# SPDX-License-Identifier: Apache-2.0
"""A picture of a plan as shapes on a canvas: regions, footprints, exclusions, routes, legend."""

import math
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.scale_bar import bar_length_m
from rocsafe_planner.export.route_colors import EXCLUSION_COLOR, route_color
from rocsafe_planner.plan.flight_path import flight_path, landing_place
from rocsafe_planner.plan.flight_summary import flight_summary
from rocsafe_planner.plan.objective import OBJECTIVE_UNITS, OBJECTIVE_VALUES, objective_gap
from rocsafe_planner.plan.plan import Route, SurveyPlan

Pixels = tuple[tuple[float, float], ...]

WIDTH_PX = 1200
_MARGIN_PX = 40.0
_LINE_PX = 22
_TEXT_PX = 16
_LINE_LETTERS = 130
_MAP_PX = (WIDTH_PX - 2 * _MARGIN_PX, 900.0)
_INK = '#222222'
_REGION_FILL = '#e8ece4'


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """A line, or an area if it has a fill; in pixels, y downwards; an empty colour is none."""

    points: Pixels
    stroke: str = ''
    fill: str = ''
    width: float = 1.0
    opacity: float = 1.0
    is_closed: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Dot:
    """A filled circle."""

    centre: tuple[float, float]
    radius: float
    fill: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Label:
    """A line of text that begins at `place`, on its base line."""

    place: tuple[float, float]
    text: str
    color: str = _INK
    size: int = _TEXT_PX


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawing:
    """Shapes in drawing order, on a white canvas."""

    width_px: int
    height_px: int
    marks: tuple[Shape | Dot | Label, ...]


def plan_drawing(plan: SurveyPlan) -> Drawing:
    """Return the picture of a plan, north up."""
    sheet = _Sheet(plan)
    facts = _facts(plan)
    marks = (*_ground(plan, sheet), *_routes(plan, sheet), *_legend(plan, sheet, facts))
    lines = 2 + len(facts) + len(plan.routes)
    height = int(sheet.bottom_px + _MARGIN_PX + _LINE_PX * lines)
    return Drawing(width_px=WIDTH_PX, height_px=height, marks=marks)


class _Sheet:
    """Places on the ground to pixels."""

    def __init__(self, plan: SurveyPlan) -> None:
        centre = plan.request.regions[0].area.centroid()
        origin = GeoPosition(centre.latitude_deg, centre.longitude_deg, 0.0)
        self._frame = LocalFrame(origin)
        ground = np.vstack([self._plane(ring) for ring in _all_rings(plan)])
        self._low, high = ground.min(axis=0), ground.max(axis=0)
        extent = np.maximum(high - self._low, 1.0)
        self.px_per_m = float(min(np.array(_MAP_PX) / extent))
        self._top = float(high[1])
        self.bottom_px = _MARGIN_PX + float(extent[1]) * self.px_per_m

    def pixels(self, positions: Sequence[GeoPosition]) -> Pixels:
        """Return the pixels (x, y) of positions."""
        east, north = self._plane(positions).T
        x = _MARGIN_PX + (east - self._low[0]) * self.px_per_m
        y = _MARGIN_PX + (self._top - north) * self.px_per_m
        return tuple(zip(x.round(2).tolist(), y.round(2).tolist(), strict=True))

    def _plane(self, positions: Sequence[GeoPosition]) -> FloatArray:
        return self._frame.to_enu(
            [position.latitude_deg for position in positions],
            [position.longitude_deg for position in positions],
            math.nan,
        )[:, :2]


def _all_rings(plan: SurveyPlan) -> Iterator[Sequence[GeoPosition]]:
    for region in plan.request.regions:
        yield region.area.boundary
    for zone in plan.request.exclusions:
        yield zone.boundary
    for route in plan.routes:
        yield [route.vehicle.home, *([route.vehicle.end] if route.vehicle.end else [])]
        for number in range(len(route.sorties)):
            yield [stop.position for stop in flight_path(route, number)]
        for viewpoint in route.viewpoints:
            yield viewpoint.footprint


def _ground(plan: SurveyPlan, sheet: _Sheet) -> Iterator[Shape]:
    for region in plan.request.regions:
        yield from _area(region.area, sheet, stroke=_INK, fill=_REGION_FILL)
    for index, route in enumerate(plan.routes):
        for viewpoint in route.viewpoints:
            yield Shape(
                points=sheet.pixels(viewpoint.footprint),
                stroke=route_color(index),
                fill=route_color(index),
                width=0.5,
                opacity=0.08,
                is_closed=True,
            )
    for zone in plan.request.exclusions:
        yield from _area(zone, sheet, stroke=EXCLUSION_COLOR, fill='#e8b0b0')


def _area(area: SurveyArea, sheet: _Sheet, *, stroke: str, fill: str) -> Iterator[Shape]:
    rings = (area.boundary, *area.holes)
    for ring, inside in zip(rings, (fill, *['#ffffff'] * len(area.holes)), strict=True):
        yield Shape(points=sheet.pixels(ring), stroke=stroke, fill=inside, is_closed=True)


def _routes(plan: SurveyPlan, sheet: _Sheet) -> Iterator[Shape | Dot]:
    for index, route in enumerate(plan.routes):
        color = route_color(index)
        for number in range(len(route.sorties)):
            way = sheet.pixels([stop.position for stop in flight_path(route, number)])
            yield Shape(points=way, stroke=color, width=2.0)
        for place in sheet.pixels([v.position for v in route.viewpoints] or ()):
            yield Dot(centre=place, radius=2.5, fill=color)
        (home,) = sheet.pixels([route.vehicle.home])
        yield Dot(centre=home, radius=7.0, fill=_INK)
        yield Dot(centre=home, radius=5.0, fill=color)
        for place in sheet.pixels(_landings(route)):
            yield Dot(centre=place, radius=7.0, fill=color)
            yield Dot(centre=place, radius=4.0, fill='#ffffff')


def _landings(route: Route) -> list[GeoPosition]:
    """Return where a vehicle lands at last, unless that is its home."""
    if not route.sorties or landing_place(route, len(route.sorties) - 1) == route.vehicle.home:
        return []
    return [flight_path(route, len(route.sorties) - 1)[-1].position]


def _facts(plan: SurveyPlan) -> list[str]:
    """Return lines about the whole plan."""
    name = plan.request.regions[0].area.name or 'survey'
    gap = 100.0 * plan.gap_fraction
    photographs = f'{plan.viewpoint_count} photographs, {100.0 * plan.covered_fraction:.1f} % of'
    is_time = plan.request.effort.objective == 'longest_time'
    claim = f', at most {gap:.1f} % above optimal' if is_time else ' until all have landed'
    proof = f'no plan is shorter than {plan.lower_bound_s:.0f} s ({plan.lower_bound_method})'
    area = f'{plan.region_area_m2 / 1e4:.2f} ha'
    return [
        f'{name}: {photographs} {area}, method {plan.request.effort.method}',
        f'{plan.makespan_s:.0f} s{claim}: {proof}',
        *textwrap.wrap(_promises(plan), _LINE_LETTERS),
    ]


def _legend(plan: SurveyPlan, sheet: _Sheet, facts: list[str]) -> Iterator[Shape | Dot | Label]:
    y = sheet.bottom_px + _MARGIN_PX
    yield from _scale_bar(sheet, y)
    for text in facts:
        yield Label(place=(_MARGIN_PX, y), text=text)
        y += _LINE_PX
    for index, route in enumerate(plan.routes):
        yield Dot(centre=(_MARGIN_PX + 7.0, y - 5.0), radius=6.0, fill=route_color(index))
        above = route.flight_height_m - plan.request.coverage.height_agl_m
        high = f', {above:g} m above the others' if above > 0.0 else ''
        yield Label(place=(_MARGIN_PX + 24.0, y), text=_work(route) + high)
        y += _LINE_PX


def _work(route: Route) -> str:
    """Return a line about the work of a vehicle."""
    if not route.sorties:
        return f'{route.vehicle.name}: stays on the ground'
    flights = f' in {len(route.sorties)} flights' if len(route.sorties) > 1 else ''
    late = f', takes off after {route.delay_s:.0f} s' if route.delay_s else ''
    lands = flight_summary(route, len(route.sorties) - 1).lands
    where = '' if lands == 'home' else f', lands at its {lands}'
    return (
        f'{route.vehicle.name}: {len(route.viewpoints)} photographs, '
        f'{route.length_m:.0f} m, {route.duration_s:.0f} s{flights}{late}{where}'
    )


def _promises(plan: SurveyPlan) -> str:
    """Return lines about the objective, the least separation and the unseen ground."""
    unit = OBJECTIVE_UNITS[plan.request.effort.objective]
    value = OBJECTIVE_VALUES[plan.request.effort.objective](plan)
    gap = objective_gap(plan)
    proof = '' if math.isnan(gap) else f' (at most {100.0 * gap:.1f} % above optimal)'
    parts = [f'objective {plan.request.effort.objective} {value:.0f} {unit}{proof}']
    if math.isfinite(plan.minimum_separation_m):
        parts.append(f'no two vehicles nearer than {plan.minimum_separation_m:.1f} m')
    hole = plan.largest_hole_m2
    parts.append(f'largest hole {hole:.0f} m2' if hole > 0.0 else 'no hole')
    if plan.request.airspace.wind_mps != (0.0, 0.0):
        east, north = plan.request.airspace.wind_mps
        parts.append(f'wind {east:g} m/s east, {north:g} m/s north')
    if plan.request.exclusions:
        count = len(plan.request.exclusions)
        parts.append(f'{count} exclusion{"s" if count > 1 else ""}')
    return ', '.join(parts)


def _scale_bar(sheet: _Sheet, y: float) -> Iterator[Shape | Label]:
    """Yield a bar of 1, 2 or 5 times a power of ten, about a sixth of the picture wide."""
    length = bar_length_m(WIDTH_PX / 6.0 / sheet.px_per_m)
    end = WIDTH_PX - _MARGIN_PX
    begin = end - length * sheet.px_per_m
    yield Shape(points=((begin, y - 5.0), (end, y - 5.0)), stroke=_INK, width=3.0)
    yield Label(place=(begin, y + 14.0), text=f'{length:g} m')
