# SPDX-License-Identifier: Apache-2.0
"""A request in the plane of a local frame: viewpoints, exclusions, and the routing problem."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_planner.airspace import Airspace
from rocsafe_planner.coverage import Coverage, CoverageSpec, cover, coverage_spec
from rocsafe_planner.errors import MissingSensorError
from rocsafe_planner.fleet_problem import FleetProblem
from rocsafe_planner.plan import Viewpoint
from rocsafe_planner.request import SurveyRequest
from rocsafe_planner.vehicle import Vehicle

FloatArray = NDArray[np.float64]

MAX_HOME_DISTANCE_M = 100_000.0
"""Homes further from the first region's centre than this are a slip of the pen."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SurveySite:
    """What a request means in the plane; index and id of viewpoints are the same."""

    frame: LocalFrame
    spec: CoverageSpec
    coverage: Coverage
    viewpoints: tuple[Viewpoint, ...]
    problem: FleetProblem


def survey_site(request: SurveyRequest) -> SurveySite:
    """Return the site of a request.

    Raises
    ------
    ValueError
        If a home or end lies too far away or in an exclusion.
    PlannerError
        If the request has no viewpoints within its limits, or no vehicle for one of them.
    """
    _check_distances(request)
    frame = _frame_of(request)
    polygons = [region.area.polygon(frame) for region in request.regions]
    zones = [zone.polygon(frame) for zone in request.exclusions]
    airspace = Airspace(zones, request.clearance_m) if zones else None
    spec = _spec_of(request)
    coverage = cover(polygons, spec, airspace.holds if airspace else None)
    return SurveySite(
        frame=frame,
        spec=spec,
        coverage=coverage,
        viewpoints=_viewpoints(request, coverage, frame),
        problem=_problem_of(request, coverage, frame, airspace),
    )


def _check_distances(request: SurveyRequest) -> None:
    centre = request.regions[0].area.centroid()
    places = [(f'region {r.area.name!r}', r.area.centroid()) for r in request.regions[1:]]
    for vehicle in request.vehicles:
        places.append((f'{vehicle.name} home', vehicle.home))
        if vehicle.end is not None:
            places.append((f'{vehicle.name} end', vehicle.end))
    for what, place in places:
        distance = distance_m(centre, place)
        if distance > MAX_HOME_DISTANCE_M:
            raise ValueError(
                f'{what} is {distance / 1000.0:.0f} km from the region: must be '
                f'within {MAX_HOME_DISTANCE_M / 1000.0:.0f} km'
            )


def _frame_of(request: SurveyRequest) -> LocalFrame:
    """Return the frame about the first region's centre; level ground as high as the homes."""
    centre = request.regions[0].area.centroid()
    ground = _ground_altitude_m(request)
    altitude = 0.0 if math.isnan(ground) else ground
    return LocalFrame(GeoPosition(centre.latitude_deg, centre.longitude_deg, altitude))


def _ground_altitude_m(request: SurveyRequest) -> float:
    """Return the mean altitude of the homes whose altitude is known, NaN if none is."""
    known = [v.home.altitude_m for v in request.vehicles if not math.isnan(v.home.altitude_m)]
    return sum(known) / len(known) if known else math.nan


def _spec_of(request: SurveyRequest) -> CoverageSpec:
    return coverage_spec(
        request.camera,
        request.height_agl_m,
        (request.overlap_fraction, request.front_overlap),
        request.spacing_rule,
        request.grid,
        request.max_viewpoints,
    )


def _problem_of(
    request: SurveyRequest, coverage: Coverage, frame: LocalFrame, airspace: Airspace | None
) -> FleetProblem:
    homes = _places(frame, [vehicle.home for vehicle in request.vehicles])
    ends = _places(frame, [vehicle.end or vehicle.home for vehicle in request.vehicles])
    detours = None
    if airspace is not None:
        _check_stands(request.vehicles, airspace, homes, ends)
        detours = airspace.detours(np.vstack([coverage.centres, homes, ends]))
    return FleetProblem(
        vehicles=request.vehicles,
        homes=homes,
        ends=ends,
        points=coverage.centres,
        height_m=request.height_agl_m,
        wind_mps=request.wind_mps,
        detours=None if detours is None or detours.is_straight else detours,
        may_visit=_may_visit(request, coverage),
        grid_rad=float(coverage.yaw_rad[0]) - 0.5 * math.pi,
    )


def _places(frame: LocalFrame, positions: list[GeoPosition]) -> FloatArray:
    """Return (east, north) of positions, shape (n, 2)."""
    return frame.to_enu(
        [position.latitude_deg for position in positions],
        [position.longitude_deg for position in positions],
        math.nan,
    )[:, :2]


def _check_stands(
    vehicles: tuple[Vehicle, ...], airspace: Airspace, homes: FloatArray, ends: FloatArray
) -> None:
    for what, places in (('home', homes), ('end', ends)):
        for vehicle, is_free in zip(vehicles, airspace.holds(places).tolist(), strict=True):
            if not is_free:
                raise ValueError(
                    f'{vehicle.name} {what} lies in an exclusion, or nearer to it than '
                    'clearance_m: must be outside'
                )


def _may_visit(request: SurveyRequest, coverage: Coverage) -> NDArray[np.bool_] | None:
    """Return which vehicle may visit which point; None if all may."""
    if not any(region.sensors for region in request.regions):
        return None
    able: NDArray[np.bool_] = np.array(
        [
            [set(region.sensors) <= set(vehicle.sensors) for region in request.regions]
            for vehicle in request.vehicles
        ]
    )
    for number, region in enumerate(request.regions):
        if not able[:, number].any():
            raise MissingSensorError(
                f'region {region.area.name!r} requires {", ".join(region.sensors)}: no vehicle '
                'carries all of them'
            )
    allowed: NDArray[np.bool_] = able[:, coverage.polygon]
    return allowed


def _viewpoints(
    request: SurveyRequest, coverage: Coverage, frame: LocalFrame
) -> tuple[Viewpoint, ...]:
    """Return all viewpoints; the index is the id."""
    height = request.height_agl_m
    count = len(coverage.centres)
    geodetic = frame.to_geodetic(np.column_stack([coverage.centres, np.full(count, height)]))
    if math.isnan(_ground_altitude_m(request)):
        geodetic[:, 2] = math.nan
    corners = coverage.footprints.reshape(-1, 2)
    ground = frame.to_geodetic(np.column_stack([corners, np.full(len(corners), math.nan)]))
    footprints = ground.reshape(count, 4, 3).tolist()
    yaws, regions = coverage.yaw_rad.tolist(), coverage.polygon.tolist()
    return tuple(
        Viewpoint(
            id=number,
            position=GeoPosition(*place),
            height_agl_m=height,
            yaw_rad=yaws[number],
            footprint=tuple(GeoPosition(*corner) for corner in footprint),
            sensors=request.regions[regions[number]].sensors,
        )
        for number, (place, footprint) in enumerate(
            zip(geodetic.tolist(), footprints, strict=True)
        )
    )
