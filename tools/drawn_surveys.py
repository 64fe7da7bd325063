# SPDX-License-Identifier: Apache-2.0
"""Random surveys of all kinds: a number is the seed of its survey.

Regions are concave, holed, thin or tiny, up to three of them; exclusions lie inside, across and
around; every option of a vehicle varies; there is wind and terrain; every objective,
method and grid. Many of these surveys cannot be planned: the planner must refuse them in one line.
"""

import dataclasses
import math
from typing import TypeVar

import numpy as np

from rocsafe_geo.motion.autopilot import ARDUCOPTER, DIRECT, Autopilot
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition, offset
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.terrain.terrain import Terrain
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.situation import Situation
from rocsafe_planner.plan.survey_options import (
    GRIDS,
    OBJECTIVES,
    SEPARATIONS,
    SPACING_RULES,
    AirspaceOptions,
    CoverageOptions,
    Effort,
    SeparationOptions,
)
from rocsafe_planner.plan.survey_region import SurveyRegion
from rocsafe_planner.plan.vehicle import Aloft, Vehicle
from rocsafe_planner.routing.methods import METHODS

CENTRE = GeoPosition(53.28, -9.06)
CAMERA = PinholeCamera(math.radians(60.0), 640, 480)
AUTOPILOTS = (
    ARDUCOPTER,
    DIRECT,
    Autopilot(jerk_mps3=4.0, smoothing_s=0.0, waypoint_radius_m=8.0, landing_height_m=50.0),
)
T = TypeVar('T')
Ring = list[tuple[float, float]]


class Dice:
    """Random choices from one seed."""

    def __init__(self, *seed: int) -> None:
        self._draw = np.random.default_rng(seed)

    def within(self, low: float, high: float) -> float:
        """Return a number between two."""
        return float(self._draw.uniform(low, high))

    def count(self, low: int, high: int) -> int:
        """Return a whole number from `low` to `high`."""
        return int(self._draw.integers(low, high + 1))

    def one(self, *choices: T) -> T:
        """Return one of several."""
        return choices[self.count(0, len(choices) - 1)]

    def chance(self, of: float) -> bool:
        """Return True with the given probability."""
        return self.within(0.0, 1.0) < of


def drawn_request(number: int) -> SurveyRequest:
    """Return the random survey of a seed.

    Raises
    ------
    ValueError
        In one line, if the drawn values are no valid request.
    """
    dice = Dice(1, number)
    ground = dice.within(0.0, 80.0) if dice.chance(0.7) else math.nan
    terrain = _terrain(dice) if dice.chance(0.25) else None
    regions, fleet = _regions(dice), _fleet(dice, ground)
    coverage = CoverageOptions(
        height_agl_m=dice.one(25.0, 40.0, 40.0, 60.0, 120.0),
        spacing_rule=dice.one(*SPACING_RULES),
        overlap_fraction=dice.one(0.0, 0.2, 0.2, 0.6),
        front_overlap_fraction=dice.one(None, None, 0.0, 0.7),
        grid=dice.one(*GRIDS),
        max_viewpoints=500,
    )
    method = dice.one('solver', 'solver', 'solver', *METHODS)
    objective = dice.one(*OBJECTIVES)
    exclusions = tuple(_exclusion(dice) for _ in range(dice.one(0, 0, 1, 2, 4)))
    clearance_m = dice.one(0.0, 2.0, 10.0)
    wind_mps = dice.one((0.0, 0.0), (dice.within(-5.0, 5.0), dice.within(-5.0, 5.0)))
    separation = SeparationOptions(
        distance_m=dice.one(0.0, 0.0, 5.0, 20.0), by=dice.one(*SEPARATIONS)
    )
    return SurveyRequest(
        regions=regions,
        camera=CAMERA,
        vehicles=fleet,
        coverage=coverage,
        exclusions=exclusions,
        terrain=terrain,
        airspace=AirspaceOptions(
            clearance_m=clearance_m,
            wind_mps=wind_mps,
            terrain_clearance_m=dice.one(5.0, 10.0, 20.0),
        ),
        separation=separation,
        effort=Effort(method=method, objective=objective, seed=dice.count(0, 9)),
    )


def drawn_situation(plan: SurveyPlan, number: int, times: int) -> Situation:
    """Return a random situation during a plan: vehicles left, viewpoints visited, new places."""
    dice = Dice(2, number, times)
    share = dice.within(0.0, 1.0)
    alive: dict[str, Aloft | float | None] = {}
    visited: set[int] = set()
    for route in plan.routes:
        done = route.viewpoints[: int(share * len(route.viewpoints))]
        visited |= {view.id for view in done}
        place = done[-1].position if done else route.vehicle.start
        used_s = min(share * route.duration_s, 0.9 * route.vehicle.endurance_s)
        now = dice.one(Aloft(position=place, used_s=used_s), used_s, None)
        if not dice.chance(0.3):
            alive[route.vehicle.name] = now
    return Situation(
        alive=alive,
        visited=frozenset(visited),
        new_places=tuple(_near(dice, 200.0) for _ in range(dice.one(0, 0, 1, 5))),
        new_exclusions=tuple(_exclusion(dice) for _ in range(dice.one(0, 0, 1, 2))),
    )


def _near(dice: Dice, far_m: float) -> GeoPosition:
    return offset(CENTRE, dice.within(-far_m, far_m), dice.within(-far_m, far_m))


def _placed(corners: Ring, east: float = 0.0, north: float = 0.0) -> tuple[GeoPosition, ...]:
    return tuple(offset(CENTRE, x + east, y + north) for x, y in corners)


def _star(dice: Dice, low_m: float, high_m: float) -> Ring:
    count, turn = dice.count(3, 9), dice.within(0.0, 6.0)
    angles = [turn + math.tau * k / count for k in range(count)]
    radii = [dice.within(low_m, high_m) for _ in angles]
    return [(r * math.cos(a), r * math.sin(a)) for r, a in zip(radii, angles, strict=True)]


def _comb(dice: Dice) -> Ring:
    """Return a comb with two to four teeth, a very concave region."""
    teeth, wide, long = dice.count(2, 4), dice.within(15.0, 40.0), dice.within(40.0, 160.0)
    top: Ring = []
    for k in range(teeth):
        left = 2.0 * k * wide
        top += [(left, long), (left + wide, long), (left + wide, 20.0), (left + 2 * wide, 20.0)]
    return [(x - teeth * wide, y) for x, y in [(2.0 * wide * teeth, 0.0), (0.0, 0.0), *top[:-1]]]


def _area(dice: Dice, name: str) -> SurveyArea:
    east, north = dice.one((0.0, 0.0), (dice.within(-150.0, 150.0), dice.within(-150.0, 150.0)))
    kind = dice.one('star', 'star', 'holed', 'comb', 'thin', 'tiny')
    if kind == 'tiny':
        return SurveyArea(_placed([(0.0, 0.0), (0.5, 0.0), (0.0, 0.5)], east, north), name=name)
    if kind == 'thin':
        long, turn = dice.within(50.0, 300.0), dice.within(0.0, 3.0)
        cos, sin = math.cos(turn), math.sin(turn)
        strip = [(-long, 0.0), (long, 0.0), (long, 0.5), (-long, 0.5)]
        turned = [(x * cos - y * sin, x * sin + y * cos) for x, y in strip]
        return SurveyArea(_placed(turned, east, north), name=name)
    corners = _comb(dice) if kind == 'comb' else _star(dice, 20.0, 170.0)
    holes = []
    if kind == 'holed':
        inner = dice.within(0.1, 0.9)
        holes = [_placed([(inner * x, inner * y) for x, y in corners], east, north)]
    return SurveyArea(_placed(corners, east, north), tuple(holes), name=name)


def _regions(dice: Dice) -> tuple[SurveyRegion, ...]:
    return tuple(
        SurveyRegion(area=_area(dice, f'field {k}'), sensors=dice.one((), (), ('gamma',)))
        for k in range(dice.one(1, 1, 2, 3))
    )


def _exclusion(dice: Dice) -> SurveyArea:
    """Return a zone: a star somewhere, or rarely a wall all around the regions."""
    if dice.chance(0.03):
        wall = [(1.1 * x, 1.1 * y) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        outer, inner = ([(s * x, s * y) for x, y in wall] for s in (190.0, 180.0))
        return SurveyArea(_placed(outer), (_placed(inner),))
    east, north = dice.within(-150.0, 150.0), dice.within(-150.0, 150.0)
    return SurveyArea(_placed(_star(dice, 5.0, dice.one(20.0, 60.0, 120.0)), east, north))


def _fleet(dice: Dice, ground_m: float) -> tuple[Vehicle, ...]:
    """Return up to six vehicles, all alike at one home or each of its own kind."""
    count = dice.one(1, 2, 3, 4, 6)
    if dice.chance(0.3):
        kind = _vehicle(dice, 'rav0', ground_m)
        kind = dataclasses.replace(kind, sensors=('gamma',))
        return tuple(dataclasses.replace(kind, name=f'rav{k}') for k in range(count))
    fleet = [_vehicle(dice, f'rav{k}', ground_m) for k in range(count)]
    if dice.chance(0.9):
        fleet[0] = dataclasses.replace(fleet[0], sensors=('gamma',))
    return tuple(fleet)


def _vehicle(dice: Dice, name: str, ground_m: float) -> Vehicle:
    home = _stand(dice, ground_m)
    landing = dice.one('home', 'home', 'open', 'elsewhere')
    endurance_s = dice.one(dice.within(60.0, 400.0), 600.0, 1500.0, 10_000.0, 10_000.0)
    return Vehicle(
        name=name,
        home=home,
        cruise_speed_mps=dice.within(4.0, 18.0),
        acceleration_mps2=dice.within(0.5, 5.0),
        climb_rate_mps=dice.within(1.0, 6.0),
        descent_rate_mps=dice.within(0.5, 4.0),
        hover_s=dice.one(0.0, 0.0, 2.0, dice.within(0.0, 4.0)),
        endurance_s=endurance_s,
        battery_swap_s=dice.one(None, 0.0, 60.0, 60.0),
        end=_stand(dice, ground_m) if landing == 'elsewhere' else None,
        is_open=landing == 'open',
        sensors=dice.one((), ('gamma',), ('gamma', 'gas')),
        aloft=_aloft(dice, home) if dice.chance(0.1) else None,
        used_s=dice.one(0.0, 0.0, 0.0, 100.0),
        autopilot=dice.one(*AUTOPILOTS),
    )


def _stand(dice: Dice, ground_m: float) -> GeoPosition:
    """Return a random home outside the regions, rarely in one of them."""
    if dice.chance(0.1):
        place = _near(dice, 150.0)
    else:
        bearing, far = dice.within(0.0, 6.28), dice.within(200.0, 600.0)
        place = offset(CENTRE, far * math.cos(bearing), far * math.sin(bearing))
    return GeoPosition(place.latitude_deg, place.longitude_deg, ground_m)


def _aloft(dice: Dice, home: GeoPosition) -> Aloft:
    place = _near(dice, 200.0)
    altitude = home.altitude_m + dice.within(5.0, 150.0)
    return Aloft(
        position=GeoPosition(place.latitude_deg, place.longitude_deg, altitude),
        used_s=dice.within(0.0, 100.0),
    )


def _terrain(dice: Dice) -> Terrain:
    """Return hills of up to 100 m on pixels of 20 m, rarely with too little ground."""
    half_m, step_m = dice.one(2000.0, 2000.0, 2000.0, 250.0), 20.0
    count = int(2 * half_m / step_m)
    along = step_m * (np.arange(count) + 0.5) - half_m
    east, north = np.meshgrid(along, along[::-1])
    heights = dice.within(-50.0, 200.0) + dice.within(-0.1, 0.1) * east
    for _ in range(dice.count(0, 4)):
        x, y, wide = (dice.within(-300.0, 300.0) for _ in range(3))
        distance2 = (east - x) ** 2 + (north - y) ** 2
        heights += dice.within(-40.0, 100.0) * np.exp(-distance2 / (50.0 + abs(wide)) ** 2)
    wide_deg = 111_320.0 * math.cos(math.radians(CENTRE.latitude_deg))
    west = CENTRE.longitude_deg - half_m / wide_deg
    top = CENTRE.latitude_deg + half_m / 111_320.0
    return Terrain(
        heights_m=heights,
        to_column=(wide_deg / step_m, 0.0, -west * wide_deg / step_m),
        to_row=(0.0, -111_320.0 / step_m, top * 111_320.0 / step_m),
        crs='EPSG:4326',
        digest=f'{heights.sum():.6f}',
    )
