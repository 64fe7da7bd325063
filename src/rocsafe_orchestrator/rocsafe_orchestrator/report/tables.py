# SPDX-License-Identifier: Apache-2.0
"""Figures of the report: tiles, the table of vehicles, wall time, and where all comes from."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from rocsafe_orchestrator.products.readings_table import COLUMNS
from rocsafe_orchestrator.products.run_record import MissionSample, RunRecord
from rocsafe_orchestrator.products.summary import PlanFigures, RunSummary, VehicleFigures
from rocsafe_orchestrator.report import formats
from rocsafe_orchestrator.report.markup import Content, Markup, element, join, style

_PRODUCTS = ('scenario.yaml', 'plan.json', 'mission.mcap', 'readings.csv',
             'mosaic.tif')  # fmt: skip
_HASH_BLOCK = 1 << 20
_VEHICLE_HEADS = (
    ('Vehicle', ''), ('Flight time', 'flown / planned'), ('Distance', 'flown / planned'),
    ('Viewpoints', 'visited / planned'), ('Images', 'stored'), ('Highest', 'dose rate'),
    ('Dose', 'taken'), ('Battery', 'left'), ('State', 'at the end'),
)  # fmt: skip
_LEAST_SPAN_S = 0.05


def tiles(summary: RunSummary, dose_colour: str | None) -> Markup:
    """Return the key figures, the most urgent first."""
    made = [
        _highest_tile(summary, dose_colour),
        _dose_tile(summary),
        *(_plan_tiles(summary.plan) if summary.plan else ()),
        _image_tile(summary),
        _time_tile(summary),
    ]
    return element('ul', made, class_='tiles')


def vehicle_table(summary: RunSummary, colours: Mapping[str, str]) -> Markup:
    """Return a row of figures for each vehicle."""
    longest = max(
        (d for v in summary.vehicles for d in (v.planned_duration_s, v.flown_duration_s) if d),
        default=1.0,
    )
    head = (
        element('th', name, element('small', note) if note else None, scope='col')
        for name, note in _VEHICLE_HEADS
    )
    rows = (_vehicle_row(v, colours[v.name], longest) for v in summary.vehicles)
    table = element(
        'table',
        element('caption', 'Figures of each vehicle', class_='visually-hidden'),
        element('thead', element('tr', head)),
        element('tbody', rows),
    )
    return element('div', table, class_='table-scroll vehicles', tabindex=0, role='region',
                   aria_label='Table of vehicles')  # fmt: skip


def wall_time_bar(mission: Sequence[MissionSample]) -> Markup | None:
    """Return how long the phases took on the clock on the wall."""
    spans = wall_spans_s(mission)
    total = sum(spans.values())
    if total <= 0.0:
        return None
    parts = (
        element(
            'li',
            element('span', name.lower(), class_='phase-name'),
            element('span', formats.duration(span), class_='phase-time'),
            class_=f'phase phase-{name.lower()}',
            style=style({'flex-grow': f'{max(span / total, 0.02):.4f}'}),
        )
        for name, span in spans.items()
        if span >= _LEAST_SPAN_S
    )
    return element('ol', parts, class_='phases', aria_label='Wall time of each phase')


def wall_spans_s(mission: Sequence[MissionSample]) -> dict[str, float]:
    """Return the wall time of each phase in seconds, in order of appearance."""
    spans: dict[str, float] = {}
    before = 0.0
    for sample, after in zip(mission, (*mission[1:], None), strict=False):
        end = after.wall_time_s if after else sample.wall_time_s
        if not sample.phase.is_over:
            spans[sample.phase.name] = spans.get(sample.phase.name, 0.0) + end - before
        before = end
    return spans


def facts(rows: Iterable[tuple[Content, Content]]) -> Markup:
    """Return names and values as a description list; what is empty is left out."""
    shown = ((name, value) for name, value in rows if value not in ('', None))
    pairs = (element('div', element('dt', name), element('dd', value)) for name, value in shown)
    return element('dl', pairs, class_='facts')


def file_table(record: RunRecord) -> Markup:
    """Return the files that the report was made of, each with size and hash."""
    rows = []
    for name in _PRODUCTS:
        path = record.path / name
        if path.is_file():
            rows.append(
                element(
                    'tr',
                    element('th', name, scope='row'),
                    element('td', formats.size(path.stat().st_size)),
                    element('td', element('code', _sha256(path), class_='hash')),
                )
            )
    head = (element('th', name, scope='col') for name in ('File', 'Size', 'SHA-256'))
    table = element('table', element('thead', element('tr', head)), element('tbody', rows))
    columns = element(
        'details',
        element('summary', 'Columns of readings.csv'),
        facts((element('code', name), meaning) for name, meaning in COLUMNS),
    )
    return join((element('div', table, class_='table-scroll files'), columns))


def _tile(
    name: str, value: tuple[str, str], note: Content, *extra: Markup | None, class_: str = ''
) -> Markup:
    figure, unit = value
    return element(
        'li',
        element('div', name, class_='tile-name'),
        element('div', figure, element('span', unit, class_='unit') if unit else None,
                class_='tile-value'),
        *extra,
        element('div', note, class_='tile-note'),
        class_=f'tile {class_}'.strip(),
    )  # fmt: skip


def _highest_tile(summary: RunSummary, colour: str | None) -> Markup:
    top = summary.highest_reading
    if top is None:
        return _tile('Highest dose rate', (formats.UNKNOWN, ''), 'no reading', class_='tile-first')
    place = formats.latitude_longitude(top.latitude_deg, top.longitude_deg)
    strip = element('div', class_='tile-strip', style=style({'background': colour or 'none'}))
    return _tile(
        'Highest dose rate',
        formats.dose_rate(top.dose_rate_usvh),
        f'{top.vehicle}, {place}',
        strip,
        class_='tile-first',
    )


def _dose_tile(summary: RunSummary) -> Markup:
    doses = [(v.integrated_dose_usv, v.name) for v in summary.vehicles
             if v.integrated_dose_usv is not None]  # fmt: skip
    if not doses:
        return _tile('Dose taken', (formats.UNKNOWN, ''), 'no readings')
    most, name = max(doses)
    total = formats.spaced(formats.dose(summary.integrated_dose_usv))
    return _tile('Highest dose taken', formats.dose(most), f'by {name}; all vehicles {total}')


def _plan_tiles(plan: PlanFigures) -> tuple[Markup, ...]:
    share = plan.lower_bound_s / plan.makespan_s if plan.makespan_s > 0 else 1.0
    bound = _meter(share, f'lower bound at {formats.percent(share)} of the makespan')
    return (
        _tile(
            'Coverage planned',
            _split(formats.percent(plan.covered_fraction)),
            f'{formats.area(plan.covered_area_m2)} of {formats.area(plan.region_area_m2)}',
            _meter(plan.covered_fraction, 'share of the region covered'),
        ),
        _tile(
            'Makespan planned',
            (formats.duration(plan.makespan_s), ''),
            f'at most {formats.upper_percent(plan.gap_fraction)} above optimal; '
            f'no plan is shorter than {formats.duration(plan.lower_bound_s)}',
            bound,
        ),
    )


def _image_tile(summary: RunSummary) -> Markup:
    stored, expected = summary.images_stored, summary.images_expected
    if expected is None:
        return _tile('Photographs stored', (formats.whole(stored), ''), 'no plan to compare with')
    note = 'every viewpoint' if stored == expected else f'{expected - stored} missing'
    return _tile(
        'Photographs stored',
        (formats.whole(stored), f'of {formats.whole(expected)}'),
        note,
        _meter(stored / expected if expected else 1.0, 'share of the photographs stored'),
        class_='' if stored >= expected else 'tile-warning',
    )


def _time_tile(summary: RunSummary) -> Markup:
    factor = summary.real_time_factor
    notes = [
        f'{formats.figures(factor)} times as fast as real' if factor else '',
        f'{formats.duration(summary.wall_time_s)} from command to report'
        if summary.wall_time_s
        else '',
    ]
    note = '; '.join(filter(None, notes))
    return _tile('Mission time', (formats.duration(summary.mission_duration_s), ''), note)


def _meter(fraction: float, text: str) -> Markup:
    filled = min(max(fraction, 0.0), 1.0)
    return element(
        'div',
        element('span', style=style({'width': f'{100 * filled:.1f}%'})),
        class_='meter',
        role='img',
        aria_label=text,
    )


def _split(text: str) -> tuple[str, str]:
    figure, _, unit = text.partition(formats.GAP)
    return figure, unit


def _vehicle_row(vehicle: VehicleFigures, colour: str, longest_s: float) -> Markup:
    battery = vehicle.battery_left_fraction
    cells: tuple[Content, ...] = (
        element('span', _time_bars(vehicle, colour, longest_s),
                _of(formats.duration(vehicle.flown_duration_s),
                    formats.duration(vehicle.planned_duration_s))),
        _of(formats.length(vehicle.flown_length_m), formats.length(vehicle.planned_length_m)),
        _of(formats.whole(vehicle.viewpoints_visited), formats.whole(vehicle.viewpoints_planned)),
        formats.whole(vehicle.images_stored),
        formats.spaced(formats.dose_rate(vehicle.highest_dose_rate_usvh)),
        formats.spaced(formats.dose(vehicle.integrated_dose_usv)),
        formats.percent(battery, 0),
        vehicle.state,
    )  # fmt: skip
    dot = element('span', class_='dot', style=style({'background': colour}), aria_hidden='true')
    return element(
        'tr',
        element('th', dot, vehicle.name, scope='row'),
        (
            element('td', cell, data_label=' '.join(head).strip())
            for cell, head in zip(cells, _VEHICLE_HEADS[1:], strict=True)
        ),
    )


def _of(flown: str, planned: str) -> Markup:
    return element('span', flown, element('small', f' / {planned}'))


def _time_bars(vehicle: VehicleFigures, colour: str, longest_s: float) -> Markup:
    flown = (vehicle.flown_duration_s or 0.0) / longest_s
    planned = (vehicle.planned_duration_s or 0.0) / longest_s
    return element(
        'svg',
        element('rect', class_='bar-planned', width=100.0 * planned, height=8, rx=2),
        element('rect', width=100.0 * flown, y=2, height=4, rx=1, fill=colour),
        class_='bars', viewBox='0 0 100 8', preserveAspectRatio='none', aria_hidden='true',
    )  # fmt: skip


def _sha256(path: Path) -> str:
    digest = hashlib.sha256()
    with path.open('rb') as stream:
        while block := stream.read(_HASH_BLOCK):
            digest.update(block)
    return digest.hexdigest()
