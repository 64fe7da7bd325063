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
     "method": "solver", "seed": 1, "max_viewpoints": 5000,
     "output_directory": "runs/plan"}
"""

import math
from dataclasses import fields
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from rocsafe_geo.motion.autopilot import Autopilot
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import Ring, SurveyArea
from rocsafe_geo.terrain.terrain_file import read_terrain
from rocsafe_planner.problem.survey_region import SurveyRegion
from rocsafe_planner.problem.vehicle import Vehicle
from rocsafe_planner.site.request import (
    DEFAULT_MAX_VIEWPOINTS,
    DEFAULT_METHOD,
    DEFAULT_OBJECTIVE,
    DEFAULT_SEPARATION,
    SurveyRequest,
)

Place = Annotated[list[float], Field(min_length=2, max_length=3)]


class StrictJson(BaseModel):
    """Refuses unknown keys and numbers in quotes."""

    model_config = ConfigDict(extra='forbid', strict=True, frozen=True)


class ZoneJson(StrictJson):
    """A polygon with holes."""

    polygon: list[Place]
    holes: list[list[Place]] = []
    name: str = ''


class RegionJson(ZoneJson):
    """A region to survey."""

    sensors: list[str] = []


class CameraJson(StrictJson):
    """The nadir camera that all vehicles carry."""

    horizontal_fov_deg: float
    image_width_px: int
    image_height_px: int


class VehicleJson(StrictJson):
    """One vehicle."""

    name: str
    home: Place
    cruise_speed_mps: float
    acceleration_mps2: float
    climb_rate_mps: float
    descent_rate_mps: float
    hover_s: float
    endurance_s: float
    battery_swap_s: float | None = None
    end: Place | None = None
    is_open: bool = False
    sensors: list[str] = []
    cruise_power_w: float = 200.0
    hover_power_w: float = 220.0
    autopilot: dict[str, float] = {}


class RequestJson(StrictJson):
    """The whole request; `output_directory` empty: no files are written."""

    region: RegionJson
    other_regions: list[RegionJson] = []
    exclusions: list[ZoneJson] = []
    camera: CameraJson
    vehicles: list[VehicleJson]
    height_agl_m: float
    spacing_rule: str = 'iou'
    overlap_fraction: float = 0.2
    front_overlap_fraction: float | None = None
    grid: str = 'axis_aligned'
    method: str = DEFAULT_METHOD
    objective: str = DEFAULT_OBJECTIVE
    clearance_m: float = 2.0
    wind_mps: tuple[float, float] = (0.0, 0.0)
    separation_m: float = 0.0
    separation_by: str = DEFAULT_SEPARATION
    terrain_file: str = ''
    terrain_clearance_m: float = 10.0
    budget_s: float = 0.0
    proposals: int = 0
    seed: int = 0
    max_viewpoints: int = DEFAULT_MAX_VIEWPOINTS
    output_directory: str = ''

    def survey_request(self) -> SurveyRequest:
        """Return the request proper; ValueError naming the value and the limit."""
        camera = self.camera
        apart = {'region', 'other_regions', 'exclusions', 'camera', 'vehicles', 'terrain_file'}
        return SurveyRequest(
            regions=(
                _region('region', self.region),
                *(_region(f'other_regions.{k}', r) for k, r in enumerate(self.other_regions)),
            ),
            exclusions=tuple(
                area_of(f'exclusions.{k}', zone) for k, zone in enumerate(self.exclusions)
            ),
            camera=PinholeCamera(
                math.radians(camera.horizontal_fov_deg),
                camera.image_width_px,
                camera.image_height_px,
            ),
            vehicles=tuple(_vehicle(vehicle) for vehicle in self.vehicles),
            terrain=read_terrain(self.terrain_file) if self.terrain_file else None,
            **self.model_dump(exclude={*apart, 'output_directory'}),
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
        raise ValueError(one_line(error)) from error


def one_line(error: ValidationError) -> str:
    """Return the path of the first wrong key and what is wrong with it."""
    # A misspelt key also leaves its place empty: the misspelling says more.
    first = min(error.errors(), key=lambda fault: fault['type'] != 'extra_forbidden')
    path = '.'.join(str(part) for part in first['loc']) or 'request'
    return f'{path}: {first["msg"]}'


def _region(path: str, region: RegionJson) -> SurveyRegion:
    return SurveyRegion(area=area_of(path, region), sensors=tuple(region.sensors))


def area_of(path: str, zone: ZoneJson) -> SurveyArea:
    """Return a zone as an area; `path` names it in errors."""
    boundary = _ring(f'{path}.polygon', zone.polygon)
    holes = tuple(_ring(f'{path}.holes.{number}', hole) for number, hole in enumerate(zone.holes))
    try:
        return SurveyArea(boundary=boundary, holes=holes, name=zone.name)
    except ValueError as error:
        raise ValueError(f'{path}: {error}') from error


def _ring(path: str, places: list[Place]) -> Ring:
    return tuple(position_of(f'{path}.{number}', place) for number, place in enumerate(places))


def _vehicle(vehicle: VehicleJson) -> Vehicle:
    home = position_of(f'{vehicle.name} home', vehicle.home)
    end = None if vehicle.end is None else position_of(f'{vehicle.name} end', vehicle.end)
    return Vehicle(
        **{
            **vehicle.model_dump(),
            'home': home,
            'end': end,
            'sensors': tuple(vehicle.sensors),
            'autopilot': _autopilot(vehicle),
        }
    )


def _autopilot(vehicle: VehicleJson) -> Autopilot:
    known = {field.name for field in fields(Autopilot)}
    for key in sorted(set(vehicle.autopilot) - known):
        raise ValueError(f'{vehicle.name} autopilot.{key}: no such setting')
    try:
        return Autopilot(**vehicle.autopilot)
    except ValueError as error:
        raise ValueError(f'{vehicle.name} autopilot: {error}') from error


def position_of(path: str, place: Place) -> GeoPosition:
    """Return a place as a position; `path` names it in errors."""
    try:
        return GeoPosition(*place)
    except ValueError as error:
        raise ValueError(f'{path}: {error}') from error
