# SPDX-License-Identifier: Apache-2.0
"""What was surveyed beside the photographs - ground control, a track - in a map's local frame."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_mapping.alignment.adjustment.sightings import mark_places_m
from rocsafe_mapping.alignment.initial.flown_path import FlownPath
from rocsafe_mapping.alignment.model.mark import Mark
from rocsafe_mapping.alignment.model.photo import GroundFrame, Photo
from rocsafe_mapping.alignment.model.state import State
from rocsafe_mapping.drawing.grid import LOCAL_EPSG, utm_epsg
from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.photographs.ground_control import ControlPoint, sightings_of
from rocsafe_mapping.photographs.shot import ShotRecord
from rocsafe_mapping.photographs.track import Track

FARTHEST_CONTROL_M = 10_000.0
"""Ground control farther from the first photograph is that of another place, or in another CRS."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Survey:
    """What was surveyed beside the photographs.

    Attributes
    ----------
    control
        Points of the ground.
    track
        Of the vehicle that took the photographs without a fix.
    clock_offset_s
        What the camera's clock is behind the track's; NaN where it is to be found.
    places_datum_error_m
        How exactly the CRS of places from a file is known in WGS84.
    """

    control: tuple[ControlPoint, ...] = ()
    track: Track | None = None
    clock_offset_s: float = math.nan
    places_datum_error_m: float = 0.0

    @property
    def datum_error_m(self) -> float:
        """How exactly the CRS of what places the map is known in WGS84, metres."""
        placing = [point.datum_error_m for point in self.control if not point.is_check]
        return max([self.places_datum_error_m, *placing])


@dataclass(frozen=True, slots=True, kw_only=True)
class SurveyedMark:
    """A control point in the local frame, see `ControlPoint`."""

    mark: Mark
    is_check: bool
    datum_error_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundPoint:
    """A control point on the map.

    Attributes
    ----------
    name, is_check
        Of the point.
    off_m
        Where the photographs put it less where it was surveyed, (east, north), shape (2,).
    datum_error_m
        How exactly its CRS is known in WGS84.
    place_m
        Where it was surveyed, local (east, north).
    photos
        That show it and are tied.
    """

    name: str
    is_check: bool
    off_m: FloatArray
    datum_error_m: float
    place_m: FloatArray
    photos: tuple[str, ...]


def frame_of(survey: Survey) -> tuple[GroundFrame, int]:
    """Return the frame and the EPSG code of a map whose photographs have no fix."""
    if survey.control:
        points = survey.control
        latitude = float(np.median([point.latitude_deg for point in points]))
        longitude = float(np.median([point.longitude_deg for point in points]))
    elif survey.track is not None:
        latitude = float(np.median(survey.track.latitudes_deg))
        longitude = float(np.median(survey.track.longitudes_deg))
    else:
        return GroundFrame(LocalFrame(GeoPosition(0.0, 0.0, 0.0))), LOCAL_EPSG
    frame = GroundFrame(LocalFrame(GeoPosition(latitude, longitude, 0.0)))
    return frame, utm_epsg(latitude, longitude)


def control_in(
    frame: GroundFrame, survey: Survey, records: Mapping[str, ShotRecord]
) -> tuple[SurveyedMark, ...]:
    """Return the control points that `records`, by file name, show.

    Raises
    ------
    MappingError
        If one lies far away or outside its photograph, or none is shown.
    """
    if not survey.control:
        return ()
    sightings = sightings_of(survey.control, records)
    found = []
    for point in survey.control:
        if point.name not in sightings:
            continue
        place = frame.local(point.latitude_deg, point.longitude_deg)
        away_m = float(np.linalg.norm(place))
        if away_m > FARTHEST_CONTROL_M:
            raise MappingError(
                f'{point.sightings[0].where}: {point.name} is {away_m / 1000.0:.0f} km from the '
                f'photographs, more than {FARTHEST_CONTROL_M / 1000.0:g} km: wrong CRS, or x and '
                'y exchanged?'
            )
        pixels = {name: np.array(pixel) for name, pixel in sightings[point.name].items()}
        mark = Mark(name=point.name, surveyed_m=place, found_m=place, sightings=pixels)
        found.append(
            SurveyedMark(mark=mark, is_check=point.is_check, datum_error_m=point.datum_error_m)
        )
    return tuple(found)


def path_in(frame: GroundFrame, survey: Survey) -> FlownPath | None:
    """Return the track in local metres, None if there is none."""
    track = survey.track
    if track is None:
        return None
    ground_m = frame.frame.origin.altitude_m
    level = np.full(len(track.times_s), ground_m)
    places = frame.frame.to_enu(track.latitudes_deg, track.longitudes_deg, level)
    places[:, 2] = track.altitudes_m - ground_m
    return FlownPath(times_s=track.times_s, places_m=places)


def found_points(
    control: Sequence[SurveyedMark], photos: Mapping[str, Photo], state: State
) -> tuple[FoundPoint, ...]:
    """Return where the photographs put the control points that tied ones show."""
    found = mark_places_m([surveyed.mark for surveyed in control], photos, state)
    return tuple(
        FoundPoint(
            name=surveyed.mark.name,
            is_check=surveyed.is_check,
            off_m=found[surveyed.mark.name] - surveyed.mark.surveyed_m,
            datum_error_m=surveyed.datum_error_m,
            place_m=surveyed.mark.surveyed_m,
            photos=tuple(sorted(set(surveyed.mark.sightings) & set(state.poses))),
        )
        for surveyed in control
        if surveyed.mark.name in found
    )
