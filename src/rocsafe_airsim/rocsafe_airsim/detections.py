# SPDX-License-Identifier: Apache-2.0
"""Things in an image: their boxes, by the instance and the depth of each pixel."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.ned import Vector
from rocsafe_airsim.vehicle import Picture
from rocsafe_geo.pinhole import rotation_of_quaternion


@dataclass(frozen=True, slots=True, kw_only=True)
class Detection:
    """What is seen of a thing; its hidden parts are not known.

    Attributes
    ----------
    name
        Name of the instance.
    box_px
        Left, top, right, bottom in the image, pixels; right and bottom are the last ones.
    low_m, high_m
        Least and greatest ahead, right, down from the camera, metres.
    distance_m
        Distance of the nearest point.
    place_enu
        Middle of what is seen, in the mission's frame, metres.
    """

    name: str
    box_px: tuple[int, int, int, int]
    low_m: Vector
    high_m: Vector
    distance_m: float
    place_enu: Vector

    @property
    def middle_m(self) -> Vector:
        """Middle of what is seen, ahead, right, down from the camera, metres."""
        return _vector((np.array(self.low_m) + np.array(self.high_m)) / 2.0)


def detections(picture: Picture, names: Mapping[int, str]) -> list[Detection]:
    """Return what an image shows of the instances of these numbers, by rising number.

    Raises
    ------
    AirsimError
        If depth and instances of the image are not known.
    """
    if picture.depth_m is None or picture.labels is None:
        raise AirsimError('depth and instances of this image are not known')
    return list(_found(picture, picture.depth_m, picture.labels, names))


def _found(
    picture: Picture,
    depth_m: NDArray[np.float32],
    labels: NDArray[np.uint16],
    names: Mapping[int, str],
) -> Iterator[Detection]:
    height, width = labels.shape
    focal_px = width / 2.0 / math.tan(math.radians(picture.fov_deg) / 2.0)
    rotation = rotation_of_quaternion(picture.attitude)
    for number in sorted(set(np.unique(labels).tolist()) & names.keys()):
        rows, columns = np.nonzero(labels == number)
        ahead = depth_m[rows, columns].astype(float)
        right = (columns + 0.5 - width / 2.0) / focal_px * ahead
        down = (rows + 0.5 - height / 2.0) / focal_px * ahead
        points = np.stack([ahead, right, down], axis=-1)
        low, high = points.min(axis=0), points.max(axis=0)
        middle = (low + high) / 2.0
        # The optical frame is right, down, ahead.
        place = np.array(picture.place_enu) + rotation @ middle[[1, 2, 0]]
        yield Detection(
            name=names[number],
            box_px=(int(columns.min()), int(rows.min()), int(columns.max()), int(rows.max())),
            low_m=_vector(low),
            high_m=_vector(high),
            distance_m=float(np.linalg.norm(points, axis=-1).min()),
            place_enu=_vector(place),
        )


def _vector(array: NDArray[np.float64]) -> Vector:
    first, second, third = array.tolist()
    return first, second, third
