# SPDX-License-Identifier: Apache-2.0
"""Options of a survey: photographs, airspace, separation, effort. The defaults are defined here.

Scenarios, messages and commands take their defaults from these values.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

from rocsafe_geo.limits import (
    require_between,
    require_count,
    require_finite,
    require_not_negative,
    require_positive,
)
from rocsafe_geo.position import GeoPosition
from rocsafe_planner.plan.viewpoint import Viewpoint

MAX_HEIGHT_AGL_M = 20_000.0
MAX_CLEARANCE_M = 1000.0
USUAL_VIEWPOINTS_LIMIT = 100_000
"""A survey that needs more is refused unless its limit is raised: a slip of the pen."""
MAX_VIEWPOINTS_LIMIT = 1_000_000
"""Height to which the limit can be raised."""
Grid = Literal['best', 'rotated', 'axis_aligned']
Objective = Literal['longest_time', 'longest_distance', 'total_time', 'total_distance', 'energy']
Separation = Literal['delay', 'layers', 'reserved']
SpacingRule = Literal['iou', 'linear']
GRIDS: tuple[Grid, ...] = get_args(Grid)
OBJECTIVES: tuple[Objective, ...] = get_args(Objective)
PEAK_OBJECTIVES = ('longest_time', 'longest_distance')
"""Objectives of the costliest route; the others are sums over all routes."""
SEPARATIONS: tuple[Separation, ...] = get_args(Separation)
METHODS = (
    'solver', 'boustrophedon_minmax', 'boustrophedon_equal', 'strips', 'christofides',
    'nearest_to_shortest', 'insertion', 'paper_greedy',
)  # fmt: skip

SPACING_RULES: dict[str, Callable[[float], float]] = {
    'iou': lambda overlap: (1.0 - overlap) / (1.0 + overlap),
    'linear': lambda overlap: 1.0 - overlap,
}
"""Spacing as a fraction of the footprint, by name of the rule."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CoverageOptions:
    """Places at which photographs are taken.

    Attributes
    ----------
    height_agl_m
        Height of the camera above the ground, metres.
    spacing_rule
        ``'iou'`` (the paper's) or ``'linear'`` (surveyors'), see `spacing_m`.
    overlap_fraction
        0 to below 1, as `spacing_rule` defines it: across the image, and along it unless
        `front_overlap_fraction` is given.
    front_overlap_fraction
        The same along the image, in the direction of the nose; None: `overlap_fraction`.
    grid
        ``'best'`` (the angle that needs the fewest viewpoints), ``'rotated'`` (the smallest
        rectangle) or ``'axis_aligned'`` (the paper's circum-rectangle).
    max_viewpoints
        A survey that needs more is refused.
    """

    height_agl_m: float
    spacing_rule: str = 'iou'
    overlap_fraction: float = 0.2
    front_overlap_fraction: float | None = None
    grid: str = GRIDS[0]
    max_viewpoints: int = USUAL_VIEWPOINTS_LIMIT

    def __post_init__(self) -> None:
        height = require_positive('height_agl_m', self.height_agl_m, 'm')
        if height > MAX_HEIGHT_AGL_M:
            raise ValueError(
                f'height_agl_m is {height:g} m: must be at most {MAX_HEIGHT_AGL_M:g} m'
            )
        object.__setattr__(self, 'height_agl_m', height)
        spacing_m(1.0, self.overlap_fraction, self.spacing_rule)
        object.__setattr__(self, 'overlap_fraction', float(self.overlap_fraction))
        if self.front_overlap_fraction is not None:
            require_overlap('front_overlap_fraction', self.front_overlap_fraction)
        require_one_of('grid', self.grid, GRIDS)
        require_count('max_viewpoints', self.max_viewpoints, 1, MAX_VIEWPOINTS_LIMIT)

    @property
    def front_overlap(self) -> float:
        """Overlap along the image."""
        front = self.front_overlap_fraction
        return self.overlap_fraction if front is None else front


@dataclass(frozen=True, slots=True, kw_only=True)
class AirspaceOptions:
    """Clearances of flights, and the wind.

    Attributes
    ----------
    clearance_m
        Distance of legs and viewpoints from exclusions, metres; may be 0.
    terrain_clearance_m
        Height of legs above the terrain, metres.
    max_height_agl_m
        Greatest height above the ground of anything that is flown, metres. 120 m is the limit of
        the open category in the European Union (Regulation 2019/947, UAS.OPEN.010); an operator
        with an authorisation raises it.
    wind_mps
        (east, north) velocity of the air, m/s; every vehicle must be able to fly in it.
    """

    clearance_m: float = 2.0
    terrain_clearance_m: float = 10.0
    max_height_agl_m: float = 120.0
    wind_mps: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        require_between('clearance_m', self.clearance_m, 0.0, MAX_CLEARANCE_M, 'm')
        clearance = require_positive('terrain_clearance_m', self.terrain_clearance_m, 'm')
        east, north = (require_finite('wind_mps', part, 'm/s') for part in self.wind_mps)
        object.__setattr__(self, 'clearance_m', float(self.clearance_m))
        object.__setattr__(self, 'terrain_clearance_m', clearance)
        highest = require_positive('max_height_agl_m', self.max_height_agl_m, 'm')
        object.__setattr__(self, 'max_height_agl_m', highest)
        object.__setattr__(self, 'wind_mps', (east, north))


@dataclass(frozen=True, slots=True, kw_only=True)
class SeparationOptions:
    """Separation of vehicles in the air.

    Attributes
    ----------
    distance_m
        Least distance of any two, metres; 0: all take off at once, at one height. The default is
        twice the 95 % error of a receiver without correction signals (about 5 m, GPS Standard
        Positioning Service, with a vehicle's own size and its deviation from its way).
    by
        ``'delay'`` (vehicles wait), ``'layers'`` (they fly at different heights, too, where
        that lets them land earlier), or ``'reserved'`` (each vehicle has a layer of its own in
        all plans, so that vehicles with different plans do not meet on their way).
    """

    distance_m: float = 10.0
    by: str = 'layers'

    def __post_init__(self) -> None:
        distance = require_not_negative('separation distance_m', self.distance_m, 'm')
        object.__setattr__(self, 'distance_m', distance)
        require_one_of('separation by', self.by, SEPARATIONS)


@dataclass(frozen=True, slots=True, kw_only=True)
class Effort:
    """Routing method, objective, and length of the search.

    Attributes
    ----------
    method
        Routing method.
    objective
        What is minimised; methods without a search ignore it.
    budget_s
        Wall-clock time that may be used to improve the plan, seconds. 0: the search ends after a
        number of proposals, so that a request has the same plan on every machine.
    proposals
        Without a budget: changes that each lane of the search tries; 0: as many as the number of
        points suggests.
    seed
        Seed of the search.
    """

    method: str = METHODS[0]
    objective: str = OBJECTIVES[0]
    budget_s: float = 0.0
    proposals: int = 0
    seed: int = 0

    def __post_init__(self) -> None:
        require_one_of('method', self.method, METHODS)
        require_one_of('objective', self.objective, OBJECTIVES)
        budget = require_not_negative('budget_s', self.budget_s, 's')
        object.__setattr__(self, 'budget_s', budget)
        require_count('proposals', self.proposals, 0, 2**40)
        require_count('seed', self.seed, 0, 2**64 - 1)

    @property
    def minimises_makespan(self) -> bool:
        """Whether the objective is the time until the last vehicle has landed."""
        return self.objective == OBJECTIVES[0]


@dataclass(frozen=True, slots=True, kw_only=True)
class UnheardVehicle:
    """A vehicle in the air that nobody hears, and that has no part in the plan.

    It goes on along its route, or returns, by itself.

    Attributes
    ----------
    name
        Its name.
    flight_height_m
        Height of its legs above the ground.
    home
        Where it lands.
    places
        Corners of its route.
    """

    name: str
    flight_height_m: float
    home: GeoPosition
    places: tuple[GeoPosition, ...]

    def __post_init__(self) -> None:
        require_not_negative('flight_height_m', self.flight_height_m, 'm')


@dataclass(frozen=True, slots=True, kw_only=True)
class Continuation:
    """Data that a plan takes over from the plan that it continues.

    Attributes
    ----------
    viewpoints
        Places to visit instead of those of a grid; empty: the regions are covered.
    visited
        Places photographed before, which count as seen.
    ground_reference
        Places whose altitudes define the height of level ground; empty: the homes.
    unheard
        Vehicles of which nobody hears. No route is flown nearer to their heights than the
        separation, nor, where a layer avoids it, through the columns of their homes or up and
        down over their routes.
    last
        Ids of viewpoints that each vehicle visits after all its others.
    """

    viewpoints: tuple[Viewpoint, ...] = ()
    visited: tuple[Viewpoint, ...] = ()
    ground_reference: tuple[GeoPosition, ...] = ()
    unheard: tuple[UnheardVehicle, ...] = ()
    last: tuple[int, ...] = ()

    @property
    def is_rest(self) -> bool:
        """Whether the viewpoints are the rest of an earlier plan: some may be left out."""
        return bool(self.ground_reference)


def spacing_m(footprint_m: float, overlap_fraction: float, rule: str) -> float:
    """Return the distance between neighbouring viewpoints along one side of the footprint.

    Rule ``'iou'`` is w = 2h((1-y)/(1+y))tan(theta) with theta half the field of view (Smyth et
    al. 2018, section IV): two neighbouring photographs share the fraction y of the ground that
    either shows. Rule ``'linear'`` is the surveyors' w = F(1-y): they share the fraction y of
    one. With F = 2h tan(theta), y = 0.2 is 33.3 % of the image side by the first rule and 20 %
    by the second.

    Raises
    ------
    ValueError
        If the rule is not known or the overlap is outside 0 to below 1.
    """
    require_one_of('spacing_rule', rule, tuple(SPACING_RULES))
    return footprint_m * SPACING_RULES[rule](require_overlap('overlap_fraction', overlap_fraction))


def require_overlap(name: str, value: float) -> float:
    """Return an overlap as a float; raise ValueError unless it is from 0 to below 1."""
    overlap = require_finite(name, value)
    if not 0.0 <= overlap < 1.0:
        raise ValueError(f'{name} is {overlap:g}: must be from 0 to below 1')
    return overlap


def require_one_of(name: str, value: str, allowed: tuple[str, ...]) -> None:
    """Raise ValueError unless `value` is one of the names `allowed`."""
    if value not in allowed:
        raise ValueError(f'{name} is {value!r}: must be one of {", ".join(allowed)}')
