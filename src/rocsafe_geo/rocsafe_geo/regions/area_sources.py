# SPDX-License-Identifier: Apache-2.0
"""Survey areas in files of other programs: KMZ, QGroundControl plans, CSV."""

import csv
import json
import zipfile
from collections.abc import Mapping
from io import BytesIO
from typing import Any

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import Ring

_LATITUDE_NAMES = ('latitude', 'latitude_deg', 'lat', 'y')
_LONGITUDE_NAMES = ('longitude', 'longitude_deg', 'lon', 'lng', 'long', 'x')


def kml_of_kmz(content: bytes, max_bytes: int) -> bytes:
    """Return the main document of a KMZ archive: the first `.kml` in it.

    Raises
    ------
    ValueError
        If it is not such an archive, or its document is larger than `max_bytes`.
    """
    try:
        with zipfile.ZipFile(BytesIO(content)) as archive:
            names = [name for name in archive.namelist() if name.lower().endswith('.kml')]
            if not names:
                raise ValueError('has no .kml file inside')
            with archive.open(names[0]) as document:
                text = document.read(max_bytes + 1)
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError) as error:
        raise ValueError(f'is not a KMZ archive: {error}') from error
    if len(text) > max_bytes:
        raise ValueError(f'has a document larger than {max_bytes} bytes, the limit')
    return text


def plan_rings(text: str) -> list[Ring]:
    """Return the polygons of the surveys in a QGroundControl plan (`.plan`).

    Raises
    ------
    ValueError
        If it is not such a plan.
    """
    try:
        document = json.loads(text)
    except json.JSONDecodeError as error:
        raise ValueError(f'is not JSON: {error.msg} in line {error.lineno}') from error
    if not isinstance(document, Mapping) or document.get('fileType') != 'Plan':
        raise ValueError('is not a QGroundControl plan: "fileType" must be "Plan"')
    mission = document.get('mission')
    items = mission.get('items') if isinstance(mission, Mapping) else None
    if not isinstance(items, list):
        raise ValueError('is a plan without the list "mission.items"')  # noqa: TRY004
    return [_survey_ring(item) for item in items if _is_survey(item)]


def csv_ring(text: str) -> Ring:
    """Return the ring of a table with one corner a line.

    The columns are latitude and longitude, in this order or as a header names them, separated by
    commas, semicolons or tabs. Lines that begin with # are ignored.

    Raises
    ------
    ValueError
        If a line is not a corner; it names the line.
    """
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith('#')
    ]
    if not lines:
        raise ValueError('has no lines')
    separator = next((mark for mark in ',;\t' if mark in lines[0][1]), ',')
    rows = list(csv.reader((line for _, line in lines), delimiter=separator))
    columns = _columns([cell.strip().lower() for cell in rows[0]])
    first = 0 if columns is None else 1
    latitude, longitude = columns or (0, 1)
    return tuple(
        _corner(row, latitude, longitude, number)
        for row, (number, _) in zip(rows[first:], lines[first:], strict=True)
    )


def _is_survey(item: object) -> bool:
    return isinstance(item, Mapping) and item.get('type') == 'ComplexItem' and 'polygon' in item


def _survey_ring(item: Mapping[str, Any]) -> Ring:
    polygon = item['polygon']
    if not isinstance(polygon, list):
        raise ValueError('has a survey whose "polygon" is no list')  # noqa: TRY004
    corners = []
    for place in polygon:
        if not isinstance(place, list) or len(place) < 2:
            raise ValueError(f'has {place!r:.60} where [latitude, longitude] must be')
        corners.append(GeoPosition(place[0], place[1]))
    return tuple(corners)


def _columns(header: list[str]) -> tuple[int, int] | None:
    """Return where latitude and longitude are, None if the line is no header."""
    latitude = next((header.index(name) for name in _LATITUDE_NAMES if name in header), None)
    longitude = next((header.index(name) for name in _LONGITUDE_NAMES if name in header), None)
    return None if latitude is None or longitude is None else (latitude, longitude)


def _corner(row: list[str], latitude: int, longitude: int, number: int) -> GeoPosition:
    try:
        return GeoPosition(float(row[latitude]), float(row[longitude]))
    except IndexError as error:
        raise ValueError(f'has {len(row)} columns in line {number}: must have 2') from error
    except ValueError as error:
        raise ValueError(f'line {number}: {error}') from error
