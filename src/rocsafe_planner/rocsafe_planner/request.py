# SPDX-License-Identifier: Apache-2.0
"""What to plan: a region, a camera, a fleet, and how."""

import hashlib
import json
from collections import Counter
from dataclasses import dataclass

from rocsafe_geo.area import SurveyArea
from rocsafe_geo.limits import require_count, require_not_negative, require_positive
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_planner.coverage import GRIDS, spacing_m
from rocsafe_planner.document import area_document, camera_document, vehicle_document
from rocsafe_planner.routing import METHODS
from rocsafe_planner.vehicle import Vehicle

DEFAULT_METHOD = 'paper_greedy'
DEFAULT_MAX_VIEWPOINTS = 5000
MAX_VEHICLES = 1000
MAX_HEIGHT_AGL_M = 20_000.0
_IDENTITY_VERSION = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class SurveyRequest:
    """A complete question to the planner; the same question has the same answer.

    Attributes
    ----------
    area, camera, vehicles
        The region, a nadir camera that all vehicles carry, and the fleet.
    height_agl_m
        Of the camera above level ground.
    spacing_rule
        ``'iou'`` (the paper's) or ``'linear'`` (surveyors'), see `coverage.spacing_m`.
    overlap_fraction
        0 to below 1, meant as `spacing_rule` says.
    grid
        ``'axis_aligned'`` (the paper's circum-rectangle) or ``'rotated'`` (the smallest one).
    method
        Name of a routing method, see `routing.METHODS`.
    budget_s
        Wall-clock time that may be used to improve the plan; today's methods need none.
    seed
        Of methods that draw random numbers; today's do not.
    max_viewpoints
        A region that needs more is refused.
    """

    area: SurveyArea
    camera: PinholeCamera
    vehicles: tuple[Vehicle, ...]
    height_agl_m: float
    spacing_rule: str = 'iou'
    overlap_fraction: float = 0.2
    grid: str = 'axis_aligned'
    method: str = DEFAULT_METHOD
    budget_s: float = 0.0
    seed: int = 0
    max_viewpoints: int = DEFAULT_MAX_VIEWPOINTS

    def __post_init__(self) -> None:
        _check_vehicles(self.vehicles)
        height = require_positive('height_agl_m', self.height_agl_m, 'm')
        if height > MAX_HEIGHT_AGL_M:
            raise ValueError(
                f'height_agl_m is {height:g} m: must be at most {MAX_HEIGHT_AGL_M:g} m'
            )
        spacing_m(1.0, self.overlap_fraction, self.spacing_rule)
        require_one_of('grid', self.grid, tuple(GRIDS))
        require_one_of('method', self.method, tuple(METHODS))
        require_not_negative('budget_s', self.budget_s, 's')
        require_count('seed', self.seed, 0, 2**64 - 1)
        require_count('max_viewpoints', self.max_viewpoints, 1, 2**32 - 1)

    def identity(self) -> str:
        """Return 16 hexadecimal digits that name the request: SHA-256 of all that it says."""
        said = {
            'identity_version': _IDENTITY_VERSION,
            'area': area_document(self.area),
            'camera': camera_document(self.camera),
            'vehicles': [vehicle_document(vehicle) for vehicle in self.vehicles],
            'height_agl_m': float(self.height_agl_m),
            'spacing_rule': self.spacing_rule,
            'overlap_fraction': float(self.overlap_fraction),
            'grid': self.grid,
            'method': self.method,
            'budget_s': float(self.budget_s),
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
