# SPDX-License-Identifier: Apache-2.0
"""The sections of the report that are words and facts."""

from collections.abc import Mapping

import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_orchestrator.products.run_record import Photograph, RunRecord
from rocsafe_orchestrator.products.summary import RunSummary
from rocsafe_orchestrator.report import formats
from rocsafe_orchestrator.report.charts import line_sample
from rocsafe_orchestrator.report.events import start_ns
from rocsafe_orchestrator.report.map_data import MapData
from rocsafe_orchestrator.report.map_facts import map_facts
from rocsafe_orchestrator.report.markup import Content, Markup, element, join
from rocsafe_orchestrator.report.run_facts import (
    estimate_facts,
    field_facts,
    run_facts,
    survey_facts,
)
from rocsafe_orchestrator.report.tables import facts
from rocsafe_scenario.scenario import Scenario

OUTCOMES = {
    'complete': ('✓', 'Complete'),
    'failed': ('✕', 'Failed'),
    'cancelled': ('◼', 'Cancelled'),
    'unknown': ('?', 'Not finished'),
}
LIMITS = (
    'Not for dosimetry, and no basis for a decision on anybody’s exposure.',
    (
        'Dose rates follow the field model of the scenario alone: no background, no shielding and '
        'no counting noise unless the model has them. They were measured in flight, not at the '
        'ground.'
    ),
    (
        'True sources are marked as the scenario has them. Estimated ones follow from the '
        'readings and the law of the dose rate alone.'
    ),
    (
        'Coverage counts ground inside at least one planned footprint, on flat ground and with a '
        'level camera.'
    ),
    (
        'The lower bound holds for these viewpoints, vehicles and the planner’s model of time; it '
        'says nothing about other viewpoints.'
    ),
    'Positions are WGS84, altitudes above the ellipsoid, not above the sea.',
)


def header(record: RunRecord, summary: RunSummary) -> Markup:
    """Return the head of the page: what it is about, how it ended, and one sentence."""
    sign, word = OUTCOMES.get(summary.outcome, OUTCOMES['unknown'])
    badge = element(
        'p',
        element('span', sign, aria_hidden='true', class_='badge-sign'),
        word,
        class_=f'badge badge-{summary.outcome}',
    )
    begin_ns = start_ns(record)
    time = formats.moment(begin_ns) if begin_ns else ''
    return element(
        'header',
        element(
            'div',
            element('p', 'ROCSAFE', element('span', 'mission report'), class_='brand'),
            element('button', 'Dark', type='button', id='theme', class_='theme script-only'),
            class_='topline',
        ),
        element('div', element('h1', summary.description or summary.scenario), badge,
                class_='title-row'),
        element('p', lead(summary), class_='lead'),
        element('p', summary.outcome_text, class_='reason') if summary.outcome_text else None,
        element('p', *_stamps(summary, time), class_='stamps'),
    )  # fmt: skip


def lead(summary: RunSummary) -> str:
    """Return the run in one or two sentences, of what is known."""
    count = len(summary.vehicles)
    text = f'{count} vehicle{"s" if count != 1 else ""}'
    if summary.mission_duration_s is not None:
        text += f' flew {formats.duration(summary.mission_duration_s)}'
    if summary.plan:
        text += f' over a region of {formats.area(summary.plan.region_area_m2)}'
    stored = formats.whole(summary.images_stored)
    if summary.images_expected is not None:
        stored += f' of {formats.whole(summary.images_expected)}'
    text += f'{" and" if summary.mission_duration_s else ""} stored {stored} photographs.'
    top = summary.highest_reading
    if top is not None:
        place = formats.latitude_longitude(top.latitude_deg, top.longitude_deg)
        dose_rate = formats.spaced(formats.dose_rate(top.dose_rate_usvh))
        text += f' The highest dose rate in flight was {dose_rate}, at {place}.'
    return text


def missing(summary: RunSummary) -> Markup | None:
    """Return what the run lacks, None if nothing."""
    if not summary.missing:
        return None
    items = (element('li', line) for line in summary.missing)
    return element(
        'section',
        element('h2', 'Not in this report'),
        element('ul', items),
        class_='card warning',
    )


def card(title: str, *content: Markup | None) -> Markup:
    """Return a section with a heading."""
    return element('section', element('h2', title), *content, class_='card')


def vehicle_key(colours: Mapping[str, str]) -> Markup:
    """Return the lines that stand for the vehicles in the charts."""
    items = (
        element('li', line_sample(colour, place), name)
        for place, (name, colour) in enumerate(colours.items())
    )
    return element('ul', items, class_='key')


def wall_time(bar: Markup | None) -> Markup | None:
    """Return the bar of phases under its heading."""
    if bar is None:
        return None
    return join((element('h3', 'Phases, on the clock on the wall', class_='chart-title'), bar))


def gallery(record: RunRecord, pictures: Mapping[str, str], zero_ns: int) -> Markup:
    """Return a contact sheet; each picture can be selected on the map."""

    def shot(photograph: Photograph) -> Markup:
        time = formats.clock(max((photograph.time_ns - zero_ns) / NS_PER_S, 0.0))
        text = f'{photograph.shot_id}, viewpoint {photograph.viewpoint_id}, {time}'
        return element(
            'button',
            element('img', src=pictures[photograph.shot_id], alt=text, loading='lazy'),
            element('span', photograph.shot_id, element('time', time)),
            type='button',
            data_shot=photograph.shot_id,
        )

    shown = [photograph for photograph in record.photographs if photograph.shot_id in pictures]
    note = (
        f'{len(shown)} of {len(record.photographs)} photographs, small. The files lie in images/.'
    )
    return card(
        'Photographs',
        element('div', map(shot, shown), class_='gallery'),
        element('p', note, class_='note'),
    )


def details(record: RunRecord, summary: RunSummary) -> Markup:
    """Return how the survey was planned, what was simulated, and with which software."""
    columns = (
        ('Survey', facts(survey_facts(record.plan, summary)) if record.plan else None),
        (
            'Radiation, as simulated',
            facts(field_facts(record.scenario)) if record.scenario else None,
        ),
        (
            'Sources, as estimated',
            facts(estimate_facts(record.estimates)) if record.estimates else None,
        ),
        ('Map', facts(found) if (found := map_facts(record.path)) else None),
        ('Run', facts(run_facts(record, summary))),
        ('Software', facts((name, text) for name, text in summary.versions.items())),
    )
    return card(
        'How it was made',
        element(
            'div',
            (element('div', element('h3', name), part) for name, part in columns if part),
            class_='columns',
        ),
    )


def limits(record: RunRecord, data: MapData | None) -> Markup:
    """Return what the figures do not say."""
    notes = [what_is_simulated(record.scenario), *LIMITS]
    if data is not None and data.readings_per_point > 1:
        notes.append(
            f'Map and charts show the highest of every {data.readings_per_point} readings; '
            'readings.csv has them all.'
        )
    if data is not None and record.log and any(t.is_truth for t in record.log.tracks.values()):
        notes.append('Flown tracks are the true positions of the simulation, readings lie where '
                     'the vehicle believed to be.')  # fmt: skip
    return card('Limits', element('ul', (element('li', note) for note in notes), class_='limits'))


def what_is_simulated(scenario: Scenario | None) -> str:
    """Return which flights and readings of the run are not real."""
    if scenario is None or not scenario.linked:
        return 'Simulated flight and simulated detectors.'
    metered = scenario.with_simulated_detector
    groups = {
        'Real flight': scenario.linked,
        'Simulated flight': scenario.simulated,
        'Own detector': [vehicle for vehicle in scenario.vehicles if vehicle not in metered],
        'Simulated detector': metered,
    }
    return ' '.join(
        f'{what}: {", ".join(vehicle.name for vehicle in vehicles)}.'
        for what, vehicles in groups.items()
        if vehicles
    )


def footer(record: RunRecord) -> Markup:
    """Return the last line of the page."""
    return element('footer', element('p', f'ROCSAFE · {record.path.name}'))


def metres_per_degree(frame: LocalFrame) -> list[float]:
    """Return metres in a degree of latitude and of longitude at the origin."""
    origin = frame.origin
    step = 1e-3
    enu = frame.to_enu(
        np.array([origin.latitude_deg + step, origin.latitude_deg]),
        np.array([origin.longitude_deg, origin.longitude_deg + step]),
        np.full(2, origin.altitude_m),
    )
    return [round(float(enu[0, 1]) / step, 3), round(float(enu[1, 0]) / step, 3)]


def _stamps(summary: RunSummary, time: str) -> list[Content]:
    parts = [summary.scenario, time, f'seed {summary.seed}' if summary.seed is not None else '']
    shown: list[Content] = [element('span', part) for part in parts if part]
    return [*shown, element('code', summary.run)]
