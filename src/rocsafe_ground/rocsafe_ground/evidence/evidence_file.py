# SPDX-License-Identifier: Apache-2.0
"""Evidence points of an operator, from GeoJSON or from text, and those that a survey proposes."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rocsafe_geo.evidence.place_marks import PlaceMark
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.storage.named_file import require_file
from rocsafe_ground.dose.source_posterior import SourcePosterior
from rocsafe_ground.evidence.evidence_point import MARK, SOURCE, EvidencePoint

FROM_SOURCES, FROM_OBJECTS, FROM_RELEASES = 'sources', 'objects', 'releases'
FROM_MARKS = 'marks'


def evidence_of(
    texts: list[str],
    posterior: SourcePosterior | None,
    objects: Sequence[EvidencePoint] | None = None,
    releases: Sequence[EvidencePoint] | None = None,
    marks: Sequence[PlaceMark] = (),
) -> tuple[EvidencePoint, ...]:
    """Return the evidence points that words of a command line name.

    Parameters
    ----------
    texts
        Each ``LAT,LON``, the path of a GeoJSON file of points, ``sources``, ``releases``,
        ``objects`` or ``marks``.
    posterior
        The sources that a survey found.
    objects
        The things that labels propose; None: there are no labels.
    releases
        Those of gas that a survey proposes; None: it looked for none.
    marks
        Places that operators marked on the console.

    Raises
    ------
    ValueError
        In one line, if a word is none of these.
    """
    found: list[EvidencePoint] = []
    for text in texts:
        if text == FROM_SOURCES:
            found += _of_sources(posterior)
        elif text == FROM_RELEASES:
            found += _of_releases(releases)
        elif text == FROM_OBJECTS:
            found += _of_objects(objects)
        elif text == FROM_MARKS:
            found += _of_marks(marks)
        elif Path(text).suffix.lower() in ('.geojson', '.json'):
            found += read_evidence(Path(text))
        else:
            found.append(EvidencePoint(id=f'mark-{len(found) + 1}', position=place_of(text)))
    return tuple(found)


def place_of(text: str) -> GeoPosition:
    """Return the position that ``LAT,LON`` names, degrees; ValueError if it names none."""
    parts = text.split(',')
    try:
        latitude, longitude = (float(part) for part in parts)
    except ValueError as error:
        raise ValueError(f'{text}: must be LAT,LON in degrees') from error
    return GeoPosition(latitude, longitude)


def read_evidence(path: Path) -> list[EvidencePoint]:
    """Return the points of a GeoJSON file; properties: id, kind, priority, dwell_s, found_in.

    Raises
    ------
    ValueError
        In one line, if the file cannot be read or a point is not valid.
    """
    try:
        require_file(path)
        features = json.loads(path.read_text(encoding='utf-8'))['features']
        points = [one for one in features if one['geometry']['type'] == 'Point']
    except OSError as error:
        raise ValueError(f'{path}: {error.strerror}') from error
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f'{path}: must be a GeoJSON FeatureCollection of points') from error
    if not points:
        raise ValueError(f'{path}: has no point')
    return [_of_feature(path, number, one) for number, one in enumerate(points, 1)]


def _of_feature(path: Path, number: int, feature: dict[str, Any]) -> EvidencePoint:
    properties = feature.get('properties') or {}
    try:
        longitude, latitude = feature['geometry']['coordinates'][:2]
        return EvidencePoint(
            id=str(properties.get('id') or properties.get('name') or f'{path.stem}-{number}'),
            position=GeoPosition(latitude, longitude),
            kind=str(properties.get('kind', MARK)),
            **{
                key: float(properties[key])
                for key in ('priority', 'dwell_s')
                if properties.get(key) is not None
            },
            found_in=str(properties.get('found_in', '')),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f'{path}: point {number}: {error}') from error


def _of_objects(objects: Sequence[EvidencePoint] | None) -> Sequence[EvidencePoint]:
    if objects is None:
        raise ValueError(f'--to {FROM_OBJECTS}: needs --labels')
    if not objects:
        raise ValueError(f'--to {FROM_OBJECTS}: the labels show no drum, flask, wagon or marker')
    return objects


def _of_marks(marks: Sequence[PlaceMark]) -> list[EvidencePoint]:
    if not marks:
        raise ValueError(f'--to {FROM_MARKS}: nobody marked a place in this run')
    return [
        EvidencePoint(
            id=f'operator-{number}', position=mark.position, found_in=f'{mark.by}: {mark.text}'
        )
        for number, mark in enumerate(marks, 1)
    ]


def _of_releases(releases: Sequence[EvidencePoint] | None) -> Sequence[EvidencePoint]:
    if not releases:
        raise ValueError(f'--to {FROM_RELEASES}: the survey found no release of gas')
    return releases


def _of_sources(posterior: SourcePosterior | None) -> list[EvidencePoint]:
    """Return a point for each source, the stronger the higher its priority."""
    if posterior is None or not posterior.sources:
        raise ValueError(f'--to {FROM_SOURCES}: the survey found no source')
    strongest = max(source.rate_usvh for source in posterior.sources)
    return [
        EvidencePoint(
            id=f'source-{number}',
            position=source.position,
            kind=SOURCE,
            priority=max(0.1, source.rate_usvh / strongest),
            found_in=f'source {number}: {source.rate_usvh:.4g} uSv/h at 1 m',
        )
        for number, source in enumerate(posterior.sources, 1)
    ]
