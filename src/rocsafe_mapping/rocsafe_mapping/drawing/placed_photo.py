# SPDX-License-Identifier: Apache-2.0
"""An aligned photograph, and where the map's pixels lie in it."""

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.model.photo import Photo, Pose, footprint
from rocsafe_mapping.alignment.model.state import Lens
from rocsafe_mapping.alignment.model.surface import Surface
from rocsafe_mapping.drawing.grid import MapGrid, Window
from rocsafe_mapping.photographs.shot import Intrinsics

# The place in the photograph is computed at every so many pixels of the map, and drawn straight
# between: the error is far below a tenth of a pixel.
LATTICE_PX = 16
LONGEST_REACH = 1.7
# Three heights away.
LEAST_COSINE_SQUARE = 0.1
Shares = NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True)
class PixelMap:
    """Places in a photograph at which the pixels of a window are seen, (height, width) each.

    Attributes
    ----------
    across, down
        Pixels of the photograph.
    window
        That is seen.
    steepness
        Squared cosines of the angles off nadir, at every 16th pixel edge of the window.
    """

    across: Shares
    down: Shares
    window: Window
    steepness: FloatArray

    @property
    def cosines(self) -> Shares:
        """Squared cosines of the angles off nadir, (height, width)."""
        return spread_lattice(self.steepness, self.window)

    def squares(self, camera: Intrinsics) -> Shares:
        """Return the squared distances from the middle of the image, 1 in its corners."""
        across = self.across - np.float32(0.5 * (camera.width_px - 1))
        down = self.down - np.float32(0.5 * (camera.height_px - 1))
        half = 0.25 * (camera.width_px**2 + camera.height_px**2)
        return ((across**2 + down**2) / half).astype(np.float32)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlacedPhoto:
    """An aligned photograph.

    Attributes
    ----------
    photo, pose, lens, surface
        What was found of it and of the ground.
    gains
        Factors of blue, green, red that make its colours those of the map.
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

    def pixel_map(self, grid: MapGrid, window: Window) -> PixelMap:
        """Return where the pixels of `window`, whose sides are multiples of 16, are seen."""
        ground = grid.ground_lattice(window, LATTICE_PX)
        pixels, cosines = self.pixels_of(ground.reshape(-1, 2))
        pixels = pixels.reshape(ground.shape)
        return PixelMap(
            across=spread_lattice(pixels[..., 0], window),
            down=spread_lattice(pixels[..., 1], window),
            window=window,
            steepness=cosines.reshape(ground.shape[:2]),
        )


def drawn(image: NDArray[np.uint8], seen: PixelMap, interpolation: int) -> NDArray[np.uint8]:
    """Return what a photograph, `image`, shows at the places `seen`; edges are drawn outwards."""
    across, down = seen.across, seen.down
    # A map coarser than the photograph would skip pixels of it.
    step = abs(across[0, 0] - across[0, -1]) + abs(down[0, 0] - down[0, -1])
    shrink = int(step / max(across.shape[1] - 1, 1) / 1.1)
    if shrink >= 2 and interpolation != cv2.INTER_NEAREST:
        size = (max(image.shape[1] // shrink, 1), max(image.shape[0] // shrink, 1))
        scale = np.float32(size[0] / image.shape[1]), np.float32(size[1] / image.shape[0])
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
        across = (across + np.float32(0.5)) * scale[0] - np.float32(0.5)
        down = (down + np.float32(0.5)) * scale[1] - np.float32(0.5)
    border = cv2.BORDER_CONSTANT if interpolation == cv2.INTER_NEAREST else cv2.BORDER_REPLICATE
    picture: NDArray[np.uint8] = cv2.remap(image, across, down, interpolation, borderMode=border)
    return picture


def scores(camera: Intrinsics, seen: PixelMap, edge_share: float) -> Shares:
    """Return how well a photograph shows each place of `seen`: 0 not at all, 1 best.

    The squared cosine of the angle off nadir, falling to zero at the edges of the photograph, and
    zero where it looks farther than three heights: there pixels are smeared over the map.
    """
    half_width, half_height = np.float32(0.5 * camera.width_px), np.float32(0.5 * camera.height_px)
    to_side = half_width - np.abs(seen.across + (np.float32(0.5) - half_width))
    to_end = half_height - np.abs(seen.down + (np.float32(0.5) - half_height))
    ramp = np.float32(edge_share * min(camera.width_px, camera.height_px))
    edge = np.clip(np.minimum(to_side, to_end) / ramp, 0.0, 1.0)
    cosines = seen.cosines
    found: Shares = np.where(cosines > LEAST_COSINE_SQUARE, cosines, np.float32(0.0)) * edge
    return found


def spread_lattice(values: FloatArray, window: Window) -> Shares:
    """Return values at every 16th pixel edge of `window`, brought to its pixels' centres."""
    rows, columns = values.shape
    if rows < 2 or columns < 2:
        raise ValueError(f'window = {window} must have sides of at least {LATTICE_PX}')
    # `resize` puts the values at the middles of 16 pixels, not at their edges.
    whole = cv2.resize(
        values.astype(np.float32),
        (columns * LATTICE_PX, rows * LATTICE_PX),
        interpolation=cv2.INTER_LINEAR,
    )
    half = LATTICE_PX // 2
    spread: Shares = whole[half : half + window.height, half : half + window.width]
    return spread
