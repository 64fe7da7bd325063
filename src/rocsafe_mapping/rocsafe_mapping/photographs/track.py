# SPDX-License-Identifier: Apache-2.0
"""The track of a vehicle, from GPX 1.0 and 1.1 or from a CSV file with a header.

Columns of a CSV file are time, latitude, longitude and altitude, under the names in `COLUMNS`;
times are ISO 8601 (without a zone: UTC) or seconds since 1970.
"""

import csv
import io
import math
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.storage.utc_time import time_of_text
from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.photographs.survey_file import Row, read_text

COLUMNS = {
    'time': ('time', 'timestamp', 'datetime', 'time_utc', 'utc', 'time_s'),
    'latitude': ('latitude', 'lat', 'latitude_deg'),
    'longitude': ('longitude', 'lon', 'lng', 'long', 'longitude_deg'),
    'altitude': ('altitude', 'alt', 'ele', 'elevation', 'height', 'altitude_m'),
}
LEAST_POINTS = 2
Point = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Track:
    """Places of a vehicle, in the order of time.

    Attributes
    ----------
    times_s
        Seconds since 1970 UTC, shape (n,), increasing.
    latitudes_deg, longitudes_deg, altitudes_m
        WGS84, shape (n,); altitudes are NaN where unknown.
    """

    times_s: FloatArray
    latitudes_deg: FloatArray
    longitudes_deg: FloatArray
    altitudes_m: FloatArray


def read_track(path: Path) -> Track:
    """Return the track in a file.

    Raises
    ------
    MappingError
        If it cannot be read; the message names file, row or point, and value.
    """
    text = read_text(path)
    points = list(_gpx(path, text) if text.lstrip().startswith('<') else _csv(path, text))
    if len(points) < LEAST_POINTS:
        raise MappingError(f'{path}: {len(points)} points with a time are no track')
    values = np.array(sorted(points))
    # The first of several points of one time is taken.
    _, first = np.unique(values[:, 0], return_index=True)
    times, latitudes, longitudes, altitudes = values[first].T
    return Track(
        times_s=times,
        latitudes_deg=latitudes,
        longitudes_deg=longitudes,
        altitudes_m=altitudes,
    )


def _gpx(path: Path, text: str) -> Iterator[Point]:
    if '<!DOCTYPE' in text or '<!ENTITY' in text:
        raise MappingError(f'{path}: a GPX file has no DOCTYPE')
    try:
        root = ElementTree.fromstring(text)  # noqa: S314 (no entities: refused above)
    except ElementTree.ParseError as error:
        raise MappingError(f'{path}: it is no GPX: {error}') from error
    points = [element for element in root.iter() if _tag(element) == 'trkpt']
    for number, element in enumerate(points, 1):
        values = {_tag(child): (child.text or '').strip() for child in element}
        if 'time' in values:
            words = (values['time'], element.get('lat', ''), element.get('lon', ''),
                     values.get('ele', 'nan'))  # fmt: skip
            yield _point(Row(where=f'{path}: trkpt {number}', words=words))


def _tag(element: ElementTree.Element) -> str:
    return element.tag.rpartition('}')[2]


def _csv(path: Path, text: str) -> Iterator[Point]:
    lines = csv.reader(io.StringIO(text))
    header = [word.strip().lower() for word in next(lines, [])]
    index = {}
    for kind, names in COLUMNS.items():
        index[kind] = next((header.index(name) for name in names if name in header), -1)
        if index[kind] < 0 and kind != 'altitude':
            raise MappingError(f'{path}: row 1: no column is called {" or ".join(names)}')
    for number, words in enumerate(lines, 2):
        if any(word.strip() for word in words):
            chosen = [words[at].strip() if 0 <= at < len(words) else '' for at in index.values()]
            chosen[-1] = chosen[-1] or 'nan'
            yield _point(Row(where=f'{path}: row {number}', words=chosen))


def _point(row: Row) -> Point:
    altitude = math.nan if row.words[3].lower() == 'nan' else row.number(3, 'altitude')
    return (
        _seconds(row),
        row.number(1, 'latitude', -90.0, 90.0),
        row.number(2, 'longitude', -180.0, 180.0),
        altitude,
    )


def _seconds(row: Row) -> float:
    try:
        return row.number(0, 'time')
    except MappingError:
        found = time_of_text(row.words[0])
    if not isinstance(found, datetime):
        raise MappingError(
            f'{row.where}: time = {found!r} is neither ISO 8601 nor seconds since 1970'
        )
    return (found if found.tzinfo is not None else found.replace(tzinfo=timezone.utc)).timestamp()
