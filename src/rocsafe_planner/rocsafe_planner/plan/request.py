# SPDX-License-Identifier: Apache-2.0
"""The request: regions, camera, fleet and options."""

import hashlib
import json
from collections import Counter
from dataclasses import asdict, dataclass, field, replace

from rocsafe_geo.limits import require_count
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.terrain.terrain import Terrain
from rocsafe_planner.plan.document import (
    area_document,
    camera_document,
    continuation_document,
    region_document,
    terrain_document,
    vehicle_document,
)
from rocsafe_planner.plan.survey_options import (
    AirspaceOptions,
    Continuation,
    CoverageOptions,
    Effort,
    SeparationOptions,
)
from rocsafe_planner.plan.survey_region import SurveyRegion
from rocsafe_planner.plan.vehicle import Vehicle

MAX_VEHICLES = 1000
MAX_REGIONS = 1000
_IDENTITY_VERSION = 3
_LIMIT = 'max_height_agl_m'


@dataclass(frozen=True, slots=True, kw_only=True)
class SurveyRequest:
    """A complete request to the planner; equal requests have equal plans.

    Attributes
    ----------
    regions, camera, vehicles
        Areas to photograph, the nadir camera that all vehicles carry, and the fleet.
    coverage, airspace, separation, effort
        See the values of `survey_options`.
    exclusions
        Zones that no leg crosses and no viewpoint lies in.
    terrain
        Ground that flights follow at the height of the camera; None: the ground is level.
    continuation
        Data taken over from an earlier plan.
    """

    regions: tuple[SurveyRegion, ...]
    camera: PinholeCamera
    vehicles: tuple[Vehicle, ...]
    coverage: CoverageOptions
    exclusions: tuple[SurveyArea, ...] = ()
    terrain: Terrain | None = None
    airspace: AirspaceOptions = field(default_factory=AirspaceOptions)
    separation: SeparationOptions = field(default_factory=SeparationOptions)
    effort: Effort = field(default_factory=Effort)
    continuation: Continuation = field(default_factory=Continuation)

    def __post_init__(self) -> None:
        require_count('number of regions', len(self.regions), 1, MAX_REGIONS)
        require_count('number of exclusions', len(self.exclusions), 0, MAX_REGIONS)
        _check_vehicles(self.vehicles)
        _check_wind(self.airspace.wind_mps, self.vehicles)
        clearance, height = self.airspace.terrain_clearance_m, self.coverage.height_agl_m
        highest = self.airspace.max_height_agl_m
        if height > highest:
            raise ValueError(
                f'height_agl_m is {height:g} m: must be at most max_height_agl_m, {highest:g} m'
            )
        self._reserve_layers()
        if self.terrain is not None and clearance >= height:
            raise ValueError(
                f'terrain_clearance_m is {clearance:g} m: must be below height_agl_m, {height:g} m'
            )

    def _reserve_layers(self) -> None:
        """Give each vehicle a layer of its own, if layers are reserved."""
        if self.separation.by != 'reserved':
            return
        vehicles = tuple(
            replace(vehicle, layer=number) if vehicle.layer is None else vehicle
            for number, vehicle in enumerate(self.vehicles)
        )
        object.__setattr__(self, 'vehicles', vehicles)
        if len({vehicle.layer for vehicle in vehicles}) < len(vehicles):
            raise ValueError('two vehicles have the same layer: layers must differ')
        highest = self.coverage.height_agl_m + max(self.layers_m)
        if highest > self.airspace.max_height_agl_m:
            raise ValueError(
                f'the highest of {len(vehicles)} reserved layers is at {highest:g} m: must be at '
                f'most max_height_agl_m, {self.airspace.max_height_agl_m:g} m'
            )

    @property
    def layers_m(self) -> tuple[float, ...]:
        """How much higher than the camera's height each vehicle flies; empty: not reserved."""
        if self.separation.by != 'reserved':
            return ()
        return tuple(self.separation.distance_m * (v.layer or 0) for v in self.vehicles)

    def identity(self) -> str:
        """Return 16 hexadecimal digits that name the request: SHA-256 of all its values."""
        said = {
            'identity_version': _IDENTITY_VERSION,
            'regions': [region_document(region) for region in self.regions],
            'camera': camera_document(self.camera),
            'vehicles': [vehicle_document(vehicle) for vehicle in self.vehicles],
            'exclusions': [area_document(zone) for zone in self.exclusions],
            'terrain': terrain_document(self.terrain),
            'separation_m': self.separation.distance_m,
            'separation_by': self.separation.by,
            **asdict(self.coverage),
            # A limit that a plan keeps is no part of it.
            **{key: value for key, value in asdict(self.airspace).items() if key != _LIMIT},
            **asdict(self.effort),
            **continuation_document(self.continuation),
        }
        text = json.dumps(said, sort_keys=True, allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def _check_vehicles(vehicles: tuple[Vehicle, ...]) -> None:
    require_count('number of vehicles', len(vehicles), 1, MAX_VEHICLES)
    name, count = Counter(vehicle.name for vehicle in vehicles).most_common(1)[0]
    if count > 1:
        raise ValueError(f'vehicle name {name!r} is given {count} times: names must differ')


def _check_wind(wind_mps: tuple[float, float], vehicles: tuple[Vehicle, ...]) -> None:
    for vehicle in vehicles:
        try:
            vehicle.performance(wind_mps)
        except ValueError as error:
            raise ValueError(f'{vehicle.name}: {error}') from error
