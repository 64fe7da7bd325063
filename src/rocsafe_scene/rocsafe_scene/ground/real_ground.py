# SPDX-License-Identifier: Apache-2.0
"""The ground of real places: heights and colours from GeoTIFFs."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.terrain.height_grid import GridFrame
from rocsafe_geo.terrain.terrain import Terrain as Heights
from rocsafe_geo.terrain.terrain_file import read_terrain
from rocsafe_scene.errors import GroundError, SceneError
from rocsafe_scene.ground.ground_map import GroundMap
from rocsafe_scene.ground.ground_patch import GroundBounds
from rocsafe_scene.ground.orthophoto import OrthophotoGround
from rocsafe_scene.ground.terrain import INNER_HALF_M, HeightFunction
from rocsafe_scene.mesh.mesh import Floats

_TILE_PX = 1024
# Bisection steps that move a place beyond the model back onto it.
_HALVINGS = 14


def measured_heights(path: str, frame: LocalFrame) -> HeightFunction:
    """Return the heights of an elevation model relative to its height at the mission origin.

    So the datum of the model does not matter. Beyond the model the ground continues level in the
    direction away from the origin.

    Raises
    ------
    SceneError
        One line, if the file is no elevation model or does not cover the site.
    """
    try:
        model = read_terrain(path)
    except ValueError as error:
        raise SceneError(f'terrain.dem = {path}: {error}') from error
    half = np.array(INNER_HALF_M)
    corners = np.array([(0.0, 0.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]) * half
    found = _altitudes(model, frame, corners)
    if np.isnan(found).any():
        east, north = corners[np.flatnonzero(np.isnan(found))[0]].tolist()
        raise SceneError(
            f'terrain.dem = {path}: has no height at east {east:g} m, north {north:g} m: must '
            f'cover {half[0]:g} m east and west, {half[1]:g} m north and south of the origin'
        )
    level = float(found[0])

    def heights(grid: GridFrame) -> Floats:
        return _reaching(model, frame, grid.places()) - level

    return heights


def open_photo(path: str, frame: LocalFrame) -> OrthophotoGround:
    """Return an orthophoto.

    Raises
    ------
    SceneError
        One line, if the file is no orthophoto or does not show the origin.
    """
    try:
        return OrthophotoGround(Path(path), frame)
    except GroundError as error:
        raise SceneError(f'terrain.orthophoto = {path}: {error}') from error


def draped(ground: GroundMap, path: str, frame: LocalFrame) -> GroundMap:
    """Return a map with the colours of an orthophoto wherever that has data.

    Raises
    ------
    SceneError
        One line, if the file is no orthophoto or does not show the origin.
    """
    photo = open_photo(path, frame)
    colours = ground.colours.copy()
    try:
        rows, columns = colours.shape[:2]
        for row in range(0, rows, _TILE_PX):
            for column in range(0, columns, _TILE_PX):
                part = colours[row : row + _TILE_PX, column : column + _TILE_PX]
                part[:] = _painted_over(part, photo, ground, (row, column))
    except GroundError as error:
        raise SceneError(f'terrain.orthophoto = {path}: {error}') from error
    return replace(ground, colours=colours)


def _painted_over(
    part: Floats, photo: OrthophotoGround, ground: GroundMap, corner: tuple[int, int]
) -> Floats:
    """Return a part of a map, whose first texel is `corner`, with the photo over it."""
    texel = ground.texel_m
    west, south = ground.west_m + corner[1] * texel, ground.south_m + corner[0] * texel
    rows, columns = part.shape[:2]
    bounds = GroundBounds(
        west_m=west, south_m=south, east_m=west + columns * texel, north_m=south + rows * texel
    )
    patch = photo.patch(bounds, texel)
    to_ground = np.array(
        [[texel, 0.0, west + 0.5 * texel], [0.0, texel, south + 0.5 * texel], [0.0, 0.0, 1.0]]
    )
    seen = cv2.warpPerspective(
        patch.image, patch.pixel_from_ground @ to_ground, (columns, rows),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
    )  # fmt: skip
    return np.asarray(np.where(seen.any(axis=2, keepdims=True), seen, part))


def _altitudes(model: Heights, frame: LocalFrame, places: Floats) -> Floats:
    """Return heights at (east, north) places (n, 2), NaN where the model has none."""
    geodetic = frame.to_geodetic(np.column_stack([places, np.zeros(len(places))]))
    return model.altitudes_m(geodetic[:, 0], geodetic[:, 1])


def _reaching(model: Heights, frame: LocalFrame, places: Floats) -> Floats:
    """Return heights at places; where there is none, the next one on the way to the origin."""
    found: Floats = _altitudes(model, frame, places)
    lost = np.flatnonzero(np.isnan(found))
    if not len(lost):
        return found
    known: Floats = np.zeros(len(lost))
    unknown: Floats = np.ones(len(lost))
    heights = np.zeros(len(lost))
    for halving in range(_HALVINGS + 1):
        share = 0.5 * (known + unknown) if halving else known
        here = _altitudes(model, frame, places[lost] * share[:, None])
        is_known = np.isfinite(here)
        heights[is_known] = here[is_known]
        known, unknown = np.where(is_known, share, known), np.where(is_known, unknown, share)
    found[lost] = heights
    return found
