# SPDX-License-Identifier: Apache-2.0
"""Make the moving picture of the README from a run: from planned routes to a located source.

    python tools/moving_picture.py runs/derailment-20261123-101500 docs/mission.webp

Everything shown is of the run: a photograph's part of the mosaic appears when it was taken, a
track is coloured by its readings, and the dose map shows where its readings have been taken. The
last frames show the source that was found and its cordons, on the mosaic.
"""

import csv
import json
import sys
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import rasterio
from PIL import Image, ImageDraw, ImageFilter, ImageFont
from pyproj import Transformer
from rasterio.enums import Resampling
from rasterio.vrt import WarpedVRT

from rocsafe_geo.arrays import FloatArray

WIDTH_PX, FRAMES, FRAME_MS = 820, 48, 120
# How long the first and the last picture stay, milliseconds.
FIRST_MS, LAST_MS = 1800, 5000
QUALITY = 62
# Parts of the picture around the mosaic, metres.
MARGIN_M = 12.0
DARK, LINE = (28, 34, 33), (235, 235, 235)
# The dose map is shown this far from readings that were taken, metres.
KNOWN_M = 14.0
# Height of the line of text below, pixels.
CAPTION_PX = 64
# Levels of the cordons that are shown, uSv/h at 1 m: for most people, and for responders.
CORDONS_USVH = (25.0, 100.0)
# Colours from 1 to 300 uSv/h, by logarithm (plasma).
COLOURS = np.array(
    [(13, 8, 135), (84, 2, 163), (156, 23, 158), (219, 92, 104), (248, 149, 64), (240, 249, 33)]
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """A run in pixels of the picture.

    Attributes
    ----------
    mosaic, dose
        Pictures of the whole map, and of the dose map with its opacity.
    shots
        Time, seconds, and corners of the footprint of each photograph.
    readings
        Time, seconds, x, y and dose rate, shape (n, 4), by vehicle.
    routes
        Planned routes.
    sources
        Place of each source that was found, and what was found about it.
    cordons
        Level, uSv/h, and outline of each cordon.
    """

    mosaic: Image.Image
    dose: Image.Image
    shots: list[tuple[float, list[tuple[float, float]]]]
    readings: dict[str, FloatArray]
    routes: list[list[tuple[float, float]]]
    sources: list[tuple[tuple[float, float], str]]
    cordons: list[tuple[float, list[tuple[float, float]]]]


def read_scene(run: Path) -> Scene:
    """Return what a run shows."""
    with rasterio.open(run / 'mosaic.tif') as source:
        box = source.bounds
        west, north = box.left - MARGIN_M, box.top + MARGIN_M
        metres = box.right - box.left + 2 * MARGIN_M
        scale = WIDTH_PX / metres
        height = int((box.top - box.bottom + 2 * MARGIN_M) * scale) // 2 * 2
        transform = rasterio.Affine(1 / scale, 0.0, west, 0.0, -1 / scale, north)
        grid = {'crs': source.crs, 'transform': transform, 'width': WIDTH_PX, 'height': height}
        to_metres = Transformer.from_crs('EPSG:4326', source.crs, always_xy=True)
        with WarpedVRT(source, resampling=Resampling.average, **grid) as warped:
            mosaic = Image.fromarray(np.moveaxis(warped.read(), 0, -1), 'RGBA')
    with (
        rasterio.open(run / 'dose_map.tif') as source,
        WarpedVRT(source, resampling=Resampling.bilinear, nodata=np.nan, **grid) as warped,
    ):
        rates = np.nan_to_num(warped.read(1))

    def pixels(places: Any) -> list[tuple[float, float]]:
        table = np.asarray(places, float)
        east, up = to_metres.transform(table[:, 0], table[:, 1])
        return list(zip((east - west) * scale, (north - up) * scale, strict=True))

    start = min(_seconds(row['time_utc']) for row in _rows(run))
    return Scene(
        mosaic=mosaic,
        dose=Image.fromarray(np.dstack([colours(rates), np.full(rates.shape, 105, np.uint8)])),
        shots=[
            (_seconds(item['properties']['datetime']) - start,
             pixels(item['geometry']['coordinates'][0]))
            for item in _features(run / 'images/footprints.geojson')
        ],
        readings=_readings(run, pixels, start),
        routes=[
            pixels(item['geometry']['coordinates'])
            for item in _features(run / 'plan.geojson')
            if item['geometry']['type'] == 'LineString'
        ],
        sources=_sources(run, pixels),
        cordons=[
            (float(item['properties']['level_usv_h']), pixels(polygon[0]))
            for item in _features(run / 'cordons.geojson')
            if item['properties']['confidence'] == 'upper_95'
            and item['properties']['level_usv_h'] in CORDONS_USVH
            for polygon in item['geometry']['coordinates']
        ],
    )  # fmt: skip


def colours(rates_usvh: FloatArray) -> Any:
    """Return colours of dose rates, with a last axis of red, green, blue."""
    share = np.clip(np.log10(np.maximum(rates_usvh, 1e-3)) / np.log10(300.0), 0.0, 1.0)
    places = share * (len(COLOURS) - 1)
    bands = [np.interp(places, np.arange(len(COLOURS)), COLOURS[:, band]) for band in range(3)]
    return np.stack(bands, axis=-1).astype(np.uint8)


def frame(scene: Scene, time_s: float) -> Image.Image:
    """Return the picture of a moment of the mission."""
    size = scene.mosaic.size
    picture = _ground(scene, [corners for at, corners in scene.shots if at <= time_s])
    known = Image.new('L', size)
    pen = ImageDraw.Draw(known)
    radius = KNOWN_M * size[0] / 260.0
    for table in scene.readings.values():
        for _, x, y, _ in table[table[:, 0] <= time_s][::8]:
            pen.ellipse((x - radius, y - radius, x + radius, y + radius), fill=255)
    known = known.filter(ImageFilter.GaussianBlur(6))
    picture.paste(scene.dose, (0, 0), _both(scene.dose.getchannel('A'), known))
    _draw_routes(picture, scene, 150)
    pen = ImageDraw.Draw(picture)
    for name, table in scene.readings.items():
        _draw_track(pen, name, table[table[:, 0] <= time_s])
    minutes, seconds = divmod(int(time_s), 60)
    taken = sum(at <= time_s for at, _ in scene.shots)
    text = f'{minutes}:{seconds:02d} min   {taken} of {len(scene.shots)} photographs'
    return _captioned(picture, 'They fly, photograph and measure. Map and dose map grow.', text)


def first_frame(scene: Scene) -> Image.Image:
    """Return the picture of the plan."""
    picture = _ground(scene, [])
    _draw_routes(picture, scene, 255)
    text = f'{len(scene.routes)} routes for {len(scene.shots)} photographs, simulated'
    return _captioned(picture, 'Routes are planned for a region.', text)


def last_frame(scene: Scene) -> Image.Image:
    """Return the picture of what was found."""
    picture = _ground(scene, [corners for _, corners in scene.shots])
    pen = ImageDraw.Draw(picture)
    for level, outline in scene.cordons:
        pen.line(outline, fill=(255, 214, 10), width=3)
        top = min(outline, key=lambda place: place[1])
        _write(pen, (top[0], top[1] + 14), f'{level:g} uSv/h', 17, 'mm')
    for (x, y), _ in scene.sources:
        pen.ellipse((x - 8, y - 8, x + 8, y + 8), fill=(230, 40, 40), outline='white', width=2)
    found = '; '.join(text for _, text in scene.sources)
    return _captioned(picture, 'The source is found. Cordons say how near one may go.', found)


def _ground(scene: Scene, footprints: list[list[tuple[float, float]]]) -> Image.Image:
    """Return the mosaic, as far as photographs were taken."""
    picture = Image.new('RGBA', scene.mosaic.size, (*DARK, 255))
    taken = _mask(scene.mosaic.size, footprints)
    picture.paste(scene.mosaic, (0, 0), _both(scene.mosaic.getchannel('A'), taken))
    return picture


def _draw_routes(picture: Image.Image, scene: Scene, strength: int) -> None:
    layer = Image.new('RGBA', picture.size)
    pen = ImageDraw.Draw(layer)
    for route in scene.routes:
        pen.line(route, fill=(*LINE, strength), width=2)
    picture.alpha_composite(layer)


def _draw_track(pen: ImageDraw.ImageDraw, name: str, flown: FloatArray) -> None:
    for (_, x, y, rate), (_, x2, y2, _) in zip(flown[:-1:4], flown[4::4], strict=False):
        pen.line((x, y, x2, y2), fill=tuple(colours(np.array(rate)).tolist()), width=5)
    if len(flown):
        _, x, y, _ = flown[-1]
        pen.ellipse((x - 7, y - 7, x + 7, y + 7), fill='white', outline='black')
        _write(pen, (x + 11, y), name, 17, 'lm')


def _captioned(picture: Image.Image, caption: str, text: str) -> Image.Image:
    """Return the picture with a line that tells what is seen, figures and a scale of colours."""
    width, height = picture.size
    whole = Image.new('RGB', (width, height + CAPTION_PX), DARK)
    whole.paste(picture.convert('RGB'))
    pen = ImageDraw.Draw(whole)
    _write(pen, (14, height + 20), caption, 20, 'lm')
    _write(pen, (14, height + 46), text, 17, 'lm')
    scale = colours(np.logspace(0.0, np.log10(300.0), 160))
    bar = Image.fromarray(np.repeat(scale[None], 10, axis=0))
    whole.paste(bar, (width - 190, height + 14))
    _write(pen, (width - 110, height + 42), '1  to  300 uSv/h', 16, 'mm')
    return whole


def _write(
    pen: ImageDraw.ImageDraw, place: tuple[float, float], text: str, size: int, anchor: str
) -> None:
    pen.text(place, text, fill='white', anchor=anchor, stroke_width=2, stroke_fill='black',
             font=ImageFont.load_default(size))  # fmt: skip


def _mask(size: tuple[int, int], polygons: list[list[tuple[float, float]]]) -> Image.Image:
    mask = Image.new('L', size)
    pen = ImageDraw.Draw(mask)
    for corners in polygons:
        pen.polygon(corners, fill=255)
    return mask


def _both(one: Image.Image, other: Image.Image) -> Image.Image:
    product = np.asarray(one, np.uint16) * np.asarray(other, np.uint16) // 255
    return Image.fromarray(product.astype(np.uint8))


def _readings(run: Path, pixels: Any, start_s: float) -> dict[str, FloatArray]:
    by_vehicle: dict[str, list[dict[str, str]]] = {}
    for row in _rows(run):
        by_vehicle.setdefault(row['vehicle'], []).append(row)
    return {
        name: np.array([
            (_seconds(row['time_utc']) - start_s, x, y, float(row['dose_rate_usvh']))
            for row, (x, y) in zip(
                rows, pixels([(row['longitude_deg'], row['latitude_deg']) for row in rows]),
                strict=True,
            )
        ])
        for name, rows in sorted(by_vehicle.items())
    }  # fmt: skip


def _sources(run: Path, pixels: Any) -> list[tuple[tuple[float, float], str]]:
    found = []
    for source in json.loads((run / 'sources.json').read_text())['sources']:
        place = source['place']
        (pixel,) = pixels([(place['longitude_deg'], place['latitude_deg'])])
        strength = source['dose_rate_at_1m_usvh'] / 1000.0
        where = f'{place["latitude_deg"]:.6f}, {place["longitude_deg"]:.6f}'
        found.append((pixel, f'{strength:.0f} mSv/h at 1 m, at {where}'))
    return found


def _rows(run: Path) -> list[dict[str, str]]:
    with (run / 'readings.csv').open(encoding='utf-8') as file:
        return list(csv.DictReader(file))


def _features(path: Path) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads(path.read_text())['features']
    return found


def _seconds(text: str) -> float:
    return datetime.fromisoformat(text.replace('Z', '+00:00')).timestamp()


def main(run: str, out: str) -> int:
    """Write the moving picture."""
    scene = read_scene(Path(run))
    end_s = max(float(table[-1, 0]) for table in scene.readings.values())
    start_s = min(at for at, _ in scene.shots) - 10.0
    times = np.linspace(start_s, end_s, FRAMES).tolist()
    others = [*(frame(scene, time_s) for time_s in times), last_frame(scene)]
    first_frame(scene).save(
        out, save_all=True, append_images=others, loop=0,
        duration=[FIRST_MS, *[FRAME_MS] * FRAMES, LAST_MS],
        quality=QUALITY, method=6,
    )  # fmt: skip
    print(f'{out}: {Path(out).stat().st_size / 1e6:.2f} MB')
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1], sys.argv[2]))
