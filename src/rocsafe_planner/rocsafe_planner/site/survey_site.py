# SPDX-License-Identifier: Apache-2.0
"""A request in the plane of a local frame: viewpoints, exclusions, routing problem."""

import dataclasses
import math
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import shapely

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.terrain.terrain import LocalGround
from rocsafe_planner.coverage.viewpoint_grid import Coverage, CoverageSpec, cover, coverage_spec
from rocsafe_planner.errors import MissingSensorError, TooManyViewpointsError
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.viewpoint import Viewpoint
from rocsafe_planner.problem.airspace import Airspace
from rocsafe_planner.problem.fleet_problem import FleetProblem
from rocsafe_planner.site.columns import columns_of, detours_of
from rocsafe_planner.site.free_layers import lowest_layers_m
from rocsafe_planner.site.given_viewpoints import given_coverage
from rocsafe_planner.site.site_checks import check_distances, check_stands, check_ups, exits

MAX_TERRAIN_SITES = 2500
"""Around exclusions besides, where legs are known as a table only: 6 million of them take some
seconds."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SurveySite:
    """A request in the plane; `viewpoints` belong to the points of the problem.

    `left_out` are the ids of given viewpoints that have no point.
    """

    request: SurveyRequest
    frame: LocalFrame
    spec: CoverageSpec
    coverage: Coverage
    polygons: tuple[shapely.Polygon, ...]
    viewpoints: tuple[Viewpoint, ...]
    problem: FleetProblem
    left_out: tuple[int, ...] = ()

    def without(self, points: Collection[int]) -> 'SurveySite':
        """Return the site without some of its points, whose viewpoints were given."""
        more = {self.viewpoints[point].id for point in points}
        return survey_site(self.request, left_out=tuple(sorted({*self.left_out, *more})))

    def viewpoint(self, vehicle: int, point: int) -> Viewpoint:
        """Return a viewpoint at the height of a vehicle's layer."""
        view, layer = self.viewpoints[point], self.problem.layer_m(vehicle)
        if not layer:
            return view
        height = view.height_agl_m + layer
        place = view.position
        raised = GeoPosition(place.latitude_deg, place.longitude_deg, place.altitude_m + layer)
        corners = (_scaled(place, c, height / view.height_agl_m) for c in view.footprint)
        return dataclasses.replace(
            view, position=raised, height_agl_m=height, footprint=tuple(corners)
        )

    def positions(self, places: FloatArray) -> tuple[GeoPosition, ...]:
        """Return places (n, 3) of the problem; their altitude is NaN if the ground's is."""
        if not len(places):
            return ()
        geodetic = _geodetic(self.request, self.frame, places)
        return tuple(GeoPosition(*place) for place in geodetic.tolist())

    def ground_altitude_m(self, vehicle: int) -> float:
        """Return the ground's altitude at a vehicle's home, NaN if it is level."""
        ground = self.problem.ground
        if ground is None:
            return math.nan
        return float(ground.altitudes_m(self.problem.homes[vehicle : vehicle + 1])[0])

    def landing_height_m(self, vehicle: int) -> float:
        """Return the height above home of the flight over a vehicle's end, NaN if level."""
        end, ground = self.problem.end_site(vehicle), self.problem.ground
        if ground is None or end is None:
            return math.nan
        up = self.problem.ups_m[end] - ground.ups_m(self.problem.homes[vehicle : vehicle + 1])[0]
        return float(up) + self.problem.layer_m(vehicle)


def survey_site(request: SurveyRequest, left_out: tuple[int, ...] = ()) -> SurveySite:
    """Return the site of a request, without the given viewpoints of the ids `left_out`.

    Raises
    ------
    ValueError
        If a home or end lies too far away or in an exclusion.
    PlannerError
        If the request has no viewpoints within its limits, or no vehicle for one of them, or its
        terrain lacks their ground.
    """
    check_distances(request)
    frame = frame_of(request)
    polygons = tuple(region.area.polygon(frame) for region in request.regions)
    zones = [zone.polygon(frame) for zone in request.exclusions]
    airspace = None
    if zones:
        stands = np.vstack(_stands(request, frame))
        airspace = Airspace(zones, request.airspace.clearance_m, stands)
    spec = coverage_spec(request.camera, request.coverage)
    if request.continuation.viewpoints:
        coverage = given_coverage(request, frame, polygons, airspace, left_out)
    else:
        coverage = cover(polygons, spec, airspace)
    problem = _problem_of(request, coverage, frame, airspace)
    return SurveySite(
        request=request,
        frame=frame,
        spec=spec,
        coverage=coverage,
        polygons=polygons,
        viewpoints=_viewpoints(request, coverage, frame, problem),
        problem=problem,
        left_out=left_out,
    )


def frame_of(request: SurveyRequest) -> LocalFrame:
    """Return the frame about the first region's centre; level ground as high as the homes."""
    centre = request.regions[0].area.centroid()
    ground = _ground_altitude_m(request)
    altitude = 0.0 if math.isnan(ground) else ground
    return LocalFrame(GeoPosition(centre.latitude_deg, centre.longitude_deg, altitude))


def _references(request: SurveyRequest) -> list[GeoPosition]:
    return list(request.continuation.ground_reference) or [
        vehicle.home for vehicle in request.vehicles
    ]


def _ground_altitude_m(request: SurveyRequest) -> float:
    """Return the mean of the known altitudes of homes, NaN without any."""
    altitudes = [place.altitude_m for place in _references(request)]
    known = [altitude for altitude in altitudes if not math.isnan(altitude)]
    return sum(known) / len(known) if known else math.nan


def _problem_of(
    request: SurveyRequest, coverage: Coverage, frame: LocalFrame, airspace: Airspace | None
) -> FleetProblem:
    vehicles = request.vehicles
    starts, homes, ends = _stands(request, frame)
    sites = np.vstack([coverage.centres, starts, ends, homes])
    start_ups = _start_ups_m(request, frame)
    insides = None
    if airspace is not None:
        check_stands(vehicles, airspace, (starts, homes, ends))
        starts, insides = exits(vehicles, airspace, starts)
        insides = np.column_stack([insides, start_ups])
        # On their way out they come to the height of their legs.
        start_ups = np.where(np.isnan(insides[:, 0]), start_ups, math.nan)
        sites = np.vstack([coverage.centres, starts, ends, homes])
    columns = columns_of(request, frame, len(coverage.centres))
    detours = detours_of(request, sites, airspace, columns)
    ground = relief = None
    if request.terrain is not None:
        if detours is not None and len(sites) > MAX_TERRAIN_SITES:
            raise TooManyViewpointsError(
                f'{len(sites)} viewpoints and homes are to be joined around exclusions and over a '
                f'terrain: must be at most {MAX_TERRAIN_SITES}'
            )
        ground = LocalGround(request.terrain, frame, _references(request))
        corners = sites if detours is None else np.vstack([sites, detours.corners])
        relief = ground.relief(corners, request.airspace.terrain_clearance_m)
        check_ups(vehicles, start_ups - ground.ups_m(starts), request.airspace.terrain_clearance_m)
    return FleetProblem(
        vehicles=vehicles,
        homes=homes,
        ends=ends,
        starts=starts,
        insides=insides,
        start_ups_m=None if np.isnan(start_ups).all() else start_ups,
        points=coverage.centres,
        height_m=request.coverage.height_agl_m,
        ground=ground,
        relief=relief,
        separation_m=request.separation.distance_m,
        layers_m=lowest_layers_m(request),
        wind_mps=request.airspace.wind_mps,
        detours=None if detours is None or detours.is_straight else detours,
        may_visit=_may_visit(request, coverage),
        grid_rad=float(coverage.yaw_rad[0]) - 0.5 * math.pi,
        name_of=lambda point: _name(request, coverage, frame, point),
    )


def _stands(
    request: SurveyRequest, frame: LocalFrame
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return starts, homes and ends of the vehicles (east, north), (m, 2) each."""
    vehicles = request.vehicles
    return (
        frame.plane_of([vehicle.start for vehicle in vehicles]),
        frame.plane_of([vehicle.home for vehicle in vehicles]),
        frame.plane_of([vehicle.end or vehicle.home for vehicle in vehicles]),
    )


def _name(request: SurveyRequest, coverage: Coverage, frame: LocalFrame, point: int) -> str:
    """Return the id of a viewpoint and where it is, in words."""
    place = coverage.centres[point : point + 1]
    latitude, longitude = frame.to_geodetic(np.column_stack([place, [[0.0]]]))[0, :2].tolist()
    return f'viewpoint {_id(request, coverage, point)} at {latitude:.6f}, {longitude:.6f}'


def _id(request: SurveyRequest, coverage: Coverage, point: int) -> int:
    """Return the id of the viewpoint of a point: as given, or its number."""
    views = request.continuation.viewpoints
    return views[coverage.polygon[point]].id if views else point


def _start_ups_m(request: SurveyRequest, frame: LocalFrame) -> FloatArray:
    """Return how high vehicles in the air are above the frame's origin, NaN where unknown."""
    if request.terrain is None and math.isnan(_ground_altitude_m(request)):
        return np.full(len(request.vehicles), math.nan)
    return np.array(
        [
            math.nan if v.aloft is None else v.aloft.position.altitude_m - frame.origin.altitude_m
            for v in request.vehicles
        ]
    )


def _may_visit(request: SurveyRequest, coverage: Coverage) -> BoolArray | None:
    """Return which vehicle may visit which point; None: each may visit all."""
    needs = needed_sensors(request)
    if not any(needs):
        return None
    carried = [set(vehicle.sensors) for vehicle in request.vehicles]
    able: BoolArray = np.array(
        [[set(sensors) <= carries for sensors in needs] for carries in carried]
    )
    for number in np.flatnonzero(~able.any(axis=0)):
        raise MissingSensorError(
            f'{_owner(request, int(number))} requires {", ".join(needs[number])}: no vehicle '
            'carries all of them'
        )
    allowed: BoolArray = able[:, coverage.polygon]
    return allowed


def needed_sensors(request: SurveyRequest) -> list[tuple[str, ...]]:
    """Return the required sensors by region, or by viewpoint if viewpoints are given."""
    if request.continuation.viewpoints:
        return [view.sensors for view in request.continuation.viewpoints]
    return [region.sensors for region in request.regions]


def _owner(request: SurveyRequest, number: int) -> str:
    if request.continuation.viewpoints:
        return f'viewpoint {request.continuation.viewpoints[number].id}'
    return f'region {request.regions[number].area.name!r}'


def _viewpoints(
    request: SurveyRequest, coverage: Coverage, frame: LocalFrame, problem: FleetProblem
) -> tuple[Viewpoint, ...]:
    """Return the viewpoint of every point."""
    count = len(coverage.centres)
    places = np.column_stack([coverage.centres, problem.ups_m[:count]])
    geodetic = _geodetic(request, frame, places)
    corners = coverage.footprints.reshape(-1, 2)
    ground = frame.to_geodetic(np.column_stack([corners, np.full(len(corners), math.nan)]))
    footprints = ground.reshape(count, 4, 3).tolist()
    yaws, owners = coverage.yaw_rad.tolist(), coverage.polygon.tolist()
    needs = needed_sensors(request)
    return tuple(
        Viewpoint(
            id=_id(request, coverage, point),
            position=GeoPosition(*place),
            height_agl_m=request.coverage.height_agl_m,
            yaw_rad=yaws[point],
            footprint=tuple(GeoPosition(*corner) for corner in footprint),
            sensors=needs[owners[point]],
        )
        for point, (place, footprint) in enumerate(zip(geodetic.tolist(), footprints, strict=True))
    )


def _geodetic(request: SurveyRequest, frame: LocalFrame, places: FloatArray) -> FloatArray:
    """Return latitude, longitude and altitude of places (n, 3)."""
    geodetic = frame.to_geodetic(places)
    if request.terrain is not None:
        # Heights over a terrain count from the ellipsoid, which is curved, not from the plane.
        geodetic[:, 2] = frame.origin.altitude_m + places[:, 2]
    elif math.isnan(_ground_altitude_m(request)):
        geodetic[:, 2] = math.nan
    return geodetic


def _scaled(centre: GeoPosition, corner: GeoPosition, factor: float) -> GeoPosition:
    """Return a corner so much further from the centre."""
    return GeoPosition(
        centre.latitude_deg + factor * (corner.latitude_deg - centre.latitude_deg),
        centre.longitude_deg + factor * (corner.longitude_deg - centre.longitude_deg),
        corner.altitude_m,
    )
