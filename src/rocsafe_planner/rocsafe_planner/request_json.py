# SPDX-License-Identifier: Apache-2.0
"""The request of `plan_file` as JSON: what it may hold, with its defaults.

Units are in the keys; angles in degrees; positions are ``[latitude, longitude]`` or
``[latitude, longitude, altitude_m]`` (above the ellipsoid, of the ground). Unknown keys are
refused. Example::

    {"region": {"name": "yard", "polygon": [[53.2796, -9.0617], ...], "holes": []},
     "camera": {"horizontal_fov_deg": 60, "image_width_px": 640, "image_height_px": 480},
     "vehicles": [{"name": "rav1", "home": [53.28, -9.07], "cruise_speed_mps": 8,
                   "acceleration_mps2": 2.5, "climb_rate_mps": 3, "descent_rate_mps": 2,
                   "hover_s": 2, "endurance_s": 1500}],
     "height_agl_m": 32, "spacing_rule": "iou", "overlap_fraction": 0.2,
     "method": "paper_greedy", "seed": 1, "max_viewpoints": 5000,
     "output_directory": "runs/plan"}
"""

import math
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from rocsafe_geo.area import Ring, SurveyArea
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_planner.request import DEFAULT_MAX_VIEWPOINTS, DEFAULT_METHOD, SurveyRequest
from rocsafe_planner.vehicle import Vehicle

Place = Annotated[list[float], Field(min_length=2, max_length=3)]


class _Strict(BaseModel):
    """Refuses unknown keys and numbers in quotes."""

    model_config = ConfigDict(extra='forbid', strict=True, frozen=True)


class RegionJson(_Strict):
    """The region to survey."""

    polygon: list[Place]
    holes: list[list[Place]] = []
    name: str = ''


class CameraJson(_Strict):
    """The nadir camera that all vehicles carry."""

    horizontal_fov_deg: float
    image_width_px: int
    image_height_px: int


class VehicleJson(_Strict):
    """One vehicle."""

    name: str
    home: Place
    cruise_speed_mps: float
    acceleration_mps2: float
    climb_rate_mps: float
    descent_rate_mps: float
    hover_s: float
    endurance_s: float


class RequestJson(_Strict):
    """The whole request; `output_directory` empty: no files are written."""

    region: RegionJson
    camera: CameraJson
    vehicles: list[VehicleJson]
    height_agl_m: float
    spacing_rule: str = 'iou'
    overlap_fraction: float = 0.2
    grid: str = 'axis_aligned'
    method: str = DEFAULT_METHOD
    budget_s: float = 0.0
    seed: int = 0
    max_viewpoints: int = DEFAULT_MAX_VIEWPOINTS
    output_directory: str = ''

    def survey_request(self) -> SurveyRequest:
        """Return the request proper; ValueError naming the value and the limit."""
        camera = self.camera
        return SurveyRequest(
            area=_area(self.region),
            camera=PinholeCamera(
                math.radians(camera.horizontal_fov_deg),
                camera.image_width_px,
                camera.image_height_px,
            ),
            vehicles=tuple(_vehicle(vehicle) for vehicle in self.vehicles),
            **self.model_dump(exclude={'region', 'camera', 'vehicles', 'output_directory'}),
        )


def parse_request(text: str) -> RequestJson:
    """Return the request that a JSON text holds.

    Raises
    ------
    ValueError
        One line with the path of the first wrong key and what is wrong with it.
    """
    try:
        return RequestJson.model_validate_json(text)
    except ValidationError as error:
        # A misspelt key also leaves its place empty: the misspelling says more.
        first = min(error.errors(), key=lambda fault: fault['type'] != 'extra_forbidden')
        path = '.'.join(str(part) for part in first['loc']) or 'request'
        raise ValueError(f'{path}: {first["msg"]}') from error


def _area(region: RegionJson) -> SurveyArea:
    return SurveyArea(
        boundary=_ring('region.polygon', region.polygon),
        holes=tuple(
            _ring(f'region.holes.{number}', hole) for number, hole in enumerate(region.holes)
        ),
        name=region.name,
    )


def _ring(path: str, places: list[Place]) -> Ring:
    return tuple(_position(f'{path}.{number}', place) for number, place in enumerate(places))


def _vehicle(vehicle: VehicleJson) -> Vehicle:
    home = _position(f'{vehicle.name} home', vehicle.home)
    return Vehicle(**{**vehicle.model_dump(), 'home': home})


def _position(path: str, place: Place) -> GeoPosition:
    try:
        return GeoPosition(*place)
    except ValueError as error:
        raise ValueError(f'{path}: {error}') from error
