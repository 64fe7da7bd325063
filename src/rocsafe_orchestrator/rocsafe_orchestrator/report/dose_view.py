# SPDX-License-Identifier: Apache-2.0
"""The dose rate at 1 m above the ground: two maps on one scale, cordons and the sources found."""

import base64
import io
import json
from collections.abc import Sequence
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
from rocsafe_orchestrator.report.map_data import estimate_points
from rocsafe_orchestrator.report.pictures import map_xy
from rocsafe_orchestrator.report.source_texts import dose_rate_of, half_axes_of, place_of
from rocsafe_view import formats
from rocsafe_view.map_view import Box, EstimatePoint
from rocsafe_view.palette import DoseScale, ramp_colour, scale_of
from rocsafe_view.svg import polygons

DOSE_MAP, CORDONS = 'dose_map.tif', 'cordons.geojson'
MEAN_BAND, STD_BAND, UPPER_BAND = 1, 2, 3
MOST_PX = 480
LEVELS = 128
STAY_KEYS = ('public_year_1_msv', 'worker_year_20_msv')
# From background to one metre beside a strong source.
DECADES = 7.0

Rows = list[list[str]]


@dataclass(frozen=True, slots=True, kw_only=True)
class DoseMap:
    """One map: a picture and the edges of its cordons, each with its level in uSv/h."""

    title: str
    data_uri: str
    cordons: list[tuple[float, str]]


@dataclass(frozen=True, slots=True, kw_only=True)
class DoseView:
    """What the template ``dose.html`` draws; `box` and `sources` are in map coordinates."""

    sentence: str
    maps: tuple[DoseMap, ...]
    box: Box
    scale: DoseScale
    sources: tuple[EstimatePoint, ...]
    source_rows: Rows
    cordon_rows: Rows

    @property
    def scale_bar_m(self) -> float:
        """Length of the scale bar: 1, 2 or 5 times a power of ten, at most a third of the map."""
        width = self.box[2]
        power = 10.0 ** np.floor(np.log10(width / 4.0))
        return float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= width / 3.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Grid:
    """The dose map of the file: (rows, columns) in uSv/h, and its box in map coordinates."""

    mean_usvh: FloatArray
    upper_usvh: FloatArray
    box: Box


def dose_view(
    folder: Path, frame: LocalFrame | None, estimates: SourceEstimates | None
) -> DoseView | None:
    """Return what the readings say of the ground, None if there is no map of it."""
    grid = _grid(folder / DOSE_MAP, frame) if frame and estimates else None
    if frame is None or estimates is None or grid is None:
        return None
    cordons = _cordons(folder / CORDONS)
    values = [*grid.mean_usvh.ravel().tolist(), float(grid.upper_usvh.max())]
    scale = scale_of(values, decades=DECADES)
    return DoseView(
        sentence=_sentence(estimates),
        maps=tuple(
            DoseMap(
                title=title,
                data_uri=_data_uri(usvh, scale),
                cordons=_cordon_paths(cordons, kind, frame),
            )
            for title, usvh, kind in (
                ('Mean', grid.mean_usvh, 'mean'),
                ('Upper 95 %', grid.upper_usvh, 'upper_95'),
            )
        ),
        box=grid.box,
        scale=scale,
        sources=estimate_points(estimates, frame),
        source_rows=_source_rows(estimates.sources),
        cordon_rows=_cordon_rows(cordons),
    )


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


def _grid(path: Path, frame: LocalFrame) -> _Grid | None:
    """Return the map at `path`, whose axes point east and north, None if it cannot be read."""
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
    return _Grid(
        mean_usvh=np.asarray(mean, np.float64),
        upper_usvh=np.asarray(upper, np.float64),
        box=(left, top, right - left, bottom - top),
    )


def _cordons(path: Path) -> list[dict[str, Any]]:
    try:
        features: list[dict[str, Any]] = json.loads(path.read_text(encoding='utf-8'))['features']
    except (OSError, ValueError, KeyError):
        return []
    return features


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


def _cordon_paths(
    cordons: Sequence[dict[str, Any]], confidence: str, frame: LocalFrame
) -> list[tuple[float, str]]:
    """Return level and path data of the cordons of one kind."""
    return [
        (
            cordon['properties']['level_usv_h'],
            polygons((_xy(ring, frame) for part in _parts(cordon) for ring in part), ''),
        )
        for cordon in cordons
        if cordon['properties']['confidence'] == confidence
    ]


def _parts(cordon: dict[str, Any]) -> list[list[list[list[float]]]]:
    parts: list[list[list[list[float]]]] = cordon['geometry']['coordinates']
    return parts


def _xy(ring: list[list[float]], frame: LocalFrame) -> list[tuple[float, float]]:
    longitudes, latitudes = np.array(ring).T
    enu = frame.to_enu(latitudes, longitudes, np.full(len(ring), frame.origin.altitude_m))
    return [(x, -y) for x, y in enu[:, :2].tolist()]


def _source_rows(sources: Sequence[SourceEstimate]) -> Rows:
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


def _cordon_rows(cordons: Sequence[dict[str, Any]]) -> Rows:
    """Return a row a level, the highest first."""
    levels: dict[float, dict[str, dict[str, Any]]] = {}
    for cordon in cordons:
        facts = cordon['properties']
        levels.setdefault(facts['level_usv_h'], {})[facts['confidence']] = facts
    rows: Rows = []
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
