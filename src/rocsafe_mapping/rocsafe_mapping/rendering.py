# SPDX-License-Identifier: Apache-2.0
"""A photograph as it looks from straight above, pixel by pixel of the map."""

import zlib
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_mapping.canvas import Colours, Scores, Window
from rocsafe_mapping.errors import PlacementError
from rocsafe_mapping.placement import FloatArray, Placement, camera_matrix
from rocsafe_mapping.shot import Intrinsics, ShotRecord

# Distortions that OpenCV's `undistort` means by its first five or eight coefficients.
DISTORTION_MODELS = ('', 'plumb_bob', 'rational_polynomial')
# Share of the image's shorter side, at each edge, over which its score falls to zero.
EDGE_SHARE = 0.1
# Scores differ by up to this share from photograph to photograph, so that no two ever tie.
TIE_BREAK = 1e-4
Pixels = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, kw_only=True)
class Rendering:
    """A photograph laid on the map's grid: where, its colours, and how well it shows each pixel.

    The shapes of `colours` and `scores` are that of `window`, see `Canvas.lay`.
    """

    window: Window
    colours: Colours
    scores: Scores


def window_of(corners_m: FloatArray, resolution_m: float) -> Window:
    """Return the pixels that hold a footprint with the UTM corners `corners_m`, shape (n, 2).

    Pixel (row, column) spans eastings from column to column + 1 and northings from -row - 1 to
    -row, in units of `resolution_m`: one grid for the whole zone, so that maps fit together.
    """
    west, south = np.floor(np.min(corners_m, axis=0) / resolution_m)
    east, north = np.ceil(np.max(corners_m, axis=0) / resolution_m)
    return Window(int(-north), int(west), int(north - south), int(east - west))


def render(
    record: ShotRecord, placement: Placement, jpeg: bytes, resolution_m: float
) -> Rendering:
    """Return the photograph `jpeg` seen from straight above.

    The score of a pixel is the squared cosine of the angle off nadir at which it was seen, falling
    to zero at the edges of the photograph.

    Raises
    ------
    PlacementError: if `jpeg` cannot be decoded or is not what `record` says.
    """
    window = window_of(placement.corners_m, resolution_m)
    image = _decoded(record, jpeg)
    pixel_of_grid = placement.pixel_of_offset @ _offset_of_grid(window, placement, resolution_m)
    # Wide pixels of the map would skip pixels of the photograph.
    shrink = max(1, int(resolution_m * record.camera.fx_px / placement.height_m))
    colours = _warped(*_reduced(image, pixel_of_grid, shrink), window, cv2.BORDER_REPLICATE)
    edges = _warped(_edge_scores(record.camera), pixel_of_grid, window, cv2.BORDER_CONSTANT)
    scores = _nadir_scores(window, placement, resolution_m)
    scores *= edges
    scores *= np.float32(1.0 - TIE_BREAK * zlib.crc32(record.shot_id.encode()) / 2**32)
    return Rendering(window=window, colours=colours.view(np.uint32)[..., 0], scores=scores)


def _decoded(record: ShotRecord, jpeg: bytes) -> Pixels:
    """Return the pixels, red, green, blue and opaque, without the lens's distortion."""
    camera = record.camera
    flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), flags) if jpeg else None
    if image is None:
        raise PlacementError(f'{record.shot_id}: image cannot be decoded')
    if image.shape[:2] != (camera.height_px, camera.width_px):
        raise PlacementError(
            f'{record.shot_id}: image is {image.shape[1]} x {image.shape[0]} pixels, its record '
            f'says {camera.width_px} x {camera.height_px}'
        )
    if camera.distortion_model not in DISTORTION_MODELS:
        raise PlacementError(f'{record.shot_id}: distortion {camera.distortion_model} is unknown')
    if camera.distortion:
        image = cv2.undistort(image, camera_matrix(camera), np.array(camera.distortion))
    rgba: Pixels = cv2.cvtColor(image, cv2.COLOR_BGR2RGBA)
    return rgba


def _offset_of_grid(window: Window, placement: Placement, resolution_m: float) -> FloatArray:
    """Return the affine map (3, 3) from (column, row) in `window` to UTM offsets in metres."""
    west = (window.column + 0.5) * resolution_m - placement.easting_m
    north = -(window.row + 0.5) * resolution_m - placement.northing_m
    return np.array([[resolution_m, 0.0, west], [0.0, -resolution_m, north], [0.0, 0.0, 1.0]])


def _reduced(image: Pixels, pixel_of_grid: FloatArray, shrink: int) -> tuple[Pixels, FloatArray]:
    """Return `image` with each side divided by `shrink`, and the homography to its pixels."""
    if shrink == 1:
        return image, pixel_of_grid
    height, width = (max(1, side // shrink) for side in image.shape[:2])
    scale_x, scale_y = width / image.shape[1], height / image.shape[0]
    # Pixel centres are integers: the corner of both images is at -0.5.
    small_of_pixel = np.array(
        [
            [scale_x, 0.0, 0.5 * scale_x - 0.5],
            [0.0, scale_y, 0.5 * scale_y - 0.5],
            [0.0, 0.0, 1.0],
        ]
    )
    small = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
    return small, small_of_pixel @ pixel_of_grid


def _warped(
    image: NDArray[Any], pixel_of_grid: FloatArray, window: Window, border: int
) -> NDArray[Any]:
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size = (window.width, window.height)
    warped: NDArray[Any] = cv2.warpPerspective(
        image, pixel_of_grid, size, flags=flags, borderMode=border
    )
    return warped


def _nadir_scores(window: Window, placement: Placement, resolution_m: float) -> Scores:
    """Return the squared cosine of the angle off nadir of each pixel in `window`."""
    columns = np.arange(window.column, window.column + window.width) + 0.5
    rows = np.arange(window.row, window.row + window.height) + 0.5
    easts = (columns * resolution_m - placement.easting_m) / placement.height_m
    norths = (-rows * resolution_m - placement.northing_m) / placement.height_m
    squares = np.add.outer((norths**2).astype(np.float32), (easts**2).astype(np.float32))
    return np.reciprocal(np.float32(1.0) + squares)


@lru_cache(maxsize=8)
def _edge_scores(camera: Intrinsics) -> Scores:
    """Return 1 in the middle of the image, falling to 0 at its edges; shape (height, width)."""
    across = np.arange(camera.width_px, dtype=np.float32) + 0.5
    down = np.arange(camera.height_px, dtype=np.float32) + 0.5
    to_side = np.minimum(across, camera.width_px - across)
    to_end = np.minimum(down, camera.height_px - down)
    distance = np.minimum.outer(to_end, to_side)
    ramp = EDGE_SHARE * min(camera.width_px, camera.height_px)
    scores: Scores = np.minimum(distance / np.float32(ramp), np.float32(1.0))
    return scores
