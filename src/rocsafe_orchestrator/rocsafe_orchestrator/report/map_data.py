# SPDX-License-Identifier: Apache-2.0
"""Content of the map of a run, thinned to its resolution.

Map coordinates are metres east and south of the mission origin: those of SVG, north up.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import shapely

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import ground_corners, rotation_of_quaternion
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_orchestrator.products.run_record import Photograph, Reading, RunRecord, Track
from rocsafe_orchestrator.products.source_estimates import SourceEstimates
from rocsafe_orchestrator.report.gas_zones import read_zones, release_points, true_releases
from rocsafe_orchestrator.report.pictures import ground_picture
from rocsafe_orchestrator.report.plan_data import (
    exclusion_rings,
    further_lines,
    planned_footprints,
    points,
    region_rings,
    route_lines,
)
from rocsafe_orchestrator.report.sections.cordons import safe_cordons
from rocsafe_view.map_marks import DosePoint, EstimatePoint, PhotoPoint, ReplayTrack, SourcePoint
from rocsafe_view.map_view import MapView
from rocsafe_view.palette import vehicle_colours
from rocsafe_view.svg import Point

MOSAIC = 'mosaic.tif'
# Tracks keep what is seen at the closest zoom.
TRACK_TOLERANCE_M = 0.1
# All readings on the page, and all positions of the replay.
MOST_READINGS = 9000
MOST_REPLAY_POSITIONS = 12_000


def map_view(record: RunRecord, frame: LocalFrame, start_ns: int) -> MapView:
    """Return the map of a run; `start_ns` is its time zero."""
    tracks = record.log.tracks if record.log else {}
    readings = record.log.readings if record.log else ()
    stride = max(-(-len(readings) // MOST_READINGS), 1)
    releases = release_points(record.releases, frame)
    return MapView(
        origin_deg=(frame.origin.latitude_deg, frame.origin.longitude_deg),
        metres_per_degree=metres_per_degree(frame),
        vehicles=record.vehicles,
        colours=vehicle_colours(record.vehicles),
        region=region_rings(record, frame),
        exclusions=exclusion_rings(record, frame),
        routes=route_lines(record, frame),
        planned=planned_footprints(record, frame),
        viewpoints=_viewpoints(record, frame),
        tracks={name: _thinned(frame, track) for name, track in tracks.items()},
        replay=_replay(tracks, frame, start_ns),
        readings=tuple(_dose_points(readings, frame, start_ns, stride)),
        readings_per_point=stride,
        has_radiation=record.has_radiation,
        photos=_photos(record, frame, start_ns),
        homes=_homes(record, frame),
        sources=_sources(record, frame),
        estimates=estimate_points(record.estimates, frame),
        cordons=safe_cordons(record.path, frame),
        zones=read_zones(record.path, frame, releases),
        releases=releases,
        true_releases=true_releases(record.scenario, frame),
        replanned=further_lines(record, frame),
        picture=ground_picture(record.path / MOSAIC, frame),
    )


def metres_per_degree(frame: LocalFrame) -> tuple[float, float]:
    """Return metres in a degree of latitude and of longitude at the origin."""
    origin = frame.origin
    step = 1e-3
    enu = frame.to_enu(
        np.array([origin.latitude_deg + step, origin.latitude_deg]),
        np.array([origin.longitude_deg, origin.longitude_deg + step]),
        np.full(2, origin.altitude_m),
    )
    return round(float(enu[0, 1]) / step, 3), round(float(enu[1, 0]) / step, 3)


def _xy(frame: LocalFrame, lat: FloatArray, lon: FloatArray, alt: FloatArray) -> tuple[Point, ...]:
    enu = frame.to_enu(lat, lon, alt)
    return tuple(zip(enu[:, 0].tolist(), (-enu[:, 1]).tolist(), strict=True))


def _viewpoints(record: RunRecord, frame: LocalFrame) -> dict[str, tuple[Point, ...]]:
    routes = record.plan.routes if record.plan else ()
    return {r.vehicle.name: points(frame, (v.position for v in r.viewpoints)) for r in routes}


def _homes(record: RunRecord, frame: LocalFrame) -> dict[str, Point]:
    if record.plan is not None:
        homes = {route.vehicle.name: route.vehicle.home for route in record.plan.routes}
    elif record.scenario is not None:
        scenario = record.scenario
        homes = {v.name: scenario.ground_position(v.home) for v in scenario.vehicles}
    else:
        return {}
    return dict(zip(homes, points(frame, homes.values()), strict=True))


def _sources(record: RunRecord, frame: LocalFrame) -> tuple[SourcePoint, ...]:
    if record.scenario is None:
        return ()
    sources = record.scenario.radiation.sources
    places = points(frame, (record.scenario.ground_position(s.place) for s in sources))
    return tuple(
        SourcePoint(x, y, source.name) for (x, y), source in zip(places, sources, strict=True)
    )


def estimate_points(
    estimates: SourceEstimates | None, frame: LocalFrame
) -> tuple[EstimatePoint, ...]:
    """Return the estimated sources in map coordinates."""
    found = estimates.sources if estimates else ()
    places = points(frame, (source.position for source in found))
    return tuple(
        EstimatePoint(
            x=x,
            y=y,
            half_axes_m=source.ellipse_95_m,
            angle_deg=source.ellipse_angle_from_east_deg,
        )
        for (x, y), source in zip(places, found, strict=True)
    )


def _photos(record: RunRecord, frame: LocalFrame, start_ns: int) -> tuple[PhotoPoint, ...]:
    shots = record.photographs
    places = points(frame, (shot.position for shot in shots))
    return tuple(
        PhotoPoint(
            x, y, (shot.time_ns - start_ns) / NS_PER_S, shot.shot_id, shot.vehicle,
            shot.viewpoint_id, _footprint(shot, (x, y)),
        )
        for (x, y), shot in zip(places, shots, strict=True)
    )  # fmt: skip


def _footprint(shot: Photograph, place: Point) -> tuple[Point, ...]:
    """Return the corners of the ground in a photograph, on the flat ground below it."""
    if shot.aim is None:
        return ()
    try:
        corners = ground_corners(
            shot.aim.camera,
            (place[0], -place[1], shot.aim.height_agl_m),
            rotation_of_quaternion(shot.aim.orientation_xyzw),
        )
    except ValueError:
        return ()
    return tuple((float(east), -float(north)) for east, north in corners)


def _thinned(frame: LocalFrame, track: Track) -> tuple[Point, ...]:
    """Return a track without the points that nobody would miss."""
    places = _xy(frame, track.latitude_deg, track.longitude_deg, track.altitude_m)
    if len(places) < 3:
        return places
    line = shapely.simplify(shapely.LineString(places), TRACK_TOLERANCE_M)
    return tuple((float(x), float(y)) for x, y in line.coords)


def _replay(
    tracks: Mapping[str, Track], frame: LocalFrame, start_ns: int
) -> dict[str, ReplayTrack]:
    most = max(MOST_REPLAY_POSITIONS // max(len(tracks), 1), 2)
    replay = {}
    for name, track in tracks.items():
        kept = slice(None, None, max(-(-len(track.time_ns) // most), 1))
        places = np.array(
            _xy(frame, track.latitude_deg[kept], track.longitude_deg[kept], track.altitude_m[kept])
        )
        times = (track.time_ns[kept] - start_ns) / NS_PER_S
        replay[name] = ReplayTrack(
            time_s=times.tolist(), x=places[:, 0].tolist(), y=places[:, 1].tolist()
        )
    return replay


def _dose_points(
    readings: Sequence[Reading], frame: LocalFrame, start_ns: int, stride: int
) -> Iterable[DosePoint]:
    """Yield the highest of every `stride` readings of a vehicle, where its position is known."""
    by_vehicle: dict[str, list[Reading]] = {}
    for reading in readings:
        if np.isfinite(reading.latitude_deg + reading.longitude_deg):
            by_vehicle.setdefault(reading.vehicle, []).append(reading)
    for vehicle, own in by_vehicle.items():
        groups = (own[first : first + stride] for first in range(0, len(own), stride))
        tops = [max(group, key=lambda reading: reading.dose_rate_usvh) for group in groups]
        columns = np.array([(r.latitude_deg, r.longitude_deg, r.altitude_m) for r in tops]).T
        for (x, y), top in zip(_xy(frame, *columns), tops, strict=True):
            seconds = (top.time_ns - start_ns) / NS_PER_S
            yield DosePoint(x, y, seconds, top.dose_rate_usvh, vehicle)
