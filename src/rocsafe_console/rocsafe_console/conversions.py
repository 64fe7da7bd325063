# SPDX-License-Identifier: Apache-2.0
"""Messages -> values of this package."""

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

from nav_msgs.msg import OccupancyGrid
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from rocsafe_console.picture.coordinates import forms_of, position_of_ecef
from rocsafe_console.picture.map_image import Grid
from rocsafe_console.picture.picture import MissionNow, Reading
from rocsafe_console.picture.vehicle import Holder, VehicleReport
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_interfaces.msg import (
    Control,
    Decision,
    DoseAlarm,
    GeoPoint,
    GeoPolygon,
    HazardSourceArray,
    MissionState,
    Mosaic,
    RadiationReading,
    Region,
    Route,
    SurveyPlan,
    VehicleState,
    WindReading,
)
from rocsafe_ros.conversions import ns_of_stamp
from rocsafe_view import formats

Place = list[float]
SEVERITIES = ('info', 'warning', 'critical')
_SIGMAS_95 = 2.4477  # square root of the 95 % quantile of chi-squared with two degrees of freedom


def seconds_of(stamp: Any) -> float:
    """Return a stamp as seconds since 1970."""
    return float(ns_of_stamp(stamp) / NS_PER_S)


def oldest_s(message: MarkerArray) -> float:
    """Return the oldest stamp of some markers, seconds since 1970; -infinity: there is none."""
    return min((seconds_of(one.header.stamp) for one in message.markers), default=-math.inf)


def mission_of(message: MissionState) -> MissionNow:
    """Return the state of the mission."""
    return MissionNow(
        mission_id=message.mission_id,
        phase=message.phase,
        stamp_s=seconds_of(message.header.stamp),
        text=message.text,
        images_stored=message.images_stored,
        images_expected=message.images_expected,
        mission_time_s=message.mission_time_s,
        wall_time_s=message.wall_time_s,
    )


def report_of(message: VehicleState, *, is_ground: bool = False) -> VehicleReport:
    """Return the state of a vehicle."""
    return VehicleReport(
        name=message.vehicle,
        state=message.state,
        stamp_s=seconds_of(message.header.stamp),
        is_simulated=message.is_simulated,
        viewpoint_count=message.viewpoint_count,
        viewpoints_visited=message.viewpoints_visited,
        shots_taken=message.shots_taken,
        shots_pending=message.shots_pending,
        battery_fraction=message.battery_fraction,
        text=message.text,
        advice=message.advice,
        latitude_deg=message.position.latitude,
        longitude_deg=message.position.longitude,
        altitude_m=message.position.altitude,
        speed_mps=message.speed_mps,
        taken_by=message.taken_by,
        plan_id=message.plan_id,
        is_ground=is_ground,
    )


def reading_of(vehicle: str, message: RadiationReading) -> Reading:
    """Return a dose rate."""
    return Reading(
        vehicle=vehicle,
        stamp_s=seconds_of(message.header.stamp),
        dose_rate_usvh=message.dose_rate_usvh,
        std_usvh=message.dose_rate_std_usvh,
        latitude_deg=message.position.latitude,
        longitude_deg=message.position.longitude,
        detector=message.detector,
        is_saturated=message.saturated,
    )


def holder_of(message: Control) -> Holder:
    """Return who leads a vehicle."""
    return Holder(
        holder=message.holder,
        mission=message.mission,
        lease=message.lease,
        epoch=message.epoch,
        expires_s=seconds_of(message.expires),
        text=message.text,
    )


def decision_of(message: Decision) -> dict[str, Any]:
    """Return a decision."""
    return {
        'stamp_s': seconds_of(message.header.stamp),
        'wall_time_s': message.wall_time_s,
        'severity': SEVERITIES[min(message.severity, 2)],
        'what': message.kind,
        'by': message.by,
        'vehicles': list(message.vehicles),
        'text': message.text,
        'reason': message.reason,
    }


def alarm_text(vehicle: str, message: DoseAlarm) -> str:
    """Return the words of an alarm of a dose rate or dose."""
    is_rate = message.quantity == DoseAlarm.DOSE_RATE
    text_of = formats.dose_rate if is_rate else formats.dose
    value, level = (text_of(number) for number in (message.value_usv, message.threshold_usv))
    words = f'{vehicle}: {formats.spaced(value)} reached {message.name}, {formats.spaced(level)}'
    return f'{words}; it turns back' if message.turns_back else words


def region_of(message: Region) -> dict[str, Any]:
    """Return a region as rings of latitude and longitude, the boundary first."""
    return {'name': message.name, 'rings': _rings(message.boundary, message.holes)}


def plan_of(message: SurveyPlan) -> dict[str, Any]:
    """Return what the page shows of a plan."""
    return {
        'plan_id': message.plan_id,
        'method': message.method,
        'height_agl_m': message.height_agl_m,
        'makespan_s': message.makespan_s,
        'lower_bound_s': message.lower_bound_s,
        'lower_bound_method': message.lower_bound_method,
        'gap_fraction': message.gap_fraction,
        'covered_fraction': message.covered_fraction,
        'region_area_m2': message.region_area_m2,
        'minimum_separation_m': message.minimum_separation_m,
        'footprint_m': _footprint_m(message),
        'exclusions': [_rings(zone.boundary, zone.holes) for zone in message.exclusions],
        'routes': {route.vehicle: _route_of(route) for route in message.routes},
    }


def home_of(message: GeoPoint) -> tuple[float, float, float]:
    """Return a home as latitude, longitude and altitude."""
    return message.latitude, message.longitude, message.altitude


def sources_of(message: HazardSourceArray) -> dict[str, Any]:
    """Return the estimated sources with their ellipses of 95 %, and the verdict in words."""
    return {
        'stamp_s': seconds_of(message.header.stamp),
        'verdict': message.verdict,
        'doubts': list(message.doubts),
        'background_usvh': message.background_usvh,
        'sources': [
            _source_of(source, sum(message.source_count_probability[number:]))
            for number, source in enumerate(message.sources, 1)
        ],
    }


def grid_of(message: OccupancyGrid) -> Grid:
    """Return a map of dose rates or concentrations."""
    corner = message.info.origin.position
    return Grid(
        cells=message.data,
        columns=message.info.width,
        corner_m=(corner.x, corner.y),
        cell_m=message.info.resolution,
    )


def cordons_of(message: MarkerArray, frame: LocalFrame) -> list[dict[str, Any]]:
    """Return the lines of cordons as latitude and longitude."""
    return [
        {
            'level_usvh': float(marker.ns.split(' ')[0]),
            'is_mean': marker.ns.endswith('mean'),
            'ring': geodetic_line(frame, [(p.x, p.y, p.z) for p in marker.points]),
        }
        for marker in message.markers
        if marker.action == Marker.ADD and marker.type == Marker.LINE_STRIP
    ]


def mosaic_of(message: Mosaic) -> dict[str, Any]:
    """Return what is known of the map; its picture is served apart."""
    return {
        'stamp_s': seconds_of(message.header.stamp),
        'images_placed': message.images_placed,
        'is_final': message.is_final,
        'is_georeferenced': message.is_georeferenced,
        'ground_resolution_m': message.ground_resolution_m,
        'stated_error_m': message.stated_error_m,
        'corners': [place_of(message.south_west), place_of(message.north_east)],
    }


def wind_of(vehicle: str, message: WindReading) -> dict[str, Any] | None:
    """Return whence the wind comes, degrees clockwise from north, and its speed; None: unknown."""
    east, north = message.towards_east_mps, message.towards_north_mps
    if not math.isfinite(east + north):
        return None
    return {
        'vehicle': vehicle,
        'stamp_s': seconds_of(message.header.stamp),
        'from_deg': math.degrees(math.atan2(-east, -north)) % 360.0,
        'speed_mps': math.hypot(east, north),
        'std_mps': message.std_mps,
    }


def frame_of(message: TFMessage) -> LocalFrame | None:
    """Return the frame of the mission if `message` says where the map lies on the earth."""
    for transform in message.transforms:
        if (transform.header.frame_id, transform.child_frame_id) == ('earth', 'map'):
            place = transform.transform.translation
            return LocalFrame(position_of_ecef(place.x, place.y, place.z))
    return None


def _source_of(source: Any, probability: float) -> dict[str, Any]:
    east, north, angle = ellipse_of(source.position_covariance)
    return {
        'id': source.id,
        'place': place_of(source.position),
        'forms': forms_of(source.position.latitude, source.position.longitude),
        'half_axes_m': [east, north],
        'angle_deg': angle,
        'dose_rate_at_1m_usvh': source.dose_rate_at_1m_usvh,
        'dose_rate_at_1m_std_usvh': source.dose_rate_at_1m_std_usvh,
        'probability': formats.probability(probability),
        'nuclide': source.nuclide,
    }


def ellipse_of(covariance: Sequence[float]) -> tuple[float, float, float]:
    """Return the half axes in metres and the angle from east in degrees of the 95 % ellipse.

    Parameters
    ----------
    covariance
        East, north, up; 9 values in square metres, row major.
    """
    a, b, d = covariance[0], covariance[1], covariance[4]
    middle, spread = (a + d) / 2.0, math.hypot((a - d) / 2.0, b)
    longer = _SIGMAS_95 * math.sqrt(max(middle + spread, 0.0))
    shorter = _SIGMAS_95 * math.sqrt(max(middle - spread, 0.0))
    return longer, shorter, math.degrees(0.5 * math.atan2(2.0 * b, a - d))


def _route_of(route: Route) -> dict[str, Any]:
    points: list[GeoPoint] = [route.home]
    for viewpoint in route.viewpoints:
        points += [*viewpoint.approach, viewpoint.position]
    points += [*route.homeward, *(route.end or ([] if route.is_open else [route.home]))]
    return {
        'home': place_of(route.home),
        'line': [place_of(point) for point in points],
        'viewpoints': [[*place_of(v.position), v.yaw_rad] for v in route.viewpoints],
        'duration_s': route.duration_s,
        'length_m': route.length_m,
    }


def _footprint_m(plan: SurveyPlan) -> list[float] | None:
    """Return across and along track what a photograph shows of level ground, metres."""
    camera = plan.camera
    if not camera.image_width_px:
        return None
    across = 2.0 * plan.height_agl_m * math.tan(camera.horizontal_fov_rad / 2.0)
    return [across, across * camera.image_height_px / camera.image_width_px]


def _rings(boundary: GeoPolygon, holes: Iterable[GeoPolygon]) -> list[list[Place]]:
    return [[place_of(point) for point in polygon.points] for polygon in (boundary, *holes)]


def place_of(point: GeoPoint) -> Place:
    """Return latitude and longitude, degrees, to the centimetre."""
    return [round(point.latitude, 7), round(point.longitude, 7)]


def geodetic_line(frame: LocalFrame, points: list[tuple[float, float, float]]) -> list[Place]:
    """Return a line as latitudes and longitudes, without points that repeat."""
    if not points:
        return []
    rows: list[Place] = frame.to_geodetic(points)[:, :2].round(7).tolist()
    return [rows[0], *(b for a, b in pairwise(rows) if a != b)]
