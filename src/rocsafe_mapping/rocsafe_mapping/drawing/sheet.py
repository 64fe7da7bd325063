# SPDX-License-Identifier: Apache-2.0
"""One aligned photograph, seen from straight above."""

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_mapping.alignment.photo import FloatArray, Photo, Pose, footprint
from rocsafe_mapping.alignment.state import Lens
from rocsafe_mapping.alignment.surface import Surface
from rocsafe_mapping.drawing.grid import MapGrid, Window

# The place in the photograph is computed at every so many pixels of the map, and drawn straight
# between: the error is far below a tenth of a pixel.
LATTICE_PX = 16
# Share of the image's shorter side, at each edge, over which its score falls to zero.
EDGE_SHARE = 0.04
LONGEST_REACH = 1.7
Shares = NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True)
class Sheet:
    """An aligned photograph.

    Attributes
    ----------
    photo, pose, lens, surface: what was found of it and of the ground.
    gains: factors of blue, green, red that make its colours those of the map.
    """

    photo: Photo
    pose: Pose
    lens: Lens
    surface: Surface
    gains: tuple[float, float, float] = (1.0, 1.0, 1.0)
    corners_m: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        focal_factor = math.exp(self.lens.log_focal)
        object.__setattr__(self, 'corners_m', footprint(self.photo, self.pose, focal_factor))

    def pixels_of(self, ground_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the pixels (n, 2) where ground points (n, 2) are seen, and cosines^2 off nadir.

        Points behind the camera or far towards the horizon get pixels outside the image.
        """
        points = np.column_stack([ground_m, self.surface.at(ground_m)]) - self.pose.centre
        turned = points @ self.pose.rotation
        camera = self.photo.camera
        depth = turned[:, 2]
        is_ahead = depth > 0.05 * np.linalg.norm(points, axis=1)
        rays = turned[:, :2] / np.where(is_ahead, depth, 1.0)[:, np.newaxis]
        focal = camera.fx_px * np.exp(self.lens.log_focal)
        offsets = self._bent(rays) * focal * np.array([1.0, camera.fy_px / camera.fx_px])
        pixels = offsets + np.array([camera.cx_px, camera.cy_px])
        pixels[~is_ahead] = -1e6
        cosines = points[:, 2] ** 2 / np.sum(points**2, axis=1)
        return pixels, cosines

    def _bent(self, straight: FloatArray) -> FloatArray:
        """Return the rays as the lens bends them: inverse of v (1 + k1 r^2 + k2 r^4)."""
        if self.lens.k1 == 0.0 and self.lens.k2 == 0.0:
            return straight
        limited = np.clip(straight, -LONGEST_REACH, LONGEST_REACH)
        bent = limited
        for _ in range(4):
            square = np.sum(bent**2, axis=1, keepdims=True)
            bent = limited / (1.0 + self.lens.k1 * square + self.lens.k2 * square**2)
        return bent

    def lattice(self, grid: MapGrid, window: Window) -> tuple[FloatArray, FloatArray]:
        """Return pixels (rows, columns, 2) and cosines^2 at every 16th edge of `window`."""
        ground = grid.ground_lattice(window, LATTICE_PX)
        pixels, cosines = self.pixels_of(ground.reshape(-1, 2))
        return pixels.reshape(ground.shape), cosines.reshape(ground.shape[:2])


def drawn(
    sheet: Sheet, image: NDArray[np.uint8], grid: MapGrid, window: Window, interpolation: int
) -> NDArray[np.uint8]:
    """Return `image` over `window`, whose sides are multiples of 16; edges are drawn outwards."""
    pixels, _ = sheet.lattice(grid, window)
    across = spread_lattice(pixels[..., 0], window)
    down = spread_lattice(pixels[..., 1], window)
    # A map coarser than the photograph would skip pixels of it.
    step = abs(across[0, 0] - across[0, -1]) + abs(down[0, 0] - down[0, -1])
    shrink = int(step / max(window.width - 1, 1) / 1.1)
    if shrink >= 2 and interpolation != cv2.INTER_NEAREST:
        size = (max(image.shape[1] // shrink, 1), max(image.shape[0] // shrink, 1))
        scale = np.float32(size[0] / image.shape[1]), np.float32(size[1] / image.shape[0])
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
        across = (across + np.float32(0.5)) * scale[0] - np.float32(0.5)
        down = (down + np.float32(0.5)) * scale[1] - np.float32(0.5)
    border = cv2.BORDER_CONSTANT if interpolation == cv2.INTER_NEAREST else cv2.BORDER_REPLICATE
    picture: NDArray[np.uint8] = cv2.remap(image, across, down, interpolation, borderMode=border)
    return picture


def scores(sheet: Sheet, grid: MapGrid, window: Window) -> Shares:
    """Return how well the photograph shows each pixel of `window`: 0 not at all, 1 best.

    The squared cosine of the angle off nadir, falling to zero at the edges of the photograph.
    """
    pixels, cosines = sheet.lattice(grid, window)
    camera = sheet.photo.camera
    across = spread_lattice(pixels[..., 0], window)
    down = spread_lattice(pixels[..., 1], window)
    to_side = np.minimum(across + 0.5, camera.width_px - 0.5 - across)
    to_end = np.minimum(down + 0.5, camera.height_px - 0.5 - down)
    ramp = np.float32(EDGE_SHARE * min(camera.width_px, camera.height_px))
    edge = np.clip(np.minimum(to_side, to_end) / ramp, 0.0, 1.0)
    found: Shares = spread_lattice(cosines, window) * edge
    return found


def spread_lattice(values: FloatArray, window: Window) -> Shares:
    """Return values at every 16th pixel edge of `window`, brought to its pixels' centres."""
    rows, columns = values.shape
    # Pixel centres in units of the lattice; cv2.resize has no such corners, an affine map has.
    matrix = np.array([[1.0 / LATTICE_PX, 0.0, 0.5 / LATTICE_PX],
                       [0.0, 1.0 / LATTICE_PX, 0.5 / LATTICE_PX]])  # fmt: skip
    if rows < 2 or columns < 2:
        raise ValueError(f'window = {window} must have sides of at least {LATTICE_PX}')
    return np.asarray(_bilinear(values.astype(np.float32), matrix, window))


def _bilinear(values: Shares, matrix: FloatArray, window: Window) -> Shares:
    """Return `values` at an affine lattice of places, exactly; OpenCV rounds to 1/32."""
    x = np.float32(matrix[0, 0]) * np.arange(window.width, dtype=np.float32) + np.float32(
        matrix[0, 2]
    )
    y = np.float32(matrix[1, 1]) * np.arange(window.height, dtype=np.float32) + np.float32(
        matrix[1, 2]
    )
    column = np.minimum(x.astype(int), values.shape[1] - 2)
    row = np.minimum(y.astype(int), values.shape[0] - 2)
    x = x - column.astype(np.float32)
    y = (y - row.astype(np.float32))[:, np.newaxis]
    across = values[:, column] * (1 - x) + values[:, column + 1] * x
    return across[row] * (1 - y) + across[row + 1] * y
