# SPDX-License-Identifier: Apache-2.0
"""Ground control points from OpenDroneMap's ``gcp_list.txt``.

Rows are ``x y z pixel_x pixel_y name [label]``; rows of one label, or without labels of one place,
are sightings of one point. A label that begins with ``CHK-`` is that of a check point.
"""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.photographs.shot import ShotRecord
from rocsafe_mapping.photographs.survey_file import Row, inexactness, read_rows

CHECK_PREFIX = 'CHK-'
LABEL = 6
LARGEST_PIXEL = 1e6
SAME_PLACE_DEG = 1e-7
"""A centimetre."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sighting:
    """Pixel at which a photograph shows a point.

    Attributes
    ----------
    where
        File and row that say so.
    photo
        File name of the photograph, in lower case.
    pixel
        Column and row (OpenCV: integers are centres).
    """

    where: str
    photo: str
    pixel: tuple[float, float]

    def require_inside(self, record: ShotRecord) -> None:
        """Raise MappingError unless the pixel lies in the photograph."""
        size = record.camera.width_px, record.camera.height_px
        for name, value, most in zip(('im_x', 'im_y'), self.pixel, size, strict=True):
            if not -0.5 <= value <= most:
                raise MappingError(
                    f'{self.where}: {name} = {value:g} must be from 0 to {most}, the size of '
                    f'{self.photo}'
                )


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlPoint:
    """A point of the ground whose place was surveyed.

    Attributes
    ----------
    name
        Its label.
    latitude_deg, longitude_deg, altitude_m
        WGS84; the altitude as it stands in the file, NaN if unknown.
    datum_error_m
        How exactly its CRS is known in WGS84: all points of a file are off alike.
    sightings
        In the photographs that show it.
    """

    name: str
    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    datum_error_m: float
    sightings: tuple[Sighting, ...]

    @property
    def is_check(self) -> bool:
        """Whether it judges the map only, and does not place it."""
        return self.name.upper().startswith(CHECK_PREFIX)


def read_control(path: Path, notice: Callable[[str], None]) -> tuple[ControlPoint, ...]:
    """Return the points of a ``gcp_list.txt``.

    `notice` is told of a CRS that is known to some metres only.

    Raises
    ------
    MappingError
        If it cannot be read; the message names file, row and value.
    """
    places, rows = read_rows(path)
    found: dict[str, ControlPoint] = {}
    for row in rows:
        latitude, longitude = places.position(row, 0)
        sighting = _sighting(row)
        place = f'{latitude:.9f} {longitude:.9f}'
        name = row.words[LABEL] if len(row.words) > LABEL else place
        point = found.get(name)
        sightings = (sighting,) if point is None else (*point.sightings, sighting)
        if point is not None:
            off = max(abs(point.latitude_deg - latitude), abs(point.longitude_deg - longitude))
            if off > SAME_PLACE_DEG:
                raise MappingError(f'{row.where}: {name} has another place than in rows before')
        found[name] = ControlPoint(
            name=name,
            latitude_deg=latitude,
            longitude_deg=longitude,
            altitude_m=row.height(2),
            datum_error_m=places.datum_error_m,
            sightings=sightings,
        )
    if not found:
        raise MappingError(f'{path}: it has no point')
    if line := inexactness(places, path):
        notice(line)
    return _numbered(found)


def _sighting(row: Row) -> Sighting:
    pixel = row.number(3, 'im_x', -1.0, LARGEST_PIXEL), row.number(4, 'im_y', -1.0, LARGEST_PIXEL)
    if len(row.words) < LABEL:
        raise MappingError(f'{row.where}: image_name is missing')
    return Sighting(where=row.where, photo=row.words[5].lower(), pixel=pixel)


def _numbered(found: Mapping[str, ControlPoint]) -> tuple[ControlPoint, ...]:
    """Return the points; those without a label are called by their number."""
    return tuple(
        dataclasses.replace(point, name=f'point {number}') if ' ' in name else point
        for number, (name, point) in enumerate(found.items(), 1)
    )


def sightings_of(
    points: tuple[ControlPoint, ...], records: Mapping[str, ShotRecord]
) -> dict[str, dict[str, tuple[float, float]]]:
    """Return the pixels by point and photograph that there is, `records` being by file name.

    Raises
    ------
    MappingError
        If a pixel lies outside its photograph, or no photograph shows any point.
    """
    names = {name.lower(): name for name in records}
    found: dict[str, dict[str, tuple[float, float]]] = {}
    for point in points:
        seen = {}
        for sighting in point.sightings:
            name = names.get(sighting.photo)
            if name is not None:
                sighting.require_inside(records[name])
                seen[name] = sighting.pixel
        if seen:
            found[point.name] = seen
    if not found:
        first = points[0].sightings[0]
        raise MappingError(f'{first.where}: no photograph is called {first.photo!r}')
    return found
