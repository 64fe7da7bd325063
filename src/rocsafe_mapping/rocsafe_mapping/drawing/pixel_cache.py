# SPDX-License-Identifier: Apache-2.0
"""Decoded photographs without lens distortion, kept while memory allows."""

from collections import OrderedDict
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_mapping.alignment.model.photo import Photo, camera_matrix
from rocsafe_mapping.errors import PlacementError

# Distortions that OpenCV's `undistort` means by its first five or eight coefficients.
DISTORTION_MODELS = ('', 'plumb_bob', 'rational_polynomial')
CACHE_BYTES = 192 * 2**20
Colour = NDArray[np.uint8]
ReadImage = Callable[[], bytes]


class PixelCache:
    """Decodes photographs when they are needed and keeps those used last.

    Parameters
    ----------
    most_bytes
        Of pixels that are kept.
    """

    def __init__(self, most_bytes: int = CACHE_BYTES) -> None:
        self._most_bytes = most_bytes
        self._bytes = 0
        self._sources: dict[str, tuple[Photo, ReadImage]] = {}
        self._kept: OrderedDict[str, NDArray[Any]] = OrderedDict()

    def add(self, photo: Photo, read: ReadImage) -> None:
        """Take in a photograph; `read` returns its file."""
        self._sources[photo.name] = (photo, read)

    def colour(self, name: str) -> Colour:
        """Return the picture: blue, green, red, without the lens's known distortion.

        Raises
        ------
        PlacementError
            If it cannot be decoded or is not what its record says.
        StoreError
            If it cannot be read.
        """
        return self._cached(name, self._decoded)

    def gray(self, name: str) -> Colour:
        """Return the picture in grey. Raises as `colour` does."""
        return self._cached(name + '|gray', lambda _: _gray(self.colour(name)))

    def _decoded(self, name: str) -> Colour:
        photo, read = self._sources[name]
        return decoded(photo, read())

    def _cached(self, key: str, make: Callable[[str], Colour]) -> Colour:
        if key in self._kept:
            self._kept.move_to_end(key)
            return self._kept[key]
        picture = make(key)
        self._kept[key] = picture
        self._bytes += picture.nbytes
        while self._bytes > self._most_bytes and len(self._kept) > 1:
            _, oldest = self._kept.popitem(last=False)
            self._bytes -= oldest.nbytes
        return picture


def decoded(photo: Photo, jpeg: bytes) -> Colour:
    """Return the pixels of a JPEG file, blue, green, red, without the lens's distortion.

    Raises
    ------
    PlacementError
        If it cannot be decoded, is not what `photo` says, or the lens's model is not known.
    """
    camera = photo.camera
    flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), flags) if jpeg else None
    if image is None:
        raise PlacementError(f'{photo.name}: image cannot be decoded')
    if image.shape[:2] != (camera.height_px, camera.width_px):
        raise PlacementError(
            f'{photo.name}: image is {image.shape[1]} x {image.shape[0]} pixels, its record '
            f'says {camera.width_px} x {camera.height_px}'
        )
    if camera.distortion_model not in DISTORTION_MODELS:
        raise PlacementError(f'{photo.name}: distortion {camera.distortion_model} is unknown')
    if any(camera.distortion):
        image = cv2.undistort(image, camera_matrix(camera), np.array(camera.distortion))
    return image


def _gray(colour: Colour) -> Colour:
    gray: Colour = cv2.cvtColor(colour, cv2.COLOR_BGR2GRAY)
    return gray
