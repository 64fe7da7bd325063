# SPDX-License-Identifier: Apache-2.0
"""The routing problem in the plane, and its time model.

A vehicle climbs to the survey height at home, flies legs from standstill to standstill, hovers at
each viewpoint, returns at the survey height and descends. It stops wherever a leg bends around an
exclusion or over a hill. A vehicle without viewpoints stays on the ground; one that is in the air
already begins where it is, and lands in any case.

A vehicle that begins in the air first climbs or descends to the height of its legs.

Sites are numbered: the n points, then the starts of the m vehicles, their ends, their homes.
"""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray, IndexArray
from rocsafe_geo.motion.route_motion import RouteMotion
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.terrain.relief import Relief
from rocsafe_geo.terrain.terrain import LocalGround
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_planner.problem.detours import Air, Detours
from rocsafe_planner.problem.flight_motion import enu, flight_motion
from rocsafe_planner.problem.flight_time import FlightTime
from rocsafe_planner.problem.leg_times import MOST_KEPT, LegTimes, distances_m

# A vehicle that begins so near to the height of its legs does not climb to it first, metres.
LEVEL_M = 0.5
Order = list[int]
"""Indices of points in flying order."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FleetProblem:
    """Points to visit by a fleet; places are (east, north) in metres.

    Attributes
    ----------
    homes, ends, starts
        Where each vehicle stands, lands and begins, shape (m, 2); without `ends` it lands at
        home, without `starts` it begins there. Where a vehicle `is_open`, its end means nothing:
        it lands at its last viewpoint.
    points
        Shape (n, 2).
    height_m
        Above the ground, to climb to and to descend from.
    insides
        Where vehicles are that begin in an exclusion, which they leave to their start first,
        shape (m, 3), NaN: in none; with an up of NaN at the height of the legs.
    start_ups_m
        Height of each vehicle where it begins in the air, above the frame's origin, shape (m,),
        NaN: that of the legs.
    separation_m
        Least distance of two vehicles in the air; 0: none is kept.
    layers_m
        How much higher than `height_m` each vehicle flies; empty: none does.
    ground, relief
        What the legs follow, and what they keep above; None: level ground.
    wind_mps
        (east, north) that the air moves towards.
    detours
        Shortest paths among all sites; None: legs are straight.
    may_visit
        Which vehicle has the sensors for which point, (m, n); None: each for all.
    grid_rad
        Direction of the rows that the points lie in, if they do: 0 = east, anticlockwise.
    name_of
        Tells a person which point is meant.
    """

    vehicles: tuple[Vehicle, ...]
    homes: FloatArray
    points: FloatArray
    height_m: float
    ends: FloatArray | None = None
    starts: FloatArray | None = None
    insides: FloatArray | None = None
    start_ups_m: FloatArray | None = None
    separation_m: float = 0.0
    layers_m: tuple[float, ...] = ()
    ground: LocalGround | None = None
    relief: Relief | None = None
    wind_mps: tuple[float, float] = (0.0, 0.0)
    detours: Detours | None = None
    may_visit: BoolArray | None = None
    grid_rad: float = 0.0
    name_of: Callable[[int], str] = 'viewpoint {}'.format
    _airs: dict[tuple[FlightTime, float], Air] = field(
        default_factory=dict, init=False, repr=False
    )
    _air_of: dict[int, Air] = field(default_factory=dict, init=False, repr=False)
    _times: dict[Air, LegTimes] = field(default_factory=dict, init=False, repr=False)
    _motions: dict[Hashable, RouteMotion] = field(default_factory=dict, init=False, repr=False)

    def in_layers(self, layers_m: tuple[float, ...]) -> 'FleetProblem':
        """Return the problem of vehicles that fly higher, with the motions known so far."""
        other = replace(self, layers_m=layers_m)
        object.__setattr__(other, '_motions', self._motions)
        return other

    @cached_property
    def sites(self) -> FloatArray:
        """Places of all sites, shape (n + 3 m, 2)."""
        starts = self.homes if self.starts is None else self.starts
        ends = self.homes if self.ends is None else self.ends
        return np.vstack([self.points, starts, ends, self.homes])

    @cached_property
    def ups_m(self) -> FloatArray:
        """Flying height over the sites, above the frame's origin, shape (n + 3 m,)."""
        return self._ups_m(0.0)

    def _ups_m(self, layer_m: float) -> FloatArray:
        """Return the flying height over the sites in a layer."""
        ups = self._over(self.sites) + layer_m
        if self.start_ups_m is not None:
            starts = slice(len(self.points), len(self.points) + len(self.vehicles))
            is_level = np.abs(self.start_ups_m - ups[starts]) <= LEVEL_M
            is_open = np.array([vehicle.is_open for vehicle in self.vehicles])
            begins_there = is_level | (is_open & np.isfinite(self.start_ups_m))
            ups[starts] = np.where(begins_there, self.start_ups_m, ups[starts])
        return ups

    def flight(self, vehicle: int) -> FlightTime:
        """Return the times of a vehicle's flights."""
        spec = self.vehicles[vehicle]
        return FlightTime(
            performance=spec.performance(self.wind_mps),
            relief=self.relief,
            passes=spec.hover_s == 0.0,
        )

    @property
    def legs_are_plain(self) -> bool:
        """Whether the time of a leg depends on its length only."""
        is_level = self.ground is None and self.start_ups_m is None
        return is_level and self.detours is None and self.wind_mps == (0.0, 0.0)

    def layer_m(self, vehicle: int) -> float:
        """Return the height of a vehicle's layer above the lowest one, metres."""
        return self.layers_m[vehicle] if self.layers_m else 0.0

    def flight_height_m(self, vehicle: int) -> float:
        """Return the height above the ground at which a vehicle flies."""
        return self.height_m + self.layer_m(vehicle)

    def allowed(self, vehicle: int) -> BoolArray:
        """Return which points a vehicle has the sensors for, shape (n,)."""
        if self.may_visit is None:
            return np.ones(len(self.points), dtype=bool)
        return self.may_visit[vehicle]

    def alike(self, vehicle: int) -> Hashable:
        """Return a key: vehicles with equal keys take equal times over equal orders."""
        ends = [self.start_site(vehicle), self.home_site(vehicle)]
        end = self.end_site(vehicle)
        ends += [] if end is None else [end]
        places = np.column_stack([self.sites[ends], self.ups_m[ends]])
        return (
            self.flight(vehicle),
            self.layer_m(vehicle),
            self.vehicles[vehicle].hover_s,
            self.first_fixed_s(vehicle),
            tuple(places.ravel().tolist()),
        )

    def start_site(self, vehicle: int) -> int:
        """Return the site where a vehicle begins."""
        return len(self.points) + vehicle

    def end_site(self, vehicle: int) -> int | None:
        """Return the site where a vehicle lands, None if that is its last viewpoint."""
        if self.vehicles[vehicle].is_open:
            return None
        return len(self.points) + len(self.vehicles) + vehicle

    def home_site(self, vehicle: int) -> int:
        """Return the site where a vehicle changes its battery."""
        return len(self.points) + 2 * len(self.vehicles) + vehicle

    def distances_m(self, site: int) -> FloatArray:
        """Return the lengths of the legs from one site to all, shape (n + 3 m,)."""
        if self.detours is not None:
            return self.detours.length_m[site]
        return distances_m(self.sites, self.sites[site])

    def legs_m(self, origins: IndexArray, targets: IndexArray) -> FloatArray:
        """Return the horizontal lengths of legs between sites."""
        if self.detours is not None:
            lengths: FloatArray = self.detours.length_m[origins, targets]
            return lengths
        return distances_m(self.sites[targets], self.sites[origins])

    def legs_s(self, vehicle: int, origins: IndexArray, targets: IndexArray) -> FloatArray:
        """Return the times that a vehicle needs for legs between sites, without hovering."""
        return self._times[self._air(vehicle)](origins, targets)

    def stopping_legs_s(self, vehicle: int) -> FloatArray:
        """Return the times of all legs between sites as if the vehicle stopped at viewpoints."""
        air, every = self._air(vehicle), np.arange(len(self.sites))
        stopping = replace(air, flight=replace(self.flight(vehicle), passes=False))
        return LegTimes(stopping, self.detours, 0)(every[:, None], every[None, :])

    def fixed_s(self, vehicle: int) -> float:
        """Return the time of climb and descent of a flight from home."""
        return self.vehicles[vehicle].vertical_s(self.flight_height_m(vehicle))

    def first_fixed_s(self, vehicle: int) -> float:
        """Return the time of a vehicle's first flight besides its legs and stands.

        It climbs, unless it is in the air, leaves the exclusion that it is in, and descends.
        """
        vertical_s = self.vehicles[vehicle].first_vertical_s(self.flight_height_m(vehicle))
        return vertical_s + self._exit_s(vehicle)

    def inside(self, vehicle: int) -> Enu | None:
        """Return where a vehicle is that first flies to its start; None: it is there.

        It leaves an exclusion, or comes to the height of its legs.
        """
        start_east, start_north, over = self._air(vehicle).sites[self.start_site(vehicle)].tolist()
        if self.is_shut_in(vehicle) and self.insides is not None:
            east, north, up = self.insides[vehicle].tolist()
            return east, north, over if np.isnan(up) else up
        up = np.nan if self.start_ups_m is None else float(self.start_ups_m[vehicle])
        return None if np.isnan(up) or up == over else (start_east, start_north, up)

    def is_shut_in(self, vehicle: int) -> bool:
        """Return whether a vehicle begins inside an exclusion."""
        return self.insides is not None and not np.isnan(self.insides[vehicle, 0])

    def exit_m(self, vehicle: int) -> float:
        """Return the length of a vehicle's way out of the exclusion that it begins in."""
        if (inside := self.inside(vehicle)) is None:
            return 0.0
        return float(distances_m(self.sites[self.start_site(vehicle)], np.array(inside[:2])))

    def _exit_s(self, vehicle: int) -> float:
        if (inside := self.inside(vehicle)) is None:
            return 0.0
        flight = self.flight(vehicle)
        start = self._air(vehicle).sites[self.start_site(vehicle)]
        return float(flight.straight(np.array(inside), start))

    def stops(self, vehicle: int, order: Sequence[int]) -> IndexArray:
        """Return the sites of a flight that visits points in order, from start to end."""
        end = self.end_site(vehicle)
        last = [] if end is None else [end]
        return np.array([self.start_site(vehicle), *order, *last], dtype=np.intp)

    def length_m(self, vehicle: int, order: Sequence[int]) -> float:
        """Return the horizontal length of a flight from start to end; 0 for one on the ground."""
        if not self.flies(vehicle, order):
            return 0.0
        stops = self.stops(vehicle, order)
        return self.exit_m(vehicle) + float(self.legs_m(stops[:-1], stops[1:]).sum())

    def duration_s(self, vehicle: int, order: Sequence[int]) -> float:
        """Return the time from the start to touch-down; 0 for a vehicle on the ground."""
        if not self.flies(vehicle, order):
            return 0.0
        if self.flight(vehicle).passes:
            return self.motion(vehicle, order).duration_s
        return self.reckoned_s(vehicle, order)

    def reckoned_s(self, vehicle: int, order: Sequence[int]) -> float:
        """Return the sum of a flight's parts: an estimate if it passes its viewpoints."""
        stops = self.stops(vehicle, order)
        flying = float(self.legs_s(vehicle, stops[:-1], stops[1:]).sum())
        return self.first_fixed_s(vehicle) + flying + len(order) * self.vehicles[vehicle].hover_s

    def flies(self, vehicle: int, order: Sequence[int]) -> bool:
        """Return whether a vehicle with this order flies or is in the air already."""
        return len(order) > 0 or self.vehicles[vehicle].aloft is not None

    def motion(
        self, vehicle: int, order: Sequence[int], *, is_first: bool = True, is_last: bool = True
    ) -> RouteMotion:
        """Return the motion of one of a vehicle's flights, by default of its only one."""
        spec, height = self.vehicles[vehicle], self.flight_height_m(vehicle)
        home = self.home_site(vehicle)
        start = self.start_site(vehicle) if is_first else home
        end = self.end_site(vehicle) if is_last else home
        stops = [start, *order, *([] if end is None else [end])]
        ways = [self.way(vehicle, a, b) for a, b in pairwise(stops)]
        first = ways[0][0] if ways else self.way(vehicle, start, start)[0]
        inside = self.inside(vehicle) if is_first else None
        corners = [] if inside is None else [(inside, False)]
        corners.append((enu(first), False))
        for site, way in zip(stops[1:], ways, strict=True):
            corners.extend((enu(bend), False) for bend in way[1:-1])
            corners.append((enu(way[-1]), site < len(self.points)))
        is_aloft = is_first and spec.aloft is not None
        return flight_motion(
            self.flight(vehicle).performance,
            corners,
            spec.hover_s,
            (None if is_aloft else height, height),
        )

    def kept_motion(
        self, vehicle: int, order: Sequence[int], *, is_first: bool, is_last: bool
    ) -> RouteMotion:
        """Return the same, computed once: separation asks for equal flights again and again."""
        start = self.start_site(vehicle) if is_first else self.home_site(vehicle)
        end = self.end_site(vehicle) if is_last else self.home_site(vehicle)
        key = (
            vehicle,
            self.layer_m(vehicle),
            tuple(order),
            tuple(self.sites[start].tolist()),
            self.inside(vehicle) if is_first else None,
            is_first and self.vehicles[vehicle].aloft is not None,
            None if end is None else tuple(self.sites[end].tolist()),
        )
        if key not in self._motions:
            self._motions[key] = self.motion(vehicle, order, is_first=is_first, is_last=is_last)
        return self._motions[key]

    def way(self, vehicle: int, origin: int, target: int) -> FloatArray:
        """Return the places (east, north, up) of a leg: origin, bends, target; shape (k, 3)."""
        air = self._air(vehicle)
        corners: IndexArray = np.zeros(0, dtype=np.intp)
        if self.detours is not None:
            corners = self.detours.corners_between(origin, target)
        places = [air.sites[origin], *air.corners[corners], air.sites[target]]
        if self.relief is None:
            return np.array(places)
        way = [places[0]]
        for a, b in pairwise(places):
            for bend in self.relief.bends(a, b):
                is_new = np.abs(bend - way[-1]).max() > 1e-6 and np.abs(bend - b).max() > 1e-6
                way.extend([bend] if is_new else [])
            way.append(b)
        return np.array(way)

    def _air(self, vehicle: int) -> Air:
        """Return the times and places of a vehicle's flights, shared by equal vehicles."""
        if vehicle in self._air_of:
            return self._air_of[vehicle]
        keys = [(self.flight(k), self.layer_m(k)) for k in range(len(self.vehicles))]
        key = keys[vehicle]
        if key not in self._airs:
            corners = np.zeros((0, 2)) if self.detours is None else self.detours.corners
            air = self._airs[key] = Air(
                flight=key[0],
                sites=np.column_stack([self.sites, self._ups_m(key[1])]),
                corners=np.column_stack([corners, self._over(corners) + key[1]]),
            )
            kept = 0 if self.legs_are_plain else MOST_KEPT // len(set(keys))
            self._times[air] = LegTimes(air, self.detours, kept)
        self._air_of[vehicle] = self._airs[key]
        return self._airs[key]

    def _over(self, places: FloatArray) -> FloatArray:
        """Return the flying height over places (k, 2), above the frame's origin."""
        if self.ground is None or not len(places):
            return np.full(len(places), float(self.height_m))
        return self.ground.ups_m(places) + self.height_m
