# SPDX-License-Identifier: Apache-2.0
"""Values as plain data for JSON: units in the keys, unknown numbers as null."""

import dataclasses
import math
from typing import Any

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import Ring, SurveyArea
from rocsafe_geo.terrain.terrain import Terrain
from rocsafe_planner.plan.survey_options import Continuation, UnheardVehicle
from rocsafe_planner.plan.survey_region import SurveyRegion
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_planner.plan.viewpoint import Viewpoint

Document = dict[str, Any]


def number(value: float) -> float | None:
    """Return None for NaN and infinity, which JSON lacks."""
    return float(value) if math.isfinite(value) else None


def position_document(position: GeoPosition) -> Document:
    """Return latitude, longitude, and altitude above the WGS84 ellipsoid."""
    return {
        'latitude_deg': position.latitude_deg,
        'longitude_deg': position.longitude_deg,
        'altitude_m': number(position.altitude_m),
    }


def area_document(area: SurveyArea) -> Document:
    """Return name, boundary and holes; rings are not closed."""
    return {
        'name': area.name,
        'boundary': _ring(area.boundary),
        'holes': [_ring(hole) for hole in area.holes],
    }


def region_document(region: SurveyRegion) -> Document:
    """Return an area with the sensors it requires."""
    return {**area_document(region.area), 'sensors': list(region.sensors)}


def camera_document(camera: PinholeCamera) -> Document:
    """Return the camera's three numbers."""
    return dataclasses.asdict(camera)


def vehicle_document(vehicle: Vehicle) -> Document:
    """Return all fields of a vehicle."""
    end = None if vehicle.end is None else position_document(vehicle.end)
    aloft = vehicle.aloft and {
        **position_document(vehicle.aloft.position),
        'used_s': vehicle.aloft.used_s,
    }
    document = {
        **dataclasses.asdict(vehicle),
        'aloft': aloft,
        'home': position_document(vehicle.home),
        'end': end,
        'sensors': list(vehicle.sensors),
    }
    if vehicle.layer is None:  # plans without reserved layers keep their ids
        del document['layer']
    return document


def terrain_document(terrain: Terrain | None) -> Document | None:
    """Return the name and the SHA-256 digest of an elevation model."""
    return None if terrain is None else {'name': terrain.name, 'sha256': terrain.digest}


def viewpoint_document(viewpoint: Viewpoint) -> Document:
    """Return a viewpoint without its footprint."""
    return {
        'id': viewpoint.id,
        **position_document(viewpoint.position),
        'height_agl_m': number(viewpoint.height_agl_m),
        'yaw_rad': viewpoint.yaw_rad,
        'sensors': list(viewpoint.sensors),
    }


def _unheard_document(vehicle: UnheardVehicle) -> Document:
    return {
        'name': vehicle.name,
        'flight_height_m': vehicle.flight_height_m,
        'home': position_document(vehicle.home),
        'places': [position_document(place) for place in vehicle.places],
    }


def continuation_document(continuation: Continuation) -> Document:
    """Return what is taken over from an earlier plan; what is rare only where there is some."""
    unheard = [_unheard_document(one) for one in continuation.unheard]
    document: Document = {
        'viewpoints': [viewpoint_document(view) for view in continuation.viewpoints],
        'visited': [viewpoint_document(view) for view in continuation.visited],
        'ground_reference': [position_document(p) for p in continuation.ground_reference],
        **({'unheard': unheard} if unheard else {}),
    }
    if continuation.last:  # other plans keep their ids
        document['last'] = list(continuation.last)
    return document


def _ring(ring: Ring) -> list[Document]:
    return [
        {'latitude_deg': corner.latitude_deg, 'longitude_deg': corner.longitude_deg}
        for corner in ring
    ]
