# SPDX-License-Identifier: Apache-2.0
"""The folder of a data set, and the files of one image."""

import json
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_dataset.errors import DatasetError
from rocsafe_dataset.labels.annotations import Annotation
from rocsafe_dataset.options import DatasetOptions
from rocsafe_dataset.poses.image_poses import ImagePose
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import PinholeCamera, quaternion_of_rotation
from rocsafe_geo.storage.durable import replace_whole
from rocsafe_mapping.photographs.exif import with_exif
from rocsafe_mapping.photographs.exif_png import png_with_exif
from rocsafe_mapping.photographs.shot import Intrinsics, ShotRecord
from rocsafe_scene.graphics.rendering import Rendering

_UNKNOWN = (0.0,) * 9
# Instance masks have 16 bits.
LARGEST_NUMBER = 65_535


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LabelledImage:
    """One rendered image with its labels.

    Attributes
    ----------
    pose
        Pose of the camera.
    frame
        Image, depth and labels as rendered.
    annotations
        Annotations of the instances in it.
    weather, time_ns
        Weather, and time of the sun, nanoseconds since 1970.
    height_m
        Height of the camera above the ground, metres.
    renderer
        Name of the renderer.
    """

    pose: ImagePose
    frame: Rendering
    annotations: list[Annotation]
    weather: str
    time_ns: int
    height_m: float
    renderer: str


@dataclass(frozen=True, slots=True, kw_only=True)
class DatasetFolder:
    """The folder of a data set.

    Attributes
    ----------
    path
        Path of the folder.
    options
        Options of the data set.
    """

    path: Path
    options: DatasetOptions

    def image(self, pose: ImagePose) -> str:
        """Return the path of an image, relative to the folder."""
        return f'images/{pose.split}/{pose.name}.{self.options.image_format}'

    def record(self, number: int) -> Path:
        """Return the path of the record of an image, the last of its files to be written."""
        return self.path / 'records' / f'{number:06d}.json'

    def write(self, picture: LabelledImage, frame: LocalFrame) -> None:
        """Write all files of one image; `frame` is the local frame of the scene.

        Raises
        ------
        DatasetError
            If a file cannot be written.
        """
        pose, seen = picture.pose, picture.frame
        shot = _shot(picture, frame, self.options.lens)
        depth = np.where(np.isfinite(seen.depth_m), seen.depth_m, np.float32(0.0))
        files = {
            self.image(pose): self._image(seen.image, shot),
            f'masks/{pose.split}/{pose.name}.png': _png(seen.numbers.astype(np.uint16)),
            f'semantic/{pose.split}/{pose.name}.png': _png(seen.classes),
            f'depth/{pose.split}/{pose.name}.tiff': _encoded('.tiff', depth),
            f'labels/{pose.split}/{pose.name}.txt': _yolo(picture.annotations).encode(),
            f'records/{pose.name}.json': json.dumps(self._record(picture)).encode(),
        }
        try:
            for name, data in files.items():
                path = self.path / name
                path.parent.mkdir(parents=True, exist_ok=True)
                replace_whole(path, data)
        except OSError as error:
            raise DatasetError(f'{error.filename or self.path}: {error.strerror}') from error

    def _image(self, image: NDArray[np.uint8], shot: ShotRecord) -> bytes:
        if self.options.image_format == 'png':
            return png_with_exif(_png(image), shot)
        quality = [cv2.IMWRITE_JPEG_QUALITY, self.options.jpeg_quality]
        return with_exif(_encoded('.jpg', image, quality), shot)

    def _record(self, picture: LabelledImage) -> dict[str, Any]:
        pose, lens = picture.pose, self.options.lens
        return {
            'number': pose.number,
            'split': pose.split,
            'file': self.image(pose),
            'weather': picture.weather,
            'sun_time_ns': picture.time_ns,
            'height_agl_m': round(picture.height_m, 3),
            'position_enu_m': pose.position.tolist(),
            'rotation_enu_from_optical': pose.rotation.tolist(),
            'camera_matrix': lens.matrix.tolist(),
            'foreign_share': round(pose.foreign_share, 4),
            'renderer': picture.renderer,
            'annotations': [asdict(annotation) for annotation in picture.annotations],
        }


def _shot(picture: LabelledImage, frame: LocalFrame, lens: PinholeCamera) -> ShotRecord:
    """Return the record that the image store would keep of an image."""
    pose = picture.pose
    position = frame.position_of(pose.position)
    return ShotRecord(
        shot_id=f'dataset-{pose.number:05d}',
        vehicle='dataset',
        sequence=pose.number,
        viewpoint_id=pose.number,
        time_ns=picture.time_ns,
        latitude_deg=position.latitude_deg,
        longitude_deg=position.longitude_deg,
        altitude_m=position.altitude_m,
        position_covariance_m2=_UNKNOWN,
        height_agl_m=picture.height_m,
        orientation_xyzw=_quaternion(pose),
        orientation_covariance_rad2=_UNKNOWN,
        camera=Intrinsics.of_pinhole(lens),
        sha256=sha256(picture.frame.image.tobytes()).hexdigest(),
    )  # fmt: skip


def _quaternion(pose: ImagePose) -> tuple[float, float, float, float]:
    x, y, z, w = (float(value) for value in quaternion_of_rotation(pose.rotation))
    return x, y, z, w


def _png(image: NDArray[Any]) -> bytes:
    return _encoded('.png', image)


def _encoded(suffix: str, image: NDArray[Any], settings: list[int] | None = None) -> bytes:
    return cv2.imencode(suffix, image, settings or [])[1].tobytes()


def _yolo(annotations: list[Annotation]) -> str:
    """Return YOLO's text of an image, a line per instance: class and polygon."""
    return ''.join(
        f'{annotation.category} {" ".join(map(str, annotation.polygon))}\n'
        for annotation in annotations
    )
