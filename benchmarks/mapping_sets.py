# SPDX-License-Identifier: Apache-2.0
"""Sets of photographs with exact truth for `mapping.py`.

They are cut from an orthophoto, which lies flat: the truth of every pixel is known.
"""

import json
import math
from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import (
    PinholeCamera,
    ground_corners,
    ground_homography,
    quaternion_of_rotation,
    rotation_enu_from_optical,
)
from rocsafe_geo.position import GeoPosition
from rocsafe_mapping.photographs.shot import Intrinsics, ShotRecord

HEIGHT_M = 32.0
Truth = dict[str, FloatArray]


@dataclass(frozen=True, slots=True)
class Sample:
    """A photograph: record, file, and the true corners of its footprint, metres (4, 2)."""

    record: ShotRecord
    jpeg: bytes
    corners_m: FloatArray


@dataclass(frozen=True)
class OnDisk:
    """As `Sample`, its file on disk."""

    record: ShotRecord
    path: Path
    corners_m: FloatArray

    @property
    def jpeg(self) -> bytes:
        """The file."""
        return self.path.read_bytes()


@dataclass(frozen=True, slots=True, kw_only=True)
class Flight:
    """What is flown.

    Attributes
    ----------
    overlap: share of the footprint that neighbours have in common, true.
    extent_m: east and north.
    fix_std_m, tilt_std_rad, yaw_std_rad: noise of the records.
    exposure_std: of the brightness.
    """

    camera: PinholeCamera = field(
        default_factory=lambda: PinholeCamera(math.radians(60.0), 800, 600)
    )
    overlap: float = 1.0 / 3.0
    extent_m: tuple[float, float] = (100.0, 90.0)
    fix_std_m: float = 1.5
    height_std_m: float = 0.3
    tilt_std_rad: float = math.radians(2.0)
    yaw_std_rad: float = math.radians(1.0)
    exposure_std: float = 0.05
    vehicle: str = 'rav1'


@dataclass(frozen=True, slots=True)
class Orthophoto:
    """Ground as a picture; its middle is the origin."""

    picture: NDArray[np.uint8]
    resolution_m: float
    frame: LocalFrame = field(default_factory=lambda: LocalFrame(GeoPosition(53.28, -9.06, 60.0)))

    def seen(
        self, camera: PinholeCamera, centre: FloatArray, rotation: FloatArray
    ) -> NDArray[np.uint8]:
        """Return what a camera sees."""
        half_y, half_x = (0.5 * self.resolution_m * side for side in self.picture.shape[:2])
        to_ground = np.array(
            [
                [self.resolution_m, 0.0, 0.5 * self.resolution_m - half_x],
                [0.0, -self.resolution_m, half_y - 0.5 * self.resolution_m],
                [0.0, 0.0, 1.0],
            ]
        )
        size = (camera.image_width_px, camera.image_height_px)
        seen: NDArray[np.uint8] = cv2.warpPerspective(
            self.picture,
            ground_homography(camera, centre, rotation) @ to_ground,
            size,
            flags=cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REFLECT_101,
        )
        return seen


def orthophoto(path: Path, resolution_m: float) -> Orthophoto:
    """Return the largest full rectangle about the middle of a picture with coverage."""
    picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    shown = picture[..., 3] > 0
    side = min(shown.shape)
    for share in np.arange(0.95, 0.2, -0.02):
        half = int(share * side / 2)
        row, column = shown.shape[0] // 2, shown.shape[1] // 2
        part = (slice(row - half, row + half), slice(column - half, column + half))
        if shown[part].all():
            return Orthophoto(np.ascontiguousarray(picture[part][..., :3]), resolution_m)
    raise ValueError(f'{path} shows no full square')


def enlarged(ground: Orthophoto, copies: int, seed: int) -> Orthophoto:
    """Return ground that repeats itself only farther away than neighbours look.

    Large soft spots make the copies different from each other; a mirror image would not do, for
    about its corners the ground would look the same turned by half.
    """
    whole = np.tile(ground.picture, (copies, copies, 1))
    rng = np.random.default_rng(seed)
    cells = rng.normal(1.0, 0.25, (24 * copies, 24 * copies)).astype(np.float32)
    spots = cv2.resize(cells, whole.shape[1::-1], interpolation=cv2.INTER_CUBIC)
    for start in range(0, len(whole), 1024):
        part = slice(start, start + 1024)
        whole[part] = np.clip(whole[part] * spots[part, :, np.newaxis], 0, 255)
    return Orthophoto(whole, ground.resolution_m)


def flown(ground: Orthophoto, flight: Flight, seed: int, most: int = 10_000) -> list[Sample]:
    """Return the photographs of a lawnmower flight about the origin."""
    rng = np.random.default_rng(seed)
    width_m, height_m = flight.camera.footprint_m(HEIGHT_M)
    steps = width_m * (1.0 - flight.overlap), height_m * (1.0 - flight.overlap)
    columns = max(2, round(flight.extent_m[0] / steps[0]))
    rows = max(2, round(flight.extent_m[1] / steps[1]))
    samples: list[Sample] = []
    for row in range(rows):
        for step in range(columns):
            if len(samples) == most:
                return samples
            column = step if row % 2 == 0 else columns - 1 - step
            place = (column - (columns - 1) / 2) * steps[0], ((rows - 1) / 2 - row) * steps[1]
            samples.append(_taken(ground, flight, len(samples), place, rng))
    return samples


def _taken(
    ground: Orthophoto,
    flight: Flight,
    number: int,
    place: tuple[float, float],
    rng: np.random.Generator,
) -> Sample:
    pitch, roll = rng.normal(0.0, flight.tilt_std_rad, 2)
    # The image top points north, as on a drone that holds its heading.
    rotation = rotation_enu_from_optical(math.pi / 2 + rng.normal(0.0, 0.03), pitch, roll)
    centre = np.array([*place, HEIGHT_M]) + rng.normal(0.0, [0.3, 0.3, 0.1])
    picture = ground.seen(flight.camera, centre, rotation)
    gain = rng.normal(1.0, flight.exposure_std)
    picture = np.clip(picture * gain + rng.normal(0.0, 2.0, picture.shape), 0, 255)
    jpeg = bytes(cv2.imencode('.jpg', picture.astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, 92])[1])
    told = centre + rng.normal(0.0, [flight.fix_std_m, flight.fix_std_m, flight.height_std_m])
    yaw = math.atan2(rotation[1, 0], rotation[0, 0]) + math.pi / 2
    level = rotation_enu_from_optical(yaw + rng.normal(0.0, flight.yaw_std_rad))
    record = record_of(ground.frame, flight, number, told, level)
    corners = ground_corners(flight.camera, centre, rotation)
    return Sample(record, jpeg, corners)


def record_of(
    frame: LocalFrame,
    flight: Flight,
    number: int,
    told: FloatArray,
    rotation: FloatArray,
) -> ShotRecord:
    """Return a record as a vehicle would send it."""
    place = frame.position_of(told)
    fix, height = flight.fix_std_m**2, flight.height_std_m**2
    tilt, yaw = flight.tilt_std_rad**2, flight.yaw_std_rad**2
    x, y, z, w = quaternion_of_rotation(rotation).tolist()
    return ShotRecord(
        shot_id=f'{flight.vehicle}-{number:05d}',
        vehicle=flight.vehicle,
        sequence=number,
        viewpoint_id=number,
        time_ns=number * 1_500_000_000,
        latitude_deg=place.latitude_deg,
        longitude_deg=place.longitude_deg,
        altitude_m=place.altitude_m,
        position_covariance_m2=(fix, 0.0, 0.0, 0.0, fix, 0.0, 0.0, 0.0, height),
        height_agl_m=float(told[2]),
        orientation_xyzw=(x, y, z, w),
        orientation_covariance_rad2=(tilt, 0.0, 0.0, 0.0, tilt, 0.0, 0.0, 0.0, yaw),
        camera=Intrinsics.of_pinhole(flight.camera),
        sha256='0' * 64,
    )


def moved(sample: Sample, frame: LocalFrame, east_m: float, north_m: float) -> Sample:
    """Return a sample whose fix is off by so much."""
    record = sample.record
    place = GeoPosition(record.latitude_deg, record.longitude_deg, record.altitude_m)
    wrong = frame.position_of(frame.enu_of(place) + np.array([east_m, north_m, 0.0]))
    return replace(
        sample,
        record=replace(record, latitude_deg=wrong.latitude_deg, longitude_deg=wrong.longitude_deg),
    )


def turned(sample: Sample, angle_rad: float) -> Sample:
    """Return a sample whose yaw is told wrong by an angle."""
    x, y, z, w = sample.record.orientation_xyzw
    cos, sin = math.cos(angle_rad / 2), math.sin(angle_rad / 2)
    # Product of the turn about up (0, 0, sin, cos) and the orientation.
    orientation = (
        cos * x - sin * y, cos * y + sin * x, cos * z + sin * w, cos * w - sin * z
    )  # fmt: skip
    return replace(sample, record=replace(sample.record, orientation_xyzw=orientation))


def shared_set(folder: Path) -> list[Sample]:
    """Return a set that is described by a ``truth.json`` of exact poses and noisy fixes."""
    truth = json.loads((folder / 'truth.json').read_text())
    frame = LocalFrame(GeoPosition(truth['lat0'], truth['lon0'], 0.0))
    fov = 2.0 * math.atan(truth['W'] / 2.0 / truth['f'])
    flight = Flight(camera=PinholeCamera(fov, truth['W'], truth['H']), height_std_m=0.5)
    samples = []
    for number, image in enumerate(truth['images']):
        told = np.array([*image['gps_xy'], image['true_xyz'][2]])
        level = rotation_enu_from_optical(math.pi / 2 + image['yaw'])
        record = record_of(frame, flight, number, told, level)
        jpeg = (folder / image['name']).read_bytes()
        samples.append(Sample(record, jpeg, np.array(image['corners_xy'])))
    return samples
