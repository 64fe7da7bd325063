# SPDX-License-Identifier: Apache-2.0
"""A photograph to be aligned: its camera, and its pose as measured on board.

Local frame: east and north in metres about an origin on the ground, up in metres above the
ground. The curvature of the earth is left out of `up`, so that level ground is level everywhere.
"""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import rotation_of_quaternion
from rocsafe_geo.position import GeoPosition
from rocsafe_mapping.alignment_options import PriorOptions
from rocsafe_mapping.errors import PlacementError
from rocsafe_mapping.photographs.shot import Intrinsics, ShotRecord

# A yaw less certain than this is not used.
UNKNOWN_YAW_STD_RAD = math.radians(60.0)
# Prior height of a camera whose height above the ground is unknown: any value above 0.
PLACEHOLDER_HEIGHT_M = 100.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """Place and attitude of a camera.

    Attributes
    ----------
    centre
        East, north, up in metres, shape (3,).
    rotation
        From the optical frame to east-north-up, shape (3, 3).
    """

    centre: FloatArray
    rotation: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Photo:
    """A photograph to be aligned.

    Attributes
    ----------
    name
        Unique among the photographs of a map.
    vehicle
        That took it.
    lens
        Names the camera; photographs of one lens share its calibration.
    camera
        Without distortion: points are straightened before they come here.
    focal_std_share
        Uncertainty of the focal length over itself; 0 for a calibrated camera.
    prior
        Pose as measured on board.
    horizontal_std_m, vertical_std_m, tilt_std_rad, yaw_std_rad
        Its uncertainty; infinite are `horizontal_std_m` without a fix, and `vertical_std_m` where
        the height above the ground is unknown.
    time_ns
        Of exposure.
    altitude_m
        Of the fix above the origin of the local frame; NaN if unknown.
    """

    name: str
    vehicle: str
    lens: str
    camera: Intrinsics
    focal_std_share: float
    prior: Pose
    horizontal_std_m: float
    vertical_std_m: float
    tilt_std_rad: float
    yaw_std_rad: float
    time_ns: int = 0
    altitude_m: float = math.nan

    @property
    def has_yaw(self) -> bool:
        """Whether the prior says where the top of the image points."""
        return self.yaw_std_rad < UNKNOWN_YAW_STD_RAD

    @property
    def has_fix(self) -> bool:
        """Whether the prior says where the camera was."""
        return math.isfinite(self.horizontal_std_m)

    @property
    def is_located(self) -> bool:
        """Whether it is known or was found where the camera about is."""
        return math.isfinite(self.prior.centre[0])

    @property
    def has_height(self) -> bool:
        """Whether the prior says how high above the ground the camera is."""
        return math.isfinite(self.vertical_std_m)

    def with_height(self, height_m: float, std_m: float) -> 'Photo':
        """Return the photograph with another prior height above the ground."""
        centre = np.array([*self.prior.centre[:2], height_m])
        prior = Pose(centre=centre, rotation=self.prior.rotation)
        return dataclasses.replace(self, prior=prior, vertical_std_m=std_m)

    def at(self, place_m: FloatArray, std_m: float) -> 'Photo':
        """Return the photograph with another prior (east, north), shape (2,)."""
        centre = np.array([*place_m, self.prior.centre[2]])
        prior = Pose(centre=centre, rotation=self.prior.rotation)
        return dataclasses.replace(self, prior=prior, horizontal_std_m=std_m)

    @property
    def ground_resolution_m(self) -> float:
        """Side of the ground that a pixel shows straight below, by the prior."""
        return float(self.prior.centre[2]) / self.camera.fx_px


@dataclass(frozen=True, slots=True)
class GroundFrame:
    """Ties local metres to the earth.

    Attributes
    ----------
    frame
        East-north-up about the origin, which lies on the ground.
    """

    frame: LocalFrame

    def local(self, latitude_deg: float, longitude_deg: float) -> FloatArray:
        """Return (east, north) in metres of a position, shape (2,)."""
        ground = self.frame.origin.altitude_m
        return self.frame.to_enu([latitude_deg], [longitude_deg], [ground])[0, :2]

    def geodetic(self, ground_m: FloatArray) -> FloatArray:
        """Return latitude and longitude in degrees of points (n, 2) on the ground."""
        enu = np.column_stack([ground_m, np.zeros(len(ground_m))])
        return self.frame.to_geodetic(enu)[:, :2]


def ground_frame_of(record: ShotRecord) -> GroundFrame:
    """Return the frame about the ground below a photograph.

    Raises
    ------
    PlacementError
        If it has no position.
    """
    if not record.has_fix:
        raise PlacementError('taken without a fix')
    altitude_m = record.altitude_m - record.height_agl_m
    ground_m = altitude_m if math.isfinite(altitude_m) else 0.0
    return GroundFrame(
        LocalFrame(GeoPosition(record.latitude_deg, record.longitude_deg, ground_m))
    )


def photo_of_record(
    record: ShotRecord, frame: GroundFrame, options: PriorOptions, name: str
) -> Photo:
    """Return the photograph of `record` in `frame`, called `name`; without a fix its place is NaN.

    Raises
    ------
    PlacementError
        If its attitude is unknown, or its height above the ground is not above 0.
    """
    if record.height_agl_m <= 0.0 or math.isinf(record.height_agl_m):
        raise PlacementError(f'height_agl_m = {record.height_agl_m} is no height')
    try:
        rotation = rotation_of_quaternion(record.orientation_xyzw)
    except ValueError as error:
        raise PlacementError(f'no orientation: {error}') from error
    east, north, fix_std_m = _place(record, frame, options)
    up_m, up_std_m = _up(record, frame, options)
    _require_downward(record, rotation, options.longest_reach)
    turn = record.orientation_covariance_rad2
    lens = f'{record.lens or record.vehicle}/{record.camera.width_px}x{record.camera.height_px}'
    return Photo(
        name=name,
        vehicle=record.vehicle,
        lens=lens,
        camera=record.camera,
        focal_std_share=record.camera.focal_std_share,
        prior=Pose(centre=np.array([east, north, up_m]), rotation=rotation),
        horizontal_std_m=fix_std_m,
        vertical_std_m=up_std_m,
        tilt_std_rad=_std(
            0.5 * (turn[0] + turn[4]), options.tilt_std_rad, options.least_angle_std_rad
        ),
        yaw_std_rad=_std(turn[8], options.yaw_std_rad, options.least_angle_std_rad),
        time_ns=record.time_ns,
        altitude_m=record.altitude_m - frame.frame.origin.altitude_m,
    )


def _place(
    record: ShotRecord, frame: GroundFrame, options: PriorOptions
) -> tuple[float, float, float]:
    """Return (east, north) of a fix and its uncertainty; NaN and infinite without one."""
    if not record.has_fix:
        return math.nan, math.nan, math.inf
    east, north = frame.local(record.latitude_deg, record.longitude_deg)
    variance = 0.5 * (record.position_covariance_m2[0] + record.position_covariance_m2[4])
    std_m = _std(variance, options.horizontal_std_m, options.least_position_std_m)
    return float(east), float(north), std_m


def _up(record: ShotRecord, frame: GroundFrame, options: PriorOptions) -> tuple[float, float]:
    """Return how high a camera is above the frame's origin, metres, and its uncertainty.

    The altitude is used, as heights above the ground refer to different ground. Where the two
    differ too much for nearly level ground, the height above the ground is used, which keeps the
    scale right; the difference is added to its uncertainty. Without a height above the ground
    the uncertainty is infinite.
    """
    if math.isnan(record.height_agl_m):
        return PLACEHOLDER_HEIGHT_M, math.inf
    variance = record.position_covariance_m2[8]
    std_m = _std(variance, options.vertical_std_m, options.least_position_std_m)
    up_m = record.altitude_m - frame.frame.origin.altitude_m
    if not math.isfinite(up_m):
        return record.height_agl_m, std_m
    relief_m = abs(up_m - record.height_agl_m)
    if relief_m > options.largest_relief_share * record.height_agl_m:
        return record.height_agl_m, math.hypot(std_m, relief_m)
    return up_m, std_m


def camera_matrix(camera: Intrinsics) -> FloatArray:
    """Return the intrinsic matrix (3, 3): optical coordinates to homogeneous pixels."""
    return np.array(
        [
            [camera.fx_px, 0.0, camera.cx_px],
            [0.0, camera.fy_px, camera.cy_px],
            [0.0, 0.0, 1.0],
        ]
    )


def rays_of_pixels(camera: Intrinsics, pixels: FloatArray) -> FloatArray:
    """Return the optical directions (n, 3), third part 1, of pixels (n, 2)."""
    x = (pixels[:, 0] - camera.cx_px) / camera.fx_px
    y = (pixels[:, 1] - camera.cy_px) / camera.fy_px
    return np.column_stack([x, y, np.ones(len(pixels))])


def footprint(photo: Photo, pose: Pose, focal_factor: float = 1.0) -> FloatArray:
    """Return (east, north) of the image's corners on level ground, metres, shape (4, 2).

    Order: top left, top right, bottom right, bottom left. Rays near the horizon end at five
    heights from the camera. `focal_factor` is the focal length over the believed one.
    """
    right, bottom = photo.camera.width_px - 0.5, photo.camera.height_px - 0.5
    corners = np.array([[-0.5, -0.5], [right, -0.5], [right, bottom], [-0.5, bottom]])
    rays = rays_of_pixels(photo.camera, corners) / (focal_factor, focal_factor, 1.0)
    rays = rays @ pose.rotation.T
    steepness = np.maximum(-rays[:, 2], 0.2 * np.hypot(rays[:, 0], rays[:, 1]))
    reach: FloatArray = rays[:, :2] / np.maximum(steepness, 1e-9)[:, np.newaxis] * pose.centre[2]
    return pose.centre[:2] + reach


def _require_downward(record: ShotRecord, rotation: FloatArray, longest_reach: float) -> None:
    """Raise PlacementError unless all of the image shows ground that is not too far away."""
    camera = record.camera
    right, bottom = camera.width_px - 0.5, camera.height_px - 0.5
    corners = np.array([[-0.5, -0.5], [right, -0.5], [right, bottom], [-0.5, bottom]])
    rays = rays_of_pixels(camera, corners) @ rotation.T
    if not np.all(rays[:, 2] < 0.0):
        raise PlacementError('it looks at or above the horizon')
    if np.max(np.hypot(rays[:, 0], rays[:, 1]) / -rays[:, 2]) > longest_reach:
        raise PlacementError(f'it looks farther than {longest_reach:g} heights')


def _std(variance: float, default: float, least: float) -> float:
    """Return the standard deviation of `variance`; 0 or NaN mean unknown (NavSatFix)."""
    if not 0.0 < variance < math.inf:
        return default
    return max(math.sqrt(variance), least)
