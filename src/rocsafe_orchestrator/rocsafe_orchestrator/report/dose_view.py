# SPDX-License-Identifier: Apache-2.0
"""The dose rate at 1 m above the ground: two maps on one scale, cordons and the sources found."""

import base64
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rasterio
from PIL import Image
from rasterio.enums import Resampling
from rasterio.errors import RasterioError

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.scale_bar import bar_length_m
from rocsafe_orchestrator.products.source_estimates import SourceEstimates
from rocsafe_orchestrator.report.map_data import estimate_points
from rocsafe_orchestrator.report.pictures import map_xy
from rocsafe_orchestrator.report.sections.cordons import SAFE, EstimatedCordon, read_cordons
from rocsafe_orchestrator.report.sections.source_texts import dose_rate_of, half_axes_of, place_of
from rocsafe_view import formats
from rocsafe_view.map_marks import EstimatePoint
from rocsafe_view.map_view import Box
from rocsafe_view.palette import DoseScale, ramp_colour, scale_of
from rocsafe_view.svg import polygons

DOSE_MAP = 'dose_map.tif'
MEAN_BAND, UPPER_BAND = 1, 3
MOST_PX = 480
# Share of the readings over the region that may lie below the colour scale.
READINGS_BELOW = 0.02
LEVELS = 128
STAY_KEYS = ('public_year_1_msv', 'worker_year_20_msv')

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
        return bar_length_m(self.box[2] / 3.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Grid:
    """The dose map of the file: (rows, columns) in uSv/h, and its box in map coordinates."""

    mean_usvh: FloatArray
    upper_usvh: FloatArray
    box: Box


def dose_view(
    folder: Path,
    frame: LocalFrame | None,
    estimates: SourceEstimates | None,
    readings_usvh: Sequence[float] = (),
) -> DoseView | None:
    """Return the dose map as the report draws it; None if there is none.

    Map and readings have one scale, so that a colour means one dose rate on the whole page.
    """
    grid = _grid(folder / DOSE_MAP, frame) if frame and estimates else None
    if frame is None or estimates is None or grid is None:
        return None
    cordons = read_cordons(folder, frame)
    scale = _scale(readings_usvh, grid)
    return DoseView(
        sentence=_sentence(estimates),
        maps=tuple(
            DoseMap(
                title=title,
                data_uri=_data_uri(usvh, scale),
                cordons=[
                    (c.edge.level_usvh, polygons(c.edge.rings, ''))
                    for c in cordons
                    if c.confidence == kind
                ],
            )
            for title, usvh, kind in (
                ('Mean', grid.mean_usvh, 'mean'),
                ('Upper 95 %', grid.upper_usvh, SAFE),
            )
        ),
        box=grid.box,
        scale=scale,
        sources=estimate_points(estimates, frame),
        source_rows=_source_rows(estimates),
        cordon_rows=_cordon_rows(cordons),
    )


def _scale(readings_usvh: Sequence[float], grid: _Grid) -> DoseScale:
    """Return a scale on which readings differ, up to a decade above them.

    The map goes on for decades towards a source: it would leave one colour for all readings.
    """
    if not readings_usvh:
        return scale_of(grid.mean_usvh.ravel().tolist())
    highest = min(float(grid.upper_usvh.max()), 10.0 * max(readings_usvh))
    return scale_of([*readings_usvh, highest], READINGS_BELOW)


def _sentence(found: SourceEstimates) -> str:
    count = len(found.sources)
    words = (
        f'{count or "No"} source{"" if count == 1 else "s"} from {found.reading_count} readings'
    )
    background = formats.spaced(formats.dose_rate(found.background_usvh))
    chances = found.source_count_probability
    chance = chances[count] if count < len(chances) else 0.0
    text = (
        f'{words}, with a probability of {formats.probability(chance)}; background {background}.'
    )
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


def _source_rows(found: SourceEstimates) -> Rows:
    return [
        [
            f'{index}',
            place_of(source),
            half_axes_of(source),
            dose_rate_of(source),
            formats.probability(found.probability_of(index)),
        ]
        for index, source in enumerate(found.sources, 1)
    ]


def _cordon_rows(cordons: Sequence[EstimatedCordon]) -> Rows:
    """Return a row a level, the highest first."""
    levels: dict[float, dict[str, EstimatedCordon]] = {}
    for cordon in cordons:
        levels.setdefault(cordon.edge.level_usvh, {})[cordon.confidence] = cordon
    return [
        _cordon_row(by_confidence) for _, by_confidence in sorted(levels.items(), reverse=True)
    ]


def _cordon_row(by_confidence: Mapping[str, EstimatedCordon]) -> list[str]:
    any_one = next(iter(by_confidence.values()))
    safe = by_confidence.get(SAFE)
    return [
        formats.spaced(formats.dose_rate(any_one.edge.level_usvh)),
        any_one.edge.name,
        safe.edge.radius_text if safe else formats.UNKNOWN,
        *(_area(by_confidence.get(kind)) for kind in ('mean', SAFE)),
        *(formats.stay(any_one.stay_h[key]) for key in STAY_KEYS),
    ]


def _area(cordon: EstimatedCordon | None) -> str:
    return formats.area(cordon.area_m2) if cordon else 'none'
