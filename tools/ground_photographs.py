# SPDX-License-Identifier: Apache-2.0
"""Make the photographs that flat ground shows: each scene from straight above, with boxes.

    python tools/ground_photographs.py [--only derailment] [--out FOLDER]

Run it after a change of a scene or of the engine. It takes about a minute a scene and needs EGL.
"""

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from rocsafe_geo.arrays import ImageArray
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.engine.renderer import Renderer
from rocsafe_scene.flat_ground.ground_photograph import FOLDER, GroundPhotograph, write_photograph
from rocsafe_scene.flat_ground.scene_box import SceneBox, boxes_of
from rocsafe_scene.ground.ground_map import painted_map
from rocsafe_scene.ground.terrain import INNER_HALF_M, OUTER_HALF_M
from rocsafe_scene.painting.noise import CM_PER_M
from rocsafe_scene.scene.building import build, ground_works
from rocsafe_scene.scene.description import SceneDescription
from rocsafe_scene.scene.environment import Environment
from rocsafe_scene.scene.map_cache import default_folder
from rocsafe_scene.scene.scene_file import read_scene
from rocsafe_scene.scene.sunlight import lighting, sun_direction

SCENES = Path(__file__).resolve().parents[1] / 'config' / 'scenes'
_TILE_PX = 512
# Height of the camera above the origin, metres: above everything that stands in a scene.
_ABOVE_M = 300.0
# The camera looks down, with north at the top.
_DOWN = np.diag([1.0, -1.0, -1.0])


@dataclass(frozen=True, slots=True, kw_only=True)
class PhotographOptions:
    """Extent and quality of a photograph.

    Attributes
    ----------
    tiles
        Number of tiles of 512 x 512 pixels, east and north.
    texel_m
        Width of a pixel on the ground, metres.
    oversampling
        The engine draws so many times as wide and high.
    """

    tiles: tuple[int, int]
    texel_m: float
    oversampling: int = 3


# The extent that missions over the scene need, at the resolution of their photographs: 6 cm from
# 32 m above the derailment, 14 cm from 60 m above the field.
OPTIONS = {
    'derailment': PhotographOptions(tiles=(9, 8), texel_m=0.06),
    'field': PhotographOptions(tiles=(11, 8), texel_m=0.16),
}
JPEG_QUALITY = 68


def photographed(
    description: SceneDescription, options: PhotographOptions, cache: Path | None
) -> tuple[GroundPhotograph, tuple[SceneBox, ...]]:
    """Return the photograph of a scene, and the boxes of what stands on it.

    Raises
    ------
    SceneError, EngineError
        One line.
    """
    environment = _painted_as_fine(build(description, cache=cache), options)
    light, place = description.light, description.place
    direction = sun_direction(light.time, place.latitude_deg, place.longitude_deg)
    clear = replace(lighting(direction, light.weather), haze_per_m=0.0)
    image = photograph_of(Renderer(environment, clear), options)
    photograph = GroundPhotograph(image, options.texel_m)
    return photograph, boxes_of(environment.objects, photograph.half_m)


def _painted_as_fine(environment: Environment, options: PhotographOptions) -> Environment:
    """Return the scene with ground as fine as a photograph that shows more than the inner map."""
    halves = [0.5 * count * _TILE_PX * options.texel_m for count in options.tiles]
    if all(half <= inner for half, inner in zip(halves, INNER_HALF_M, strict=True)):
        return environment
    octave = math.floor(math.log2(options.texel_m * CM_PER_M))
    works = ground_works(environment.description, environment.seed)
    inner, outer = (
        painted_map(works, environment.seed, octave, half_m)
        for half_m in (INNER_HALF_M, OUTER_HALF_M)
    )
    return replace(environment, inner=inner, outer=outer)


def photograph_of(renderer: Renderer, options: PhotographOptions) -> ImageArray:
    """Return the ground about the origin from straight above, north at the top."""
    side_px = options.oversampling * _TILE_PX
    width_m = _TILE_PX * options.texel_m
    eye = renderer.camera(PinholeCamera(1.0, side_px, side_px))
    eye.use_parallel_projection(width_m, 2.0 * _ABOVE_M)
    columns, rows = options.tiles
    image = np.empty((rows * _TILE_PX, columns * _TILE_PX, 3), np.uint8)
    for row, column in np.ndindex(rows, columns):
        east, north = column + 0.5 - 0.5 * columns, 0.5 * rows - row - 0.5
        frame = eye.expose(np.array([east * width_m, north * width_m, _ABOVE_M]), _DOWN)
        image[
            row * _TILE_PX : (row + 1) * _TILE_PX, column * _TILE_PX : (column + 1) * _TILE_PX
        ] = cv2.resize(frame.image, (_TILE_PX, _TILE_PX), interpolation=cv2.INTER_AREA)
    eye.close()
    return image


def main(argv: Sequence[str] | None = None) -> int:
    """Make them; return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').splitlines()[0])
    parser.add_argument('--only', choices=tuple(OPTIONS), action='append', help='of this scene')
    parser.add_argument('--out', type=Path, default=FOLDER, metavar='FOLDER')
    arguments = parser.parse_args(argv)
    for scene in arguments.only or tuple(OPTIONS):
        description = read_scene(SCENES / f'{scene}.yaml')
        photograph, boxes = photographed(description, OPTIONS[scene], default_folder())
        path = arguments.out / f'{scene}.jpg'
        write_photograph(path, photograph, boxes, JPEG_QUALITY)
        sys.stdout.write(f'{path}: {path.stat().st_size / 1e6:.1f} MB, {len(boxes)} boxes\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
