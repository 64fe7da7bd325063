# SPDX-License-Identifier: Apache-2.0
"""The report of a run: one HTML file that needs nothing else, no network and no server."""

import base64
import hashlib
from importlib import resources
from string import Template
from typing import Any

from rocsafe_geo.frame import LocalFrame
from rocsafe_orchestrator.products.run_record import RunRecord
from rocsafe_orchestrator.products.summary import RunSummary
from rocsafe_orchestrator.report import sections
from rocsafe_orchestrator.report.charts import dose_chart, flight_chart, frames
from rocsafe_orchestrator.report.dose_map_view import dose_section
from rocsafe_orchestrator.report.events import event_list, events, flights, start_ns
from rocsafe_orchestrator.report.map_data import MapData, map_data
from rocsafe_orchestrator.report.map_view import map_section, view_boxes
from rocsafe_orchestrator.report.markup import Markup, element, json_block
from rocsafe_orchestrator.report.palette import DoseScale, scale_of, vehicle_colours
from rocsafe_orchestrator.report.pictures import ground_picture, thumbnails
from rocsafe_orchestrator.report.tables import file_table, tiles, vehicle_table, wall_time_bar

MOSAIC = 'mosaic.tif'
# Of the readings over the region, how many the lowest colour may stand for.
_TAIL = 0.02


def report_page(record: RunRecord, summary: RunSummary, frame: LocalFrame | None) -> str:
    """Return the report as HTML; without a `frame` it has no map."""
    page = _Page(record, summary, frame)
    script = _resource('report.js')
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return Template(_resource('template.html')).substitute(
        title=element('title', f'{summary.scenario}: {summary.outcome}, ROCSAFE mission report'),
        script_hash=f'sha256-{digest}',
        css=_resource('report.css'),
        script=script,
        header=sections.header(record, summary),
        body=page.body(),
        data=json_block('report-data', page.payload()),
        footer=sections.footer(record),
    )


class _Page:
    """Everything that several parts of the page share."""

    def __init__(self, record: RunRecord, summary: RunSummary, frame: LocalFrame | None) -> None:
        self._record = record
        self._frame = frame
        self._summary = summary
        self._zero_ns = start_ns(record)
        self._colours = vehicle_colours(record.vehicles)
        readings = record.log.readings if record.log else ()
        self._scale: DoseScale = scale_of(reading.dose_rate_usvh for reading in readings)
        self._map: MapData | None = map_data(record, frame, self._zero_ns) if frame else None
        self._map_scale = _survey_scale(self._map) if self._map else self._scale

    def body(self) -> Markup:
        """Return all sections between header and footer."""
        top = self._summary.highest_reading
        colour = self._map_scale.colour(top.dose_rate_usvh) if top else None
        return element(
            'main',
            sections.missing(self._summary),
            tiles(self._summary, colour),
            self._map_section(),
            dose_section(self._record.path, self._frame, self._record.estimates),
            self._charts(),
            sections.card('Vehicles', vehicle_table(self._summary, self._colours)),
            self._gallery(),
            sections.details(self._record, self._summary),
            sections.card('Files', file_table(self._record)),
            sections.limits(self._record, self._map),
            id='main',
        )

    def payload(self) -> dict[str, Any]:
        """Return what the page's script reads."""
        data = self._map
        if data is None:
            return {}
        origin = data.frame.origin
        order = list(data.vehicles)
        return {
            'vehicles': order,
            'colours': [self._colours[name] for name in order],
            'origin': [origin.latitude_deg, origin.longitude_deg],
            'perDegree': sections.metres_per_degree(data.frame),
            'boxes': {name: [round(v, 2) for v in box] for name, box in view_boxes(data).items()},
            'readings': {
                'x': [round(point.x, 1) for point in data.readings],
                'y': [round(point.y, 1) for point in data.readings],
                't': [round(point.time_s, 1) for point in data.readings],
                'd': [float(f'{point.dose_rate_usvh:.4g}') for point in data.readings],
                'v': [order.index(point.vehicle) for point in data.readings],
            },
            'tracks': {
                name: {
                    't': [round(float(t), 1) for t in track.time_s],
                    'x': [round(float(x), 1) for x in track.x],
                    'y': [round(float(y), 1) for y in track.y],
                }
                for name, track in data.replay.items()
            },
            'highest': _highest_index(data),
            'photos': {
                photo.shot_id: [
                    round(photo.x, 1), round(photo.y, 1), round(photo.time_s, 1),
                    order.index(photo.vehicle), photo.viewpoint_id,
                    ' '.join(f'{x:.1f},{y:.1f}' for x, y in photo.footprint),
                ]
                for photo in data.photos
            },
        }  # fmt: skip

    def _map_section(self) -> Markup | None:
        if self._map is None:
            return None
        picture = ground_picture(self._record.path / MOSAIC, self._map.frame)
        highest = self._summary.highest_reading
        return map_section(self._map, picture, self._map_scale, self._colours, highest)

    def _charts(self) -> Markup | None:
        points = self._map.readings if self._map else ()
        photos = self._map.photos if self._map else ()
        flown = flights(self._record, self._zero_ns)
        if not flown:
            return None
        end_s = max(max(f.end_s, f.start_s + (f.planned_s or 0.0)) for f in flown)
        sizes = frames(end_s).items()
        dose = (
            element('div', dose_chart(points, self._scale, self._colours, frame), class_=name)
            for name, frame in sizes
        )
        bars = (
            element('div', flight_chart(flown, photos, self._colours, frame), class_=name)
            for name, frame in sizes
        )
        happened = events(self._record, self._summary, self._zero_ns)
        mission = self._record.log.mission if self._record.log else ()
        return sections.card(
            'Over time',
            sections.vehicle_key(self._colours),
            element('h3', 'Dose rate, µSv/h', class_='chart-title') if points else None,
            element('div', dose, class_='chart-box') if points else None,
            element('h3', 'Flights', class_='chart-title'),
            element('div', bars, class_='chart-box'),
            element('p', 'Minutes and seconds since the first take-off. Outlines show planned '
                    'durations, marks photographs.', class_='note'),
            element('h3', 'Events', class_='chart-title'),
            event_list(happened),
            sections.wall_time(wall_time_bar(mission)),
        )  # fmt: skip

    def _gallery(self) -> Markup | None:
        pictures = thumbnails(self._record.photographs)
        return sections.gallery(self._record, pictures, self._zero_ns) if pictures else None


def _highest_index(data: MapData) -> int | None:
    if not data.readings:
        return None
    return max(range(len(data.readings)), key=lambda i: data.readings[i].dose_rate_usvh)


def _survey_scale(data: MapData) -> DoseScale:
    """Return colours for what was measured over the region; the ways there may lie below."""
    west, north, width, height = view_boxes(data)['region']
    inside = [
        point.dose_rate_usvh
        for point in data.readings
        if west <= point.x <= west + width and north <= point.y <= north + height
    ]
    return scale_of(inside or (point.dose_rate_usvh for point in data.readings), _TAIL)


def _resource(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding='utf-8')
