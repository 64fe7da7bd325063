# SPDX-License-Identifier: Apache-2.0
"""The dose rate at 1 m: two maps on one scale, cordons, stay times and the sources found."""

import base64
import io
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import rasterio
from PIL import Image
from rasterio.enums import Resampling
from rasterio.errors import RasterioError

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_orchestrator.products.source_estimates import SourceEstimate, SourceEstimates
from rocsafe_orchestrator.report import formats
from rocsafe_orchestrator.report.map_view import legend
from rocsafe_orchestrator.report.markup import Content, Markup, element, join, number
from rocsafe_orchestrator.report.palette import DoseScale, ramp_colour, scale_of
from rocsafe_orchestrator.report.pictures import map_xy
from rocsafe_orchestrator.report.source_texts import dose_rate_of, half_axes_of, place_of

DOSE_MAP, CORDONS = 'dose_map.tif', 'cordons.geojson'
MEAN_BAND, STD_BAND, UPPER_BAND = 1, 2, 3
MOST_PX = 480
LEVELS = 128
STAY_KEYS = ('public_year_1_msv', 'worker_year_20_msv')
SOURCE_HEADS = ('Source', 'Place', '95 % ellipse', 'Dose rate at 1 m, with 95 %', 'Evidence')
CORDON_HEADS = (
    'Level', 'Meant for', 'Area, mean', 'Area, upper 95 %', 'Stay at its edge: 1 mSv', '20 mSv'
)  # fmt: skip

# From background to a metre beside a strong source: with fewer, all but its place has one colour.
DECADES = 7.0


@dataclass(frozen=True, slots=True, kw_only=True)
class DosePicture:
    """A dose map ready to be drawn: its pixels, and its bounds east and south of the origin, m."""

    mean_usvh: FloatArray
    upper_usvh: FloatArray
    bounds: tuple[float, float, float, float]


def dose_section(
    folder: Path, frame: LocalFrame | None, estimates: SourceEstimates | None
) -> Markup | None:
    """Return what the readings say of the ground, None if there is no map of it."""
    if frame is None or estimates is None:
        return None
    picture = _picture(folder / DOSE_MAP, frame)
    cordons = _cordons(folder / CORDONS)
    if picture is None:
        return None
    values = [*picture.mean_usvh.ravel().tolist(), float(picture.upper_usvh.max())]
    scale = scale_of(values, decades=DECADES)
    west, top, east, bottom = picture.bounds
    extent_m = max(east - west, bottom - top)
    marks = [_source_mark(source, frame, extent_m) for source in estimates.sources]
    maps = (
        _map(title, usvh, scale, picture.bounds, [*_lines(cordons, kind, frame), *marks])
        for title, usvh, kind in (
            ('Mean', picture.mean_usvh, 'mean'),
            ('Upper 95 %', picture.upper_usvh, 'upper_95'),
        )
    )
    return element(
        'section',
        element('h2', 'Dose rate at 1 m above the ground'),
        element('p', _sentence(estimates), class_='note'),
        element('div', maps, class_='dose-maps'),
        element('div', legend(scale), class_='map-foot'),
        _table('Sources found', SOURCE_HEADS, _source_rows(estimates.sources)),
        _table('Cordons', CORDON_HEADS, _cordon_rows(cordons)),
        element('p', 'Lines are cordons at the levels of the table. Stay times are those at a '
                'cordon’s edge; within it they are shorter.', class_='note'),
        class_='card',
    )  # fmt: skip


def _sentence(found: SourceEstimates) -> str:
    count = len(found.sources)
    words = (
        f'{count or "No"} source{"" if count == 1 else "s"} from {found.reading_count} readings'
    )
    background = formats.spaced(formats.dose_rate(found.background_usvh))
    chances = found.source_count_probability
    chance = chances[count] if count < len(chances) else 0.0
    text = f'{words}, with a probability of {100.0 * chance:.3g} %; background {background}.'
    enough = 'enough' if found.is_enough else 'not enough yet'
    if found.verdict:
        text = f'{text} The evidence is {enough}: {found.verdict}.'
    return f'{text} Not as assumed: {"; ".join(found.doubts)}.' if found.doubts else text


def _picture(path: Path, frame: LocalFrame) -> DosePicture | None:
    """Return the map at `path`, whose axes point east and north."""
    try:
        with rasterio.open(path) as raster:
            shrink = max(1.0, max(raster.width, raster.height) / MOST_PX)
            shape = (max(1, round(raster.height / shrink)), max(1, round(raster.width / shrink)))
            mean, upper = (
                raster.read(band, out_shape=shape, resampling=Resampling.average)
                for band in (MEAN_BAND, UPPER_BAND)
            )
            west, south, east, north = raster.bounds
            corners = np.array([[west, north], [east, south]])
            (left, top), (right, bottom) = map_xy(corners, raster.crs, frame).tolist()
    except (RasterioError, OSError, ValueError, IndexError):
        return None
    return DosePicture(
        mean_usvh=np.asarray(mean, np.float64),
        upper_usvh=np.asarray(upper, np.float64),
        bounds=(left, top, right, bottom),
    )


def _cordons(path: Path) -> list[dict[str, Any]]:
    try:
        features: list[dict[str, Any]] = json.loads(path.read_text(encoding='utf-8'))['features']
    except (OSError, ValueError, KeyError):
        return []
    return features


def _map(
    title: str,
    values: FloatArray,
    scale: DoseScale,
    bounds: tuple[float, float, float, float],
    marks: Iterable[Markup],
) -> Markup:
    west, top, east, bottom = bounds
    width, height = east - west, bottom - top
    image = element(
        'image', href=_data_uri(values, scale), x=west, y=top, width=width, height=height,
        preserveAspectRatio='none',
    )  # fmt: skip
    drawing = element(
        'svg',
        image,
        marks,
        _scale_bar(bounds),
        viewBox=' '.join(number(v) for v in (west, top, width, height)),
        role='img',
        aria_label=f'Map of the dose rate at 1 m, {title}, '
        f'{formats.length(width)} by {formats.length(height)}',
    )
    return element('figure', drawing, element('figcaption', title), class_='dose-map')


def _data_uri(values: FloatArray, scale: DoseScale) -> str:
    """Return the colours of `values` as a PNG with a palette."""
    span = np.log(scale.high_usvh / scale.low_usvh)
    shares = np.log(np.maximum(values, scale.low_usvh) / scale.low_usvh) / span
    indices = np.clip(np.round(shares * (LEVELS - 1)), 0, LEVELS - 1).astype(np.uint8)
    image = Image.fromarray(indices, 'P')
    colours = (ramp_colour(level / (LEVELS - 1)) for level in range(LEVELS))
    image.putpalette([int(c[i : i + 2], 16) for c in colours for i in (1, 3, 5)])
    stream = io.BytesIO()
    image.save(stream, 'PNG', optimize=True)
    return 'data:image/png;base64,' + base64.b64encode(stream.getvalue()).decode()


def _lines(cordons: Sequence[dict[str, Any]], confidence: str, frame: LocalFrame) -> list[Markup]:
    """Return the edges of the cordons of one kind, each with its level."""
    return [
        element(
            'path',
            element('title', f'{cordon["properties"]["level_usv_h"]:g} µSv/h'),
            d=''.join(_path(ring, frame) for part in _parts(cordon) for ring in part),
            class_='cordon',
        )
        for cordon in cordons
        if cordon['properties']['confidence'] == confidence
    ]


def _parts(cordon: dict[str, Any]) -> list[list[list[list[float]]]]:
    parts: list[list[list[list[float]]]] = cordon['geometry']['coordinates']
    return parts


def _path(ring: list[list[float]], frame: LocalFrame) -> str:
    longitudes, latitudes = np.array(ring).T
    enu = frame.to_enu(latitudes, longitudes, np.full(len(ring), frame.origin.altitude_m))
    corners = (f'{number(x, 1)} {number(-y, 1)}' for x, y in enu[:, :2].tolist())
    return f'M{"L".join(corners)}Z'


def _source_mark(source: SourceEstimate, frame: LocalFrame, extent_m: float) -> Markup:
    east, north, _ = frame.enu_of(source.position).tolist()
    long_m, short_m = source.ellipse_95_m
    ellipse = element(
        'ellipse', rx=long_m, ry=short_m, class_='source-ellipse',
        transform=f'rotate({number(-source.ellipse_angle_from_east_deg)})',
    )  # fmt: skip
    arm = 0.02 * extent_m
    cross = f'M{number(-arm)} 0H{number(arm)}M0 {number(-arm)}V{number(arm)}'
    return element(
        'g',
        ellipse,
        element('path', d=cross, class_='source-cross'),
        transform=f'translate({number(east)} {number(-north)})',
    )


def _scale_bar(bounds: tuple[float, float, float, float]) -> Markup:
    west, _, east, bottom = bounds
    width = east - west
    power = 10.0 ** np.floor(np.log10(width / 4.0))
    length = float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= width / 3.0))
    x, y = west + 0.04 * width, bottom - 0.04 * width
    return element(
        'g',
        element('path', d=f'M{number(x)} {number(y)}h{number(length)}', class_='dose-scale'),
        element('text', f'{length:g} m', x=x, y=y - 0.015 * width, font_size=0.04 * width),
    )


def _table(title: str, heads: Sequence[str], rows: Sequence[Sequence[Content]]) -> Markup | None:
    if not rows:
        return None
    head = (element('th', name, scope='col') for name in heads)
    body = (
        element('tr', element('th', row[0], scope='row'), (element('td', c) for c in row[1:]))
        for row in rows
    )
    table = element('table', element('thead', element('tr', head)), element('tbody', body))
    scroll = element('div', table, class_='table-scroll', tabindex=0, role='region',
                     aria_label=title)  # fmt: skip
    return join((element('h3', title, class_='chart-title'), scroll))


def _source_rows(sources: Sequence[SourceEstimate]) -> list[list[Content]]:
    return [
        [
            f'{index}',
            place_of(source),
            half_axes_of(source),
            dose_rate_of(source),
            f'{source.log_likelihood_ratio:.4g} nats',
        ]
        for index, source in enumerate(sources, 1)
    ]


def _cordon_rows(cordons: Sequence[dict[str, Any]]) -> list[list[Content]]:
    """Return a row a level, the highest first."""
    levels: dict[float, dict[str, dict[str, Any]]] = {}
    for cordon in cordons:
        facts = cordon['properties']
        levels.setdefault(facts['level_usv_h'], {})[facts['confidence']] = facts
    rows: list[list[Content]] = []
    for level, by_confidence in sorted(levels.items(), reverse=True):
        any_one = next(iter(by_confidence.values()))
        stays = (any_one['stay_time_h'][key] for key in STAY_KEYS)
        rows.append(
            [
                formats.spaced(formats.dose_rate(level)),
                any_one.get('name', ''),
                *(_area(by_confidence.get(kind)) for kind in ('mean', 'upper_95')),
                *(_hours(stay) for stay in stays),
            ]
        )
    return rows


def _area(facts: dict[str, Any] | None) -> str:
    return formats.area(facts['area_m2']) if facts else 'none'


def _hours(hours: float) -> str:
    if hours < 1.0:
        return f'{formats.figures(60.0 * hours)}{formats.GAP}min'
    if hours < 72.0:
        return f'{formats.figures(hours)}{formats.GAP}h'
    return f'{formats.figures(hours / 24.0)}{formats.GAP}d'
