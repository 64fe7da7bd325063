# SPDX-License-Identifier: Apache-2.0
"""Where on the map a photograph lies, by its position and attitude over level ground."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from pyproj import Transformer

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import rotation_of_quaternion
from rocsafe_geo.position import GeoPosition
from rocsafe_mapping.errors import PlacementError
from rocsafe_mapping.shot import Intrinsics, ShotRecord

FloatArray = NDArray[np.float64]
WGS84_EPSG = 4326
UTM_NORTH_EPSG, UTM_SOUTH_EPSG = 32600, 32700
UTM_ZONE_DEG = 6.0
UTM_ZONES = 60
# UTM ends at these latitudes (NGA.SIG.0012).
UTM_SOUTH_LIMIT_DEG, UTM_NORTH_LIMIT_DEG = -80.0, 84.0
# Farthest ground that is drawn, in heights: beyond it, 79 degrees off nadir, a pixel of the
# photograph smears over more than twenty times its size below the camera.
LONGEST_REACH = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Placement:
    """A photograph's place on the map.

    Attributes
    ----------
    easting_m, northing_m: UTM position below the camera.
    height_m: of the camera above the ground.
    pixel_of_offset: homography (3, 3) from (easting, northing) in metres, counted from the point
        below the camera, to pixels of the photograph.
    corners_m: UTM (easting, northing) of the photograph's corners, shape (4, 2).
    """

    easting_m: float
    northing_m: float
    height_m: float
    pixel_of_offset: FloatArray
    corners_m: FloatArray


def utm_epsg(record: ShotRecord) -> int:
    """Return the EPSG code of the UTM zone of a photograph, by its longitude alone.

    Raises
    ------
    PlacementError: if its position is unknown or outside the latitudes of UTM.
    """
    _require_pose(record)
    latitude_deg, longitude_deg = record.latitude_deg, record.longitude_deg
    if not UTM_SOUTH_LIMIT_DEG <= latitude_deg <= UTM_NORTH_LIMIT_DEG:
        raise PlacementError(
            f'latitude {latitude_deg} is outside UTM, {UTM_SOUTH_LIMIT_DEG:g} to '
            f'{UTM_NORTH_LIMIT_DEG:g}'
        )
    zone = min(int((longitude_deg + 180.0) // UTM_ZONE_DEG) + 1, UTM_ZONES)
    return zone + (UTM_SOUTH_EPSG if latitude_deg < 0.0 else UTM_NORTH_EPSG)


def position_of_utm(epsg: int, easting_m: float, northing_m: float) -> GeoPosition:
    """Return the WGS84 position, of unknown altitude, of a point on the map."""
    longitude, latitude = _utm_of_wgs84(epsg).transform(easting_m, northing_m, direction='INVERSE')
    return GeoPosition(latitude, longitude)


def placement_of(record: ShotRecord, epsg: int) -> Placement:
    """Return where the photograph of `record` lies on the map of UTM zone `epsg`.

    Raises
    ------
    PlacementError: if position, height or attitude is unknown, the camera's distortion has a
        model not known here, or the photograph looks too far towards the horizon.
    """
    _require_pose(record)
    easting, northing = _utm_of_wgs84(epsg).transform(record.longitude_deg, record.latitude_deg)
    pixel_of_ground = _ground_homography(record)
    ground_of_offset = _ground_of_offset(record, epsg, easting, northing)
    pixel_of_offset = pixel_of_ground @ ground_of_offset
    corners = np.linalg.solve(pixel_of_offset, _corner_pixels(record.camera))
    # The third row is one over the depth: positive in front of the camera.
    if not np.all(corners[2] > 0.0):
        raise PlacementError(f'{record.shot_id} looks at or above the horizon')
    offsets = (corners[:2] / corners[2]).T
    if np.max(np.hypot(*offsets.T)) > LONGEST_REACH * record.height_agl_m:
        raise PlacementError(f'{record.shot_id} looks farther than {LONGEST_REACH:g} heights')
    return Placement(
        easting_m=easting,
        northing_m=northing,
        height_m=record.height_agl_m,
        pixel_of_offset=pixel_of_offset,
        corners_m=offsets + np.array([easting, northing]),
    )


def camera_matrix(camera: Intrinsics) -> FloatArray:
    """Return the intrinsic matrix (3, 3): optical coordinates to homogeneous pixels."""
    return np.array(
        [
            [camera.fx_px, 0.0, camera.cx_px],
            [0.0, camera.fy_px, camera.cy_px],
            [0.0, 0.0, 1.0],
        ]
    )


def _require_pose(record: ShotRecord) -> None:
    if not math.isfinite(record.latitude_deg + record.longitude_deg):
        raise PlacementError(f'{record.shot_id} was taken without a fix')
    height_m = record.height_agl_m
    if not 0.0 < height_m < math.inf:
        raise PlacementError(f'{record.shot_id}: height_agl_m = {height_m} is no height')


def _ground_homography(record: ShotRecord) -> FloatArray:
    """Return the homography from (east, north) below the camera, metres, to pixels.

    As `rocsafe_geo.pinhole.ground_homography`, for a camera whose principal point need not be in
    the middle of the image.
    """
    try:
        rotation = rotation_of_quaternion(record.orientation_xyzw)
    except ValueError as error:
        raise PlacementError(f'{record.shot_id} has no orientation: {error}') from error
    ground = np.diag([1.0, 1.0, -record.height_agl_m])
    return camera_matrix(record.camera) @ rotation.T @ ground


def _ground_of_offset(
    record: ShotRecord, epsg: int, easting_m: float, northing_m: float
) -> FloatArray:
    """Return the affine map (3, 3) from UTM offsets to local east and north, both in metres.

    It carries the grid's convergence, its scale, and the height of the ground; over a footprint
    the grid departs from it by less than a tenth of a millimetre.
    """
    reach = record.height_agl_m
    steps = np.array([[reach, 0.0], [-reach, 0.0], [0.0, reach], [0.0, -reach]])
    longitudes, latitudes = _utm_of_wgs84(epsg).transform(
        easting_m + steps[:, 0], northing_m + steps[:, 1], direction='INVERSE'
    )
    ground_m = record.altitude_m - reach if math.isfinite(record.altitude_m) else 0.0
    frame = LocalFrame(GeoPosition(record.latitude_deg, record.longitude_deg, ground_m))
    enu = frame.to_enu(latitudes, longitudes, np.full(4, ground_m))
    affine = np.eye(3)
    affine[:2, 0] = (enu[0, :2] - enu[1, :2]) / (2.0 * reach)
    affine[:2, 1] = (enu[2, :2] - enu[3, :2]) / (2.0 * reach)
    return affine


def _corner_pixels(camera: Intrinsics) -> FloatArray:
    """Return the outer corners of the image as homogeneous pixels in columns, (3, 4)."""
    right, bottom = camera.width_px - 0.5, camera.height_px - 0.5
    return np.array(
        [[-0.5, right, right, -0.5], [-0.5, -0.5, bottom, bottom], [1.0, 1.0, 1.0, 1.0]]
    )


@lru_cache(maxsize=4)
def _utm_of_wgs84(epsg: int) -> Transformer:
    return Transformer.from_crs(WGS84_EPSG, epsg, always_xy=True)
