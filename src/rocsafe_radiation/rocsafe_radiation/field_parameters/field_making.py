# SPDX-License-Identifier: Apache-2.0
"""The simulated field, made from the parameters and the settings file of its node."""

import math
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime, timezone
from itertools import islice
from pathlib import Path

import numpy as np

from rocsafe_geo.angle import yaw_of_heading_rad
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.solids.ground_heights import GroundHeights, read_heights
from rocsafe_geo.solids.solids_file import read_solids
from rocsafe_geo.storage.value_file import read_values
from rocsafe_radiation.detection.survey_field import SurveyField
from rocsafe_radiation.field_parameters.field_file import (
    FieldFile,
    Place,
    ShieldSettings,
    SourceSettings,
)
from rocsafe_radiation.field_parameters.field_options import FieldOptions
from rocsafe_radiation.physics.background import Background
from rocsafe_radiation.physics.field import SHIELDED_MODEL, RadiationField
from rocsafe_radiation.physics.nuclide import DEFAULT_NUCLIDE
from rocsafe_radiation.physics.scene_shielding import SceneShielding
from rocsafe_radiation.physics.shielding import Box, BoxShielding, Shielding, joined
from rocsafe_radiation.physics.source import RadiationSource, decayed_sigma_usvps
from rocsafe_radiation.physics.source_shape import AreaShape, LineShape, SourceShape, TrackShape

Positions = tuple[GeoPosition, ...]


def survey_field(options: FieldOptions) -> SurveyField:
    """Return the sources, shields, background and detector that a node's parameters describe.

    Paths in the settings file count from its own folder.

    Raises
    ------
    ValueError
        In a line for each mistake, naming the source or box, the value and the limit.
    """
    path = Path(options.field_file)
    settings = read_values(path, FieldFile) if options.field_file else FieldFile()
    try:
        return field_of(options, settings, path.parent)
    except ValueError as error:
        raise ValueError(f'{path.name}: {error}' if options.field_file else error) from error


def field_of(options: FieldOptions, settings: FieldFile, folder: Path) -> SurveyField:
    """Return what parameters and settings describe; paths count from `folder`.

    Raises
    ------
    ValueError
        As `survey_field`, without the name of the file.
    """
    ground = _ground(settings, folder)
    is_shielded = options.model == SHIELDED_MODEL
    return SurveyField(
        field=RadiationField(
            sources=_sources(settings, ground, options.start_time_s),
            source_radius_m=options.source_radius_m,
            model=options.model,
            shielding=_shielding(settings, ground, folder) if is_shielded else None,
        ),
        background=_background(settings, ground, options.seed),
        detector=options.detector,
    )


def _ground(settings: FieldFile, folder: Path) -> GroundHeights | None:
    if not settings.terrain_file:
        return None
    return read_heights(folder / settings.terrain_file, settings.terrain_shift_m)


def _background(settings: FieldFile, ground: GroundHeights | None, seed: int) -> Background:
    background = settings.background
    if background.dose_rate_usvh == 0.0:
        return Background()
    return Background(
        terrestrial_usvh=background.dose_rate_usvh,
        variation=background.variation,
        length_m=background.length_m,
        ground_altitude_m=settings.ground_altitude_m,
        is_cosmic=background.cosmic,
        seed=seed,
        ground=ground,
    )


def _sources(
    settings: FieldFile, ground: GroundHeights | None, start_time_s: float
) -> tuple[RadiationSource, ...]:
    level_m = settings.ground_altitude_m
    places = _on_ground(
        [_position(each.place, level_m + each.height_m) for each in settings.sources],
        ground,
        level_m,
    )
    corners = iter(
        _on_ground(
            [
                _position(corner, level_m + each.height_m)
                for each in settings.sources
                for corner in each.corners
            ],
            ground,
            level_m,
        )
    )
    sources = []
    for source, place in zip(settings.sources, places, strict=True):
        own = tuple(islice(corners, len(source.corners)))
        sources.append(_source(source, place, own, start_time_s))
    return tuple(sources)


def _source(
    source: SourceSettings, place: GeoPosition, corners: Positions, start_time_s: float
) -> RadiationSource:
    try:
        shape = _shape(source, corners)
    except ValueError as error:
        raise ValueError(f'source {source.name}: {error}') from error
    return RadiationSource(
        name=source.name,
        position=place,
        sigma_usvps=_sigma_usvps(source, start_time_s),
        nuclide=source.nuclide or DEFAULT_NUCLIDE,
        shape=shape,
    )


def _sigma_usvps(source: SourceSettings, start_time_s: float) -> float:
    """Return the dose rate at 1 m at the start of the mission, microsievert per second."""
    if source.activity_gbq is None:
        return source.sigma_usvps or 0.0
    age_s = 0.0
    if source.activity_date is not None:
        start = datetime.fromtimestamp(start_time_s, timezone.utc)
        age_s = (start - source.activity_date).total_seconds()
    nuclide = source.nuclide or DEFAULT_NUCLIDE
    return decayed_sigma_usvps(source.name, nuclide, source.activity_gbq, age_s)


def _shape(source: SourceSettings, corners: Positions) -> SourceShape | None:
    if source.line:
        return LineShape(corners=corners)
    if source.area:
        return AreaShape(corners=corners)
    if source.track:
        return TrackShape(times_s=tuple(stop.time_s for stop in source.track), stops=corners)
    return None


def _shielding(
    settings: FieldFile, ground: GroundHeights | None, folder: Path
) -> Shielding | None:
    parts: list[Shielding] = []
    if settings.shields:
        parts.append(_boxes(settings, ground))
    if settings.solids_file:
        parts.append(SceneShielding(read_solids(folder / settings.solids_file)))
    return joined(parts)


def _boxes(settings: FieldFile, ground: GroundHeights | None) -> BoxShielding:
    level_m = settings.ground_altitude_m
    places = _on_ground(
        [_position(each.position, level_m + each.base_height_m) for each in settings.shields],
        ground,
        level_m,
    )
    frame = LocalFrame(places[0])
    boxes = []
    for index, (shield, place) in enumerate(zip(settings.shields, places, strict=True)):
        try:
            boxes.append(_box(shield, frame.enu_of(place).tolist()))
        except ValueError as error:
            raise ValueError(f'shields[{index}]: {error}') from error
    return BoxShielding(frame=frame, boxes=tuple(boxes))


def _box(shield: ShieldSettings, foot_enu_m: Sequence[float]) -> Box:
    east, north, up = foot_enu_m
    return Box(
        material=shield.material,
        centre_enu_m=(east, north, up + shield.height_m / 2.0),
        size_m=(shield.length_m, shield.width_m, shield.height_m),
        yaw_rad=yaw_of_heading_rad(math.radians(shield.heading_deg)),
        wall_m=shield.wall_m,
    )


def _position(place: Place, altitude_m: float) -> GeoPosition:
    return GeoPosition(*place, altitude_m)


def _on_ground(
    places: Sequence[GeoPosition], ground: GroundHeights | None, level_m: float
) -> Positions:
    """Return places over level ground at `level_m` as high above `ground` as above that."""
    if ground is None or not places:
        return tuple(places)
    altitudes = ground.altitudes_m(
        [place.latitude_deg for place in places], [place.longitude_deg for place in places]
    )
    rises = np.where(np.isfinite(altitudes), altitudes - level_m, 0.0).tolist()
    return tuple(
        replace(place, altitude_m=place.altitude_m + rise)
        for place, rise in zip(places, rises, strict=True)
    )
