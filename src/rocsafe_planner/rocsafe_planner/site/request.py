# SPDX-License-Identifier: Apache-2.0
"""What to plan: a region, a camera, a fleet, and how."""

import hashlib
import json
from collections import Counter
from dataclasses import dataclass

from rocsafe_geo.limits import (
    require_between,
    require_count,
    require_finite,
    require_not_negative,
    require_positive,
)
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.terrain.terrain import Terrain
from rocsafe_planner.coverage.viewpoint_grid import GRIDS, spacing_m
from rocsafe_planner.problem.survey_region import SurveyRegion
from rocsafe_planner.problem.vehicle import Vehicle
from rocsafe_planner.problem.viewpoint import Viewpoint
from rocsafe_planner.routing.methods import METHODS
from rocsafe_planner.site.document import (
    area_document,
    camera_document,
    position_document,
    region_document,
    terrain_document,
    vehicle_document,
    viewpoint_document,
)

DEFAULT_METHOD = 'solver'
DEFAULT_MAX_VIEWPOINTS = 5000
MAX_VEHICLES = 1000
MAX_REGIONS = 1000
MAX_HEIGHT_AGL_M = 20_000.0
MAX_CLEARANCE_M = 1000.0
OBJECTIVES = ('longest_time', 'longest_distance', 'total_time', 'total_distance', 'energy')
DEFAULT_OBJECTIVE = OBJECTIVES[0]
SEPARATIONS = ('delay', 'layers')
DEFAULT_SEPARATION = SEPARATIONS[0]
_IDENTITY_VERSION = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class SurveyRequest:
    """A complete question to the planner; the same question has the same answer.

    Attributes
    ----------
    regions, camera, vehicles
        What to photograph, a nadir camera that all vehicles carry, and the fleet.
    height_agl_m
        Of the camera above level ground.
    spacing_rule
        ``'iou'`` (the paper's) or ``'linear'`` (surveyors'), see `coverage.spacing_m`.
    overlap_fraction
        0 to below 1, meant as `spacing_rule` says: across the image, and along it too unless
        `front_overlap_fraction` says otherwise.
    front_overlap_fraction
        Along the image, in which the nose points.
    grid
        ``'axis_aligned'`` (the paper's circum-rectangle), ``'rotated'`` (the smallest one) or
        ``'best'`` (the angle that needs the fewest viewpoints).
    method
        Name of a routing method, see `routing.METHODS`.
    objective
        What is to be small, see `objective.OBJECTIVE_VALUES`; the methods without a search take
        no notice of it.
    exclusions, clearance_m
        Zones that no leg crosses and no viewpoint lies in, and the distance to be kept from them.
    wind_mps
        (east, north) that the air moves towards; every vehicle must be able to fly in it.
    separation_m
        Least distance of any two in the air; 0: they all take off at once, at one height.
    separation_by
        ``'delay'`` (vehicles take off so late that none comes nearer) or ``'layers'`` (they fly
        higher too where that lets them land earlier).
    terrain, terrain_clearance_m
        Ground whose height the flights follow, `height_agl_m` above it; None: it is level. No leg
        comes nearer to it than the clearance.
    budget_s
        Wall-clock time that may be used to improve the plan.
    proposals
        Without a budget: changes that each of the search's lanes tries; 0: as many as the number
        of points suggests. The same number gives the same plan on every machine.
    seed
        Of methods that draw random numbers.
    max_viewpoints
        A survey that needs more is refused.
    viewpoints, visited
        Places to visit instead of those of a grid, and places photographed before, which count
        as seen; for plans that go on with a survey.
    ground_reference
        Places whose altitudes say how high the ground lies; empty: the homes.
    """

    regions: tuple[SurveyRegion, ...]
    camera: PinholeCamera
    vehicles: tuple[Vehicle, ...]
    height_agl_m: float
    spacing_rule: str = 'iou'
    overlap_fraction: float = 0.2
    front_overlap_fraction: float | None = None
    grid: str = 'axis_aligned'
    method: str = DEFAULT_METHOD
    objective: str = DEFAULT_OBJECTIVE
    exclusions: tuple[SurveyArea, ...] = ()
    clearance_m: float = 2.0
    wind_mps: tuple[float, float] = (0.0, 0.0)
    separation_m: float = 0.0
    separation_by: str = DEFAULT_SEPARATION
    terrain: Terrain | None = None
    terrain_clearance_m: float = 10.0
    budget_s: float = 0.0
    proposals: int = 0
    seed: int = 0
    max_viewpoints: int = DEFAULT_MAX_VIEWPOINTS
    viewpoints: tuple[Viewpoint, ...] = ()
    visited: tuple[Viewpoint, ...] = ()
    ground_reference: tuple[GeoPosition, ...] = ()

    def __post_init__(self) -> None:
        require_count('number of regions', len(self.regions), 1, MAX_REGIONS)
        require_count('number of exclusions', len(self.exclusions), 0, MAX_REGIONS)
        _check_vehicles(self.vehicles)
        _check_wind(self.wind_mps, self.vehicles)
        height = require_positive('height_agl_m', self.height_agl_m, 'm')
        if height > MAX_HEIGHT_AGL_M:
            raise ValueError(
                f'height_agl_m is {height:g} m: must be at most {MAX_HEIGHT_AGL_M:g} m'
            )
        spacing_m(1.0, self.overlap_fraction, self.spacing_rule)
        if self.front_overlap_fraction is not None:
            _check_front_overlap(self.front_overlap_fraction)
        require_one_of('grid', self.grid, tuple(GRIDS))
        require_one_of('method', self.method, tuple(METHODS))
        require_one_of('objective', self.objective, OBJECTIVES)
        require_between('clearance_m', self.clearance_m, 0.0, MAX_CLEARANCE_M, 'm')
        require_not_negative('separation_m', self.separation_m, 'm')
        require_one_of('separation_by', self.separation_by, SEPARATIONS)
        _check_terrain(self)
        require_not_negative('budget_s', self.budget_s, 's')
        require_count('proposals', self.proposals, 0, 2**40)
        require_count('seed', self.seed, 0, 2**64 - 1)
        require_count('max_viewpoints', self.max_viewpoints, 1, 2**32 - 1)

    @property
    def front_overlap(self) -> float:
        """Overlap along the image: that across it unless said otherwise."""
        front = self.front_overlap_fraction
        return self.overlap_fraction if front is None else front

    def identity(self) -> str:
        """Return 16 hexadecimal digits that name the request: SHA-256 of all that it says."""
        said = {
            'identity_version': _IDENTITY_VERSION,
            'regions': [region_document(region) for region in self.regions],
            'camera': camera_document(self.camera),
            'vehicles': [vehicle_document(vehicle) for vehicle in self.vehicles],
            'height_agl_m': float(self.height_agl_m),
            'spacing_rule': self.spacing_rule,
            'overlap_fraction': float(self.overlap_fraction),
            'front_overlap_fraction': self.front_overlap_fraction,
            'grid': self.grid,
            'method': self.method,
            'objective': self.objective,
            'exclusions': [area_document(zone) for zone in self.exclusions],
            'clearance_m': float(self.clearance_m),
            'wind_mps': [float(part) for part in self.wind_mps],
            'separation_m': float(self.separation_m),
            'separation_by': self.separation_by,
            'terrain': terrain_document(self.terrain),
            'terrain_clearance_m': float(self.terrain_clearance_m),
            'viewpoints': [viewpoint_document(view) for view in self.viewpoints],
            'visited': [viewpoint_document(view) for view in self.visited],
            'ground_reference': [position_document(place) for place in self.ground_reference],
            'budget_s': float(self.budget_s),
            'proposals': self.proposals,
            'seed': self.seed,
            'max_viewpoints': self.max_viewpoints,
        }
        text = json.dumps(said, sort_keys=True, allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def require_one_of(name: str, value: str, allowed: tuple[str, ...]) -> None:
    """Raise ValueError unless `value` is one of the names `allowed`."""
    if value not in allowed:
        raise ValueError(f'{name} is {value!r}: must be one of {", ".join(allowed)}')


def _check_vehicles(vehicles: tuple[Vehicle, ...]) -> None:
    require_count('number of vehicles', len(vehicles), 1, MAX_VEHICLES)
    name, count = Counter(vehicle.name for vehicle in vehicles).most_common(1)[0]
    if count > 1:
        raise ValueError(f'vehicle name {name!r} is given {count} times: names must differ')


def _check_terrain(request: SurveyRequest) -> None:
    clearance = require_positive('terrain_clearance_m', request.terrain_clearance_m, 'm')
    if request.terrain is not None and clearance >= request.height_agl_m:
        raise ValueError(
            f'terrain_clearance_m is {clearance:g} m: must be below height_agl_m, '
            f'{request.height_agl_m:g} m'
        )


def _check_front_overlap(overlap: float) -> None:
    value = require_finite('front_overlap_fraction', overlap)
    if not 0.0 <= value < 1.0:
        raise ValueError(f'front_overlap_fraction is {value:g}: must be from 0 to below 1')


def _check_wind(wind_mps: tuple[float, float], vehicles: tuple[Vehicle, ...]) -> None:
    east, north = (require_finite('wind_mps', part, 'm/s') for part in wind_mps)
    for vehicle in vehicles:
        try:
            vehicle.performance((east, north))
        except ValueError as error:
            raise ValueError(f'{vehicle.name}: {error}') from error
