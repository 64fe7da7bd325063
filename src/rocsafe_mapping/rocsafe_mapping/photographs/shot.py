# SPDX-License-Identifier: Apache-2.0
"""A photograph's record: all that is known of it, apart from its pixels."""

import dataclasses
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.storage.json_values import finite
from rocsafe_geo.storage.value_file import values_of

_VEHICLE = re.compile(r'[A-Za-z][A-Za-z0-9_]{0,63}')
_SHA256 = re.compile(r'[0-9a-f]{64}')
COVARIANCE_SIZE = 9


@dataclass(frozen=True, slots=True, kw_only=True)
class Intrinsics:
    """What turns directions in the optical frame into pixels (OpenCV: integers are centres).

    Attributes
    ----------
    width_px, height_px
        Size of the image.
    fx_px, fy_px
        Focal lengths.
    cx_px, cy_px
        Principal point.
    distortion_model
        Of sensor_msgs/CameraInfo, e.g. ``plumb_bob``; empty for none.
    distortion
        Its coefficients; empty for none.
    focal_std_share
        Uncertainty of the focal length over itself, 0 for a calibrated camera.
    """

    width_px: int
    height_px: int
    fx_px: float
    fy_px: float
    cx_px: float
    cy_px: float
    distortion_model: str = ''
    distortion: tuple[float, ...] = ()
    focal_std_share: float = 0.0

    def __post_init__(self) -> None:
        for name in ('width_px', 'height_px', 'fx_px', 'fy_px'):
            value = getattr(self, name)
            if not 0.0 < value < math.inf:
                raise ValueError(f'camera {name} = {value} must be positive and finite')
        if not all(map(math.isfinite, (self.cx_px, self.cy_px, *self.distortion))):
            raise ValueError('camera cx_px, cy_px and distortion must be finite')

    @classmethod
    def of_pinhole(cls, camera: PinholeCamera) -> 'Intrinsics':
        """Return those of a camera without distortion."""
        matrix = camera.matrix
        return cls(
            width_px=camera.image_width_px,
            height_px=camera.image_height_px,
            fx_px=float(matrix[0, 0]),
            fy_px=float(matrix[1, 1]),
            cx_px=float(matrix[0, 2]),
            cy_px=float(matrix[1, 2]),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotRecord:
    """Where, when, how and by whom a photograph was taken.

    Attributes
    ----------
    shot_id
        ``<vehicle>-<sequence, 5 digits>``; a file name, so nothing else is accepted.
    time_ns
        Exposure, nanoseconds since 1970 UTC (simulated time in simulation).
    latitude_deg, longitude_deg, altitude_m
        Of the camera, WGS84, above the ellipsoid; NaN if unknown.
    position_covariance_m2
        East, north, up; row major.
    height_agl_m
        Above the ground below; NaN if unknown.
    orientation_xyzw
        Quaternion from the optical frame (x right, y down, z forward) to ENU.
    orientation_covariance_rad2
        About east, north, up; row major.
    sha256
        Of the image as the vehicle took it, lower-case hexadecimal.
    lens
        Names the camera, where the vehicle may change it; else empty.
    """

    shot_id: str
    vehicle: str
    sequence: int
    viewpoint_id: int
    time_ns: int
    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    position_covariance_m2: tuple[float, ...]
    height_agl_m: float
    orientation_xyzw: tuple[float, float, float, float]
    orientation_covariance_rad2: tuple[float, ...]
    camera: Intrinsics
    sha256: str
    lens: str = ''

    def __post_init__(self) -> None:
        if not _VEHICLE.fullmatch(self.vehicle):
            raise ValueError(f'vehicle = {self.vehicle!r} must be letters, digits and _')
        expected = f'{self.vehicle}-{self.sequence:05d}'
        if self.sequence < 0 or self.shot_id != expected:
            raise ValueError(f'shot_id = {self.shot_id!r} must be {expected!r}')
        if not _SHA256.fullmatch(self.sha256):
            raise ValueError(f'sha256 = {self.sha256!r} must be 64 lower-case hexadecimal digits')
        if self.time_ns < 0:
            raise ValueError(f'time_ns = {self.time_ns} must be at least 0')
        for name, limit in (('latitude_deg', 90.0), ('longitude_deg', 180.0)):
            if abs(getattr(self, name)) > limit:
                raise ValueError(f'{name} = {getattr(self, name)} must be within +-{limit:g}')
        for name in ('position_covariance_m2', 'orientation_covariance_rad2'):
            if len(getattr(self, name)) != COVARIANCE_SIZE:
                raise ValueError(f'{name} must have {COVARIANCE_SIZE} values')

    @property
    def has_fix(self) -> bool:
        """Whether latitude and longitude are known."""
        return math.isfinite(self.latitude_deg + self.longitude_deg)

    @property
    def has_position(self) -> bool:
        """Whether latitude, longitude and altitude are known."""
        return math.isfinite(self.latitude_deg + self.longitude_deg + self.altitude_m)


def plain_of_record(record: ShotRecord) -> dict[str, Any]:
    """Return `record` as values that JSON can hold; what is not finite becomes None."""
    plain: dict[str, Any] = finite(dataclasses.asdict(record))
    return plain


def record_of_plain(plain: Mapping[str, Any]) -> ShotRecord:
    """Return the record that `plain_of_record` was given; keys of others are not read.

    Raises
    ------
    ValueError
        If a key is missing or a value is wrong.
    """
    known = {field.name for field in dataclasses.fields(ShotRecord)}
    try:
        values = {name: _restored(value) for name, value in plain.items() if name in known}
        return values_of(values, ShotRecord, 'not the record of a photograph')
    except AttributeError as error:
        raise ValueError('not the record of a photograph: must be a block of keys') from error
    except ValueError as error:
        raise ValueError(str(error).partition('\n')[0]) from error


def _restored(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _restored(part) for name, part in value.items()}
    if isinstance(value, list):
        return tuple(_restored(part) for part in value)
    return math.nan if value is None else value
