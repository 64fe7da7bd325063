# SPDX-License-Identifier: Apache-2.0
"""Drone photographs of any maker: records from their Exif and XMP.

Conventions: Exif 2.32; XMP of DJI (``drone-dji``: yaw clockwise from north, a gimbal's pitch -90
looks straight down, RelativeAltitude above the take-off point) and of Pix4D (``Camera``: yaw,
pitch 0 straight down, roll). Strings may be padded with NUL, numbers may carry a plus sign.
"""

import hashlib
import math
import re
from collections import Counter
from collections.abc import Sequence
from datetime import datetime, timezone
from pathlib import Path

from PIL.ExifTags import GPS, Base

from rocsafe_geo.pinhole import quaternion_of_rotation, rotation_enu_from_optical
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.photographs.shot import Intrinsics, ShotRecord
from rocsafe_mapping.photographs.tags import Tags, limited, number_of, read_tags
from rocsafe_mapping.store.catalogue import Notice, StoredShot

SUFFIXES = ('.jpg', '.jpeg')
# How many folders below, and kinds of other files, a message names.
MOST_NAMED = 3
# A film frame is 36 mm x 24 mm; whether a maker's 35 mm equivalent is meant across the width or
# along the diagonal is not said, hence this uncertainty.
FILM_WIDTH_MM, FILM_DIAGONAL_MM = 36.0, math.hypot(36.0, 24.0)
EXIF_FOCAL_STD_SHARE = 0.06
TABLE_FOCAL_STD_SHARE = 0.03
# Limits of lenses without strong distortion: from 136 degrees wide to a long telephoto.
SHORTEST_FOCAL_WIDTHS, LONGEST_FOCAL_WIDTHS = 0.2, 50.0
# Widths of sensors in millimetres, from their makers' data sheets.
SENSOR_WIDTH_MM = {
    'FC300S': 6.17, 'FC300X': 6.17, 'FC330': 6.17, 'FC220': 6.17, 'FC6310': 13.2, 'FC6310S': 13.2,
    'FC6310R': 13.2, 'FC6520': 17.3, 'FC6540': 23.5, 'FC350': 6.17, 'FC550': 17.3,
    'L1D-20C': 13.2, 'L2D-20C': 17.3, 'FC7303': 6.3, 'FC3411': 13.2, 'FC3582': 9.6,
    'Canon PowerShot SX260 HS': 6.17, 'Canon PowerShot S100': 7.44,
}  # fmt: skip
UNIT_MM = {2: 25.4, 3: 10.0, 4: 1.0}
# Standard deviations of the attitude of a gimbal, and of a camera without one.
GIMBAL_TILT_STD_DEG, GIMBAL_YAW_STD_DEG = 2.0, 10.0
FIXED_TILT_STD_DEG, NO_YAW_STD_DEG = 6.0, 180.0
HORIZONTAL_STD_M, VERTICAL_STD_M = 2.5, 1.5
# Of altitudes and heights, which no drone reaches, of accuracies, and of angles.
MOST_HEIGHT_M, MOST_ACCURACY_M, MOST_ANGLE_DEG = 20_000.0, 100_000.0, 720.0
# Letters of Exif for the hemispheres of latitude and longitude.
HEMISPHERES = {GPS.GPSLatitude: ('N', 'S'), GPS.GPSLongitude: ('E', 'W')}
# Of GPSAltitudeRef: 1 is below sea level (Exif 2), 3 below the ellipsoid (Exif 3).
BELOW = (1.0, 3.0)
_NOT_NAME = re.compile(r'[^A-Za-z0-9]+')


def photographs_of(folder: Path, notice: Notice) -> tuple[StoredShot, ...]:
    """Return the photographs of a folder, by name; `notice` hears of those that cannot be read.

    Raises
    ------
    StoreError
        If the folder cannot be read or has no JPEG file.
    """
    try:
        there = sorted(folder.iterdir())
        paths = [path for path in there if path.suffix.lower() in SUFFIXES]
        if not paths:
            raise StoreError(f'{folder}: has no JPEG file{_instead(there)}')
    except OSError as error:
        raise StoreError(f'cannot read {folder}: {error.strerror}') from error
    counts: dict[str, int] = {}
    shots = []
    for path in paths:
        try:
            tags, data = read_tags(path)
        except StoreError as error:
            notice(str(error))
            continue
        vehicle = vehicle_of(tags)
        sequence = counts.get(vehicle, 0)
        counts[vehicle] = sequence + 1
        try:
            record = record_of_tags(tags, vehicle, sequence, hashlib.sha256(data).hexdigest())
        except ValueError as error:
            notice(f'{path}: {error}')
            continue
        for tag in HEMISPHERES:
            if not _is_on_a_side(tags, tag):
                sides = ' nor '.join(HEMISPHERES[tag])
                notice(f'{path}: {GPS(tag).name} is neither {sides}: its own place is not used')
        shots.append(StoredShot(record=record, path=path))
    return tuple(shots)


def _instead(there: Sequence[Path]) -> str:
    """Return what a folder without JPEG files has instead, in words."""
    below = [
        path.name
        for path in there
        if path.is_dir() and any(one.suffix.lower() in SUFFIXES for one in path.iterdir())
    ]
    if below:
        return f', but folders that have some: {", ".join(below[:MOST_NAMED])}; name one of them'
    kinds = Counter(path.suffix.lower() for path in there if path.suffix)
    named = ', '.join(f'{count} {kind}' for kind, count in kinds.most_common(MOST_NAMED))
    return f'; other kinds are not read: {named}' if named else ''


def vehicle_of(tags: Tags) -> str:
    """Return a name for the vehicle: what the camera's serial number, or its model, says."""
    serial = str(tags.camera.get(Base.BodySerialNumber, '')).replace('\x00', '').strip()
    words = serial or f'{tags.text(Base.Make)}_{tags.text(Base.Model)}'
    name = _NOT_NAME.sub('_', words).strip('_')[:48]
    return name if name[:1].isalpha() else f'camera_{name}'.rstrip('_')


def record_of_tags(tags: Tags, vehicle: str, sequence: int, sha256: str) -> ShotRecord:
    """Return the record that the tags of a photograph amount to.

    Unknown values are NaN.

    Raises
    ------
    ValueError
        If a tag has a value that cannot be, or the focal length is unknown.
    """
    latitude, longitude = _fix_deg(tags)
    yaw, pitch, roll, tilt_std, yaw_std = _attitude(tags)
    rotation = rotation_enu_from_optical(math.radians(90.0 - yaw), pitch, roll)
    accuracies = [
        tags.number(f'Camera:GPS{axes}Accuracy', most=MOST_ACCURACY_M) for axes in ('XY', 'Z')
    ]
    horizontal, vertical = map(_known, accuracies, (HORIZONTAL_STD_M, VERTICAL_STD_M))
    quaternion = quaternion_of_rotation(rotation).tolist()
    # Above the place of take-off for DJI: below it, it tells nothing of the ground.
    height_m = tags.number(
        'drone-dji:RelativeAltitude', 'Camera:AboveGroundAltitude', most=MOST_HEIGHT_M
    )
    return ShotRecord(
        shot_id=f'{vehicle}-{sequence:05d}',
        vehicle=vehicle,
        sequence=sequence,
        viewpoint_id=sequence,
        time_ns=_time_ns(tags),
        latitude_deg=latitude,
        longitude_deg=longitude,
        altitude_m=_altitude(tags),
        position_covariance_m2=_diagonal(horizontal, horizontal, vertical),
        height_agl_m=height_m if height_m > 0.0 else math.nan,
        orientation_xyzw=(quaternion[0], quaternion[1], quaternion[2], quaternion[3]),
        orientation_covariance_rad2=_diagonal(tilt_std, tilt_std, yaw_std),
        camera=_camera(tags),
        sha256=sha256,
        lens=f'{tags.text(Base.Make)} {tags.text(Base.Model)} {vehicle}'.strip(),
    )


def _fix_deg(tags: Tags) -> tuple[float, float]:
    """Return latitude and longitude; NaN if not known.

    Cameras that have no fix write 0/0; without a hemisphere a place is one of two.
    """
    fix = _degrees(tags, GPS.GPSLatitude), _degrees(tags, GPS.GPSLongitude)
    is_known = any(fix) and all(_is_on_a_side(tags, tag) for tag in HEMISPHERES)
    return fix if is_known else (math.nan, math.nan)


def _degrees(tags: Tags, tag: int) -> float:
    """Return latitude or longitude, NaN if there is none."""
    try:
        degrees, minutes, seconds = map(number_of, tags.gps[tag])
    except (KeyError, TypeError, ValueError):
        return math.nan
    angle = degrees + minutes / 60.0 + seconds / 3600.0
    return -angle if _side(tags, tag) == HEMISPHERES[GPS(tag)][1] else angle


def _side(tags: Tags, tag: int) -> str:
    return str(tags.gps.get(tag - 1, '')).strip('\x00 ')[:1].upper()


def _is_on_a_side(tags: Tags, tag: int) -> bool:
    """Return whether the hemisphere is known, where there is a latitude or longitude but 0."""
    angle = _degrees(tags, tag)
    return not angle or math.isnan(angle) or _side(tags, tag) in HEMISPHERES[GPS(tag)]


def _altitude(tags: Tags) -> float:
    exact = tags.number('drone-dji:AbsoluteAltitude', most=MOST_HEIGHT_M)
    if math.isfinite(exact):
        return exact
    altitude = limited('GPSAltitude', number_of(tags.gps.get(GPS.GPSAltitude)), MOST_HEIGHT_M)
    reference = tags.gps.get(GPS.GPSAltitudeRef)
    if isinstance(reference, bytes) and reference:
        reference = reference[0]
    return -altitude if number_of(reference) in BELOW else altitude


def _attitude(tags: Tags) -> tuple[float, float, float, float, float]:
    """Return yaw in degrees clockwise from north, pitch, roll, and stds of tilt and yaw in rad."""
    tilt, turn = math.radians(GIMBAL_TILT_STD_DEG), math.radians(GIMBAL_YAW_STD_DEG)
    yaw = _angle(tags, 'drone-dji:GimbalYawDegree')
    if math.isfinite(yaw):
        # Pitch -90 of a gimbal is level for a nadir camera; positive pitch of the body lowers it.
        pitch = _known(_angle(tags, 'drone-dji:GimbalPitchDegree'), -90.0)
        roll = math.radians(_known(_angle(tags, 'drone-dji:GimbalRollDegree'), 0.0))
        return yaw, -math.radians(pitch + 90.0), math.remainder(roll, math.pi), tilt, turn
    tilt = math.radians(FIXED_TILT_STD_DEG)
    yaw = _angle(tags, 'Camera:Yaw', 'drone-dji:FlightYawDegree')
    if math.isfinite(yaw):
        pitch = -math.radians(_known(_angle(tags, 'Camera:Pitch'), 0.0))
        return yaw, pitch, math.radians(_known(_angle(tags, 'Camera:Roll'), 0.0)), tilt, turn
    yaw = number_of(tags.gps.get(GPS.GPSImgDirection))
    if math.isfinite(yaw):
        return limited('GPSImgDirection', yaw, MOST_ANGLE_DEG), 0.0, 0.0, tilt, turn
    return 0.0, 0.0, 0.0, tilt, math.radians(NO_YAW_STD_DEG)


def _angle(tags: Tags, *names: str) -> float:
    return tags.number(*names, most=MOST_ANGLE_DEG)


def _camera(tags: Tags) -> Intrinsics:
    focal_px, std_share = _focal(tags)
    if not SHORTEST_FOCAL_WIDTHS <= focal_px / tags.width_px <= LONGEST_FOCAL_WIDTHS:
        raise ValueError(
            f'a focal length of {focal_px / tags.width_px:.3g} image widths is not from '
            f'{SHORTEST_FOCAL_WIDTHS:g} to {LONGEST_FOCAL_WIDTHS:g}'
        )
    return Intrinsics(
        width_px=tags.width_px,
        height_px=tags.height_px,
        fx_px=focal_px,
        fy_px=focal_px,
        cx_px=0.5 * (tags.width_px - 1),
        cy_px=0.5 * (tags.height_px - 1),
        focal_std_share=std_share,
    )


def _focal(tags: Tags) -> tuple[float, float]:
    """Return the focal length in pixels and its uncertainty over itself.

    A calibration counts most, then the camera's table, then the 35 mm equivalent, then the
    resolution of the focal plane.
    """
    exact = tags.number('rocsafe:FocalLengthPixels')
    if math.isfinite(exact):
        return exact, 0.0
    focal_mm = number_of(tags.camera.get(Base.FocalLength))
    sensor_mm = SENSOR_WIDTH_MM.get(tags.text(Base.Model))
    if sensor_mm and math.isfinite(focal_mm):
        return tags.width_px * focal_mm / sensor_mm, TABLE_FOCAL_STD_SHARE
    film_mm = number_of(tags.camera.get(Base.FocalLengthIn35mmFilm))
    if film_mm > 0.0:
        diagonal_px = math.hypot(tags.width_px, tags.height_px)
        return film_mm * diagonal_px / FILM_DIAGONAL_MM, EXIF_FOCAL_STD_SHARE
    per_unit = number_of(tags.camera.get(Base.FocalPlaneXResolution))
    unit_mm = UNIT_MM.get(tags.camera.get(Base.FocalPlaneResolutionUnit, 2), 25.4)
    declared = number_of(tags.camera.get(Base.ExifImageWidth))
    if focal_mm * per_unit > 0.0:
        shrink = tags.width_px / declared if declared > 0.0 else 1.0
        return focal_mm * per_unit / unit_mm * shrink, EXIF_FOCAL_STD_SHARE
    raise ValueError('no tag tells the focal length (FocalLengthIn35mmFilm or FocalPlane...)')


def _time_ns(tags: Tags) -> int:
    text = str(tags.camera.get(Base.DateTimeOriginal, '')).strip('\x00 ')
    part = str(tags.camera.get(Base.SubsecTimeOriginal, '')).strip('\x00 ')
    try:
        taken = datetime.strptime(text, '%Y:%m:%d %H:%M:%S').replace(tzinfo=timezone.utc)
    except ValueError:
        return 0
    fraction = int((part + '000000000')[:9]) if part.isdigit() else 0
    return max(int(taken.timestamp()), 0) * NS_PER_S + fraction


def _known(value: float, default: float) -> float:
    return value if math.isfinite(value) else default


def _diagonal(first: float, second: float, third: float) -> tuple[float, ...]:
    return (first**2, 0.0, 0.0, 0.0, second**2, 0.0, 0.0, 0.0, third**2)
