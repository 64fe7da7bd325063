# SPDX-License-Identifier: Apache-2.0
"""The report of a run: one HTML file that needs nothing else, no network and no server."""

import hashlib
from collections.abc import Sequence
from pathlib import Path

from markupsafe import Markup

from rocsafe_geo.frame import LocalFrame
from rocsafe_orchestrator.products.readings_table import COLUMNS
from rocsafe_orchestrator.products.run_record import MissionSample, RunRecord
from rocsafe_orchestrator.products.summary import RunSummary
from rocsafe_orchestrator.report.dose_view import READINGS_BELOW, dose_view
from rocsafe_orchestrator.report.events import events, flights, start_ns
from rocsafe_orchestrator.report.map_data import map_view
from rocsafe_orchestrator.report.pictures import thumbnails
from rocsafe_orchestrator.report.run_facts import fact_columns, plan_rows
from rocsafe_orchestrator.report.run_texts import gas_reading, height_of, lead, limits, verdict
from rocsafe_orchestrator.report.sections.advice_view import advice_view
from rocsafe_orchestrator.report.sections.drive_view import drive_view
from rocsafe_orchestrator.report.sections.fleet_view import fleet_view
from rocsafe_orchestrator.report.sections.gas_view import gas_view
from rocsafe_orchestrator.report.sections.particle_view import particle_view
from rocsafe_orchestrator.report.sections.people_view import people_rows
from rocsafe_orchestrator.report.sections.source_texts import dose_rate_of, strongest
from rocsafe_orchestrator.report.timeline import deviations
from rocsafe_view import formats
from rocsafe_view.charts import time_axes
from rocsafe_view.pages import render
from rocsafe_view.palette import scale_of, vehicle_colours

_PRODUCTS = ('scenario.yaml', 'plan.json', 'mission.mcap', 'readings.csv',
             'mosaic.tif')  # fmt: skip
_CODE = Markup('<code{}>{}</code>')
# Deviations above the tiles; all of them are among the events.
_MOST_DEVIATIONS = 8


def report_page(record: RunRecord, summary: RunSummary, frame: LocalFrame | None) -> str:
    """Return the report as HTML; without a `frame` it has no map."""
    begin_ns = start_ns(record)
    readings = record.log.readings if record.log else ()
    chart_scale = scale_of(reading.dose_rate_usvh for reading in readings)
    view = map_view(record, frame, begin_ns) if frame else None
    over_region = view.dose_rates_over_region() if view else []
    dose = dose_view(record.path, frame, record.estimates, over_region)
    scale = dose.scale if dose else scale_of(over_region, READINGS_BELOW)
    top = summary.highest_reading
    flown = flights(record, begin_ns)
    told = events(record, summary, begin_ns)
    otherwise = deviations(told, record, summary)
    return render(
        'report.html',
        __package__,
        record=record,
        summary=summary,
        begin_ns=begin_ns,
        lead=lead(summary),
        verdict=verdict(summary),
        deviations=otherwise[:_MOST_DEVIATIONS],
        more_deviations=max(len(otherwise) - _MOST_DEVIATIONS, 0),
        colours=vehicle_colours(record.vehicles),
        map=view,
        scale=scale,
        height_of=height_of,
        gas_reading=gas_reading,
        strongest=strongest(record.estimates),
        dose_rate_of=dose_rate_of,
        highest_colour=scale.colour(top.dose_rate_usvh) if top else None,
        dose=dose,
        gas=gas_view(record.releases, view.zones if view else ()),
        particles=particle_view(record.log.particles if record.log else (), begin_ns),
        advice=advice_view(record.advice),
        drive=drive_view(record, frame),
        fleet=fleet_view(record.log.agents if record.log else (), begin_ns),
        chart_scale=chart_scale,
        flights=flown,
        axes=time_axes(flown) if flown else {},
        events=told,
        plans=plan_rows(record),
        people=people_rows(record.path),
        phases_s=phases_s(record.log.mission if record.log else ()),
        thumbnails=thumbnails(record.photographs),
        facts=fact_columns(record, summary),
        files=_files(record.path),
        columns=[(_CODE.format('', name), meaning) for name, meaning in COLUMNS],
        limits=limits(record, view),
        data=view.script_data() if view else {},
    )


def phases_s(mission: Sequence[MissionSample]) -> dict[str, float]:
    """Return the wall time of each phase in seconds, in order of appearance."""
    spans: dict[str, float] = {}
    before = 0.0
    for sample, after in zip(mission, (*mission[1:], None), strict=False):
        end = after.wall_time_s if after else sample.wall_time_s
        if not sample.phase.is_over:
            spans[sample.phase.name] = spans.get(sample.phase.name, 0.0) + end - before
        before = end
    return spans


def _files(folder: Path) -> list[tuple[str, str, Markup]]:
    """Return name, size and hash of the files that the report was made from."""
    paths = [folder / name for name in _PRODUCTS if (folder / name).is_file()]
    return [
        (path.name, formats.size(path.stat().st_size), _CODE.format(_HASH_CLASS, _sha256(path)))
        for path in paths
    ]


_HASH_CLASS = Markup(' class="hash"')


def _sha256(path: Path) -> str:
    with path.open('rb') as stream:
        digest = hashlib.sha256()
        while block := stream.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()
