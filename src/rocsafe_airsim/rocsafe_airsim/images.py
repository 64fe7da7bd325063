# SPDX-License-Identifier: Apache-2.0
"""Images as AirSim's clients expect them.

Pixels are blue, green, red, as the clients' own examples take them (`cv2.imwrite`). Depth as
floats is sent as a list, which is what the clients read; here it is an array.
"""

from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.ned import Quaternion, Vector
from rocsafe_airsim.values import Plain, quaternion, vector
from rocsafe_airsim.vehicle import Picture

SCENE, DEPTH_PLANAR, DEPTH_PERSPECTIVE, DEPTH_VIS, SEGMENTATION = 0, 1, 2, 3, 5
TYPES = {
    SCENE: 'Scene',
    DEPTH_PLANAR: 'DepthPlanar',
    DEPTH_PERSPECTIVE: 'DepthPerspective',
    DEPTH_VIS: 'DepthVis',
    SEGMENTATION: 'Segmentation',
}
# As AirSim's DepthVis: white is this far and beyond.
FARTHEST_SHOWN_M = 100.0
# Depth of the sky: a float that all clients can hold.
SKY_M = 65_504.0
MOST_IDS = 256


def image_type(value: Any) -> int:
    """Return the number of an image type.

    Raises
    ------
    AirsimError
        If there are no such images here.
    """
    if not isinstance(value, int) or value not in TYPES:
        known = ', '.join(f'{number} {name}' for number, name in TYPES.items())
        raise AirsimError(f'image_type is {value!r:.80}: must be one of {known}')
    return int(value)


def palette() -> NDArray[np.uint8]:
    """Return the colour of each segmentation id, (256, 3); 0 is black."""
    hues = (np.arange(MOST_IDS) * 0.618_034 % 1.0 * 180.0).astype(np.uint8)
    values = np.where(np.arange(MOST_IDS) % 3 == 0, 255, 170 + 20 * (np.arange(MOST_IDS) % 5))
    hsv = np.stack([hues, np.full(MOST_IDS, 220, np.uint8), values.astype(np.uint8)], axis=-1)
    colours: NDArray[np.uint8] = cv2.cvtColor(hsv[None], cv2.COLOR_HSV2BGR)[0].astype(np.uint8)
    colours[0] = 0
    return colours


# Four bytes a colour: one look-up a pixel.
_PALETTE = cv2.cvtColor(palette()[None], cv2.COLOR_BGR2BGRA)[0].view(np.uint32)[:, 0]


def segmentation(labels: NDArray[np.uint16], chosen: Mapping[int, int]) -> NDArray[Any]:
    """Return the colour of each pixel's id: as chosen for its instance, else its number in 8 bits.

    Blue, green, red, (height, width, 3).
    """
    table = np.tile(_PALETTE, 65_536 // MOST_IDS)
    for number, value in chosen.items():
        table[number] = _PALETTE[value]
    colours = table[labels].view(np.uint8).reshape(*labels.shape, 4)
    return np.asarray(cv2.cvtColor(colours, cv2.COLOR_BGRA2BGR))


def response(
    picture: Picture,
    request: Mapping[str, Any],
    pose_ned: tuple[Vector, Quaternion],
    chosen: Mapping[int, int],
) -> Plain:
    """Return an ImageResponse.

    Parameters
    ----------
    picture
        What the camera shows.
    request
        An ImageRequest.
    pose_ned
        Pose of the camera about the vehicle's origin.
    chosen
        Segmentation ids by number of the instance.
    """
    kind = image_type(request.get('image_type', SCENE))
    as_float, is_packed = bool(request.get('pixels_as_float')), bool(request.get('compress', True))
    pixels = _pixels(picture, kind, chosen)
    height, width = pixels.shape[:2]
    common = {
        'camera_name': str(request.get('camera_name', '')),
        'camera_position': vector(pose_ned[0]),
        'camera_orientation': quaternion(pose_ned[1]),
        'time_stamp': picture.stamp_ns,
        'message': '',
        'pixels_as_float': as_float,
        'compress': is_packed and not as_float,
        'width': width,
        'height': height,
        'image_type': kind,
        'annotation_name': '',
        'image_data_float': [],
        'image_data_uint8': b'',
    }
    if as_float:
        plane = pixels if pixels.ndim == 2 else pixels.mean(axis=-1)
        values = np.minimum(plane, SKY_M).astype(np.float32)
        return {**common, 'image_data_float': values.ravel()}
    shown = _shown(pixels)
    data = png(shown) if is_packed else shown.tobytes()
    return {**common, 'image_data_uint8': data}


def png(pixels: NDArray[np.uint8]) -> bytes:
    """Return pixels (blue, green, red) as a PNG file."""
    is_made, data = cv2.imencode('.png', pixels, [cv2.IMWRITE_PNG_COMPRESSION, 1])
    if not is_made:
        raise AirsimError('the image cannot be packed')
    return bytes(data.tobytes())


def _pixels(picture: Picture, kind: int, chosen: Mapping[int, int]) -> NDArray[Any]:
    if kind == SCENE:
        return picture.pixels
    if picture.depth_m is None or picture.labels is None:
        raise AirsimError(f'{TYPES[kind]}: this camera is not drawn by an engine, so has none')
    if kind == SEGMENTATION:
        return segmentation(picture.labels, chosen)
    if kind == DEPTH_VIS:
        shown: NDArray[Any] = np.minimum(picture.depth_m / FARTHEST_SHOWN_M, 1.0)
        return shown
    return picture.depth_m


def _shown(pixels: NDArray[Any]) -> NDArray[np.uint8]:
    if pixels.ndim == 3:
        return np.ascontiguousarray(pixels, np.uint8)
    top = FARTHEST_SHOWN_M if pixels.max(initial=0.0) > 1.0 else 1.0
    grey = (np.clip(pixels / top, 0.0, 1.0) * 255.0).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=-1)
