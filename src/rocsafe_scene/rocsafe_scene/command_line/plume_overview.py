# SPDX-License-Identifier: Apache-2.0
"""The estimated plume of a finished run, laid over what an image of its scene shows."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_scene.errors import SceneError
from rocsafe_scene.mesh.mesh import Floats

PLUME_FILE = 'plume.tif'
# Weaker than this share of its highest concentration, a plume is not drawn.
_FAINTEST = 1e-3
_MOST_OPAQUE = 0.65
# Blue, green, red of the faintest and of the strongest.
_FAINT, _STRONG = np.array([60.0, 220.0, 255.0]), np.array([30.0, 0.0, 200.0])


@dataclass(frozen=True, slots=True, eq=False)
class RunPlume:
    """Mean concentration near the ground.

    Attributes
    ----------
    ppm : (rows, columns)
        Concentrations of cells, the first row in the north.
    west_m, north_m
        Corner of the first cell, metres east and north of the mission origin.
    cell_m
        Size of a cell.
    """

    ppm: Floats
    west_m: float
    north_m: float
    cell_m: float

    def shares(self, east_m: Floats, north_m: Floats) -> NDArray[np.float32]:
        """Return how strong the plume is at places, from 0 (faintest) to 1, by logarithm."""
        column = ((east_m - self.west_m) / self.cell_m - 0.5).astype(np.float32)
        row = ((self.north_m - north_m) / self.cell_m - 0.5).astype(np.float32)
        highest = max(float(self.ppm.max()), 1e-30)
        logs = np.log(np.maximum(self.ppm / highest, _FAINTEST)) / -np.log(_FAINTEST) + 1.0
        found = cv2.remap(logs.astype(np.float32), column, row, cv2.INTER_LINEAR, borderValue=0.0)
        return np.asarray(found, np.float32)


def read_plume(run: Path, origin: GeoPosition) -> RunPlume | None:
    """Return the plume of a run directory about its origin, None if it has none.

    Raises
    ------
    SceneError
        One line, if its file cannot be read.
    """
    import rasterio
    from rasterio.errors import RasterioError
    from rasterio.warp import transform

    path = run / PLUME_FILE
    if not path.is_file():
        return None
    try:
        with rasterio.open(path) as file:
            place = transform('EPSG:4326', file.crs, [origin.longitude_deg], [origin.latitude_deg])
            west_m, north_m = file.bounds.left - place[0][0], file.bounds.top - place[1][0]
            return RunPlume(file.read(1).astype(float), west_m, north_m, float(file.res[0]))
    except (RasterioError, ValueError) as error:
        raise SceneError(f'{path}: cannot be read: {error}') from error


def draw_plume(
    image: NDArray[np.uint8],
    depth_m: Floats,
    lens: PinholeCamera,
    pose: tuple[Floats, Floats],
    plume: RunPlume,
) -> NDArray[np.uint8]:
    """Return `image` with the plume as a tint of whatever stands in it.

    `pose` is position and rotation of the camera; the sky stays clear.
    """
    position, rotation = pose
    rows, columns = depth_m.shape
    pixels = np.stack([*np.meshgrid(np.arange(columns), np.arange(rows)), np.ones_like(depth_m)])
    rays = np.linalg.inv(lens.matrix) @ pixels.reshape(3, -1)
    seen = np.isfinite(depth_m)
    places = position[:2, None] + rotation[:2] @ (rays * np.where(seen, depth_m, 0.0).ravel())
    share = plume.shares(*places.reshape(2, rows, columns)) * seen
    ink = _FAINT + share[..., None] * (_STRONG - _FAINT)
    opacity = (_MOST_OPAQUE * np.sqrt(share))[..., None]
    return np.asarray(np.rint(image + opacity * (ink - image)), np.uint8)
